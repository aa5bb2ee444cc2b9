"""The FMU beside theory and measurements: one command, one report.

    measured (what was measured, with sources) ┐
    theory (of the package)                    ├→ sections (solve points with `bench`, judge) → report
    bench (steady points of the FMU)           ┘

- `outcome`: what a section hands over, as data: checks, tables, figures.
- `against_theory`: the FMU and the continuum theory at the same load, also in the theory's limit.
- `sections`: one module a section of the report.
"""
