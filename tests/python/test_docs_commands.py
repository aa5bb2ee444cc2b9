"""The book's command lines against the parsers, its generated pages against their sources, and the files that it names."""

import importlib
import json
import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pushbelt import cli
from pushbelt.calibrate.parameters import DEFAULT
from pushbelt.fmu.data import parameter_set

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "examples" / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
TOOL = (ROOT / "fmu-build" / "src" / "commands" / "program.rs").read_text(encoding="utf-8")

sys.path.insert(0, str(ROOT / "fmu-build" / "python"))
reference, page_programs = map(importlib.import_module, ("book", "page_programs"))


def modules() -> dict[tuple[str, str], str]:
    """The Python module behind a command of `cargo fmu`, by its name and the option that selects another one."""
    found = {}
    for name, rest in re.findall(r'Program \{\s+name: "(\w+)",(.*?)\n    \}', TOOL, re.DOTALL):
        found |= {(name, ""): module for module in re.findall(r'module: "([\w.]+)"', rest)}
        found |= {(name, option): module for option, module in re.findall(r'\("(--\w+)", &\["([\w.]+)"', rest)}
    return found


def lines() -> Iterator[tuple[str, str]]:
    """Command lines of all pages, in fenced blocks and between backticks, each with its page."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for language, block in re.findall(r"```(\w*)\n(.*?)```", text, re.DOTALL):
            yield from ((page.name, line.split(" # ")[0].strip()) for line in block.splitlines() if not language)
        yield from ((page.name, span) for span in re.findall(r"(?<!`)`([^`\n]+)`(?!`)", text))


def program_lines() -> list[tuple[str, str]]:
    """Those that start a Python program and have more than its name."""
    named = "|".join({*cli.PROGRAMS, *(name for name, _ in modules())})
    starts = re.compile(rf"(pushbelt [a-z]|cargo fmu ({named})\b)\S* \S")
    return sorted({(page, line) for page, line in lines() if starts.match(line) and "…" not in line and "COMMAND" not in line})


@pytest.mark.parametrize(("page", "line"), program_lines())
def test_a_command_line_of_the_book_is_one_of_its_program(page: str, line: str) -> None:
    words = shlex.split(line)
    own = words[0] == "pushbelt"
    name, words = (words[1], words[2:]) if own else (words[2], words[3:])
    words = words[1:] if words[:1] == ["--"] else words
    other = next((modules()[name, word] for word in words if (name, word) in modules()), None)
    if name == "bench" and other is None:
        source = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "benches" / "variator").rglob("*.rs"))
        for option in (word[2:].replace("-", "_") for word in words if word.startswith("--")):
            assert re.search(rf"\b{option}: ", source), f"{page}: cargo fmu bench has no --{option}"
        return
    words = [word for word in words if (name, word) not in modules()]
    if other is None and (own or name in cli.PROGRAMS):
        parser = reference.parser_of(cli.main, [name, *words, *["--fmu", "x.fmu"] * (name in cli.PROGRAMS)])
        words = words if name in cli.PROGRAMS else [name, *words]
    else:
        module = importlib.import_module(other or modules()[name, ""])
        program = importlib.import_module(f"{module.__name__}.__main__") if hasattr(module, "__path__") else module
        parser = reference.parser_of(program.main, words)
    # `cargo fmu` adds the other options that a program requires.
    needed = [action.option_strings for action in parser._actions if action.required and action.option_strings]
    parser.parse_args([*words, *(word for options in needed if not {*options} & {*words} for word in (options[-1], "x"))])


@pytest.mark.parametrize("page", reference.PAGES)
def test_generated_pages_are_up_to_date(page: str) -> None:
    written = (ROOT / "docs" / page).read_text(encoding="utf-8")
    assert written == reference.PAGES[page](), f"write docs/{page} anew by `cargo fmu describe`"


@pytest.mark.parametrize("page", page_programs.PAGES)
def test_programs_of_a_page_print_what_stands_there(page: str, fmu: Path, map_fmu: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PUSHBELT_FMU", str(fmu))
    monkeypatch.setenv("PUSHBELT_MAP_FMU", str(map_fmu))
    monkeypatch.chdir(tmp_path)
    assert page_programs.renewed(page) == (page_programs.DOCS / page).read_text(encoding="utf-8")


def test_the_template_of_a_calibration_fits_the_present_model(fmu: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PUSHBELT_FMU", str(fmu))
    written = page_programs.EXAMPLES.read_text(encoding="utf-8")
    assert written == page_programs.example_table(), "write the table anew by fmu-build/python/page_programs.py"
    table, out = tmp_path / "points.csv", tmp_path / "out"
    assert cli.main(["calibrate", "--template", str(table)]) == 0
    assert table.read_text(encoding="utf-8").endswith(written)
    assert cli.main(["calibrate", str(table), "--fmu", str(fmu), "--output", str(out)]) == 0
    found = json.loads((out / "parameters.json").read_text(encoding="utf-8"))["parameters"]
    for name, value in parameter_set("bench168").items():
        assert found[name]["value"] == pytest.approx(value, rel=0.02)
        assert (found[name]["origin"] == "calibrated") == (name in DEFAULT)


def test_files_that_the_book_names_are_there() -> None:
    missing = []
    for page, line in lines():
        for path in re.findall(r"(?<![\w/.])(?:examples|tests|docs|python|crates|map-unit|src|benches|resources|fmu-build)/[\w./-]*\w", line):
            missing += [f"{page}: {path}"] * (not (ROOT / path).exists())
        for kind, name in re.findall(r"--(example|test) ([a-z]\w+)", line):
            places = [ROOT / f"{kind}s", ROOT / "paper" / f"{kind}s", ROOT / "map-unit" / f"{kind}s"]
            there = any((place / found).exists() for place in places for found in (f"{name}.rs", name))
            missing += [f"{page}: --{kind} {name}"] * (not there)
    assert not missing


@pytest.mark.parametrize(("page", "program"), [("controllers.md", "controller.py"), ("linear.md", "linear_control.py")])
def test_a_controller_on_a_page_is_that_of_the_example(page: str, program: str) -> None:
    shown = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.DOTALL)
    code = {line.strip() for line in (ROOT / "examples" / "drivetrain" / program).read_text(encoding="utf-8").splitlines()}
    assert [len(lines) > 4 for one in shown if {*map(str.strip, lines := one.splitlines())} <= code] == [True]
