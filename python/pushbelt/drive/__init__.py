"""The pushbelt FMU in a car on the WLTC: vehicle, driver, hydraulics and controllers around it, and a report.

Data flow in each step of 10 ms:

    cycle → driver → car (engine, launch clutch) ─┐
                     control → hydraulics ────────┴→ FMU (variator, vehicle as inertia) → measured → driver, control

`measure` first solves for the FMU's steady states. `simulate` runs the loop, and `report` presents the results.
"""

from pushbelt.calls import callable_module

callable_module(__name__)
