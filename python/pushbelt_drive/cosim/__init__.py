"""The drive as a co-simulation of FMUs: variator, vehicle and transmission control, coupled by a master of others.

    vehicle_unit, control_unit (Python in FMUs, `pythonfmu`) ─┐
    PushbeltVariator.fmu ─────────────────────────────────────┴→ drive.ssp → ecos, libcosim → compared with `simulate`

The units call the very classes that `simulate` calls. `python -m pushbelt_drive.cosim` builds, runs and compares.
"""
