"""Python around the pushbelt FMU.

- `fmu`: the FMU call by call, published data, geometry, load cases, results.
- `page`, `charts`, `belt_view`, `style`, `checks`, `progress`, `side_by_side`: what the reports share.
- `theory`: what theories say, independent of the FMU.
- `calibrate`, `compare`, `demo`, `drive`, `paper`, `sweep`, `validate`: programs, each run by `python -m pushbelt.…`. None of them imports another.
"""

from ._version import __version__

__all__ = ["__version__"]
