"""The drive as a co-simulation of FMUs: variator, vehicle and transmission control, coupled by third-party masters.

    slaves/vehicle_unit, slaves/control_unit (Python in FMUs, by `pythonfmu`) ─┐
    PushbeltVariator.fmu ──────────────────────────────────────────────────────┴→ drive.ssp → ecos, libcosim

The units use the same classes as `pushbelt.drive.simulate`; `study` compares the results.
`python -m pushbelt.drive.cosim` builds, runs and compares.
"""
