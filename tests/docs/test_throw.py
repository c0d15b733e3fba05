"""The page "How a throw is computed": its functions exist, a step enters them, and the drawing shows every stage."""

import sys
from xml.etree import ElementTree

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym  # noqa: F401 - registers the environments
from benchmarks.trace_step import Trace
from docs.pages import made, side, throw

STEPS = 6
"""Enough for a pick that seals."""


@pytest.fixture(scope="module")
def entered():
    """Names of the functions of the package that some steps enter."""
    env = gym.make("PnTConveyor-v0", level="waste").unwrapped
    env.reset(seed=0)
    trace = Trace()
    sys.setprofile(trace)
    try:
        for _ in range(STEPS):
            env.step(np.full(2, 0.1, dtype=np.float32))
    finally:
        sys.setprofile(None)
    env.close()
    return {name for _, name in trace.functions}


@pytest.mark.parametrize("name", [name for stage in throw.STAGES for name in stage.functions])
def test_a_step_enters_every_function_of_the_page(name, entered):
    assert callable(throw.function(name))
    assert name.startswith("agents.") or name.partition(":")[2] in entered


def test_the_drawing_is_the_written_one_and_has_every_stage_and_room():
    text = (made.DOCS / "pictures" / "throw.svg").read_text(encoding="utf-8")
    assert text == throw.drawing()
    words = [element.text for element in ElementTree.fromstring(text).iter("{http://www.w3.org/2000/svg}text")]
    assert {*throw.ROOMS.values(), *(stage.name for stage in throw.STAGES)} <= set(words)


def test_the_side_view_is_the_written_one_and_its_arrows_add_up():
    text = (made.DOCS / "pictures" / "throw_side.svg").read_text(encoding="utf-8")
    assert text == side.drawing()
    view = side.side_view()
    assert len(view.shifts) == 4
    assert all(abs(shift) > 0.01 for shift in view.shifts.values())
    env = gym.make("PnTRelease-v0", level=side.LEVEL)
    env.reset(seed=side.SEED)
    *_, info = env.step(np.zeros(2, dtype=np.float32))
    assert sum(view.shifts.values()) == pytest.approx(info["landing_along"], abs=1e-3)
    words = [element.text for element in ElementTree.fromstring(text).iter("{http://www.w3.org/2000/svg}text")]
    assert {*view.shifts, "together", f"{1000 * sum(view.shifts.values()):+.0f} mm"} <= set(words)
