"""Programs as processes: output that can't be encoded, Ctrl-C and SIGTERM, and files on a full disk."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest
from conftest import ROOT

from pushbelt import console
from pushbelt.fmu.files import DOCS
from pushbelt.whole_file import write_whole

ENDS = {signal.SIGINT: (130, ["interrupted"]), signal.SIGTERM: (143, ["terminated"])}  # Exit code, and last line of the errors
POOL = """
import sys, time
from pathlib import Path
from pushbelt import console
from pushbelt.report import side_by_side

def work(place):
    Path(place).touch()
    time.sleep(600.0)

def main():
    side_by_side.run_all([(work, (place,)) for place in sys.argv[1:]], 2, "work", 2)

if __name__ == "__main__":
    sys.exit(console.run(main))
"""
TABLE = "i_geo,n_P [rpm],T_P [Nm],F_S [kN],slip [%]\n" + "".join(f"2,1500,{30 + 0.1 * k:g},10,0.2\n0.5,1500,{30 + 0.1 * k:g},10,0.3\n" for k in range(50))


def process(words: list[str], **variables: str) -> subprocess.Popen[bytes]:
    """A Python process in its own process group, as a terminal starts it."""
    known = {**os.environ, "PYTHONPATH": str(ROOT / "python"), **variables}
    signal.signal(signal.SIGINT, signal.default_int_handler)  # Tests in the background of a shell ignore it, and so would this process.
    return subprocess.Popen([sys.executable, *words], env=known, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


def interrupted(started: subprocess.Popen[bytes], busy: Callable[[], bool], how: int = signal.SIGINT) -> tuple[int, list[str]]:
    """Exit code and lines of the errors after Ctrl-C, which all of its group get, or another signal, in a process that is busy. No process of it
    remains."""
    while not busy():
        assert started.poll() is None, started.communicate()
        time.sleep(0.05)
    own = psutil.Process(started.pid).children(recursive=True)
    assert own
    (os.killpg if how == signal.SIGINT else os.kill)(started.pid, how)
    _, errors = started.communicate(timeout=60.0)
    assert not psutil.wait_procs(own, timeout=10.0)[1]
    return started.returncode, errors.decode().splitlines()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends Ctrl-C to all processes of a console")
@pytest.mark.parametrize("signalled", ENDS)
def test_a_signal_ends_busy_workers_with_one_line(signalled: int, tmp_path: Path) -> None:
    script, places = tmp_path / "pool.py", [tmp_path / "one", tmp_path / "two"]
    script.write_text(POOL, encoding="utf-8")
    assert interrupted(process([str(script), *map(str, places)]), lambda: all(place.exists() for place in places), signalled) == ENDS[signalled]


@pytest.mark.skipif(sys.platform != "linux", reason="What a process has loaded is read from /proc")
@pytest.mark.slow
@pytest.mark.parametrize("words", [["demo"], ["calibrate", "table.csv"], ["drive", "--cycle", "nedc"], ["maps"]], ids=lambda words: words[0])
@pytest.mark.parametrize("signalled", ENDS)
def test_a_signal_ends_a_program(signalled: int, words: list[str], fmu: Path, tmp_path: Path) -> None:
    """Once two workers use the FMU."""
    (tmp_path / "table.csv").write_text(TABLE, encoding="utf-8")
    words = [word.replace("table.csv", str(tmp_path / "table.csv")) for word in words]
    started = process(["-m", "pushbelt", *words, "--fmu", str(fmu), "--output", str(tmp_path / "out")])

    def busy() -> bool:
        maps = (Path(f"/proc/{one.pid}/maps") for one in psutil.Process(started.pid).children(recursive=True))
        return sum("PushbeltVariator" in one.read_text() for one in maps if one.exists()) >= 2

    code, said = interrupted(started, busy, signalled)
    # `calibrate` says first how long it takes.
    assert (code, said[-1:]) == ENDS[signalled] and not any("Traceback" in line for line in said), said


def test_sigterm_acts_once_processes_have_started() -> None:
    started = []

    def main() -> None:
        with console.starting_processes():
            signal.raise_signal(signal.SIGTERM)
            started.append(True)

    assert (console.run(main), started) == (143, [True])


def test_characters_that_the_output_lacks_are_replaced() -> None:
    output, errors = process(["-m", "pushbelt", "docs", "studies"], PYTHONIOENCODING="ascii").communicate()
    assert not errors
    page = (DOCS / "studies.md").read_text(encoding="utf-8").encode("ascii", "replace")
    assert b"?" in output and output.decode().split() == page.decode().split()


def test_a_file_that_cannot_be_completed_leaves_nothing(tmp_path: Path) -> None:
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    write_whole(tmp_path / "file", b"whole")
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError):
            write_whole(tmp_path / "file", bytes(2000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_bytes() == b"whole"


def test_a_program_without_an_output_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """As under `pythonw`."""
    monkeypatch.setattr(sys, "stdout", None)
    assert console.run(lambda: None) == 0
