"""Verdicts as data: what the command writes as JSON, what is pinned, and the page of the book that is made from it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from . import bands
from .measured import cause
from .outcome import Check, Part, Section, Verdict
from .runs import Results

ROOT = Path(__file__).parents[2]
PARTS = (Part.VERIFICATION, Part.ELEMENTS, Part.MEASUREMENTS)
"""Those with goals."""
PINNED = ROOT / "validation" / "results.json"
"""Results of the last reviewed run. `cargo fmu validate -- --pin` renews it, and the page."""
PAGE = ROOT / "docs" / "validation-results.md"


def document(results: Results, misses: Mapping[str, float] | None = None) -> dict[str, Any]:
    """Everything that the book and the pins need. `misses` are the standard deviations of `bands`."""
    steps = next((s for s in results.sections if s.part is Part.STEPS), None)
    return {
        "version": results.version,
        **{part.value: counts(results.sections, part) for part in PARTS},
        "score": round(sum(check.miss for section in results.sections if section.part is Part.MEASUREMENTS for check in section.checks), 2),
        "checks": [_check(section, check, (misses or {}).get(check.key)) for section in results.sections for check in section.checks],
        "steps": None if steps is None else {
            "told": steps.lead,
            "columns": [column.name for column in steps.tables[0].columns],
            "rows": steps.tables[0].shown(),
            "note": steps.tables[0].note,
        },
    }  # fmt: skip


def counts(sections: Iterable[Section], part: Part) -> dict[str, int]:
    """Numbers of met goals, of goals, and of values that are reported without one."""
    verdicts = [check.verdict for section in sections if section.part is part for check in section.checks]
    met, missed = verdicts.count(Verdict.MET), verdicts.count(Verdict.MISSED)
    return {"met": met, "goals": met + missed, "reported": len(verdicts) - met - missed}


def sentence(found: Mapping[str, Any]) -> str:
    """The verdicts in numbers."""
    told = ", ".join(f"{part.value}: {found[part.value]['met']} of {found[part.value]['goals']} goals met" for part in PARTS)
    return f"{told}, misses sum to {found['score']:.1f} tolerances"


def _check(section: Section, check: Check, deviation: float | None) -> dict[str, Any]:
    found = {
        "part": section.part.value, "section": section.title, "key": check.key, "statement": check.statement, "goal": check.goal,
        "found": check.found, "verdict": check.verdict.value, "source": check.source.text, "certainty": check.source.certainty,
    }  # fmt: skip
    if check.verdict is Verdict.MISSED:
        reason, decides = cause(check.key)
        found |= {"by": check.by, "miss": round(check.miss, 2), "cause": reason, "decides": decides}
        found["withinBand"] = bands.verdict(check.used, deviation)
    return found


def verdicts(found: Mapping[str, Any]) -> dict[str, str]:
    """The verdict of each goal, by its key: what is pinned."""
    return {check["key"]: check["verdict"] for check in found["checks"] if check["verdict"] != Verdict.REPORTED.value}


def write(path: Path, found: Mapping[str, Any]) -> None:
    """Writes the document as JSON."""
    path.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def pin(found: Mapping[str, Any]) -> None:
    """Renews the pinned results, the page of the book, and what other pages quote of them."""
    write(PINNED, found)
    PAGE.write_text(page(json.loads(PINNED.read_text(encoding="utf-8"))), encoding="utf-8")
    for path in telling():
        path.write_text(renewed(path.read_text(encoding="utf-8"), found), encoding="utf-8")


def telling() -> list[Path]:
    """The README and the pages of the book."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


QUOTED = {
    ("Thrust ratio without torque", "r_S/r_P 0.444, 15 kN"): r"(theory's\s+thrust\s+ratio\s+is\s+)[\d.]+(\s+and\s+the\s+belt's\s+)[\d.]+\b",
    ("Slope d ln(F_P/F_S)/d ln s near s = 1, no torque", "15 kN"): r"(d ln κ/d ln s\s+is\s+in\s+theory\s+)[\d.]+(\s+and\s+in\s+the\s+belt\s+)[\d.]+\b",
}
"""Sentences that quote the theory and the default belt from a row of the steps, by quantity and state."""


