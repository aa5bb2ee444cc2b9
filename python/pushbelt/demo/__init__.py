"""Demonstration of the pushbelt FMU: simulations of published data, and a report.

    `simulate` (load cases, manoeuvre; each runs the FMU) → events and checks → figures → report
"""
