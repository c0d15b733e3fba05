"""Settings for all tests: no OpenGL window, and no thread pools beside the ones a test asks for."""

import atexit
import gc
import os

import pytest
from hypothesis import settings

# How long an example takes depends on what else the machine does.
settings.register_profile("pnt_gym", deadline=None)
settings.load_profile("pnt_gym")

gc.disable()  # what is collected of tests stays to the end, so garbage is looked for after it only

COARSE = 256
"""Width of the map of shadows in tests [pixels]."""

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

# Chooses an offscreen OpenGL library, if there is one, before any test imports mujoco by itself.
import pnt_gym.engine  # noqa: E402, F401
from pnt_gym.cells.base.canvas import rendering_problem  # noqa: E402
from tests.tools.kernels import compile_kernels  # noqa: E402


def pytest_configure(config):
    """Kernels are compiled once, before workers start, each of which would compile all of them."""
    processes = getattr(config.option, "numprocesses", None)
    if processes:
        compile_kernels(processes)


def pytest_collection_finish():
    """What is collected stays to the end: collectors of garbage need not look through these millions of objects."""
    gc.freeze()
    gc.enable()
    gc.set_threshold(20_000, 20, 20)  # without what is frozen, a few new objects would already be a quarter of all
    atexit.register(gc.unfreeze)  # modules end as without tests


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


@pytest.fixture(scope="session", autouse=True)
def coarse_shadows():
    """Software draws pictures with coarse shadows five times as quickly; those that are means have them anyway."""
    from pnt_gym.cells.base import canvas  # noqa: PLC0415 - after the library of OpenGL is chosen

    def dressed(*given, **more):
        look = canvas_look(*given, **more)
        look.model.vis.quality.shadowsize, look.model.vis.quality.offsamples = COARSE, 0
        return look

    canvas_look = canvas.SceneLook
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(canvas, "SceneLook", dressed)
        yield


@pytest.fixture(scope="module")
def results_as_they_stand():
    """Figures of the project's results are read alone; the report and the pages compute them anew from the throws."""
    from agents.report import contents  # noqa: PLC0415  # most tests need no report

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contents.compare, "check", lambda content, **_: content)
        yield
    contents._read.cache_clear()