def renewed(text: str, found: Mapping[str, Any]) -> str:
    """A text with the numbers of met and missed goals of a document, and with the figures that it quotes."""
    for (quantity, state), sentence in QUOTED.items():
        row = next((row for row in found["steps"]["rows"] if row[:2] == [quantity, state]), None) if found.get("steps") else None
        if row:
            theory, belt = (f"{float(row[k]):.2f}" for k in (2, -1))
            text = re.sub(sentence, rf"\g<1>{theory}\g<2>{belt}", text)
    for part in (part.value for part in PARTS):
        met, goals = found[part]["met"], found[part]["goals"]
        text = re.sub(rf"(?i)({part}: )\d+ of \d+( goals met)", rf"\g<1>{met} of {goals}\g<2>", text)
        text = re.sub(r"(misses sum to )[\d.]+( tolerances)", rf"\g<1>{found['score']:.1f}\g<2>", text)
        text = re.sub(rf"(?i)({part}: {met} of {goals} goals met\W*)\d+ missed", rf"\g<1>{goals - met} missed", text)
    return text


# The page of the book


def page(found: Mapping[str, Any]) -> str:
    """The page, from the document."""
    of = {part.value: [check for check in found["checks"] if check["part"] == part.value] for part in PARTS}
    missed = [check for check in of["measurements"] if check["verdict"] == "missed"]
    others = [check for check in of["measurements"] if check["verdict"] != "missed"]
    sources = list(dict.fromkeys(f"{check['source']}: {check['certainty']}" for check in others))
    steps = found["steps"]
    parts = [
        "# Results of the validation\n",
        f"Written by `cargo fmu validate -- --pin`; do not edit. {capital(sentence(found))}.\n",
        "## From the theory to the belt\n",
        f"{steps['told']} {steps['note']}\n",
        rows(steps["columns"], steps["rows"]),
        "## Verification\n",
        rows(("theory in its limit", "goal", "found", "verdict"), [[c["statement"], c["goal"], c["found"], c["verdict"]] for c in of["verification"]]),
        "## Against single elements\n",
        rows(
            ("of the default belt", "goal", "found", "verdict"),
            [[c["statement"], c["goal"], with_worst(c), c["verdict"]] for c in of["single elements"]],
        ),
        "Causes of the missed goals, as far as they are known:\n",
        numbered(f"**{c['statement']}**: {c['cause']}." for c in of["single elements"] if c["verdict"] == "missed"),
        "## Measurements: missed goals\n",
        "The list below the table has the cause of each miss, as far as it is known, and the measurement on a rig that would decide it. The last "
        "column: whether the goal is met within the 95 % band of the default belt, by the known deviations of its parameters.\n",
        rows(
            ("", "goal", "allowed", "found", "values that miss", "worst value", "miss, tolerances", "met within the band"),
            [
                [k, c["statement"], c["goal"], c["found"].split(", ")[0], *outside(c), f"{c['miss']:.2f}", c["withinBand"]]
                for k, c in enumerate(missed, 1)
            ],
        ),
        numbered(f"{capital(c['cause'])}. Measurement: {c['decides']}." for c in missed),
        "## Measurements: met goals and reported values\n",
        rows(
            ("statement", "goal", "found", "verdict", "source"),
            [[c["statement"], c["goal"], c["found"], c["verdict"], sources.index(f"{c['source']}: {c['certainty']}") + 1] for c in others],
        ),
        "Sources, each with its certainty:\n",
        numbered(f"{capital(source)}." for source in sources),
    ]  # fmt: skip
    return "\n".join(parts)


def outside(check: Mapping[str, Any]) -> tuple[str, str]:
    """Number of values outside of a goal, and the worst value; empty texts for a single value and for a goal that is met."""
    head, _, worst = check.get("by", "").split("; ")[0].partition(": ")
    count = head.split(",")[0]
    return ("", "") if not head or count.startswith("1 of 1 ") else (count, worst)


def with_worst(check: Mapping[str, Any]) -> str:
    """The values of a check, and the worst of those outside of its goal."""
    count, worst = outside(check)
    return f"{check['found']}; {count}: {worst}" if count else check["found"]


def capital(text: str) -> str:
    """A text that begins with a capital letter."""
    return text[:1].upper() + text[1:]


def numbered(lines: Iterable[str]) -> str:
    """A numbered list in Markdown."""
    return "".join(f"{k}. {line}\n" for k, line in enumerate(lines, 1))


def rows(header, lines) -> str:
    """A table in Markdown."""
    every = [list(header), ["---"] * len(list(header)), *map(list, lines)]
    return "".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |\n" for line in every)
