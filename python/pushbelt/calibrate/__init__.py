"""Parameters of the pushbelt FMU from a table of measured steady points.

table (CSV with units → points) ┐
parameters (fitted ones)        ┴→ model (points and parameters → residuals; `worker` runs the FMU) → fit → report
"""

from pushbelt.calls import callable_module

callable_module(__name__)
