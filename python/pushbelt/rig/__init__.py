"""Tables of rigs and spreadsheets, and the working points of the FMU that they measure.

text (bytes → cells)           ┐
titles, numerals, units, times ┴→ sheet (cells → columns in SI) → series (plateaus) → points (what is measured where) → plausible
points, parameters   → worker (runs the FMU) → model (residuals)
"""
