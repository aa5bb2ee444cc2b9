"""Studies: many tasks for the FMU, such as points of a grid, on this machine or on a cluster: `tasks` (FMU, parameters, points, identity)
→ `cluster` (dask) → `tasks.Solver` (the FMU, loaded once). `run.solve` does all of it, and continues from stored tasks."""
