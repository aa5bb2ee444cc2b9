"""Parameter studies with the pushbelt FMU: steady states over a grid of five axes, or a design of any parameters and inputs (`design`):
study (points) → `pushbelt.study` (cluster, store) → results.parquet → maps → report with checks."""

from pushbelt.calls import callable_module

callable_module(__name__)
