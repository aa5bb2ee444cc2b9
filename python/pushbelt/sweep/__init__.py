"""Parameter studies with the pushbelt FMU: steady states over a grid of working points, on one machine or a cluster.

    study (parameters, grid, identity) → cluster (dask: chunks of points to workers) → store (finished points, Parquet)
                                            │
                                  worker (the FMU, loaded once) → point (one steady state)

    results.parquet → maps, checks → report

A study has a grid of the five axes, or a design of any parameters and inputs (`design`). Clusters are local, jobs of Slurm (`slurm`), or
existing ones.

The function `sweep` is the interface; `python -m pushbelt.sweep` is its command line.
"""

from pushbelt.slurm import Slurm

from .design import Design, DesignError
from .run import Progress, sweep
from .study import Grid, Study

__all__ = ["Design", "DesignError", "Grid", "Progress", "Slurm", "Study", "sweep"]
