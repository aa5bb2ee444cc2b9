"""Content of the archive. `test_windows` has the libraries of the portable one."""

import re
import struct
import subprocess
import zipfile
from collections.abc import Iterator
from pathlib import Path

import fmpy
import pytest
from conftest import ROOT
from lxml import html


@pytest.fixture(params=["fmu", "fmu3"])
def archive(request: pytest.FixtureRequest) -> Iterator[zipfile.ZipFile]:
    with zipfile.ZipFile(request.getfixturevalue(request.param)) as opened:
        yield opened


def test_everything_has_its_place_and_the_licences_an_entry(archive: zipfile.ZipFile) -> None:
    names = archive.namelist()
    expected = {"modelDescription.xml", *(f"documentation/{name}" for name in ("index.html", "pushbelt.h", "fmi-ls-ref.html"))}
    expected |= {f"extra/org.fmi-standard.fmi-ls-ref/{name}" for name in ("fmi-ls-manifest.xml", "smoke-test.exp")}
    expected |= {f"resources/{name}.{kind}" for name in ("bench168", "belt155", "chain168") for kind in ("json", "ssv")}
    assert expected <= set(names) and not any(name.startswith("sources/") for name in names)
    found, own = {name for name in names if name.startswith("binaries/")}, fmpy.platform if "model.png" in names else fmpy.platform_tuple
    assert f"binaries/{own}/PushbeltVariator{fmpy.sharedLibraryExtension}" in found
    if "model.png" in names:
        picture = archive.read("model.png")
        assert picture.startswith(b"\x89PNG\r\n\x1a\n") and len(picture) > 1000
        assert all(200 <= size <= 1000 for size in struct.unpack(">II", picture[16:24]))
    # FMI 2.0.4, section 2.3: documentation/licenses/license.txt refers to the others.
    entry = archive.read("documentation/licenses/license.txt").decode()
    for name in ("LICENSE-MIT.txt", "LICENSE-APACHE.txt", "third-party.txt"):
        assert name in entry and f"documentation/licenses/{name}" in names


def test_the_zip_is_small_and_one_that_every_importer_reads(archive: zipfile.ZipFile) -> None:
    """Deflated, forward slashes, no data descriptors, one fixed time; 9 MB in all, 2.2 MB a library, 6.3 MB when it is unpacked."""
    for entry in archive.infolist():
        assert entry.compress_type == zipfile.ZIP_DEFLATED and "\\" not in entry.filename
        assert not entry.flag_bits & 0x8, "a data descriptor"
        assert entry.date_time == (1980, 1, 1, 0, 0, 0)
        if entry.filename.startswith("binaries/"):
            assert entry.compress_size < 3e6 and entry.file_size < 7e6, entry
    assert archive.namelist() == sorted(archive.namelist()) and Path(archive.filename).stat().st_size < 9_000_000


def test_the_date_is_that_of_the_content(archive: zipfile.ZipFile) -> None:
    date = re.search(r'generationDateAndTime="(.*?)"', archive.read("modelDescription.xml").decode())
    inside = subprocess.run(["git", "rev-parse"], cwd=ROOT, capture_output=True).returncode == 0
    assert date or not inside
    assert date is None or re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", date[1])


def test_the_documentation_is_complete(archive: zipfile.ZipFile, description) -> None:
    page = archive.read("documentation/index.html").decode()
    assert "{{" not in page
    text = "".join(html.document_fromstring(page).itertext())
    for heading in ("What it models", "Equations", "How to wire it", "Limits", "Licence", "Variables", "FMI"):
        assert heading in text, heading
    for variable in description.modelVariables:
        name = re.sub(r"\[\d+\]", "[1…72]", variable.name)
        assert name in text, name
