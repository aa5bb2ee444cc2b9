"""Maps of the variator for vehicle simulations: steady states, losses, capacity and shift rates over working points.

    plan (FMU, parameters, axes) → `pushbelt.study` (a line of points is a task, `pushbelt.fmu.working_points` solves it)
    → data (`Maps`) → files (NetCDF, npz, MATLAB, Modelica, CSV, JSON), report

`unit` and `variator` are variators from maps, as an FMU and in numpy.
"""

from pushbelt.calls import callable_module

callable_module(__name__)
