"""Comparison of the FMU with theory and measurements: one command, one report.

    measured (what was measured, with sources) ┐
    theory (of the package)                    ├→ sections (points by `bench`, checks)        → report
    bench (steady points of the FMU)           ┘

- `outcome`: results of a section as data: checks, tables, figures.
- `against_theory`: the FMU and the continuum theory at the same load, also in the theory's limit.
- `sections`: one module per section of the report.
"""
