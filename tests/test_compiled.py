"""The planner's machine code: made once, kept, made anew where it cannot be kept, and true to its Python text."""

import gc
import importlib
import os
import pty
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import gymnasium as gym
import numba
import numpy as np
import pytest

import pnt_gym
from agents.ground.places import SHIPPED as ROOT
from pnt_gym import compiled
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Floats1
from tests.tools.commands import environment, run_python
from tests.tools.nightly import with_nightly

# Prints the plans of 400 throws under a ceiling and in a workspace as hexadecimal bytes.
PLAN = """
import numpy as np
from pnt_gym.planning import EllipticWorkspace, MotionLimits, plan_release_batch, release_at_elevation
from tests.tools.planning import random_throws

picks, targets, numbers = random_throws(400, seed=51)
picks[:, :2] *= 0.6
space = EllipticWorkspace(z_min=-1.0, z_max=-0.65)
roof = picks[:, 2] + np.linspace(0.01, 0.2, 400)
plans = plan_release_batch(picks, targets, MotionLimits(*numbers), roof, 0.01, space)
level = release_at_elevation(picks, targets, MotionLimits(*numbers), 0.2)
parts = [x for p in (plans, level) for x in (p.position, p.velocity, p.angle, p.azimuth, p.time, p.flight_time)]
print(b"".join(x.tobytes() for x in (*parts, plans.reason, plans.ceiling_active, plans.workspace_active)).hex())
"""
# Prints observations and rewards of three steps of every environment, and of flights.
STEPS = """
import gymnasium as gym
import numpy as np
import pnt_gym

flights = {"level": {"base": "cells", "fidelity": "flight"}}
cases = [*((env_id, {}) for env_id in pnt_gym.ENV_IDS), ("PnTAdapt-v0", flights)]
for env_id, options in cases:
    env = gym.make(env_id, **options)
    env.action_space.seed(3)
    values = [env.reset(seed=3)[0]]
    for _ in range(3):
        observation, reward, *ends, _ = env.step(env.action_space.sample())
        values += [observation, reward]
        values += [env.reset()[0]] if any(ends) else []
    parts = [part for value in values for part in (value.values() if isinstance(value, dict) else [value])]
    print(*np.concatenate([np.ravel(part) for part in parts]).astype(float).tolist())
"""
KEPT = """
from pnt_gym.planning.straight.kernel import choose_slopes, release_rows
print(*(len(f.stats.cache_hits) + 10 * len(f.stats.cache_misses) for f in (choose_slopes, release_rows)))
"""


def run(code, **variables):
    done = run_python("-c", code, env=environment() | {name: str(value) for name, value in variables.items()})
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def known():
    """The plans as they come from the machine code that is kept."""
    return run(PLAN).stdout


def test_machine_code_computes_what_the_text_says(known):
    """To the bit: nothing is reordered, contracted or left over from an older text or constant."""
    assert run(PLAN, NUMBA_DISABLE_JIT=1).stdout == known
    assert len(known) > 400 * 19 * 8
    assert np.isfinite(np.frombuffer(bytes.fromhex(known.strip())[: 400 * 3 * 8])).mean() > 0.5


def test_environments_step_without_machine_code_as_with_it():
    """Almost to the bit: machine code multiplies for itself where its text has a power."""
    steps, texts = (run(STEPS, NUMBA_DISABLE_JIT=off).stdout.splitlines() for off in (0, 1))
    assert len(steps) == len(pnt_gym.ENV_IDS) + 1
    for step, text in zip(steps, texts, strict=True):
        np.testing.assert_allclose(np.array(text.split(), float), np.array(step.split(), float), rtol=1e-6, atol=1e-9)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """What two processes say that make the machine code at once, and the folder they keep it in."""
    folder = tmp_path_factory.mktemp("kept") / "new"
    with ThreadPoolExecutor(2) as both:
        return list(both.map(lambda code: run(code, NUMBA_CACHE_DIR=folder), (PLAN, PLAN))), folder


@pytest.mark.nightly
def test_two_processes_at_once_make_it_and_a_third_finds_it(made, known):
    found, folder = made
    assert [one.stdout for one in found] == [known, known]
    assert not any(one.stderr for one in found)
    assert run(KEPT, NUMBA_CACHE_DIR=folder).stdout.split() == ["1", "1"]


