"""Content of the archive, and requirements of its binaries."""

from __future__ import annotations

import ctypes
import platform
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

GLIBC = (2, 17)
"""Oldest C library that the portable Linux binary loads with."""
WINDOWS = re.compile(r"(kernel32|ntdll|userenv|ws2_32|advapi32|bcrypt|bcryptprimitives|msvcrt|ucrtbase|api-ms-win-[a-z0-9-]+)\.dll")
"""Libraries that come with Windows."""
OF_LINUX = ("binaries/linux64/PushbeltVariator.so", "binaries/linux64/PushbeltVariator-avx2.so")
OF_WINDOWS = ("binaries/win64/PushbeltVariator.dll", "binaries/win64/PushbeltVariator-avx2.dll")
"""The library for all processors, and its variant for AVX2."""


@pytest.fixture(params=["fmu", "fmu3"])
def archive(request: pytest.FixtureRequest) -> Iterator[zipfile.ZipFile]:
    with zipfile.ZipFile(request.getfixturevalue(request.param)) as opened:
        yield opened


@pytest.fixture
def portable(fmu: Path) -> Iterator[zipfile.ZipFile]:
    """The archive with libraries for every system."""
    with zipfile.ZipFile(fmu) as opened:
        if OF_WINDOWS[0] not in opened.namelist():
            pytest.skip("not the portable FMU: `cargo fmu test --portable`")
        yield opened


def test_everything_has_its_place(archive: zipfile.ZipFile) -> None:
    names = archive.namelist()
    expected = {"modelDescription.xml", *(f"documentation/{name}" for name in ("index.html", "pushbelt.h", "fmi-ls-ref.html"))}
    expected |= {f"extra/org.fmi-standard.fmi-ls-ref/{name}" for name in ("fmi-ls-manifest.xml", "smoke-test.exp")}
    expected |= {f"resources/{name}.{kind}" for name in ("bench168", "belt155", "chain168") for kind in ("json", "ssv")}
    assert expected <= set(names) and not any(name.startswith("sources/") for name in names)
    found, own = {name for name in names if name.startswith("binaries/")}, fmpy.platform if "model.png" in names else fmpy.platform_tuple
    assert f"binaries/{own}/PushbeltVariator{fmpy.sharedLibraryExtension}" in found
    if OF_WINDOWS[0] in names:
        assert found == {*OF_LINUX, *OF_WINDOWS}


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


def test_the_licences_have_an_entry(archive: zipfile.ZipFile) -> None:
    """FMI 2.0.4, section 2.3: documentation/licenses/license.txt refers to the others."""
    entry = archive.read("documentation/licenses/license.txt").decode()
    for name in ("LICENSE-MIT.txt", "LICENSE-APACHE.txt", "third-party.txt"):
        assert name in entry and f"documentation/licenses/{name}" in archive.namelist()


def test_the_picture_is_a_picture(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as opened:
        picture = opened.read("model.png")
    assert picture.startswith(b"\x89PNG\r\n\x1a\n") and len(picture) > 1000
    assert all(200 <= size <= 1000 for size in struct.unpack(">II", picture[16:24]))


def test_the_documentation_is_complete(archive: zipfile.ZipFile, description) -> None:
    page = archive.read("documentation/index.html").decode()
    assert "{{" not in page
    text = "".join(html.document_fromstring(page).itertext())
    for heading in ("What it models", "Equations", "How to wire it", "Limits", "Licence", "Variables", "FMI"):
        assert heading in text, heading
    for variable in description.modelVariables:
        name = re.sub(r"\[\d+\]", "[1…72]", variable.name)
        assert name in text, name


def needed(library: str, pattern: str) -> set[str]:
    """What a library needs, by binutils, which read libraries of both systems."""
    return set(re.findall(pattern, subprocess.run(["objdump", "-p", library], capture_output=True, text=True, check=True).stdout))


def exports() -> list[str]:
    """The names that every library exports. A library with more is refused when the FMU is packed."""
    lines = (ROOT / "fmu-build" / "exports.def").read_text(encoding="utf-8").splitlines()
    return [line.strip() for line in lines if line.startswith("    ")]


@pytest.mark.parametrize("name", OF_LINUX)
def test_the_linux_library_has_the_listed_functions_and_needs_no_new_glibc(portable: zipfile.ZipFile, name: str, tmp_path: Path) -> None:
    path = portable.extract(name, tmp_path)
    versions = [tuple(map(int, text.split("."))) for text in needed(path, r"GLIBC_([\d.]+)")]
    assert versions, "it does need some"
    assert max(versions)[:2] <= GLIBC, sorted(versions)
    assert len(exports()) == 112
    if (platform.system(), platform.machine()) == ("Linux", "x86_64"):
        library = ctypes.CDLL(path)
        assert all(hasattr(library, function) for function in exports())


@pytest.mark.parametrize("name", OF_WINDOWS)
def test_the_windows_library_has_the_listed_functions_and_needs_windows_only(portable: zipfile.ZipFile, name: str, tmp_path: Path) -> None:
    libraries = {found.lower() for found in needed(portable.extract(name, tmp_path), r"DLL Name: (\S+)")}
    # Wine 8 does not have it. The linker removes it with unused parts of Rust's standard library.
    assert "bcryptprimitives.dll" not in libraries
    assert "kernel32.dll" in libraries
    assert all(WINDOWS.fullmatch(name) for name in libraries), libraries
    assert all(function.encode() in portable.read(name) for function in exports())


@pytest.mark.parametrize("name", [*OF_LINUX, *OF_WINDOWS])
def test_symbols_are_stripped_and_no_path_of_the_builder_is_left(portable: zipfile.ZipFile, name: str) -> None:
    library = portable.read(name)
    for text in (b"\0.symtab\0", b"\0.debug_info\0", b"/.cargo/registry", str(Path.home()).encode() + b"/"):
        assert text not in library
