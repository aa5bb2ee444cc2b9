"""Linear models about steady working points: `python -m pushbelt.linearize initial.ratio=0.5,1,2 primary.torque=60`.

Data flows one way: points (what is asked for) → `pushbelt.Variator.linear_grid` → figures → report.
"""
