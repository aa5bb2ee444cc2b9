"""The pushbelt FMU at work: published data in, a report out.

Data flows one way:

    data → load cases, reference_case, manoeuvre (each drives the FMU) → results → events, spiral, checks → figures → report

`simulate` runs the simulations side by side; `python -m pushbelt.demo` does all of it.
"""
