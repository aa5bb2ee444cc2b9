"""The pushbelt FMU in a car on the WLTC: vehicle, driver, hydraulics and controllers around it, and a report.

Data flows one way, each step of 10 ms:

    cycle → driver → car (engine, launch clutch) ─┐
                     control → hydraulics ────────┴→ FMU (variator, vehicle as inertia) → measured → driver, control

`thrust_map` solves for the FMU's steady states first. `simulate` runs the loop, `report` shows what came out;
`python -m pushbelt.drive` does all of it.
"""
