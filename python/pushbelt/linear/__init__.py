"""Linear models about steady states: one (`model`), over a grid (`grid`), in physical coordinates (`physical`), between points (`interpolation`)."""
