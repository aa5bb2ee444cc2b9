"""Demonstration of the pushbelt FMU: simulations of published data, and a report.

Data flow:

    data → load cases, manoeuvre (each runs the FMU) → results → events, checks → figures → report

`simulate` runs the simulations in parallel; `python -m pushbelt.demo` runs all steps.
"""
