"""Machines that would not compute the same, and clusters that are none: one sentence each, and nothing lost."""

import json
import socket
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from ray._private.ray_constants import KV_NAMESPACE_CLUSTER
from ray._raylet import GcsClient

from agents.ground import cluster
from agents.ground.cli import UsageError
from agents.ground.cluster import Needs, pool
from agents.ground.work import Job, do_missing
from tests.cluster.conftest import Machines
from tests.tools.commands import refused

STUDY = {
    "name": "study",
    "train_level": "waste",
    "levels": ["waste"],
    "picks": 8,
    "num_envs": 4,
    "entries": [{"label": "analytic", "controller": "analytic"}],
}
OTHER_NUMPY = """
import importlib.metadata as metadata
known = metadata.version
metadata.version = lambda name: "2.0.1" if name == "numpy" else known(name)
"""
OTHER_CODE = """
from pathlib import Path
from typing import Any
read = Path.read_bytes
Path.read_bytes = lambda path: read(path) + (b"#" if path.name == "features.py" else b"")
"""
DOOMED = """
import os
import signal
import time


def take_down(folder):
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(60)
"""
NO_MUJOCO = """
import sys
sys.modules["mujoco"] = None
"""


@pytest.fixture
def study(here: Path) -> list[str]:
    """The options of a small study, of which something is done already."""
    (here / "plan.yaml").write_text(yaml.safe_dump(STUDY))
    (here / "kept").mkdir()
    (here / "kept" / "before-k.json").write_text("{}")
    return ["agents.benchmark", "--config", "plan.yaml", "--work", "kept", "--out", "out.json"]


@pytest.fixture(autouse=True)
def nothing_lost(study: list[str], here: Path) -> Iterator[None]:
    yield
    assert [path.name for path in (here / "kept").iterdir()] == ["before-k.json"]
    assert not (here / "out.json").exists()


def test_no_machine_with_a_core(machines: Machines, study: list[str]) -> None:
    assert "no machine with a core is in the cluster" in refused(*study, "--cluster", machines.address)


@pytest.mark.parametrize(
    ("code", "setting", "said"),
    [
        (OTHER_NUMPY, {}, "has numpy 2.0.1, here it is "),
        (OTHER_CODE, {}, "runs other code of pnt_gym than this machine"),
        # Kernels of an older processor.
        ("", {"OPENBLAS_CORETYPE": "Nehalem"}, "rounds otherwise than this machine"),
        (NO_MUJOCO, {}, "lacks what the code needs: import of mujoco halted"),
    ],
    ids=["version", "code", "arithmetic", "package"],
)
def test_another_machine(
    machines: Machines, study: list[str], tmp_path: Path, code: str, setting: dict[str, str], said: str
) -> None:
    (tmp_path / "sitecustomize.py").write_text(code)
    machine = machines.join(PYTHONPATH=str(tmp_path), **setting)
    try:
        words = refused(*study, "--cluster", machines.address)
    finally:
        machines.leave(machine)
    assert said in words
    assert f"error: node {socket.gethostname()!r} " in words


@pytest.fixture
def doomed(here: Path) -> Iterator[Any]:
    """A module of the user's with jobs that do not end well."""
    (here / "doomed.py").write_text(DOOMED)
    import doomed  # noqa: PLC0415

    yield doomed
    sys.modules.pop("doomed", None)


def test_the_last_machine_dies(machines: Machines, doomed: Any, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "LOOK", 2.0)
    machines.join()
    with pytest.raises(UsageError, match="no machine with a core is in the cluster"):
        do_missing([Job("a", "k", doomed.take_down)], here / "kept", pool(1, machines.address, Needs(("doomed",))))


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("head", "it must be HOST:PORT of the cluster's head, or auto"),
        ("127.0.0.1:1", "no cluster can be reached at '127.0.0.1:1'"),
        ("127.0.0.1:99999", "no cluster can be reached"),
        ("no.such.host.invalid:6379", "no cluster can be reached"),
    ],
)
def test_no_cluster(study: list[str], address: str, said: str) -> None:
    assert said in refused(*study, "--cluster", address)


def test_who_answers_nothing_is_not_waited_for(study: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "ANSWER", 5.0)
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        assert "no Ray cluster answers at" in refused(*study, "--cluster", address)


def test_another_version_of_ray(machines: Machines, study: list[str]) -> None:
    """As a cluster would say of itself that was started with one."""
    store = GcsClient(address=machines.address)
    told = store.internal_kv_get(b"CLUSTER_METADATA", KV_NAMESPACE_CLUSTER)
    try:
        other = json.dumps(json.loads(told) | {"ray_version": "2.50.0"}).encode()
        store.internal_kv_put(b"CLUSTER_METADATA", other, True, KV_NAMESPACE_CLUSTER)
        words = refused(*study, "--cluster", machines.address)
    finally:
        store.internal_kv_put(b"CLUSTER_METADATA", told, True, KV_NAMESPACE_CLUSTER)
    assert "cannot be joined: RuntimeError: Version mismatch" in words
    assert "2.50.0" in words
