"""Validation of the FMU: one command, one report, three parts, each with its own verdict. It uses `pushbelt` and is not in its wheel.

1. Verification: theories in the limit in which they hold. They must be met.
2. Measurements and published statements: goals with source and certainty, met or missed; a missed one with its cause.
3. From the theory to the belt: what each effect adds, switched on one after another.

- `theory`: the continuum theory, independent of the FMU and of `pushbelt`.
- `measured`: what was measured, with sources. `limit`: parameters of the theory's limit, and the FMU beside the theory.
- `bench`: steady points and shifts. `outcome`: checks, tables and figures of a section as data. `sections`: one module each.
- `runs` → `report` (HTML, tables) and `results` (JSON, the pinned verdicts, the tables of the book).
"""
