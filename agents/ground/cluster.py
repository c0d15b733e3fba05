"""Jobs done by the machines of a Ray cluster, which share only the network with this machine.

Code and jobs are sent as bytes, results come back as bytes, and only this machine writes files. Ray repeats the jobs of
a machine that died on another machine.
"""

from __future__ import annotations

import importlib
import os
import pickle
import socket
import subprocess
import sys
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from pnt_gym.errors import one_sentence

from . import parcel, work
from .cli import UsageError
from .parcel import identity, pack
from .streams import handle_signals, interrupt
from .work import Completion, Job, Pool, processes

RETRIES: Final = 10
"""Number of times that a job is repeated after its machine or process died."""
ANSWER: Final = 60.0
"""Seconds within which a cluster has to answer."""
LOOK: Final = 30.0
"""Seconds without a finished job after which the number of machines is checked again."""
AHEAD: Final = 4
"""Jobs submitted at a time for each core."""
ALONE: Final = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA")}
"""Environment of a job, which has one core."""
_QUIET: Final = {"log_to_driver": False, "logging_level": "ERROR"}
_JOIN: Final = f"import sys, ray; ray.init(address=sys.argv[1], **{_QUIET})"


@dataclass(frozen=True)
class Needs:
    """Requirements of jobs on a machine beside the code.

    Attributes:
        modules: names of the user's modules that the jobs import.
        torch: whether jobs train networks.
    """

    modules: tuple[str, ...] = ()
    torch: bool = False


def pool(count: int, cluster: str | None, needs: Needs) -> Pool:
    """Pool of processes on this machine, or of a cluster's cores: HOST:PORT of its head, or "auto" on its machines."""
    return processes(count) if cluster is None else partial(_on_cluster, cluster, needs)


@contextmanager
def _on_cluster(
    address: str, needs: Needs, jobs: Sequence[Job], _folder: Path
) -> Generator[Iterator[tuple[Job, Completion]], None, None]:
    """Do jobs on the cores of a cluster, one core per job; the end of the block ends the jobs.

    Raises:
        UsageError: the cluster cannot be reached or used, or one of its machines would compute other results.
    """
    # Without this variable Ray warns of a future change on machines with accelerators.
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    # Without a limit Ray would repeat a job that is too large for every machine for ever.
    os.environ.setdefault("RAY_task_oom_retries", f"{RETRIES}")
    import ray  # noqa: PLC0415 # pyright: ignore[reportMissingImports] - of an extra

    for job in jobs:
        _serialise(job)
    _check(address)
    head_identity = identity(needs.modules, needs.torch)
    with TemporaryDirectory() as folder:
        pack(Path(folder), needs.modules)
        # Ray would leave out the folders in which machine code lies.
        runtime_env = {"working_dir": folder, "excludes": ["!__pycache__", "!*.nb[ic]"], "env_vars": ALONE}
        ray.init(address=address, runtime_env=runtime_env, **_QUIET)
        try:
            _count(ray)
            remote: Any = ray.remote(num_cpus=1, max_retries=RETRIES)(_self_contained_call(__name__))
            with handle_signals(interrupt):  # Ray has put a handler of its own in place
                yield _completions(
                    ray, jobs, lambda job: remote.remote(_serialise(job), head_identity, needs.modules, needs.torch)
                )
        finally:
            ray.shutdown()  # the cluster ends the jobs of a machine that leaves


def _serialise(job: Job) -> bytes:
    try:
        return pickle.dumps(job)
    except Exception as error:  # pickling a user's object may raise anything
        raise UsageError(f"{job.name!r} cannot be sent to another machine: {one_sentence(error)}") from error


def _self_contained_call(module: str) -> Callable[..., Completion | str]:
    """Function that is pickled by value, not by its module's name, and so can report a module that a node lacks."""

    def call(*arguments: Any) -> Completion | str:
        try:
            code = importlib.import_module(module)
        except ImportError as error:
            return f"node {socket.gethostname()!r} lacks what the code needs: {error}"
        return code.on_node(*arguments)

    return call


