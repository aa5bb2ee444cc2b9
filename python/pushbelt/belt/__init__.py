"""A parameter set for a belt of one's own: dimensions → geometry (formulas of `docs/belt.md`) → parameter set (JSON), with checks of the
ratio's reach and, by the FMU, of the ring's stress."""
