"""Linear models about steady states: one (`model`), in physical coordinates (`physical`), over a grid (`grid`)."""
