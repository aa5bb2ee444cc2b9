"""A parameter set for a belt of one's own, from its geometry.

    dimensions → geometry (formulas) → parameter set (JSON)
                                    ↘ checks (reach of the ratio, stress of the ring from the FMU)

`docs/belt.md` has the formulas and their sources.
"""
