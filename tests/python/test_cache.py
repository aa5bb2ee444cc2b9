"""The cache of unpacked FMUs: repaired, replaced where it cannot be written, and named where nothing may be executed."""

from __future__ import annotations

import os
import shutil
import tempfile
import zipfile
from pathlib import Path
from types import SimpleNamespace

import fmpy
import pytest

import pushbelt
from pushbelt.fmu import cache, unit


@pytest.fixture(autouse=True)
def folder_of_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("PUSHBELT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def files(folder: Path) -> dict[str, int]:
    return {str(path.relative_to(folder)): path.stat().st_size for path in folder.rglob("*") if path.is_file()}


def library(archive: unit.Archive) -> Path:
    (path,) = (archive.directory / "binaries").glob("*/PushbeltVariator.*")
    return path


def test_what_is_not_whole_is_unpacked_again(fmu: Path, folder_of_cache: Path) -> None:
    archive = cache.unpacked(fmu)
    assert archive.directory.parent == folder_of_cache
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


def test_a_temporary_folder_replaces_a_cache_that_cannot_be_written(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


@pytest.mark.skipif(not hasattr(os, "ST_NOEXEC"), reason="the system has no such mounts")
def test_a_folder_without_execution_is_named(fmu: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    archive, here = cache.unpacked(fmu), os.getcwd()
    path = library(archive)
    path.write_bytes(bytes(path.stat().st_size))
    with pytest.raises(pushbelt.UnitError, match=path.name):
        unit.Instance(archive, {})
    assert os.getcwd() == here
    monkeypatch.setattr(unit.os, "statvfs", lambda _: SimpleNamespace(f_flag=os.ST_NOEXEC))
    with pytest.raises(pushbelt.UnitError, match="noexec") as caught:
        unit.Instance(archive, {})
    assert str(archive.directory) in str(caught.value) and "PUSHBELT_CACHE" in str(caught.value)
    with pytest.raises(pushbelt.UnitError, match="TMPDIR"):
        unit.Instance(unit.Archive(archive.directory, archive.description), {})
