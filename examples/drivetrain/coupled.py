"""Runs target/drive/drive.ssp with ecos."""

import ctypes
import os
import sys
from pathlib import Path

ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)  # ecos does not find it by itself

from ecospy import EcosSimulation  # noqa: E402

with EcosSimulation(ssp_path="target/drive/drive.ssp", step_size=0.01) as simulation:
    simulation.init(parameter_set="start")
    for second in range(1, 6):
        simulation.step(100)
        values = [simulation.get_real(name) for name in ("vehicle::car.speed", "variator::ratio.geometric")]
        print("t %d s  car %.2f m/s  ratio %.3f" % (second, *values))
    simulation.terminate()

sys.stdout.flush()
os._exit(0)  # skips the exit handlers, in which units of PythonFMU 0.7 use freed memory
