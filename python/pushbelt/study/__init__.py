"""Studies: many tasks for the FMU, such as points of a grid, on this machine or on a cluster.

    tasks (`tasks`: FMU, parameters, points, identity) → `cluster` (dask) → `worker` (the FMU, loaded once) → `store` (finished tasks)

`run.solve` does all of it; a study that was interrupted continues from its stored tasks.
"""
