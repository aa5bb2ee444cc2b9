"""Fatigue of the ring over a run, a result of drive or any table of outputs: table → cycles of a revolution → damage → report."""
