"""Linear models about steady working points: points of the command line → `pushbelt.Variator.linear_grid` → report."""
