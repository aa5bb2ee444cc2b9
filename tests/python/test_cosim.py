"""The drive as a co-simulation of FMUs: the package, its units, and runs in third-party importers."""

import ctypes
import importlib.util
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from unittest.mock import Mock

import fmpy
import numpy as np
import pytest
import reports
from lxml import etree
from sample_maps import default_maps

from pushbelt.fmu.unit import UnitError

pythonfmu = pytest.importorskip("pythonfmu")
if not pythonfmu.FmuBuilder.has_binary():
    pytest.skip("pythonfmu has no binary for this machine", allow_module_level=True)

from pushbelt_cosim import __main__ as program
from pushbelt_cosim import fmus, package, report, study
from pushbelt_cosim.importers import IMPORTERS

ROOT = Path(__file__).parents[2]
NAMESPACES = {"ssd": package.SSD, "ssc": package.SSC, "ssv": package.SSV}
PACKAGES = {"ecos": "ecospy", "libcosim": "libcosimpy"}
THERE = [name for name in IMPORTERS if importlib.util.find_spec(PACKAGES[name])]


@pytest.fixture(scope="module")
def ssp(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return study.build(fmu, default_maps(), study.SHORT, tmp_path_factory.mktemp("package"))


def document(ssp: Path, name: str) -> etree._Element:
    return etree.fromstring(zipfile.Path(ssp, name).read_bytes())


def test_package_and_units_are_valid_and_have_the_laws_of_the_source_tree(ssp: Path, tmp_path: Path) -> None:
    package.validate(document(ssp, "SystemStructure.ssd"), "SystemStructureDescription")
    for name in ("variator", "vehicle", "control"):
        package.validate(document(ssp, f"resources/{name}.ssv"), "SystemStructureParameterValues")
    shutil.unpack_archive(ssp, tmp_path, "zip")
    components = document(ssp, "SystemStructure.ssd").iterfind(".//ssd:Component", NAMESPACES)
    found = {component.get("name"): tmp_path / component.get("source") for component in components}
    for path in (found["vehicle"], found["control"]):
        assert fmpy.validation.validate_fmu(str(path)) == []
        with zipfile.ZipFile(path) as archive:
            for name in ("control", "transmission", "vehicle"):
                source = ROOT / "python" / "pushbelt" / "drive" / f"{name}.py"
                assert archive.read(f"resources/pushbelt/drive/{name}.py") == source.read_bytes()


def test_refusal_is_one_line(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    monkeypatch.setattr(ctypes, "CDLL", Mock(side_effect=OSError("pythonfmu-export.so: undefined symbol: Py_Initialize")))
    with pytest.raises(UnitError, match="undefined symbol"):
        fmus.build(tmp_path, default_maps())
    monkeypatch.setattr(study, "run", Mock(side_effect=UnitError("this Python can't run FMUs of pythonfmu")))
    assert program.main(["--fmu", str(fmu), "--output", str(tmp_path)]) == 1
    assert capsys.readouterr().err == "pushbelt drive --cosim: this Python can't run FMUs of pythonfmu\n"


@pytest.fixture(scope="module")
def coupling(fmu: Path, drive_folder: Path) -> study.Coupling:
    if not THERE:
        pytest.skip("no importer has a wheel for this Python and machine")
    return study.run(fmu, study.SHORT, drive_folder, THERE)


def test_program_runs(coupling: study.Coupling, drive_folder: Path, tmp_path: Path) -> None:
    """The example in the docs; its output equals the result at 10 ms."""
    if "ecos" not in coupling.importers:
        pytest.skip("ecospy has no wheel for this Python and machine")
    (tmp_path / "target" / "drive").mkdir(parents=True)
    shutil.copy(drive_folder / study.PACKAGE, tmp_path / "target" / "drive")
    command = [sys.executable, ROOT / "examples" / "drivetrain" / "coupled.py"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600, check=False)
    assert ran.returncode == 0, ran.stderr
    ratio = coupling.importers["ecos"][0.01][399, 0]
    assert "t 4 s" in ran.stdout and f"ratio {ratio:.3f}" in ran.stdout


@pytest.mark.parametrize("importer", THERE)
def test_importer_is_the_loop_with_its_parts_side_by_side(coupling: study.Coupling, importer: str) -> None:
    """A launch at communication steps of 10, 5 and 2.5 ms: the control is designed for 10 ms, and its shift speed is filtered with the same time
    constant. The only difference between an importer and the loop is the order of the parts; all wires of the package are the loop's. The coupling
    is of first order, so the difference of x_h to its limit is 2 (x_h − x_{h/2})."""
    assert coupling.against_parallel(importer) < 1e-9
    against, estimated = coupling.against_loop(importer), 2.0 * coupling.refinement(importer)
    mean = np.log2(against[0] / against[-1]) / (len(against) - 1)
    # The ratio's largest difference is where gaps close: it falls faster in one run than in another.
    assert (mean > 0.8).all() and mean.mean() == pytest.approx(1.0, abs=0.2), dict(zip(study.SIGNALS, mean, strict=True))
    assert (against[:-1] < estimated).all() and (estimated < 0.1).all()


def test_report_shows_the_coupling(coupling: study.Coupling, tmp_path: Path) -> None:
    report.write_html(coupling, tmp_path / "coupling.html")
    page, text = reports.stands_alone(tmp_path / "coupling.html"), report.text(coupling)
    assert all(f"{importer} against the loop, order" in text and f"{importer} against the loop" in page for importer in THERE)
    assert reports.figures(page) == 2 * len(study.SIGNALS) + 2
    reports.look_at(tmp_path / "coupling.html")
