"""Settings for all tests: no OpenGL window, and no thread pools beside the ones a test asks for."""

import importlib
import os
from pathlib import Path

import pytest
from hypothesis import settings

# How long an example takes depends on what else the machine does.
settings.register_profile("pnt_gym", deadline=None)
settings.load_profile("pnt_gym")

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

# Chooses an offscreen OpenGL library, if there is one, before any test imports mujoco by itself.
import pnt_gym.engine  # noqa: E402
from pnt_gym.cells.base.canvas import rendering_problem  # noqa: E402


def pytest_configure(config):
    """Kernels are compiled once, before workers start, each of which would compile all of them."""
    if getattr(config.option, "numprocesses", None):
        package = Path(pnt_gym.__file__).parent
        for file in package.rglob("*.py"):
            if "\n@kernel\n" in file.read_text(encoding="utf-8"):
                importlib.import_module(".".join(file.relative_to(package.parent).with_suffix("").parts))


def pytest_ignore_collect(collection_path, config):
    """The machines of a cluster need Ray, which `dev` does not bring: only who names their tests gets them."""
    named = any("tests/cluster" in str(argument) for argument in config.args)
    return True if collection_path.name == "cluster" and not named else None


@pytest.fixture(scope="session")
def opengl():
    """Pictures need an OpenGL library of the system; without one the tests of pictures say so and are left out."""
    problem = rendering_problem()
    if problem is not None:
        pytest.skip(problem)
