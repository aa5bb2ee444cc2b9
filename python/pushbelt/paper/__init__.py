"""The paper's examples again: rings alone (5.3) and the variator's nine load cases (5.4) with every ring model.

Grundl, Schindler, Ulbrich, Rixen: ALE beam using reference dynamics, 2019. Numbers of sections, figures and equations are
the paper's.

- `rings`: runs the Rust program `paper_rings` and reads what it wrote.
- `cases`: the load cases through the FMU, one model after the other, with computing times.
- `tracer`: one element on its way round.
- `statements`: what the paper says, and what was found.
- `figures`, `report`: the pictures and the page.
"""
