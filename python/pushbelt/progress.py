"""The progress bar of long computations."""

from __future__ import annotations

from typing import Any


def progress_bar(total: float, description: str, done: int = 0) -> Any:
    """A bar with the remaining time, on a terminal only. `done` of `total` were finished before."""
    # Only what shows a bar needs the package.
    from tqdm import tqdm

    return tqdm(
        total=total,
        initial=done,
        disable=None,
        desc=description,
        bar_format="  {desc} {bar:32} {percentage:3.0f} % [{elapsed}<{remaining}{postfix}]",
    )
