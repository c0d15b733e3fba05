"""Parts that fly freely into the pallets: who stays, who does not, and how it is judged."""

import numpy as np
import pytest

from pnt_gym.cells.one_joint.outcome import IN_POCKET, ON_STEM, is_joined, lies_at, lies_in_pocket
from pnt_gym.cells.one_joint.pallets import ASSEMBLY, SORTING, STAND, stack_pose
from pnt_gym.cells.one_joint.parts import AITCH, BLOCK, TEE
from tests.tools.capture import CaptureBench, rewind
from tests.tools.one_joint import GUESS, arriving

SCATTER = np.array([0.0025, 0.0025, np.deg2rad(2.0), 0.01, 0.01, 0.0])
"""Standard deviations of x, y, phi and their rates at the goal; the accuracy that learning reaches."""
LEAD, SETTLE = 0.10, 0.45
COUNT = 64
SORT = pytest.mark.parametrize("which", range(len(SORTING)), ids=[p.name for p in SORTING])


def scattered(state, seed):
    """States about one at a goal; the first is exact."""
    states = state + np.random.default_rng(seed).standard_normal((COUNT, 6)) * SCATTER
    states[0] = state
    return states


def across(state, misses):
    """States at a goal, moved square to the flight."""
    states = np.tile(state, (len(misses), 1))
    direction = state[3:5] / np.hypot(*state[3:5])
    states[:, :2] += np.asarray(misses)[:, None] * np.array([-direction[1], direction[0]])
    return states


def sort(which, states):
    """Blocks that pass states (N, 6) near a goal: whether each is sorted, and the end."""
    bench = CaptureBench(SORTING, [BLOCK], len(states))
    rest = bench.launch(rewind(states, LEAD)[:, None], LEAD + SETTLE)
    inside = lies_in_pocket(rest.pose[:, 0], rest.velocity[:, 0], SORTING[which])
    other = np.delete(rest.touched[:, 0], which, axis=1).any(axis=1)
    return inside & ~other, rest


@SORT
def test_blocks_with_the_accuracy_of_learned_throws_stay_in_the_pocket(which):
    pallet = SORTING[which]
    caught, rest = sort(which, scattered(arriving(BLOCK, pallet.goal, GUESS[pallet.name]), which))
    assert caught[0]
    assert caught.mean() >= 0.98
    assert rest.touched[caught, 0, which].all()
    # Flat on the bottom: it is off only along the play.
    miss = rest.pose[caught, 0] - pallet.pose
    height = miss[:, 1] * np.cos(pallet.pose[2]) - miss[:, 0] * np.sin(pallet.pose[2])
    np.testing.assert_allclose(height, 0.0, atol=2e-4)
    np.testing.assert_allclose(miss[:, 2], 0.0, atol=5e-3)


@SORT
def test_blocks_that_miss_by_centimetres_do_not_stay(which):
    pallet = SORTING[which]
    misses = [-0.08, -0.065, -0.05, -0.04, 0.04, 0.05, 0.065, 0.08]
    caught, _ = sort(which, across(arriving(BLOCK, pallet.goal, GUESS[pallet.name]), misses))
    assert not caught.any()


def test_a_throw_through_another_pallet_is_reported():
    steep = arriving(BLOCK, (*SORTING[2].goal[:3], -1.95), GUESS["pallet_3"])
    bench = CaptureBench(SORTING, [BLOCK], 1)
    rest = bench.launch(rewind(steep, 0.2)[None, None], 0.3)
    np.testing.assert_array_equal(rest.touched[0, 0, :2], [False, True])


def test_assembly_in_two_throws():
    (first, first_goal), (second, second_goal) = ASSEMBLY
    states = scattered(arriving(first, first_goal, GUESS["aitch"]), 10)
    rest = CaptureBench([STAND], [first], COUNT).launch(rewind(states, LEAD)[:, None], LEAD + SETTLE)
    seated = lies_in_pocket(rest.pose[:, 0], rest.velocity[:, 0], STAND, ON_STEM)
    assert seated[0]
    assert seated.mean() >= 0.98

    start = np.zeros((COUNT, 2, 6))
    start[:, 0, :3] = rest.pose[:, 0]
    start[:, 1] = rewind(scattered(arriving(second, second_goal, GUESS["tee"]), 11), LEAD)
    end = CaptureBench([STAND], [first, second], COUNT).launch(start, LEAD + SETTLE)
    stays = lies_in_pocket(end.pose[:, 0], end.velocity[:, 0], STAND, ON_STEM)
    done = seated & stays & is_joined(end.pose[:, 0], end.pose[:, 1], end.velocity[:, 1])
    assert done[0]
    assert done.mean() >= 0.97
    assert not end.touched[done, 1].any()  # the T is on the H, not on the stand
    assert not is_joined(end.pose[:, 0], start[:, 1, :3], end.velocity[:, 1]).any()


@pytest.mark.parametrize(("part", "goal"), ASSEMBLY, ids=["aitch", "tee"])
def test_parts_that_miss_the_stem_are_not_joined(part, goal):
    misses = np.array([-0.05, -0.03, -0.02, 0.02, 0.03, 0.05])
    states = across(arriving(part, goal, GUESS[part.name]), misses)
    start = np.zeros((len(misses), 2, 6))
    start[:, 0, :3], start[:, 1, :3] = STAND.pose, (0.0, 5.0, 0.0)  # waits high above
    moving = 0 if part is AITCH else 1
    start[:, moving] = rewind(states, LEAD)
    end = CaptureBench([STAND], [AITCH, TEE], len(misses)).launch(start, LEAD + SETTLE)
    seated = lies_in_pocket(end.pose[:, 0], end.velocity[:, 0], STAND, ON_STEM)
    joined = is_joined(end.pose[:, 0], end.pose[:, 1], end.velocity[:, 1])
    assert not (seated if part is AITCH else joined).any()


def test_what_lies_right_stays_there():
    start = np.zeros((1, 2, 6))
    start[0, 0, :3], start[0, 1, :3] = STAND.pose, stack_pose(STAND.pose)
    end = CaptureBench([STAND], [AITCH, TEE], 1).launch(start, 1.0)
    np.testing.assert_allclose(end.pose[0], start[0, :, :3], atol=2e-4)
    assert np.abs(end.velocity).max() < 1e-3


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
    assert lies_in_pocket(pose, velocity, SORTING[2])[0] == lies
