"""FMUs as files: untrusted ones give one error, nothing is written outside the folder, and no temporary files remain; the cache of unpacked
ones is repaired, and replaced where it cannot be written."""

import os
import shutil
import stat
import struct
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

import pushbelt
from pushbelt import InputFileError, cli, parameter_set
from pushbelt.demo import __main__ as demo_main
from pushbelt.fmu import cache, unit, untrusted

ENTITIES = b"".join(b'<!ENTITY a%d "%s">' % (k, b"&a%d;" % (k - 1) * 10) for k in range(1, 10))


@pytest.fixture(autouse=True)
def own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("PUSHBELT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def with_entry(fmu: Path, to: Path, name: str, content: bytes = b"x", mode: int = 0) -> Path:
    """The model description of the FMU, and one more file."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(to, "w", zipfile.ZIP_DEFLATED) as target:
        target.writestr("modelDescription.xml", source.read("modelDescription.xml"))
        entry = zipfile.ZipInfo("placeholder")
        entry.filename, entry.compress_type, entry.external_attr = name, zipfile.ZIP_DEFLATED, mode << 16
        target.writestr(entry, content)
    return to


@pytest.mark.parametrize(
    ("name", "mode"),
    [
        *((name, 0) for name in ("../outside", "resources/../../outside", "/outside", "resources//x", "C:/outside", "..\\outside")),
        ("resources/link", stat.S_IFLNK | 0o777), ("modelDescription.xml", 0),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_paths_that_lead_out_are_refused(fmu: Path, tmp_path: Path, own_cache: Path, name: str, mode: int) -> None:
    place = tmp_path / "in" / "here"
    place.mkdir(parents=True)
    path = with_entry(fmu, place / "bad.fmu", name, b"outside", mode)
    for unpack in (lambda: unit.Archive.unpack(path, place / "unpacked"), lambda: cache.unpacked(path)):
        with pytest.raises(InputFileError, match="bad.fmu is not unpacked") as refused:
            unpack()
        assert name.replace("\\", "") in str(refused.value).replace("\\", "")
    assert not list(tmp_path.rglob("outside*"))
    assert not (place / "unpacked").exists() and not list(own_cache.glob("*"))


@pytest.mark.parametrize("identifier", ["../../evil", "/evil", "a.b", "2x", "", "x\u00e9"])
def test_an_identifier_is_a_name_in_c(fmu: Path, tmp_path: Path, identifier: str) -> None:
    path = tmp_path / "bad.fmu"
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(path, "w") as target:
        content = source.read("modelDescription.xml")
        other = content.replace(b'modelIdentifier="PushbeltVariator"', f'modelIdentifier="{identifier}"'.encode())
        assert other != content
        target.writestr("modelDescription.xml", other)
    for unpack in (unit.Archive.unpack, cache.unpacked, untrusted.described):
        with pytest.raises(InputFileError, match="bad.fmu is not a usable FMU: its modelIdentifier[^\n]*$"):
            unpack(path)
    assert [one.name for one in tmp_path.iterdir()] == ["bad.fmu"]


def test_an_archive_that_would_fill_the_disk_is_refused(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = with_entry(fmu, tmp_path / "bomb.fmu", "resources/zeros", bytes(50_000_000))
    assert path.stat().st_size < 100_000
    for limit, value, named in (("LARGEST_FILE", 40_000_000, "40 MB"), ("MOST_FILES", 1, "1")):
        with monkeypatch.context() as patch, pytest.raises(InputFileError, match=f"above the limit of {named}"):
            patch.setattr(untrusted, limit, value)
            unit.Archive.unpack(path)
    # The directory of the archive contains a small size, but the file's content is large.
    path = with_entry(fmu, tmp_path / "lie.fmu", "resources/zeros", bytes(1_000_000))
    data = bytearray(path.read_bytes())
    at = data.rindex(b"resources/zeros") - 46
    assert data[at : at + 4] == b"PK\1\2"
    struct.pack_into("<I", data, at + 24, 10)
    path.write_bytes(data)
    with pytest.raises(InputFileError, match="lie.fmu is not a usable FMU"):
        unit.Archive.unpack(path, tmp_path / "unpacked")


@pytest.mark.parametrize("spoil", [lambda data: b"", lambda data: b"PK\3\4", lambda data: data[: len(data) // 2], lambda data: data[:-22] + bytes(22)])
def test_what_is_cut_or_damaged_is_refused(fmu: Path, tmp_path: Path, spoil: Callable[[bytes], bytes], capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bad.fmu"
    path.write_bytes(spoil(fmu.read_bytes()))
    with pytest.raises(InputFileError, match="bad.fmu"):
        unit.Archive.unpack(path)
    for main, words in ((cli.main, ["fmu", str(tmp_path / "own.fmu")]), (demo_main.main, ["--output", str(tmp_path / "out")])):
        assert main([*words, "--fmu", str(path)]) == 1
        said = capsys.readouterr().err
        assert said.count("\n") == 1 and "bad.fmu" in said, "one error, and no more"


@pytest.mark.parametrize(
    "xml",
    [
        b"no xml", b"<fmiModelDescription/>",
        b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><fmiModelDescription modelName="&b;"/>',
        b'<!DOCTYPE a [<!ENTITY a0 "aaaaaaaaaa">' + ENTITIES + b']><fmiModelDescription fmiVersion="2.0" modelName="&a9;"/>',
    ],
)  # fmt: skip
def test_a_model_description_that_is_none_is_refused(tmp_path: Path, xml: bytes) -> None:
    path = tmp_path / "xml.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", xml)
    with pytest.raises(InputFileError, match="xml.fmu is not a usable FMU") as refused:
        unit.Archive.unpack(path)
    assert "root:" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[1, 2", ""), ("[" * 100_000, ""), ("\xff", ""), ("3", "parameters"), ('{"parameters": []}', "parameters"),
        ('{"parameters": {"belt.play": 2e-4}}', "belt.play"), ('{"parameters": {"belt.play": {"value": [1]}}}', "belt.play"),
        ('{"parameters": {"belt.play": {"value": NaN}}}', "NaN"),
    ],
)  # fmt: skip
def test_json_of_another_form_is_refused(tmp_path: Path, text: str, named: str) -> None:
    path = tmp_path / "bad.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputFileError, match=f"^[^\n]*bad.json[^\n]*{named}[^\n]*$"):
        parameter_set(str(path))


def files(folder: Path) -> dict[str, int]:
    return {str(path.relative_to(folder)): path.stat().st_size for path in folder.rglob("*") if path.is_file()}


def library(archive: unit.Archive) -> Path:
    (path,) = (archive.directory / "binaries").glob("*/PushbeltVariator.*")
    return path


def test_what_is_not_whole_is_unpacked_again(fmu: Path, own_cache: Path) -> None:
    archive = cache.unpacked(fmu)
    assert archive.directory.parent == own_cache
    with zipfile.ZipFile(fmu) as source:
        whole = {entry.filename: entry.file_size for entry in source.infolist() if not entry.is_dir()}
    assert files(archive.directory) == whole
    kept = archive.directory / "modelDescription.xml"
    before = kept.stat().st_mtime_ns
    library(archive).unlink()
    (archive.directory / "resources" / "manoeuvre.csv").unlink(missing_ok=True)
    with next((archive.directory / "resources").rglob("*.json")).open("ab") as file:
        file.write(b" ")
    assert files(archive.directory) != whole
    assert files(cache.unpacked(fmu).directory) == whole and kept.stat().st_mtime_ns == before
    shutil.rmtree(archive.directory / "binaries")
    with pushbelt.Variator("bench168", {"ring.model": "ALE0"}, fmu=fmu) as belt:
        assert belt["ring.model"] == 1


def test_a_temporary_folder_replaces_a_cache_that_cannot_be_written(fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("a file", encoding="utf-8")
    monkeypatch.setenv("PUSHBELT_CACHE", str(tmp_path / "file" / "cache"))
    for _ in range(2):
        with pytest.warns(pushbelt.VariatorWarning, match="PUSHBELT_CACHE") as caught:
            archive = cache.unpacked(fmu)
        assert str(archive.directory) in str(caught[0].message) and caught[0].filename == __file__
    assert Path(tempfile.gettempdir()) in archive.directory.parents and library(archive).is_file()
    if os.name == "posix":
        assert archive.directory.parent.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(
    ("tuple_", "there", "expected"),
    [
        ("aarch64-linux", ["aarch64-linux", "linux64"], "aarch64-linux"), ("aarch64-linux", ["linux64", "win64"], None),
        ("aarch64-darwin", ["darwin64"], "darwin64"), ("x86_64-linux", ["linux64", "aarch64-linux"], "linux64"),
    ],
)  # fmt: skip
def test_binaries_are_those_of_processor_and_system(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuple_: str, there: list[str], expected: str | None
) -> None:
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(tmp_path / "other.fmu", "w") as copy:
        copy.writestr("modelDescription.xml", archive.read("modelDescription.xml"))
        for folder in there:
            copy.writestr(f"binaries/{folder}/PushbeltVariator.so", b"")
    monkeypatch.setattr(fmpy, "platform_tuple", tuple_)
    monkeypatch.setattr(fmpy, "platform", f"{tuple_.partition('-')[2]}64")
    if expected is None:
        with pytest.raises(pushbelt.InputFileError, match=tuple_):
            cache.unpacked(tmp_path / "other.fmu")
    else:
        directory = cache.unpacked(tmp_path / "other.fmu").directory
        assert unit.binaries_of(directory) == directory / "binaries" / expected


def test_a_library_that_is_damaged_is_named(fmu: Path) -> None:
    archive, here = cache.unpacked(fmu), os.getcwd()
    path = library(archive)
    path.write_bytes(bytes(path.stat().st_size))
    with pytest.raises(pushbelt.UnitError, match=path.name):
        unit.Instance(archive, {})
    assert os.getcwd() == here
