"""The drive as a co-simulation of FMUs: variator, vehicle and transmission control, coupled by third-party importers.

    slaves/vehicle_unit, slaves/control_unit (Python in FMUs, by `pythonfmu`) ─┐
    PushbeltVariator.fmu ──────────────────────────────────────────────────────┴→ drive.ssp → ecos, libcosim

The units use the same classes as `pushbelt.drive.simulate`; `study` compares the results.
`cargo fmu drive --cosim`, or `python -m pushbelt_cosim` with the folders `python` and `examples/cosim` on the path, builds, runs and compares.
"""
