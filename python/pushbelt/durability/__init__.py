"""Fatigue of the ring over a run: `python -m pushbelt.durability RUN.csv`, for a result of drive or any table of outputs.

Data flow: table → cycles of a revolution → damage → figures → report.
"""
