"""A Ray cluster of several machines in one: each has its own raylet, which starts its own workers in its own folder."""

import time
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any, Final

import psutil
import pytest
from ray.cluster_utils import Cluster

SETTINGS: Final = {
    # Nothing is sent to Ray's makers, and nothing gives up or yields on a machine that has other work.
    "RAY_USAGE_STATS_ENABLED": "0",
    "RAY_worker_niceness": "0",
    "RAY_raylet_start_wait_time_s": "300",
    "RAY_worker_register_timeout_seconds": "300",
    "RAY_health_check_timeout_ms": "60000",
    "RAY_health_check_period_ms": "1000",
}
STORE: Final = 80_000_000
"""Bytes of a machine's object store."""


class Machines:
    """A cluster whose head does no jobs; what its machines inherit says nothing of where this checkout lies."""

    def __init__(self) -> None:
        head = {"num_cpus": 0, "include_dashboard": False, **self._common()}
        self.cluster = Cluster(initialize_head=True, head_node_args=head)
        self.address: str = self.cluster.address
        self._joined = count()

    def join(self, **environment: str) -> Any:
        """One more machine with a core."""
        # Each machine unpacks what was sent: with one folder for all, under the feet of the others' workers.
        folder = f"machine_{next(self._joined)}/runtime_resources"
        return self.cluster.add_node(num_cpus=1, runtime_env_dir_name=folder, **self._common(**environment))

    def leave(self, machine: Any) -> None:
        self.cluster.remove_node(machine)

    def _common(self, **environment: str) -> dict[str, Any]:
        return {"object_store_memory": STORE, "env_vars": {"PYTHONPATH": "", **environment}}


def raylet(machine: Any) -> psutil.Process:
    return psutil.Process(machine.all_processes["raylet"][0].process.pid)


def workers(machine: Any) -> list[psutil.Process]:
    """Processes of a machine that do jobs, or have done some."""
    agents = ("DashboardAgent", "RuntimeEnvAgent")
    started = raylet(machine).children(recursive=True)
    return [one for one in started if "ray::" in one.name() and not any(agent in one.name() for agent in agents)]


def lose_power(machine: Any) -> list[psutil.Process]:
    """Kill all processes of a machine by their ids, and return those that did jobs."""
    working, root = workers(machine), raylet(machine)
    for process in [root, *root.children(recursive=True)]:
        process.kill()
    return working


def all_gone(*machines: Any, seconds: float = 20.0) -> bool:
    """Whether no machine has a process at work within some time."""
    deadline = time.monotonic() + seconds
    while any(workers(machine) for machine in machines) and time.monotonic() < deadline:
        time.sleep(0.2)
    return not any(workers(machine) for machine in machines)


@pytest.fixture(scope="module")
def machines() -> Iterator[Machines]:
    with pytest.MonkeyPatch.context() as patch:
        for name, value in SETTINGS.items():
            patch.setenv(name, value)
        found = Machines()
        try:
            yield found
        finally:
            found.cluster.shutdown()


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder, from which modules are imported."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path
