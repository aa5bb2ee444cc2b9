"""The drive as a co-simulation of FMUs: variator, vehicle and transmission control, coupled by masters of others.

    slaves/vehicle_unit, slaves/control_unit (Python in FMUs, by `pythonfmu`) ─┐
    PushbeltVariator.fmu ──────────────────────────────────────────────────────┴→ drive.ssp → ecos, libcosim

The units call the classes that `pushbelt.drive.simulate` calls; `study` compares what comes out.
`python -m pushbelt.drive.cosim` builds, runs and compares.
"""
