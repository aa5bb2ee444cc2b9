"""The report: one self-contained HTML file, the tables as CSV, and everything as Markdown for the docs."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from pushbelt import page, tables

from . import figures
from .outcome import Check, Section, Table, Verdict
from .runs import Results

CHECKS = "checks.csv"


def write(results: Results, folder: Path) -> Path:
    """Writes all files into a folder; returns the path of the report."""
    folder.mkdir(parents=True, exist_ok=True)
    _write_checks(results, folder / CHECKS)
    for table in (table for section in results.sections for table in section.tables):
        tables.write(folder / f"{table.key}.csv", table.titles, table.rows)
    (folder / "tables.md").write_text(markdown(results), encoding="utf-8")
    path = folder / "report.html"
    context = {
        "results": results,
        "verdicts": {verdict.value: count for verdict, count in counts(results).items()},
        "summary": [summary(section) for section in results.sections],
        "sources": {s.key: list(dict.fromkeys(check.source for check in s.checks)) for s in results.sections},
        "pictures": {s.key: [(figures.draw(p), p.caption) for p in s.pictures] for s in results.sections},
    }
    page.write_html("validate/validate.html.j2", context, path)
    return path


@dataclass(frozen=True)
class Summary:
    """The verdict of a quantity: `meets` if all goals of its section are met, `reported` if there is none."""

    key: str
    title: str
    verdict: str
    met: int
    goals: int
    missed: str
    """Statement of the first missed goal."""
    used: float | None = None
    """Largest share of a tolerance that is used."""


def summary(section: Section) -> Summary:
    """The verdict of a section."""
    missed = [check for check in section.checks if check.verdict is Verdict.MISSES]
    met = sum(check.verdict is Verdict.MEETS for check in section.checks)
    verdict = Verdict.MISSES if missed else Verdict.MEETS if met else Verdict.REPORTED
    text = missed[0].statement if missed else ""
    used = max((check.used for check in section.checks if check.used is not None), default=None)
    return Summary(section.key, section.title, verdict.value, met, met + len(missed), text, used)


def counts(results: Results) -> Counter[Verdict]:
    """Number of checks by verdict."""
    return Counter(check.verdict for section in results.sections for check in section.checks)


def _write_checks(results: Results, path: Path) -> None:
    header = ("section", "statement", "goal", "found", "verdict", "by", "source", "certainty", "used [1]")
    rows = [
        (section.title, c.statement, c.goal, c.found, c.verdict.value, c.by, c.source.text, c.source.certainty, c.used)
        for section in results.sections
        for c in section.checks
    ]
    tables.write(path, header, rows)


# Markdown for the docs


def markdown(results: Results) -> str:
    """All checks and tables."""
    return "\n".join(part for section in results.sections for part in _markdown_section(section))


def _markdown_section(section: Section) -> list[str]:
    lines = [
        f"## {section.title}\n",
        _markdown_rows(("statement", "goal", "found", "verdict"), map(_markdown_check, section.checks)),
    ]
    for table in section.tables:
        lines += [f"### {table.title}\n", _markdown_table(table)]
    return lines


def _markdown_check(check: Check) -> tuple[str, ...]:
    verdict = f"{check.verdict.value}: {check.by}" if check.by else check.verdict.value
    return check.statement, check.goal, check.found, verdict


def _markdown_table(table: Table) -> str:
    return _markdown_rows([column.heading for column in table.columns], table.shown())


def _markdown_rows(header, rows) -> str:
    lines = [list(header), ["---"] * len(header), *map(list, rows)]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)