@pytest.mark.nightly
def test_an_index_that_cannot_be_read_is_made_anew(made, known, tmp_path):
    folder = shutil.copytree(made[1], tmp_path / "copy")
    for file in folder.rglob("*.nbi"):
        file.write_bytes(b"")
    done = run(PLAN, NUMBA_CACHE_DIR=folder)
    assert (done.stdout, done.stderr) == (known, "")
    assert run(KEPT, NUMBA_CACHE_DIR=folder).stdout.split() == ["1", "1"]


@pytest.mark.nightly
def test_where_it_cannot_be_kept_plans_are_made_all_the_same(known):
    # Nothing but a folder below a file is offered, as where neither the package nor the home can be written.
    where = {"NUMBA_CACHE_DIR": ROOT / "LICENSE" / "no", "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
    done = run(PLAN, **where)
    assert done.stdout == known
    assert done.stderr.count("set NUMBA_CACHE_DIR to an empty folder that can be written") == 1
    assert "Traceback" not in done.stderr


PARTS = """
from pnt_gym.compiled import kernel_part
from limits import LIMIT

@kernel_part
def shorten(length):
    return min(length, LIMIT) * {factor}
"""
WHOLE = """
from pnt_gym.compiled import kernel
from parts import shorten

@kernel
def shorten_twice(length: float) -> float:
    return shorten(shorten(length))
"""


@pytest.fixture
def imported(tmp_path, monkeypatch):
    """A module of a folder as a new process would import it, whose machine code lies in another folder."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "kept"))

    def import_anew(name):
        for file in tmp_path.glob("*.py"):
            sys.modules.pop(file.stem, None)
        compiled._text.cache_clear()
        importlib.invalidate_caches()
        return importlib.import_module(name)

    yield import_anew
    for file in tmp_path.glob("*.py"):
        sys.modules.pop(file.stem, None)


def test_code_on_disk_follows_functions_and_constants_of_other_files(tmp_path, imported):
    def shorten(limit, factor):
        (tmp_path / "limits.py").write_text(f"LIMIT = {limit}\n")
        (tmp_path / "parts.py").write_text(PARTS.format(factor=factor))
        (tmp_path / "whole.py").write_text(WHOLE)
        shorten_twice = imported("whole").shorten_twice
        return shorten_twice(8.0), len(shorten_twice.stats.cache_hits)

    assert shorten(6.0, 0.5) == (1.5, 0)
    assert shorten(6.0, 0.5) == (1.5, 1)
    assert shorten(4.0, 0.5) == (1.0, 0), "a constant changed"
    assert shorten(4.0, 0.25) == (0.25, 0), "a function changed"


TWO = """
from pnt_gym.compiled import kernel

@kernel
def double(length: float) -> float:
    return 2.0 * length

@kernel
def halve(length: float) -> float:
    return 0.5 * length
"""


def test_only_somebody_at_a_terminal_is_told_that_code_is_made(tmp_path):
    (tmp_path / "two.py").write_text(TWO)
    code = "import two"
    assert run(code, NUMBA_CACHE_DIR=tmp_path / "pipe", PYTHONPATH=tmp_path).stderr == ""
    for lines in (1, 0):  # made, and then found
        ours, theirs = pty.openpty()
        where = environment() | {"NUMBA_CACHE_DIR": str(tmp_path / "terminal"), "PYTHONPATH": str(tmp_path)}
        subprocess.run([sys.executable, "-c", code], env=where, stderr=theirs, check=True)
        os.write(theirs, b"end")
        said = os.read(ours, 10_000).decode()
        os.close(ours), os.close(theirs)
        assert said.count("pnt_gym makes machine code, once after an installation") == said.count("\n") == lines


KIND = """
from typing import NamedTuple
from pnt_gym.compiled import kernel

class {name}(NamedTuple):
    length: float

@kernel
def double(given: {name}) -> float:
    return 2.0 * given.length

print(double({name}(4.0)), len(double.stats.cache_hits))
"""


def test_code_on_disk_of_a_class_that_is_gone_is_made_anew(tmp_path):
    # Without bytecode on disk: Python takes it for that of another text of the same length and second.
    where = {"NUMBA_CACHE_DIR": tmp_path / "kept", "PYTHONPATH": tmp_path, "PYTHONDONTWRITEBYTECODE": 1}
    for name, hits in (("Old", "0"), ("New", "0"), ("New", "1")):
        (tmp_path / "kinds.py").write_text(KIND.format(name=name))
        done = run("import kinds", **where)
        assert (done.stdout.split(), done.stderr) == (["8.0", hits], "")


class Inner(NamedTuple):
    first: Floats1
    second: float


class Outer(NamedTuple):
    inner: Inner
    third: Floats1


@kernel
def nest(size: int) -> Outer:
    return Outer(Inner(np.zeros(size), 1.0), np.ones(size))


@kernel_part
def double(number):
    return 2 * number


@numba.njit  # compiled anew in every process, so that the versions of its parts are there
def double_all(number):
    return double(number) + double(0) + double(1)


def test_numbers_that_callers_write_out_bring_no_versions_of_their_own():
    assert double_all(20) == 42
    assert len(double.overloads) == 1


@kernel
def copy_values(target: Floats1, source: Floats1) -> None:
    target[:] = source


@numba.njit
def copy_elsewhere(target, source):
    target[:] = source


def test_an_array_of_another_shape_is_refused_and_numba_itself_is_as_before():
    target = np.zeros(2)
    copy_values(target, np.ones(2))
    assert target.tolist() == [1.0, 1.0]
    with pytest.raises(ValueError, match="place of another shape"):
        copy_values(target, np.ones(3))
    assert gc.isenabled()
    with pytest.raises(ValueError, match=r"slice of shape \(2,\) from input of shape \(3,\)"):
        copy_elsewhere(target, np.ones(3))


def entered(call):
    """Files of the Python code that a call enters."""
    files = []
    sys.setprofile(lambda frame, event, _: files.append(frame.f_code.co_filename) if event == "call" else None)
    try:
        call()
    finally:
        sys.setprofile(None)
    return files


def test_results_are_made_without_python_code():
    """Python handles signals where Python code begins; what Ctrl-C ended there, machine code would take for made."""
    nest(2)
    assert set(entered(lambda: nest(3))) <= {__file__}
    made = nest(3)
    assert (type(made), type(made.inner)) == (Outer, Inner)
    assert (made.inner.first.tolist(), made.inner.second, made.third.tolist()) == ([0.0] * 3, 1.0, [1.0] * 3)


@pytest.mark.parametrize("env_id", with_nightly(pnt_gym.ENV_IDS, ["PnTConveyor-v0", "PnTLine-v0"]))
def test_a_step_enters_no_python_code_of_numba(env_id):
    env = gym.make_vec(env_id, num_envs=2)

    def steps():
        env.reset(seed=3)
        for _ in range(6):
            env.step(np.zeros(env.action_space.shape, env.action_space.dtype))

    steps()  # what is made for the first time may
    files = entered(steps)
    assert len(files) > 500
    assert not [file for file in files if "numba" in file]


INTERRUPTED = """
import random, signal
import gymnasium as gym, numpy as np, pnt_gym

env = gym.make("PnTConveyor-v0", level={"base": "waste", "fidelity": "flight"})
env.reset(seed=0)

def step(count):
    for _ in range(count):
        *_, terminated, truncated, info = env.step(np.zeros(2, np.float32))
        if terminated or truncated:
            env.reset()

step(100)
signal.signal(signal.SIGALRM, signal.default_int_handler)
for _ in range(300):
    try:
        signal.setitimer(signal.ITIMER_REAL, random.uniform(1e-4, 5e-3))
        step(10**9)
    except KeyboardInterrupt:
        env.reset(seed=0)
print("unharmed")
"""


@pytest.mark.nightly
def test_three_hundred_interrupts_do_no_harm():
    assert run(INTERRUPTED).stdout == "unharmed\n"


def test_a_notebook_hears_that_machine_code_is_made_and_a_log_does_not(capsys, monkeypatch):
    monkeypatch.delitem(sys.modules, "ipykernel", raising=False)
    compiled._announce.__wrapped__()
    assert capsys.readouterr().err == ""
    monkeypatch.setitem(sys.modules, "ipykernel", None)
    compiled._announce.__wrapped__()
    assert "makes machine code, once" in capsys.readouterr().err