def on_node(job_bytes: bytes, head_identity: Mapping[str, str], modules: Sequence[str], torch: bool) -> Completion:
    """Do a job on a machine of the cluster, after checking that the machine computes the same results."""
    _check_once(tuple(head_identity.items()), tuple(modules), torch)
    with TemporaryDirectory() as folder:
        return work.run(pickle.loads(job_bytes), Path(folder))._replace(where=f" on {socket.gethostname()}")


@cache
def _check_once(head_identity: tuple[tuple[str, str], ...], modules: tuple[str, ...], torch: bool) -> None:
    parcel.check(dict(head_identity), modules, torch)


def _completions(ray: Any, jobs: Sequence[Job], begin: Callable[[Job], Any]) -> Iterator[tuple[Job, Completion]]:
    """Jobs as they end; only enough are submitted at a time to keep all cores busy, because a job may hold a policy."""
    queue, tasks = iter(jobs), dict[Any, Job]()
    while True:
        room = AHEAD * _count(ray) - len(tasks)
        tasks |= {begin(job): job for job in islice(queue, max(room, 0))}
        if not tasks:
            return
        ended, _ = ray.wait([*tasks], timeout=LOOK)
        for task in ended:
            try:
                outcome = ray.get(task)
            except ray.exceptions.RayTaskError as error:
                raise error.cause from None
            except ray.exceptions.RayError as error:
                raise UsageError(f"the cluster could not do a job; run the command again to go on: {error}") from None
            if isinstance(outcome, str):
                raise UsageError(outcome)
            yield tasks.pop(task), outcome


def _count(ray: Any) -> int:
    """Number of cores in the cluster.

    Raises:
        UsageError: the cluster has no core.
    """
    count = sum(int(node["Resources"].get("CPU", 0)) for node in ray.nodes() if node["Alive"])
    if not count:
        raise UsageError("no machine with a core is in the cluster; let one join and run the command again to go on")
    return count


def _check(address: str) -> None:
    """Make sure that a Ray cluster answers and accepts this machine; Ray itself would try for many minutes.

    Raises:
        UsageError: the cluster does not answer, or does not accept this machine.
    """
    host, _, port = address.rpartition(":")
    if address != "auto":
        if not (host and port.isdecimal()):
            raise UsageError(f"--cluster is {address!r}; it must be HOST:PORT of the cluster's head, or auto")
        try:
            socket.create_connection((host, int(port)), timeout=10.0).close()
        except (OSError, OverflowError) as error:
            raise UsageError(f"no cluster can be reached at {address!r}: {one_sentence(error)}") from None
    command = [sys.executable, "-c", _JOIN, address]
    # By default Ray searches for its part on this machine for 60 s, as long as `ANSWER`.
    patient = {**os.environ, "RAY_gcs_server_request_timeout_seconds": f"{ANSWER / 2:.0f}"}
    hint = "this machine has to be in it, for instance by `ray start --address=HOST:PORT --num-cpus=0`"
    try:
        process = subprocess.run(command, env=patient, capture_output=True, text=True, timeout=ANSWER, check=False)
    except subprocess.TimeoutExpired:
        raise UsageError(f"no Ray cluster answers at {address!r} within {ANSWER:.0f} s; {hint}") from None
    if process.returncode != 0:
        # End of a traceback as one sentence, from the line with the error's name on.
        lines = process.stderr.strip().splitlines()
        first = next((n for n in reversed(range(len(lines))) if lines[n][:1].isalpha() and "Error: " in lines[n]), -1)
        reason = one_sentence(" ".join(lines[first:]))
        advice = f"; {hint}" if reason.startswith("ConnectionError") else ""
        raise UsageError(f"the cluster at {address!r} cannot be joined: {reason}{advice}")
