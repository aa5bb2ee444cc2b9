"""Tables of rigs and spreadsheets, and the working points of the FMU that they measure.

text (bytes → cells) ┐
numerals, units      ┴→ sheet (cells → columns in SI) → points (what is measured where)
points, parameters   → worker (runs the FMU) → model (residuals)
"""
