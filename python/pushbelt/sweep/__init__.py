"""Parameter studies with the pushbelt FMU: steady states over a grid of working points, on one machine or a cluster.

    study (parameters, grid, identity) → cluster (dask: chunks of points to workers) → store (finished points, Parquet)
                                            │
                                  worker (the FMU, loaded once) → point (one steady state)

    results.parquet → maps, checks → report

The function `sweep` is the interface; `python -m pushbelt.sweep` is its command line.
"""

from .run import Progress, sweep
from .study import Grid, Study

__all__ = ["Grid", "Progress", "Study", "sweep"]
