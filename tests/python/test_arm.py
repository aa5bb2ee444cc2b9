"""The wheel for Linux on ARM: under qemu its libraries compute what those of x86-64 compute, in hosts of both versions of FMI."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import ROOT, cargo
from test_windows import SOURCE, readings_of

HOSTS = {"": (SOURCE, "linux64"), "3": (ROOT / "examples" / "fmi3" / "importer.c", "x86_64-linux")}
QEMU = ("qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu")


@pytest.mark.full
def test_digits_on_arm_are_those_on_x86(tmp_path: Path) -> None:
    if not shutil.which(QEMU[0]) or not Path(QEMU[2]).is_dir():
        (pytest.fail if os.environ.get("CI") else pytest.skip)("no qemu for ARM: install qemu-user-static and libc6-arm64-cross")
    subprocess.run([cargo(), "fmu", "wheel", "--arm", "--output", tmp_path], cwd=ROOT, check=True)
    shutil.unpack_archive(*tmp_path.glob("pushbelt-*-py3-none-manylinux_2_17_aarch64.whl"), tmp_path, "zip")
    for number, (source, folder) in HOSTS.items():
        fmu, found = tmp_path / "pushbelt" / "data" / f"PushbeltVariator{number}.fmu", []
        shutil.unpack_archive(fmu, tmp_path / number, "zip")
        real = readings_of(description := fmpy.read_model_description(fmu))
        (tmp_path / "references").write_text("\n".join(str(one.valueReference) for one in real))
        for processor, place, start in (("x86_64", folder, ()), ("aarch64", "aarch64-linux", QEMU)):
            compiler = [ROOT / "target" / "venv-portable" / "bin" / "python", "-m", "ziglang", "cc", "-target", f"{processor}-linux-gnu.2.17", "-O2"]
            subprocess.run([*compiler, "-I", Path(fmpy.__file__).parent / "c-code", "-o", tmp_path / processor, source, "-ldl", "-lm"], check=True)
            run = [*start, tmp_path / processor, tmp_path / number / "binaries" / place / "PushbeltVariator.so", description.guid]
            run += [] if number else ["references", "-", "state", "readings"]
            done = subprocess.run(run, cwd=tmp_path, env={**os.environ, "PUSHBELT_AVX2": "0"}, check=True, capture_output=True, text=True)
            said = re.findall(r"^thrust.*|^slips.*(?=, \d+ messages)", done.stdout, re.M)
            found.append(said if number else np.frombuffer(bytes.fromhex((tmp_path / "readings").read_text()), ">f8").reshape(2, -1))
        if number:
            assert found[0] == found[1] and len(found[0]) == 2
        else:
            difference = np.abs(found[1] - found[0]) / [float(one.nominal) for one in real]
            print(f"largest difference {difference.max():.1e} of a nominal value, of {real[difference.max(axis=0).argmax()].name}")
            assert difference.max() < 1e-8
