"""A success at the conveyor is an object that crossed its bin's opening and lies in the bin: either alone is none."""

from dataclasses import replace

import numpy as np
import pytest

from pnt_gym.cells.conveyor.outcome import PlannedResults, SimulatedThrows, judge
from tests.tools.throws import make_core, whole_cycle

COUNT = 6
CORE = make_core("ideal", COUNT)
CONFIG, CONTEXT = CORE.config, CORE.context
OPENING = CONTEXT.opening[:, 0]


@pytest.fixture(scope="module")
def flown() -> SimulatedThrows:
    return CORE.cell.plant.fly(CONTEXT, whole_cycle(CORE)[1])


def judged(flown, **changes):
    moved = replace(flown, touchdown=flown.touchdown._replace(**changes))
    never = np.zeros(COUNT, dtype=np.bool_)
    waiting = PlannedResults(np.full(COUNT, 0.1), np.zeros(COUNT, dtype=np.int64), never, never)
    return judge(moved, CONTEXT, CONFIG, CONFIG.acceptance(), np.full(COUNT, 0.9), waiting)


def test_through_the_opening_and_in_the_bin_is_a_success(flown):
    outcome = judged(flown)
    assert outcome.in_opening.all()
    assert outcome.in_bin.all()
    assert outcome.is_success.all()
    assert not outcome.rim.any()
    assert (outcome.cycle_time == 0.9).all()
    assert (outcome.wait_time == 0.1).all()


def test_an_object_that_lies_in_its_bin_without_having_crossed_its_opening_is_no_success(flown):
    outcome = judged(flown, landing=flown.touchdown.landing + np.stack([OPENING, 0.0 * OPENING], axis=1))
    assert outcome.in_bin.all()
    assert not outcome.in_opening.any()
    assert not outcome.is_success.any()
    assert (CORE.cell.reward(outcome)["success"] == 0.0).all()


def test_an_object_that_crossed_the_opening_and_bounced_out_is_no_success(flown):
    zero = 0.0 * OPENING
    outcome = judged(flown, position=flown.touchdown.position + np.stack([OPENING, zero, zero], axis=1))
    assert outcome.in_opening.all()
    assert not outcome.in_bin.any()
    assert not outcome.is_success.any()
    assert outcome.rim.all()
