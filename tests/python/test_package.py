"""The package, read from its source: imports between its parts, errors and their messages, version and data."""

import ast
import importlib
from xml.etree import ElementTree

from conftest import ROOT

import pushbelt

PACKAGE = ROOT / "python" / "pushbelt"
PROGRAMS = ("belt", "calibrate", "compare", "demo", "drive", "durability", "linearize", "maps", "sweep")
MODULES = {".".join(("pushbelt", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__"): path for path in sorted(PACKAGE.rglob("*.py"))}

LIBRARY = {f"pushbelt.{name}" for name in ("points", "recording", "variator")}
"""Modules of what `pushbelt` exports, besides the packages `fmu`, `linear` and `maps`."""
BUILTIN = {"ValueError", "KeyError", "FileNotFoundError", "ModuleNotFoundError", "AttributeError", "argparse.ArgumentTypeError"}
"""Errors of Python that the package raises. Other errors are classes of the package."""
BROAD = {f"pushbelt.{name}" for name in ("fmu.unit", "fmu.untrusted", "study.tasks", "tables.files", "report.side_by_side", "study.cluster")}
"""Modules that convert any exception of a library or a worker to an error or a reason."""
TREES = {module: ast.parse(path.read_text(encoding="utf-8")) for module, path in MODULES.items()}
LOW = {"errors", "fmu", "shared", "linear", "study", "maps", "tables"}
MAY_IMPORT = {
    "errors": {"errors"}, "fmu": {"errors", "fmu"}, "shared": LOW, "linear": LOW, "study": LOW,
    "maps": {*LOW, "cli"}, "tables": LOW, "cli": {*LOW, "cli"},
} | {program: {*LOW, "cli", program} for program in PROGRAMS}  # fmt: skip


def part_of(module: str) -> str:
    """Part of a module: a package, or `shared` for the modules at the top."""
    names = module.split(".")
    if module in ("pushbelt.arguments", "pushbelt.whole_file"):
        return "errors"
    if module == "pushbelt.__main__":
        return "cli"
    return names[1] if len(names) > 1 and names[1] in MAY_IMPORT else "shared"


def imported(module: str) -> set[str]:
    """Modules of this package that a module imports, at the top or inside a function."""
    found = set()
    here = module.split(".") if MODULES[module].name == "__init__.py" else module.split(".")[:-1]
    for node in ast.walk(TREES[module]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else []
            source = ".".join([*base, *(node.module or "").split(".")]).strip(".")
            found |= {source, *(f"{source}.{alias.name}" for alias in node.names)}
    return found & MODULES.keys() - {module}


def test_imports_go_one_way() -> None:
    """Programs import what is below them, and not each other."""
    assert {part_of(module) for module in MODULES} == MAY_IMPORT.keys()
    for module in MODULES:
        wrong = {other for other in imported(module) if part_of(other) not in MAY_IMPORT[part_of(module)]}
        # The version is read from the package itself.
        assert wrong - {"pushbelt"} == set(), module


def test_every_error_has_the_base_class() -> None:
    for module in MODULES:
        if not module.endswith("__main__"):
            for name, found in vars(importlib.import_module(module)).items():
                if isinstance(found, type) and issubclass(found, Exception) and found.__module__.startswith("pushbelt"):
                    assert issubclass(found, (pushbelt.PushbeltError, Warning)), f"{module}.{name}"


def test_errors_have_a_known_class_and_a_message() -> None:
    """Exceptions of any kind are caught only where they become reasons."""
    classes = {node.name for tree in TREES.values() for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
    programs = ("__main__", "report", "files", "figures", "lines", "plan")
    for module, node in ((module, node) for module, tree in TREES.items() for node in ast.walk(tree)):
        place = f"{module}:{getattr(node, 'lineno', 0)}"
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, place
            assert ast.unparse(node.type) not in ("Exception", "BaseException") or module in BROAD, place
        if not isinstance(node, ast.Raise) or node.exc is None:
            continue
        assert isinstance(node.exc, ast.Call) and node.exc.args, f"{place}: it has a message"
        name = ast.unparse(node.exc.func)
        assert name in BUILTIN or name.rpartition(".")[2] in classes, f"{place}: a class of the package or ValueError"
        if (part_of(module) in ("fmu", "linear", "maps") or module in LIBRARY) and not module.endswith(programs) and "." not in name:
            assert name in pushbelt.__all__, f"{place}: the library raises what it exports"
        message = ast.unparse(node.exc.args[0]).removeprefix("f").strip("'\"")
        assert not message.endswith((".", "!", " ", "\\n")), f"{place}: it may be the middle of a sentence"
        assert len(message.split()) >= 4 or not isinstance(node.exc.args[0], ast.Constant), f"{place}: it has the name, the value or the range"


def test_version_is_that_of_the_model_description() -> None:
    assert pushbelt.__version__ == ElementTree.parse(ROOT / "modelDescription.xml").getroot().get("version")
    assert 'version = { attr = "pushbelt._version.__version__" }' in (ROOT / "python" / "pyproject.toml").read_text(encoding="utf-8")
