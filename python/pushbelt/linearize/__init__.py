"""Linear models about steady working points: `python -m pushbelt.linearize initial.ratio=0.5,1,2 primary.torque=60`.

Data flow: points (the command line) → `pushbelt.Variator.linear_grid` → figures → report.
"""
