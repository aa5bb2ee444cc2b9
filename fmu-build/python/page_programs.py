"""Programs of the book's pages with what they print, and the example table of `calibrate --template`. `PYTHONPATH=python
PUSHBELT_FMU=target/PushbeltVariator.fmu target/venv/bin/python fmu-build/python/page_programs.py` renews them."""

from __future__ import annotations

import contextlib
import io
import os
import re
import tempfile
from pathlib import Path
from typing import Any

from pushbelt.calibrate import worker
from pushbelt.fmu.data import parameter_set
from pushbelt.fmu.unit import Archive
from pushbelt.report.style import RPM
from pushbelt.tables.columns import EXAMPLES
from pushbelt.tables.points import Measured, Point

DOCS = Path(__file__).parents[2] / "docs"
PAGES = ("introduction.md", "levels.md", "linear.md", "python.md", "studies.md")
PROGRAM = re.compile(r"```python\n((?:(?!```).)*?)```\n\n(?:It prints:\n\n```\n|prints\n\n```\n|prints `)(.*?)(?=```|`\.)", re.DOTALL)

HEADER = (
    "name,ratio.geometric,primary.speed [rpm],primary.torque [N.m],secondary.clampingForce [kN],primary.clampingForce [kN],"
    "thrustRatio,slip [%],slip.sd [%],efficiency [%],ds/dt [1/s]\n"
)
STEADY = {
    "underdrive,2,1500,60,14": ",,{thrustRatio:.3f},{slip:.2f},,,",
    "ratio 1,1,2000,50,9": ",,{thrustRatio:.3f},,,{efficiency:.1f},",
    "overdrive,0.5,2000,40,10": ",{force:.2f},,{slip:.2f},0.05,,",
}
SHIFT = "upshift,1,1000,0,20,26"
"""Lines of the example table: name, ratio, speed in rpm, torque in N·m, secondary and primary force in kN; and what is measured."""


def example_table() -> str:
    """The example table of `calibrate --template`, as the FMU has it with `bench168`."""
    fmu, parameters = Path(os.environ["PUSHBELT_FMU"]), parameter_set("bench168")
    with Archive.unpack(fmu) as archive:

        def solved(line: str, quantity: str, primary_force: float | None = None, value: float = 0.0) -> dict[str, float]:
            name, *numbers = line.split(",")
            ratio, speed, torque, force = map(float, numbers[:4])
            measured = (Measured(quantity, value, 1.0, True),)
            point = Point(0, name, ratio, None, speed / RPM, torque, 1e3 * force, primary_force, measured)
            return dict(worker.solve(fmu, archive.directory, parameters, point).values)

        text = HEADER
        for line, form in STEADY.items():
            found = solved(line, "slip")
            percent = {name: 100.0 * found[name] for name in ("slip", "efficiency")}
            force = found["thrustRatio"] * float(line.split(",")[4])
            text += line + form.format(thrustRatio=found["thrustRatio"], force=force, **percent) + "\n"
        rate = 0.0
        # A shift starts at a ratio from which it passes the point's ratio if it shifts as measured.
        for _ in range(3):
            rate = solved(SHIFT, "ds/dt", 26e3, rate)["ds/dt"]
        return f"{text}{SHIFT},,,,,{rate:.3f}\n"


def renewed(page: str) -> str:
    """A page with what its programs print with the FMU that `PUSHBELT_FMU` names, and with that of maps beside it. They share their names."""
    names: dict[str, Any] = {}

    def run(found: re.Match[str]) -> str:
        printed = io.StringIO()
        fmu = Path(os.environ["PUSHBELT_FMU"])
        maps = Path(os.environ.get("PUSHBELT_MAP_FMU", fmu.with_name("PushbeltMap.fmu")))
        code = found[1].replace("target/PushbeltVariator.fmu", fmu.as_posix()).replace("target/PushbeltMap.fmu", maps.as_posix())
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
    EXAMPLES.write_text(example_table(), encoding="utf-8")
    for page in PAGES:
        (DOCS / page).write_text(renewed(page), encoding="utf-8")
