"""`--help` of a program whose packages are not installed.

The program's module imports its packages before it makes its parser. Here each missing package has a stand-in, so that the parser can be
made. Nothing else of the program runs.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from unittest.mock import MagicMock

PACKAGES = frozenset(
    {
        "cloudpickle", "control", "dask", "dask_jobqueue", "distributed", "jinja2", "markupsafe", "matplotlib", "openpyxl", "pandas", "plotly",
        "pyarrow", "rainflow", "scipy", "tqdm", "xarray",
    }
)  # fmt: skip
"""Packages of the extras."""


class _StandIn(ModuleType):
    """A module with every attribute."""

    __path__: list[str] = []

    def __getattr__(self, name: str) -> object:
        if name.startswith("__"):
            raise AttributeError(name)
        return MagicMock(name=f"{self.__name__}.{name}")


class _Missing(MetaPathFinder, Loader):
    """Finds the packages that no other finder has found."""

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        return ModuleSpec(fullname, self, is_package=True) if fullname.partition(".")[0] in PACKAGES else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return _StandIn(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """There is nothing to run."""


@contextmanager
def _stand_ins() -> Iterator[None]:
    """Stand-ins for missing packages. Modules that are imported meanwhile are removed at the end."""
    before, finder = set(sys.modules), _Missing()
    sys.meta_path.append(finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        for name in set(sys.modules) - before:
            del sys.modules[name]


def show(run: Callable[[], int]) -> int:
    """Runs a program that prints its help and exits, with stand-ins for missing packages."""
    with _stand_ins():
        try:
            return run()
        except SystemExit as done:
            return int(done.code or 0)
