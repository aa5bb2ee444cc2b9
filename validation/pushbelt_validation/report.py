"""The report: one self-contained HTML file, the tables as CSV and Markdown, the verdicts as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pushbelt import tables
from pushbelt.report import page

from . import results as documents
from .outcome import Part, Section, Verdict
from .runs import Results


def summary(section: Section) -> dict[str, Any]:
    """The verdict of a section: `met` if all its goals are met, `reported` if there is none; and the largest share of a tolerance."""
    found = documents.counts([section], section.part)
    verdict = Verdict.MET if 0 < found["met"] == found["goals"] else Verdict.MISSED if found["goals"] else Verdict.REPORTED
    used = max((check.used for check in section.checks if check.used is not None), default=None)
    return {**found, "key": section.key, "title": section.title, "part": section.part.value, "verdict": verdict.value, "used": used}


def write(results: Results, folder: Path, misses: Mapping[str, float] | None = None) -> dict[str, Any]:
    """Writes report.html, results.json, tables.md and a CSV file for each table into a folder; returns the document."""
    folder.mkdir(parents=True, exist_ok=True)
    found = documents.document(results, misses)
    documents.write(folder / "results.json", found)
    for one in (one for section in results.sections for one in section.tables):
        tables.write(folder / f"{one.key}.csv", one.titles, one.rows)
    (folder / "tables.md").write_text(markdown(results), encoding="utf-8")
    context = {
        "results": results,
        "found": found,
        "steps": [section for section in results.sections if section.part is Part.STEPS],
        "missed": [check for check in found["checks"] if check["verdict"] == Verdict.MISSED.value],
        "summary": {section.key: summary(section) for section in results.sections},
        "sources": {s.key: list(dict.fromkeys(check.source for check in s.checks)) for s in results.sections},
    }
    page.write_html("validate.html.j2", context, folder / "report.html", Path(__file__).parent)
    return found


def markdown(results: Results) -> str:
    """All tables."""
    found = [one for section in results.sections for one in section.tables]
    return "\n".join(f"### {one.title}\n\n{documents.rows([c.heading for c in one.columns], one.shown())}" for one in found)
