"""The FMU, and data for it.

geometry → results → unit (the FMU, call by call), data (published parameters and inputs) → load_cases (steady states at a belt torque)
steady (start values of steady states, and one after another), gradients and bands (around one), working_points (what maps consist of)
"""
