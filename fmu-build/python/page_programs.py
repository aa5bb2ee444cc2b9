"""Programs of the book's pages with what they print. `PUSHBELT_FMU=target/PushbeltVariator.fmu PYTHONPATH=python target/venv/bin/python
fmu-build/python/page_programs.py` renews the pages."""

from __future__ import annotations

import contextlib
import io
import os
import re
import tempfile
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[2] / "docs"
PAGES = ("introduction.md", "linear.md", "python.md")
PROGRAM = re.compile(r"```python\n((?:(?!```).)*?)```\n\n(?:It prints:\n\n```\n|prints\n\n```\n|prints `)(.*?)(?=```|`\.)", re.DOTALL)


def renewed(page: str) -> str:
    """A page with what its programs print with the FMU that `PUSHBELT_FMU` names. They share their names."""
    names: dict[str, Any] = {}

    def run(found: re.Match[str]) -> str:
        printed = io.StringIO()
        code = found[1].replace("target/PushbeltVariator.fmu", Path(os.environ["PUSHBELT_FMU"]).as_posix())
        with contextlib.redirect_stdout(printed):
            exec(compile(code, page, "exec"), names)
        # fmpy warns of speed set points that are not wired.
        text = re.sub(r"^Warning: .*\n", "", printed.getvalue(), flags=re.MULTILINE)
        start = found.start(2) - found.start()
        return found[0][:start] + (text if found[0][start - 1] == "\n" else text.rstrip())

    return PROGRAM.sub(run, (DOCS / page).read_text(encoding="utf-8"))


if __name__ == "__main__":
    os.environ["PUSHBELT_FMU"] = str(Path(os.environ["PUSHBELT_FMU"]).resolve())
    os.chdir(tempfile.mkdtemp())
    for page in PAGES:
        (DOCS / page).write_text(renewed(page), encoding="utf-8")
