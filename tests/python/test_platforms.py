"""Folders of binaries by processor and system."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import pytest
from pushbelt.fmu import cache, unit

CASES = [
    ("aarch64-linux", "linux64", ["aarch64-linux", "linux64"], "aarch64-linux"),
    ("aarch64-linux", "linux64", ["linux64", "win64"], None),
    ("aarch64-darwin", "darwin64", ["aarch64-darwin", "darwin64"], "aarch64-darwin"),
    ("aarch64-darwin", "darwin64", ["darwin64"], "darwin64"),
    ("x86_64-linux", "linux64", ["linux64", "aarch64-linux"], "linux64"),
    ("x86_64-windows", "win64", ["linux64"], None),
]


@pytest.mark.parametrize(("tuple_", "name", "there", "expected"), CASES)
def test_the_folder_is_that_of_processor_and_system(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuple_: str, name: str, there: list[str], expected: str | None
) -> None:
    monkeypatch.setattr(fmpy, "platform_tuple", tuple_)
    monkeypatch.setattr(fmpy, "platform", name)
    for folder in there:
        (tmp_path / "binaries" / folder).mkdir(parents=True)
    found = unit.binaries_of(tmp_path)
    assert found == (tmp_path / "binaries" / expected if expected else None)


def test_a_missing_binary_is_named_by_processor_and_system(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(tmp_path / "other.fmu", "w") as copy:
        copy.writestr("modelDescription.xml", archive.read("modelDescription.xml"))
        copy.writestr("binaries/linux64/PushbeltVariator.so", b"")
    monkeypatch.setattr(cache, "folder", lambda: tmp_path / "cache")
    monkeypatch.setattr(fmpy, "platform_tuple", "aarch64-linux")
    with pytest.raises(ValueError, match=r"no binary for aarch64-linux, only for linux64"):
        cache.unpacked(tmp_path / "other.fmu")
