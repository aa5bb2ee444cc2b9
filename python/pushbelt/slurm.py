"""Workers as jobs of Slurm, by dask-jobqueue."""

from __future__ import annotations

import shlex
import shutil
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from .errors import PushbeltError

if TYPE_CHECKING:
    from dask_jobqueue import SLURMCluster

TEXTS = {
    "queue": "queue",
    "account": "account",
    "walltime": "walltime",
    "memory": "memory",
    "name": "job_name",
    "logs": "log_directory",
    "scratch": "local_directory",
    "interface": "interface",
    "python": "python",
}
"""Options with one value, and the arguments of SLURMCluster."""
NUMBERS = ("jobs", "cores", "port")
REPEATED = {"directive": "job_extra_directives", "prologue": "job_script_prologue"}
"""Options that may be repeated, and the arguments of SLURMCluster."""
HELP = (
    "key=value, separated by spaces: "
    + ", ".join([*NUMBERS, *TEXTS])
    + "; repeated: directive (a line #SBATCH), prologue (a command before the worker)"
)
CLOSING = 120
"""Time before the end of a job at which its worker closes and passes its points on, s."""


class SlurmError(PushbeltError, ValueError):
    """An option that is not known or has no value."""


@dataclass(frozen=True)
class Slurm:
    """Jobs of Slurm: how many, and what each asks for."""

    jobs: int = 1
    cores: int = 1
    """Processes per job, each on one core."""
    port: int = 0
    """Port of the scheduler; 0: any free one."""
    arguments: dict[str, Any] = field(default_factory=dict)
    """Arguments of SLURMCluster."""

    @classmethod
    def read(cls, text: str) -> Slurm:
        """Options such as `queue=normal walltime=02:00:00 jobs=4 cores=16 memory=16GB "directive=--nice=100"`."""
        arguments: dict[str, Any] = {}
        numbers = {}
        for word in shlex.split(text):
            key, separator, value = word.partition("=")
            if not separator or not value:
                raise SlurmError(f"--slurm: {word} is not of the form key=value ({HELP})")
            if key in NUMBERS:
                if not value.isdigit() or (int(value) < 1 and key != "port"):
                    raise SlurmError(f"--slurm: {key}={value} is not a number above 0")
                numbers[key] = int(value)
            elif key in TEXTS:
                arguments[TEXTS[key]] = value
            elif key in REPEATED:
                arguments.setdefault(REPEATED[key], []).append(value)
            else:
                raise SlurmError(f"--slurm: {key} is not known ({HELP})")
        if "walltime" in arguments:
            _seconds(arguments["walltime"])
        arguments.setdefault("memory", f"{numbers.get('cores', 1)}GB")
        return cls(**numbers, arguments=arguments)

    def cluster(self) -> SLURMCluster:
        """The scheduler in this process, without jobs so far. Raises ModuleNotFoundError without dask-jobqueue."""
        from dask_jobqueue import SLURMCluster

        arguments = dict(self.arguments)
        if "walltime" in arguments:
            # A worker that closes by itself passes its points on. One that Slurm ends would lose them and count as crashed.
            lifetime = max(_seconds(arguments["walltime"]) - CLOSING, 30)
            arguments["worker_extra_args"] = ["--lifetime", f"{lifetime}s", "--lifetime-stagger", "30s"]
        return SLURMCluster(
            cores=self.cores,
            processes=self.cores,
            scheduler_options={"port": self.port, "dashboard_address": ":0"},
            **arguments,
        )

    def script(self) -> str:
        """The script of a job. Its address is that of a scheduler of this process."""
        with self.cluster() as cluster:
            return cluster.job_script()


def is_there() -> bool:
    """Whether jobs can be submitted on this machine."""
    return shutil.which("sbatch") is not None


def _seconds(walltime: str) -> int:
    """Seconds of [days-]hours[:minutes[:seconds]] or minutes[:seconds], as Slurm reads them."""
    days, _, rest = walltime.rpartition("-")
    try:
        parts = [int(part) for part in rest.split(":")]
        if len(parts) > 3 or min(parts) < 0:
            raise ValueError(f"{walltime} is not [days-]hours[:minutes[:seconds]] or minutes[:seconds]")
        if days:
            hours, minutes, seconds = [*parts, 0, 0][:3]
            return 86400 * int(days) + 3600 * hours + 60 * minutes + seconds
        hours, minutes, seconds = parts if len(parts) == 3 else (0, *[*parts, 0][:2])
        return 3600 * hours + 60 * minutes + seconds
    except ValueError:
        raise SlurmError(f"--slurm: walltime={walltime} is not of the form 02:00:00") from None
