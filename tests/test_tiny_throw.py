"""The throw in plain NumPy: its plans and landings are those of the suite, in every air and for every kind of thing."""

import importlib.util
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym  # noqa: F401 - registers the environments

FILE = Path(__file__).resolve().parents[1] / "examples" / "09_tiny_throw.py"
CELLS = 20
MILLIMETRE = 1e-3


@pytest.fixture(scope="module")
def tiny():
    spec = importlib.util.spec_from_file_location("tiny_throw", FILE)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def first_throws(level, seed):
    """The core before the first throws of cells, and what the suite says of these throws."""
    level = {"base": level, "fidelity": "flight"}
    core = gym.make_vec("PnTRelease-v0", num_envs=CELLS, level=level).unwrapped
    core.reset(seed=seed)
    return core.core, core.core.preview(np.zeros((CELLS, 2)), jitter=True)


@pytest.mark.parametrize(("level", "seed"), [("nominal_plain", 11), ("waste_plain", 222), ("unseen_plain", 3333)])
def test_a_tiny_throw_lands_where_the_suite_says(tiny, level, seed):
    core, outcome = first_throws(level, seed)
    plans, rows = core.cell.context.plan, np.flatnonzero(~outcome.recontact)  # a cup that touches again is no flight
    assert len(rows) > 0.9 * CELLS
    assert plans.ceiling_active[rows].any()
    assert not plans.ceiling_active[rows].all()
    for row in rows:
        thrown = tiny.throw(*tiny.coming(core, row))
        assert thrown.plan.distance == pytest.approx(plans.distance[row], abs=1e-6)
        assert thrown.plan.time == pytest.approx(plans.time[row], abs=1e-6)
        np.testing.assert_allclose(thrown.plan.ahead, plans.direction[row], atol=1e-6)
        assert np.linalg.norm(thrown.landing - outcome.landing[row]) < MILLIMETRE
    miss = np.linalg.norm(outcome.landing - core.cell.context.target[:, :2], axis=1)
    assert np.median(miss[rows]) > 20 * MILLIMETRE  # so that a planned landing would not pass


def test_every_hidden_value_moves_the_landing(tiny):
    core, _ = first_throws("waste_plain", 5)
    thing, *place = tiny.coming(core)
    landing = tiny.throw(thing, *place).landing
    changed = {"delay": thing.delay + 0.01, "drag": 2 * thing.drag, "spin": thing.spin + 20.0, "mass": thing.mass / 2}
    for name, value in changed.items():
        moved = tiny.throw(thing._replace(**{name: value}), *place).landing
        assert np.linalg.norm(moved - landing) > MILLIMETRE, name


def test_a_point_that_is_let_go_at_once_hits_in_a_vacuum(tiny):
    core, _ = first_throws("nominal_plain", 7)
    for row in range(4):
        thing, pick, target, limits = tiny.coming(core, row)
        point = thing._replace(hanging=np.zeros(3), delay=0.0)
        landing = tiny.throw(point, pick, target, limits, share=0.0).landing
        assert np.linalg.norm(landing - target[:2]) < 2 * MILLIMETRE  # what Euler's steps cost


def test_the_hand_stops_after_its_window(tiny):
    limits = tiny.Limits(2.4, 48.0, 1200.0)
    plan = tiny.plan(np.array([0.0, -0.3, -0.83]), np.array([0.3, 0.5, -0.75]), limits)
    way, speed = tiny.hand(plan.time, plan, limits)
    assert (way, speed) == pytest.approx((plan.distance, plan.speed), abs=1e-9)
    way, speed = tiny.hand(plan.time + tiny.WINDOW, plan, limits)
    assert (way, speed) == pytest.approx((plan.distance + tiny.WINDOW * plan.speed, plan.speed), abs=1e-9)
    assert tiny.hand(9.0, plan, limits)[1] == pytest.approx(0.0, abs=1e-9)
