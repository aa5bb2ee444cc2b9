"""Values of variables that exist only in PushbeltPaper.fmu. A test compares them with its model description."""

from __future__ import annotations

from enum import IntEnum


class RingModel(IntEnum):
    """Values of `ring.model` in PushbeltPaper.fmu."""

    ALE0 = 1
    ALE = 2
    RCM = 3
    ANCF = 4
    ALE0Centred = 5
