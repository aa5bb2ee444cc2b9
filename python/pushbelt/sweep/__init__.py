"""Parameter studies with the pushbelt FMU: steady states over a grid of five axes, or a design of any parameters and inputs (`design`).

    study (points) → `pushbelt.study` (cluster, store) → results.parquet → maps, checks → report

The function `sweep` is the interface; `python -m pushbelt.sweep` is its command line.
"""

from pushbelt.study.run import Progress

from .design import Design, DesignError
from .study import Grid, Study, sweep

__all__ = ["Design", "DesignError", "Grid", "Progress", "Study", "sweep"]
