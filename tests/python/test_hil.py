"""The program for rigs: it runs the FMU's library in real time, and a unit without a time reserve is not late."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from conftest import ROOT

LOADS = ["smooth", "firing", "ripple", "noise", "slam", "launch", "flips", "stairs", "firing-and-noise", "hunting"]
SOURCE = ROOT / "examples" / "hil" / "hil.c"


@pytest.mark.skipif(sys.platform != "linux", reason="the program needs Linux")
@pytest.mark.skipif(shutil.which("cc") is None, reason="the program needs a C compiler")
def test_the_program_runs_the_library_and_counts(fmu: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path)
    guid = re.search(r'guid="([^"]+)"', (tmp_path / "modelDescription.xml").read_text(encoding="utf-8"))
    assert guid
    program = tmp_path / "hil"
    command = ["cc", "-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-o", program, SOURCE, "-ldl", "-lm"]
    subprocess.run(command, check=True)
    library = tmp_path / "binaries" / "linux64" / "PushbeltVariator.so"
    run = subprocess.run(
        [program, library, guid[1], "--seconds", "0.3", "--ring", "1", "--free"], check=True, capture_output=True, text=True
    )
    rows = re.findall(r"^([\w-]+): mean [\d.]+ ms, .*, 0 misses of 300, largest defect .*, (\d+) steps begun again, .* at most", run.stdout, re.M)
    assert [name for name, _ in rows] == LOADS, run.stdout
    # Of 15 000 steps.
    assert sum(int(again) for _, again in rows) <= 30, run.stdout
    counted = [int(count) for count in re.findall(r"up to .* ms: (\d+)", run.stdout)]
    assert sum(counted) == 300 * len(rows)
    unknown = subprocess.run([program, library, guid[1], "--sideways"], capture_output=True, text=True)
    assert unknown.returncode == 2 and "unknown option --sideways" in unknown.stderr
    nothing = subprocess.run([program, library, guid[1], "--load", "surf"], capture_output=True, text=True)
    assert nothing.returncode == 1 and "no load is called surf" in nothing.stderr
