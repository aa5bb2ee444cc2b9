"""Maps of the variator for vehicle simulations: steady states, losses, capacity and shift rates over working points.

    `pushbelt.map_plan` (FMU, parameters, axes) → cluster (dask: a line of points to a worker) → store (finished lines)
                                                    │
                                          worker → `pushbelt.fmu.working_points` (the points of a line)

    lines → `pushbelt.map_lines` → `pushbelt.map_data.Maps` → files (NetCDF, npz, MATLAB, Modelica, CSV, JSON), report

The function `solve` is the interface; `python -m pushbelt.maps` is its command line.
"""

from pushbelt.map_plan import Grid, Plan

from .run import solve

__all__ = ["Grid", "Plan", "solve"]
