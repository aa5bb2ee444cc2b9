"""Theories, independent of the FMU: these modules do not import other parts of this package.

- `cmm`: the continuum theory of a belt on deformable pulleys, steady and while the ratio changes.
- `shifting`: the speed of ratio change without load, from the continuum theory.
"""
