"""Parts thrown near their goals: who stays, who does not, and how it is judged."""

import numpy as np
import pytest

from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.context import Context
from pnt_gym.cells.one_joint.hidden import expected_hidden
from pnt_gym.cells.one_joint.outcome import IN_POCKET, judge, lies_at, lies_in
from pnt_gym.cells.one_joint.pallets import SORTING, STAND
from pnt_gym.cells.one_joint.plant import OneJointPlant
from pnt_gym.cells.one_joint.tasks import Job
from tests.tools.one_joint import GUESS, arrival, release
from tests.tools.thrower import throws

SCATTER = np.array([0.0025, 0.0025, np.deg2rad(2.0), 0.01])
"""Standard deviations of x, y, phi and dy at the goal; the accuracy that learning reaches."""
COUNT = 64
SORT = pytest.mark.parametrize("which", range(len(SORTING)), ids=[p.name for p in SORTING])


def thrown(task, kind, misses, lying=None):
    """Outcome of throws that pass a goal by misses (N, 4), whatever the arm's limits; other parts may lie there."""
    config, count = OneJointConfig.load("ideal", task=task), len(misses)
    job = Job.of(config)
    target = job.targets[kind]
    height, guess = job.parts[target.part].half_height, GUESS[target.name]
    plan = throws([release(state, height, guess) for state in target.state + misses])
    kinds, parts, goal = np.full(count, kind), np.full(count, target.part), np.tile(target.state, (count, 1))
    lying = np.full((count, len(job.parts), 3), np.nan) if lying is None else lying
    context = Context(kinds, parts, goal, goal, plan, lying, expected_hidden(count, config))
    flight = OneJointPlant(config, count, 1).fly(context, plan)
    return judge(flight, context, plan, job, config, np.zeros(count))


def scatter(seed):
    """Misses of which the first is none."""
    return np.random.default_rng(seed).standard_normal((COUNT, 4)) * SCATTER * (np.arange(COUNT) > 0)[:, None]


def across(task, kind, misses):
    """Misses [m] square to the flight."""
    job = Job.of(OneJointConfig.load("ideal", task=task))
    target = job.targets[kind]
    height = job.parts[target.part].half_height
    way = arrival(release(np.array(target.state), height, GUESS[target.name])[None], height)[0, 3:5]
    return np.asarray(misses)[:, None] * np.array([-way[1], way[0], 0.0, 0.0]) / np.hypot(*way)


@SORT
def test_blocks_with_the_accuracy_of_learned_throws_stay_in_the_pocket(which):
    outcome = thrown("sort", which, scatter(which))
    caught = outcome.is_success
    assert caught[0]
    assert caught.mean() >= 0.98
    # Flat on the bottom: it is off only along the play.
    miss, angle = outcome.final[caught, 0] - SORTING[which].pose, SORTING[which].pose[2]
    np.testing.assert_allclose(miss[:, 1] * np.cos(angle) - miss[:, 0] * np.sin(angle), 0.0, atol=2e-4)
    np.testing.assert_allclose(miss[:, 2], 0.0, atol=5e-3)


@SORT
def test_blocks_that_miss_by_centimetres_do_not_stay(which):
    misses = [-0.065, -0.05, -0.04, 0.04, 0.05, 0.065]
    assert not thrown("sort", which, across("sort", which, misses)).in_pallet.any()


def test_assembly_in_two_throws():
    first = thrown("assembly", 0, scatter(10))
    assert first.is_success[0]
    assert first.is_success.mean() >= 0.98
    lying = np.full((COUNT, 2, 3), np.nan)
    lying[:, 0] = first.final[:, 0]
    second = thrown("assembly", 1, scatter(11), lying)
    done = first.is_success & second.is_success
    assert done[0]
    assert done.mean() >= 0.97


@pytest.mark.parametrize("kind", [0, 1], ids=["aitch", "tee"])
def test_parts_that_miss_the_stem_are_not_joined(kind):
    misses = across("assembly", kind, [-0.05, -0.03, -0.02, 0.02, 0.03, 0.05])
    lying = np.full((len(misses), 2, 3), np.nan)
    if kind == 1:
        lying[:, 0] = STAND.pose
    assert not thrown("assembly", kind, misses, lying).is_success.any()


@pytest.mark.parametrize(
    ("miss", "rate", "lies"),
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), True),
        ((0.0, 0.0, 2 * np.pi), (0.0, 0.0, 0.0), True),
        ((0.0, 0.0, -4 * np.pi + 0.05), (0.0, 0.0, 0.0), True),
        ((0.0, 0.0, np.pi), (0.0, 0.0, 0.0), False),
        ((0.005, 0.005, 0.0), (0.0, 0.0, 0.0), True),
        ((0.006, 0.006, 0.0), (0.0, 0.0, 0.0), False),
        ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0), False),
        ((0.0, 0.0, 0.0), (0.0, 0.03, 0.0), False),
        ((0.0, 0.0, 0.0), (0.0, 0.0, -0.5), False),
    ],
)
def test_lying_is_near_turned_right_and_still(miss, rate, lies):
    seat = SORTING[2].pose
    pose, velocity = (seat + miss)[None], np.array([rate])
    assert lies_at(pose, velocity, seat, IN_POCKET)[0] == lies
    assert lies_in(pose, velocity, SORTING[2])[0] == lies
