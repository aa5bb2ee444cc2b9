"""Writes docs/commands.md and docs/python-interface.md from the parsers and docstrings of the package. `cargo fmu describe` runs it."""

from __future__ import annotations

import argparse
import dataclasses
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pushbelt
from pushbelt import cli
from pushbelt.calls import Program

DOCS = Path(__file__).parents[2] / "docs"
WRITTEN = "<!-- Written by `cargo fmu describe`: don't edit. -->\n\n"


class Parsed(BaseException):
    """A program has got to its command line. The argument is its parser."""


@contextmanager
def stopping() -> Iterator[None]:
    """Programs end with `Parsed` where they would parse their words."""

    def parse(self: argparse.ArgumentParser, *_: Any) -> None:
        raise Parsed(self)

    kind, names = argparse.ArgumentParser, ("parse_args", "parse_intermixed_args")
    originals = {name: getattr(kind, name) for name in names}
    try:
        for name in names:
            setattr(kind, name, parse)
        yield
    finally:
        for name, original in originals.items():
            setattr(kind, name, original)


def parser_of(main: Callable[[list[str]], int], words: list[str]) -> argparse.ArgumentParser:
    """The parser of a program."""
    try:
        with stopping():
            main(words)
    except Parsed as parsed:
        return parsed.args[0]
    raise RuntimeError(f"{main.__module__} {words} parses no command line")


def parsers() -> dict[str, argparse.ArgumentParser]:
    """The parser of each command of `pushbelt`."""
    own = next(action.choices for action in cli.parser()._actions if isinstance(action, argparse._SubParsersAction))
    found = {name: parser_of(cli.main, [name, "--fmu", "none.fmu"]) for name in cli.PROGRAMS}
    return found | {name: parser for name, parser in own.items() if name not in found}


def commands() -> str:
    """The page of all commands."""
    text = "# Commands\n\nAll commands of `pushbelt`. In the source tree `cargo fmu COMMAND` takes the same words for the programs among them; "
    text += "`cargo fmu --help` lists the others.\n"
    for name, parser in parsers().items():
        text += f"\n## pushbelt {name}\n\n{(parser.description or '').strip()}\n\n| | |\n|---|---|\n"
        for action in parser._actions:
            if action.help in (None, argparse.SUPPRESS) or action.dest == "help":
                continue
            value = action.metavar or ("|".join(map(str, action.choices)) if action.choices else action.dest.upper())
            value = "" if action.nargs == 0 else " ".join(value) if isinstance(value, tuple) else value
            title = f"{', '.join(action.option_strings)} {value}".strip()
            meaning = " ".join((action.help % {**vars(action), "prog": parser.prog}).split())
            text += "| `{}` | {} |\n".format(title.replace("|", "\\|"), meaning)
    return WRITTEN + text


def told(thing: Any, *, whole: bool = False) -> str:
    """The docstring of an object, or its first paragraph in one line. One that Python writes for a dataclass is none."""
    text = inspect.getdoc(thing) or ""
    if inspect.isclass(thing) and text.startswith(f"{thing.__name__}("):
        return ""
    return text if whole else " ".join(text.split("\n\n")[0].split())


def signature(name: str, function: Any) -> str:
    """Name and arguments of a function, without types."""
    found = inspect.signature(function)
    bare = [one.replace(annotation=one.empty) for one in found.parameters.values() if one.name not in ("self", "cls")]
    return re.sub(r"=<[^,)]*>", "=…", f"{name}{found.replace(parameters=bare, return_annotation=found.empty)}")


def item(title: str, thing: Any) -> str:
    """An item of a list: an object with all paragraphs of its docstring."""
    return textwrap.indent(f"- `{title}`: {told(thing, whole=True)}", "  ", lambda line: not line.startswith("- ") and bool(line.strip()))


def members(kind: type) -> Iterator[str]:
    """A line for each public field, property and method of a class."""
    if dataclasses.is_dataclass(kind):
        yield from (
            f"- `{field.name}`: `{field.type}`" for field in dataclasses.fields(kind) if not field.name.startswith("_")
        )
    own = [base for base in kind.__mro__ if base.__module__.startswith("pushbelt")]
    for name in dict.fromkeys(name for base in own for name in vars(base) if not name.startswith("_")):
        member = inspect.getattr_static(kind, name)
        function = getattr(member, "__func__", member)
        if inspect.isfunction(function):
            yield item(signature(name, function), function)
        elif hasattr(member, "__get__") and told(member):
            yield item(name, member)


def interface() -> str:
    """The page of the Python interface."""
    named = {name: getattr(pushbelt, name) for name in sorted(pushbelt.__all__) if not name.startswith("_")}
    text = "# The Python interface\n\nEverything that `import pushbelt` offers. [Python](python.md) explains how to use it.\n"
    for name, thing in named.items():
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            lines = list(members(thing))
            title = signature(name, thing.__init__) if "__init__" in vars(thing) else name
            text += f"\n## {name}\n\n`{title}`\n\n{told(thing, whole=True)}\n\n" + "".join(f"{line}\n" for line in lines)
    text += "\n## Functions\n\n"
    text += "".join(f"{item(signature(name, one), one)}\n" for name, one in named.items() if inspect.isfunction(one))
    text += f"\n## Programs\n\n{told(Program, whole=True)}\n\n"
    text += "".join(f"- `{signature(name, one)}`\n" for name, one in named.items() if isinstance(one, Program))
    text += "\n## Errors and warnings\n\n| name | bases | meaning |\n|---|---|---|\n"
    for name, thing in named.items():
        if inspect.isclass(thing) and issubclass(thing, Exception):
            text += f"| `{name}` | {', '.join(f'`{base.__name__}`' for base in thing.__bases__)} | {told(thing)} |\n"
    return WRITTEN + re.sub(r"\n{3,}", "\n\n", text)


PAGES = {"commands.md": commands, "python-interface.md": interface}

if __name__ == "__main__":
    for name, page in PAGES.items():
        (DOCS / name).write_text(page(), encoding="utf-8")
        print(DOCS / name)
