"""Linear models about steady states: one (`model`), over a grid and between its points (`grid`), in physical coordinates (`physical`)."""
