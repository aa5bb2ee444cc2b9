"""Every error of the package, collected from its source. `python tests/python/test_messages.py` prints the list."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path(__file__).parents[2] / "python" / "pushbelt"
BUILTIN = {
    "ValueError",
    "KeyError",
    "FileNotFoundError",
    "ModuleNotFoundError",
    "AttributeError",
    "argparse.ArgumentTypeError",
}
"""Errors of Python that the package raises. Other errors are classes of the package."""
BROAD = {
    "fmu/unit.py",
    "fmu/untrusted.py",
    "study/worker.py",
    "tables/files.py",
    "report/side_by_side.py",
    "study/cluster.py",
}
"""Files that convert any exception of a library or a worker to an error or a reason."""
VAGUE = re.compile(
    r"\b(invalid|illegal|bad|wrong|something|unexpected|oops|please|sorry|error occurred|failed)\b", re.IGNORECASE
)


class Error(NamedTuple):
    """A statement that raises an error."""

    file: str
    line: int
    kind: str
    texts: tuple[str, ...]
    """Parts of the message. Values are in braces."""


def text(node: ast.expr) -> str:
    """A message, with the expressions of its values in braces."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(text(part.value if isinstance(part, ast.FormattedValue) else part) for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return text(node.left) + text(node.right)
    return f"{{{ast.unparse(node)}}}"


def statements() -> Iterator[tuple[str, ast.AST]]:
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            yield path.relative_to(PACKAGE).as_posix(), node


def errors() -> list[Error]:
    found = []
    for file, node in statements():
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            name, texts = ast.unparse(node.exc.func), tuple(text(argument) for argument in node.exc.args)
            found.append(Error(file, node.lineno, name, texts))
    return found


ERRORS = errors()


def test_all_errors_are_found() -> None:
    assert len(ERRORS) > 120
    kinds = {error.kind for error in ERRORS}
    assert {"StartValueError", "SteadyStateError", "LinearPointError", "UnitError", "InputFileError"} <= kinds
    classes = {node.name for _, node in statements() if isinstance(node, ast.ClassDef)}
    # `table.error` makes an error of the class DurabilityError.
    other = {kind for kind in kinds - BUILTIN if kind.rpartition(".")[2] not in {*classes, "error"}}
    assert not other, "an error that a user sees is a class of the package or ValueError"


def test_nothing_is_raised_without_a_message() -> None:
    for file, node in statements():
        if isinstance(node, ast.Raise) and node.exc is not None:
            assert isinstance(node.exc, ast.Call) and node.exc.args, f"{file}:{node.lineno}"
    assert not [error for error in ERRORS if not any(part.strip() for part in error.texts)]


def test_a_message_names_what_is_at_fault() -> None:
    for error in ERRORS:
        message, place = error.texts[0], f"{error.file}:{error.line}"
        words = re.sub(r"\{[^{}]*\}", "{}", message)
        assert not message.endswith((".", "!", " ", "\n")), f"{place}: it may be the middle of a sentence"
        assert "  " not in words and not words.startswith((" ", ":")), place
        assert not re.match(r"[A-Z][a-z]+ (is|are|has|must|not|does|cannot)\b", words), f"{place}: it follows a name"
        assert not VAGUE.search(words) or "{" in words, f"{place}: it gives the reason"
        # A message either has a value in it, or is a whole statement.
        assert "{" in words or len(words.split()) >= 4, f"{place}: it has the name, the value or the range"


def test_exceptions_of_any_kind_are_caught_only_where_they_become_reasons() -> None:
    broad = {
        file
        for file, node in statements()
        if isinstance(node, ast.ExceptHandler)
        and (node.type is None or ast.unparse(node.type) in ("Exception", "BaseException"))
    }
    assert broad <= BROAD
    assert not [
        f"{file}:{node.lineno}"
        for file, node in statements()
        if isinstance(node, ast.ExceptHandler) and node.type is None
    ]


if __name__ == "__main__":
    for one in ERRORS:
        print(f"{one.file}:{one.line}: {one.kind}: {'; '.join(one.texts)}")
