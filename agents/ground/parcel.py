"""Conditions for equal results on another machine: the same code, user's modules, packages and arithmetic."""

from __future__ import annotations

import hashlib
import importlib
import shutil
import socket
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from .cli import UsageError
from .environments import import_user_module, make_vector
from .fitting import fit_from
from .places import CHECKOUT, CODE
from .versions import code_digest, versions

PARTS: Final = (
    ("pnt_gym", "agents", "benchmarks/studies", "configs", "results/policies", "pyproject.toml")
    if CHECKOUT
    else ("pnt_gym",)
)
"""Parts below `CODE` that are sent: the code, the files it reads and the shipped policies, but no other results."""
_TEXTS: Final = (
    "pnt_gym/**/*.py",
    "pnt_gym/**/*.y*ml",
    "agents/**/*.py",
    "benchmarks/studies/*.py",
    "configs/**/*.y*ml",
)
_MOST: Final = 200_000_000
"""Largest size of a user's module that is sent [bytes]."""


def pack(folder: Path, modules: Iterable[str]) -> None:
    """Copy the code, and the user's modules that are no part of it, into an empty folder.

    Machine code that lies beside the modules goes with them: a node whose processor is the same compiles nothing.

    Raises:
        UsageError: a module has no file, or is too large.
    """
    for part in PARTS:
        _copy(CODE / part, folder / part)
    for top in sorted({name.partition(".")[0] for name in modules} - {*PARTS}):
        # The file of a module, or the folder of a package.
        package = import_user_module(top)
        if package.__file__ is None:
            raise UsageError(f"module {top!r} lies in no file, so it cannot be sent to a node; give it an __init__.py")
        file = Path(package.__file__).resolve()
        source = file.parent if hasattr(package, "__path__") else file
        size = sum(path.stat().st_size for path in (source, *source.rglob("*")) if path.is_file())
        if size > _MOST:
            raise UsageError(
                f"module {top!r} takes {size / 1e6:.0f} MB; at most {_MOST / 1e6:.0f} MB are sent to a node"
            )
        _copy(source, folder / source.name)


def _copy(source: Path, target: Path) -> None:
    if source.is_dir():
        # Numba writes its files under temporary names, which may be gone a moment later.
        shutil.copytree(source, target, ignore=shutil.ignore_patterns("*.pyc", "*.pyc.*", "*.nb?.tmp.*"))
    else:
        shutil.copyfile(source, target)


@cache
def digest(module: str) -> str:
    """Digest of the code of a user's module or package."""
    package = import_user_module(module)
    file = Path(package.__file__ or "")
    return code_digest(["**/*.py" if hasattr(package, "__path__") else file.name], root=file.parent)


def identity(modules: Iterable[str], torch: bool) -> dict[str, str]:
    """Versions, code digests and fingerprints of arithmetic that must be equal on all machines of a study, by name.

    Args:
        modules: names of the user's modules that the jobs import.
        torch: whether jobs train networks, so that torch's arithmetic counts.
    """
    return dict(_identity(modules, torch))


def check(head_identity: Mapping[str, str], modules: Iterable[str], torch: bool) -> None:
    """Make sure that this process computes the same as another one; `head_identity` is the other one's `identity`.

    The comparison stops at the first difference, before arithmetic that depends on differing packages.

    Raises:
        UsageError: this process differs; the message names this machine and the first difference.
    """
    for name, value in _identity(modules, torch):
        if value != head_identity[name]:
            raise UsageError(
                f"node {socket.gethostname()!r} "
                f"{_DIFFERENCES.get(name, _PACKAGE).format(name, value, head_identity[name])}"
            )


_PACKAGE: Final = "has {0} {1}, here it is {2}; a study needs the same everywhere"
_DIFFERENCES: Final = {
    "code": "runs other code of pnt_gym than this machine, perhaps from a folder in its PYTHONPATH",
    "arithmetic": "rounds otherwise than this machine, so its throws would not be these; leave it out of the cluster",
    "torch's arithmetic": "rounds otherwise than this machine when a network is fitted; leave it out of the cluster",
}


def _identity(modules: Iterable[str], torch: bool) -> Iterator[tuple[str, str]]:
    yield "code", code_digest(_TEXTS)
    # A machine that received the code need not have the package installed.
    yield from ((name, version) for name, version in versions().items() if name != "pnt_gym")
    yield from ((f"module {name}", digest(name)[:12]) for name in modules)
    yield "arithmetic", arithmetic()
    if torch:
        yield "torch's arithmetic", torch_arithmetic()


@cache
def arithmetic() -> str:
    """Fingerprint of some throws and of NumPy's arithmetic, in which processors round differently."""
    random = np.random.default_rng(0)
    numbers, square = random.standard_normal(999), random.standard_normal((24, 24))
    results = [np.exp(numbers), np.sin(numbers), np.tanh(numbers), square @ square, *np.linalg.svd(square)]
    with closing(make_vector("PnTRelease-v0", "waste", num_envs=2, threads=1)) as env:
        env.reset(seed=0)
        observations, reward, _, _, info = env.step(np.full(env.action_space.shape or (), 0.3, dtype=np.float32))
    return _digest([*results, observations, reward, info["landing_error"]])


@cache
def torch_arithmetic() -> str:
    """Fingerprint of some training steps of a small network on one core, as in a job."""
    torch: Any = importlib.import_module("torch")
    with fit_from(0):
        network = torch.nn.Sequential(torch.nn.Linear(26, 64), torch.nn.SiLU(), torch.nn.Linear(64, 2))
        batch = torch.randn(256, 26)
        optimiser = torch.optim.Adam(network.parameters())
        for _ in range(3):
            optimiser.zero_grad()
            network(batch).square().mean().backward()
            optimiser.step()
    return _digest([part.detach().numpy() for part in network.parameters()])


def _digest(arrays: Iterable[Any]) -> str:
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()[:12]
