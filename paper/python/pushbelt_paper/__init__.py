"""Reproduction of the paper's examples: rings alone (5.3) and the variator's nine load cases (5.4) with every ring model.

Grundl, Schindler, Ulbrich, Rixen: ALE beam using reference dynamics, 2019. Numbers of sections, figures and equations are
the paper's.

- `rings`: runs the Rust program `paper_rings` and reads its results.
- `cases`, `runs`: the load cases through the FMU with every model; `times`: their computing times.
- `profiles`: fields along the belt, and the path of one element.
- `statements`: the results for the statements of the paper.
- `figures`, `report`: figures and page of the report.
"""
