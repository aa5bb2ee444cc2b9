"""What theories say, independent of the FMU: no module here imports another part of this package.

- `cmm`: the continuum theory of a belt on deformable pulleys, steady and while the ratio changes.
- `shifting`: the speed of ratio change that follows from it without load.
"""
