"""Jobs of Slurm as workers, by dask-jobqueue."""

from __future__ import annotations

import shlex
from typing import Any

from pushbelt.study.cluster import ClusterError

CLOSING = 120  # Time before the end of a job at which its worker closes and passes its points on, s
NAMES = {"name": "job_name", "logs": "log_directory", "scratch": "local_directory"}
REPEATED = {"directive": "job_extra_directives", "prologue": "job_script_prologue"}


def cluster(text: str) -> tuple[Any, int]:
    """A cluster without jobs so far, and their number; each has `cores` processes, as
    `queue=normal walltime=02:00:00 jobs=4 cores=16 "directive=--nice=100"` says."""
    from dask_jobqueue import SLURMCluster

    given: dict[str, Any] = {}
    try:
        for key, value in (word.split("=", 1) for word in shlex.split(text)):
            if key in REPEATED:
                given.setdefault(REPEATED[key], []).append(value)
            else:
                given[NAMES.get(key, key)] = value
        jobs, cores, port = (int(given.pop(name, default)) for name, default in (("jobs", 1), ("cores", 1), ("port", 0)))
        days, _, clock = given.get("walltime", "00:30:00").rpartition("-")
        hours, minutes, seconds = map(int, clock.split(":"))
        lifetime = max(86400 * int(days or 0) + 3600 * hours + 60 * minutes + seconds - CLOSING, 30)
        # A worker that closes by itself passes its points on. One that Slurm ends would lose them and count as crashed.
        given = {"memory": f"{cores}GB", "worker_extra_args": ["--lifetime", f"{lifetime}s", "--lifetime-stagger", "30s"]} | given
        options = {"port": port, "dashboard_address": ":0"}
        found = SLURMCluster(cores=cores, processes=cores, scheduler_options=options, **given)
    except (TypeError, ValueError) as error:
        raise ClusterError(f"--slurm {text}: {error}; words are key=value, with walltime=02:00:00 or 1-02:00:00") from error
    return found, jobs
