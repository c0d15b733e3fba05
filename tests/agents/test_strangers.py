"""Run folders that a stranger made to cost memory or to hang: one sentence, before anything is unpacked."""

import io
import os
import shutil
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
import pytest

from agents.ground.places import POLICY
from tests.tools.commands import run_python
from tests.tools.nightly import with_nightly

MOST: Final = 600
"""Of memory [MB]; a command that throws takes some 250."""
PATIENCE: Final = 120
"""A command that takes longer hangs [s]."""
PEAK: Final = """\
import resource, subprocess, sys
code = subprocess.run(sys.argv[1:]).returncode
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(code)
"""
"""Runs a command, and prints the most memory that it took [kB]."""


def zeros(file: Path, name: str, numbers: int, count: int = 1) -> None:
    """Arrays of zeros, packed a thousand times smaller."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f4", "fortran_order": False, "shape": (numbers, 1)})
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as parts:
        for k in range(count):
            with parts.open(f"{name}_{k}.npy", "w", force_zip64=True) as part:
                part.write(header.getvalue())
                for _ in range(numbers // 2**20):
                    part.write(bytes(2**22))


def sparse(name: str) -> Callable[[Path], object]:
    """A file of a terabyte, of which the disk holds nothing."""
    return lambda folder: os.truncate(folder / name, 2**40)


def endless(folder: Path) -> None:
    (folder / "policy.npz").unlink()
    (folder / "policy.npz").symlink_to("/dev/zero")


FOLDERS: Final[dict[str, Callable[[Path], object]]] = {
    "one large array": lambda folder: zeros(folder / "policy.npz", "weight", 2**28),
    "many arrays": lambda folder: zeros(folder / "policy.npz", "weight", 2**20, 200),
    "policy without an end": endless,
    "large level": sparse("env.yaml"),
}
"""What makes an honest folder another one, by what is wrong with it; for other files see `tests/test_reading.py`."""


@pytest.mark.parametrize("kind", with_nightly(FOLDERS, ["large level"]))
def test_a_folder_that_would_cost_memory_is_refused_in_a_sentence(kind: str, tmp_path: Path) -> None:
    shutil.copytree(POLICY, tmp_path / "run", ignore=shutil.ignore_patterns("*.mp4", "*.zip", "*.onnx"))
    FOLDERS[kind](tmp_path / "run")
    command = (sys.executable, "-m", "agents.evaluate", "--controller", "run", "--picks", "8")
    done = run_python("-c", PEAK, *command, cwd=tmp_path, timeout=PATIENCE)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("error: "), done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert int(done.stdout.split()[-1]) < MOST * 1024
