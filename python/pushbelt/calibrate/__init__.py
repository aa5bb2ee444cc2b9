"""Parameters of the pushbelt FMU from a table of measured steady points: points of the table, and parameters → model (residuals; `worker`
runs the FMU) → fit → misfit (which error of the table, `causes`, or law of the friction, `friction`, explains it) → report."""

from pushbelt.calls import callable_module

callable_module(__name__)
