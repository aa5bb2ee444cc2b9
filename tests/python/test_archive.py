"""Content of the archive, and requirements of its binaries."""

from __future__ import annotations

import ctypes
import platform
import re
import struct
import subprocess
import zipfile
from pathlib import Path

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


@pytest.fixture(scope="module")
def archive(fmu: Path):
    with zipfile.ZipFile(fmu) as opened:
        yield opened


@pytest.fixture(scope="module")
def names(archive: zipfile.ZipFile) -> list[str]:
    return archive.namelist()


def portable(names: list[str]) -> None:
    if OF_WINDOWS[0] not in names:
        pytest.skip("not the portable FMU: `cargo fmu test --portable`")


def test_everything_has_its_place(names: list[str]) -> None:
    expected = {"modelDescription.xml", "model.png", *(f"documentation/{name}" for name in ("index.html", "pushbelt.h", "fmi-ls-ref.html"))}
    expected |= {f"extra/org.fmi-standard.fmi-ls-ref/{name}" for name in ("fmi-ls-manifest.xml", "smoke-test.exp")}
    expected |= {f"resources/{name}.{kind}" for name in ("bench168", "belt155", "chain168") for kind in ("json", "ssv")}
    assert expected <= set(names) and any(name.startswith("binaries/") for name in names)
    if OF_WINDOWS[0] in names:
        assert {name for name in names if name.startswith("binaries/")} == {*OF_LINUX, *OF_WINDOWS}


def test_the_zip_is_small_and_one_that_every_importer_reads(fmu: Path, archive: zipfile.ZipFile, names: list[str]) -> None:
    """Deflated, forward slashes, no data descriptors, one fixed time; 9 MB in all, 2 MB a library, 6 MB when it is unpacked."""
    for entry in archive.infolist():
        assert entry.compress_type == zipfile.ZIP_DEFLATED and "\\" not in entry.filename
        assert not entry.flag_bits & 0x8, "a data descriptor"
        assert entry.date_time == (1980, 1, 1, 0, 0, 0)
        library = entry.filename.startswith("binaries/")
        assert not library or (entry.compress_size < 2_000_000 and entry.file_size < 6_000_000), entry
    assert names == sorted(names) and fmu.stat().st_size < 9_000_000


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


def test_the_picture_is_a_picture(archive: zipfile.ZipFile) -> None:
    picture = archive.read("model.png")
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


def headers(archive: zipfile.ZipFile, name: str, folder: Path) -> str:
    """What a library needs, by binutils, which read libraries of both systems."""
    command = ["objdump", "-p", archive.extract(name, folder)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("name", OF_LINUX)
def test_the_linux_binary_needs_no_new_glibc(archive: zipfile.ZipFile, names: list[str], name: str, tmp_path: Path) -> None:
    portable(names)
    versions = [tuple(map(int, text.split("."))) for text in re.findall(r"GLIBC_([\d.]+)", headers(archive, name, tmp_path))]
    assert versions, "it does need some"
    assert max(versions)[:2] <= GLIBC, sorted(versions)


@pytest.mark.parametrize("name", OF_WINDOWS)
def test_the_windows_binary_needs_windows_only(archive: zipfile.ZipFile, names: list[str], name: str, tmp_path: Path) -> None:
    portable(names)
    library = archive.read(name)
    needed = {found.lower() for found in re.findall(r"DLL Name: (\S+)", headers(archive, name, tmp_path))}
    # Wine 8 does not have it. The linker removes it with unused parts of Rust's standard library.
    assert "bcryptprimitives.dll" not in needed
    assert "kernel32.dll" in needed
    assert all(WINDOWS.fullmatch(name) for name in needed), needed
    for function in exports():
        assert function.encode() in library


def exports() -> list[str]:
    """The names that every library exports."""
    lines = (ROOT / "fmu-build" / "exports.def").read_text(encoding="utf-8").splitlines()
    return [line.strip() for line in lines if line.startswith("    ")]


@pytest.mark.skipif((platform.system(), platform.machine()) != ("Linux", "x86_64"), reason="for Linux on x86-64")
@pytest.mark.parametrize("name", OF_LINUX)
def test_every_library_has_the_listed_functions(archive: zipfile.ZipFile, names: list[str], tmp_path: Path, name: str) -> None:
    """A library with more is refused when the FMU is packed."""
    portable(names)
    library = ctypes.CDLL(archive.extract(name, tmp_path))
    assert len(exports()) == 112
    assert all(hasattr(library, function) for function in exports())


def test_symbols_are_stripped_and_no_path_of_the_builder_is_left(archive: zipfile.ZipFile, names: list[str]) -> None:
    portable(names)
    for name in names:
        if name.startswith("binaries/"):
            library = archive.read(name)
            for section in (b"\0.symtab\0", b"\0.debug_info\0"):
                assert section not in library
            assert b"/.cargo/registry" not in library
            assert str(Path.home()).encode() + b"/" not in library
