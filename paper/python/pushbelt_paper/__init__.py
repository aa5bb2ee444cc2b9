"""Reproduction of the paper's examples: rings alone (5.3) and the variator's nine load cases (5.4) with every ring model.

Grundl, Schindler, Ulbrich, Rixen: ALE beam using reference dynamics, 2019. Numbers of sections, figures and equations are
the paper's.

- `rings`: runs the Rust program `paper_rings` and reads its results.
- `cases`: the load cases through the FMU, one model after the other, with computing times.
- `tracer`: the path of one element around the belt.
- `statements`: statements of the paper, and the results for them.
- `figures`, `report`: figures and page of the report.
"""
