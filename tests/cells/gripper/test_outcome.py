"""A success is an object that crossed the opening of its compartment and lies in it: either alone is none."""

from dataclasses import replace

import numpy as np
import pytest

from pnt_gym.cells.gripper.outcome import judge
from tests.tools.gripper import made

COUNT = 4
CELL = made("ideal", COUNT)
PLANS = CELL.context.plans
BESIDE = CELL.config.tray.opening[1] / 2 + 0.01
"""So far from the middle of a compartment is beside its opening [m]."""


@pytest.fixture(scope="module")
def flown():
    return CELL.plant.fly(CELL.context, PLANS)


def judged(flown, position):
    moved = replace(flown, flight=flown.flight._replace(position=position))
    return judge(moved, PLANS, CELL.config, CELL.planner.return_time(PLANS))


def test_through_the_opening_and_in_the_compartment_is_a_success(flown):
    outcome = judged(flown, flown.flight.position)
    assert outcome.in_opening.all()
    assert outcome.in_bin.all()
    assert outcome.is_success.all()
    assert not outcome.rim.any()


def test_an_object_that_lies_in_its_compartment_without_having_crossed_its_opening_is_no_success(flown):
    position = flown.flight.position.copy()
    last = flown.flight.last_step
    for row in range(COUNT):
        position[row, : last[row], 1] += BESIDE
    outcome = judged(flown, position)
    assert outcome.in_bin.all()
    assert not outcome.in_opening.any()
    assert not outcome.is_success.any()
    assert not outcome.rim.any()
    assert (CELL.reward(outcome)["success"] == 0.0).all()


def test_an_object_that_crossed_the_opening_and_bounced_out_is_no_success(flown):
    position = flown.flight.position.copy()
    position[np.arange(COUNT), flown.flight.last_step, 1] += BESIDE
    outcome = judged(flown, position)
    assert outcome.in_opening.all()
    assert not outcome.in_bin.any()
    assert not outcome.is_success.any()
    assert outcome.rim.all()


def test_errors_are_measured_along_and_across_the_throw(flown):
    outcome = judged(flown, flown.flight.position + np.array([0.004, -0.003, 0.0]))
    before = judged(flown, flown.flight.position)
    moved = np.stack([outcome.landing_along - before.landing_along, outcome.landing_across - before.landing_across])
    np.testing.assert_allclose(np.hypot(*moved), 0.005, atol=1e-9)
    np.testing.assert_allclose(moved[0], PLANS.heading[:, :2] @ [0.004, -0.003], atol=1e-9)
    np.testing.assert_allclose(outcome.landing_error, np.hypot(outcome.landing_along, outcome.landing_across))
