"""The package, read from its source: imports between its parts, errors and their messages, version and data."""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Iterator
from xml.etree import ElementTree

import pytest
from conftest import ROOT

import pushbelt

PACKAGE = ROOT / "python" / "pushbelt"
PROGRAMS = (
    "belt", "calibrate", "compare", "demo", "drive", "durability", "linearize", "maps", "sweep",
)  # fmt: skip
MODULES = {
    ".".join(("pushbelt", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}


LIBRARY = {f"pushbelt.{name}" for name in ("input_table", "points", "recording", "variator")}
"""Modules of what `pushbelt` exports, besides the packages `fmu`, `linear` and `maps`."""
NOT_RAISED_BY_CALLS = {"NotFoundError"}
"""Errors of modules in `pushbelt.fmu` that serve the programs."""


BUILTIN = {
    "ValueError", "KeyError", "FileNotFoundError", "ModuleNotFoundError", "AttributeError", "argparse.ArgumentTypeError",
}  # fmt: skip
"""Errors of Python that the package raises. Other errors are classes of the package."""
BROAD = {
    f"pushbelt.{name}"
    for name in ("fmu.unit", "fmu.untrusted", "study.worker", "tables.files", "report.side_by_side", "study.cluster")
}
"""Modules that convert any exception of a library or a worker to an error or a reason."""
VAGUE = re.compile(r"\b(invalid|illegal|bad|wrong|something|unexpected|oops|please|sorry|error occurred|failed)\b", re.IGNORECASE)


def part_of(module: str) -> str:
    """Part of a module: a package, or `shared` for the modules at the top."""
    names = module.split(".")
    if module == "pushbelt.whole_file":
        return "errors"
    return names[1] if len(names) > 1 and names[1] in MAY_IMPORT else "shared"


def imported(module: str) -> set[str]:
    """Modules of this package that a module imports, at the top or inside a function."""
    path, found = MODULES[module], set()
    here = module.split(".") if path.name == "__init__.py" else module.split(".")[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else []
            source = ".".join([*base, *(node.module or "").split(".")]).strip(".")
            found |= {source, *(f"{source}.{alias.name}" for alias in node.names)}
    return found & MODULES.keys() - {module}


LOW = {"errors", "fmu", "shared", "linear", "study", "maps", "tables"}
MAY_IMPORT = {
    "errors": set(), "fmu": {"errors", "fmu"}, "shared": LOW, "linear": LOW, "study": LOW,
    "maps": {*LOW, "cli"}, "tables": LOW, "cli": {*LOW, "cli"},
} | {program: {*LOW, "cli", program} for program in PROGRAMS}  # fmt: skip


def test_imports_go_one_way() -> None:
    """Programs import what is below them, and not each other."""
    assert {part_of(module) for module in MODULES} == MAY_IMPORT.keys()
    for module in MODULES:
        wrong = {other for other in imported(module) if part_of(other) not in MAY_IMPORT[part_of(module)]}
        # The version is read from the package itself.
        assert wrong - {"pushbelt"} == set(), module


def test_no_module_imports_itself_in_a_circle() -> None:
    # A package imports its modules, and they name it when they import each other: that is no circle.
    graph = {
        module: {other for other in imported(module) if MODULES[other].name != "__init__.py"} for module in MODULES
    }
    while graph:
        leaves = {module for module, others in graph.items() if not others & graph.keys()}
        assert leaves, f"a circle among {sorted(graph)}"
        graph = {module: others for module, others in graph.items() if module not in leaves}


def test_every_error_has_the_base_class() -> None:
    for module in MODULES:
        if not module.endswith("__main__"):
            for name, found in vars(importlib.import_module(module)).items():
                if isinstance(found, type) and issubclass(found, Exception) and found.__module__.startswith("pushbelt"):
                    assert issubclass(found, (pushbelt.PushbeltError, Warning)), f"{module}.{name}"


def text(node: ast.expr) -> str:
    """A message, with the expressions of its values in braces."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(text(part.value if isinstance(part, ast.FormattedValue) else part) for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return text(node.left) + text(node.right)
    return f"{{{ast.unparse(node)}}}"


def statements(kind: type[ast.AST]) -> Iterator[tuple[str, str, ast.AST]]:
    """Modules, places and nodes of a kind."""
    for module, path in MODULES.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, kind):
                yield module, f"{path.relative_to(PACKAGE)}:{node.lineno}", node


def test_errors_have_a_known_class_and_say_what_is_at_fault() -> None:
    classes = {node.name for _, _, node in statements(ast.ClassDef)}
    programs = ("__main__", "report", "files", "figures", "lines", "plan")
    found = 0
    for module, place, node in statements(ast.Raise):
        if node.exc is None:
            continue
        assert isinstance(node.exc, ast.Call) and node.exc.args, f"{place}: it has a message"
        name, message, found = ast.unparse(node.exc.func), text(node.exc.args[0]), found + 1
        # `table.error` makes an error of the class DurabilityError.
        assert name in BUILTIN or name.rpartition(".")[2] in {*classes, "error"}, f"{place}: a class of the package or ValueError"
        if (part_of(module) in ("fmu", "linear", "maps") or module in LIBRARY) and not module.endswith(programs) and "." not in name:
            assert name in {*pushbelt.__all__, *NOT_RAISED_BY_CALLS}, f"{place}: the library raises what it exports"
        words = re.sub(r"\{[^{}]*\}", "{}", message)
        assert not message.endswith((".", "!", " ", "\n")), f"{place}: it may be the middle of a sentence"
        assert "  " not in words and not words.startswith((" ", ":")), place
        assert not re.match(r"[A-Z][a-z]+ (is|are|has|must|not|does|cannot)\b", words), f"{place}: it follows a name"
        assert not VAGUE.search(words) or "{" in words, f"{place}: it gives the reason"
        assert "{" in words or len(words.split()) >= 4, f"{place}: it has the name, the value or the range"
    assert found > 120


def test_exceptions_of_any_kind_are_caught_only_where_they_become_reasons() -> None:
    for module, place, node in statements(ast.ExceptHandler):
        assert node.type is not None, place
        assert ast.unparse(node.type) not in ("Exception", "BaseException") or module in BROAD, place


def test_version_is_that_of_the_model_description() -> None:
    description = ElementTree.parse(ROOT / "modelDescription.xml").getroot()
    assert pushbelt.__version__ == description.get("version")


def test_project_takes_its_version_and_data_from_the_package() -> None:
    tomllib = pytest.importorskip("tomllib", reason="Python 3.10 has no tomllib")
    project = tomllib.loads((ROOT / "python" / "pyproject.toml").read_text(encoding="utf-8"))
    assert "version" not in project["project"]
    assert project["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "pushbelt._version.__version__"}
    packages = {path.parent for path in PACKAGE.rglob("__init__.py")}
    listed = {
        path
        for name, patterns in project["tool"]["setuptools"]["package-data"].items()
        for folder in (packages if name == "*" else [ROOT.joinpath("python", *name.split("."))])
        for pattern in patterns
        for path in folder.glob(pattern)
    }
    data = {
        path
        for path in PACKAGE.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and (path.suffix != ".py" or path.parent not in packages)
    }
    assert listed == data
