"""Grasps and throws of a batch: what a try changes, and what it leaves as it was."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base.core import Step
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.groups import offsets
from pnt_gym.cells.grasp.images import pixel_places
from pnt_gym.errors import ActionError, ConfigError
from tests.tools.throws import make_core, same_bits

AGAIN, RIDE = 1.0, -1.0
FLIGHT = {"fidelity": "flight"}


def cells(count: int = 16, seed: int = 0, **level: Any) -> GraspCore:
    """Cells of a level that differs from `grasp`, with their first objects."""
    core = GraspCore(GraspConfig.load({"base": "grasp", **FLIGHT, **level}), count)
    core.reset(np.arange(count), [np.random.default_rng(seed + i) for i in range(count)], seeded=True)
    return core


def step(core: GraspCore, place: Any = (0.0, 0.0), choice: float = 0.0, pace: float = 0.0) -> Step:
    """A step in which all cells do the same, with places in metres."""
    action = np.zeros((core.count, *core.action_space.shape))
    action[:, :2] = np.asarray(place) / core.config.grasp.reach
    if action.shape[1] == 6:
        action[:, 2] = choice
    action[:, -3] = pace
    return core.step(action)


@pytest.mark.parametrize("fidelity", ["flight", "full"])
def test_without_surfaces_a_grasp_of_zero_is_the_throw_of_the_conveyor_to_the_bit(fidelity: str) -> None:
    level = {"base": "waste", "fidelity": fidelity}
    core = GraspCore(GraspConfig.load({**level, "grasp": {"stages": 1, "pace": [0.18, 1.0]}}), 8)
    core.reset(np.arange(8), [np.random.default_rng(i) for i in range(8)], seeded=True)
    plain = make_core(level, 8)
    for _ in range(3):
        ours, theirs = step(core, pace=1.0), plain.step(np.zeros((8, 2)))
        assert same_bits(ours.reward, theirs.reward)
        assert all(same_bits(ours.info[name], theirs.info[name]) for name in theirs.info)
        assert same_bits(core.observe()["vector"][:, :17], plain.observe()[:, :17])


def test_what_follows_a_grasp_is_the_same_in_one_stage_and_in_two() -> None:
    place = (0.01, -0.005)
    one, two = cells(grasp={"stages": 1}), cells()
    both = step(one, place, pace=-0.5)
    held = step(two, place).info["held"]
    thrown = step(two, place, pace=-0.5)
    assert 4 < held.sum() < 16
    assert same_bits(held, both.info["held"])
    for name in ("landing_error", "cycle_time", "grip_margin", "pace", "energy"):
        assert same_bits(both.info[name][held], thrown.info[name][held]), name


def test_a_cup_beside_the_object_holds_nothing_and_the_next_step_tries_again() -> None:
    core = cells()
    miss = step(core, (0.1, 0.1))
    assert not miss.info["held"].any()
    left = miss.partial.get("cycle_time", np.zeros(16, dtype=bool))  # where the window leaves no time for another try
    again = step(core, (0.0, 0.0))
    goes_on = ~left
    assert (again.info["tries"][goes_on] == 2).all()
    assert again.info["held"][goes_on].mean() > 0.5


def test_an_object_is_given_up_after_a_failed_try_but_not_before_one() -> None:
    core = cells()
    first = step(core, (0.1, 0.1), RIDE)
    assert (first.info["tries"] == 1).all()
    ended = first.partial.get("cycle_time", np.zeros(16, dtype=bool))
    second = step(core, choice=RIDE)
    assert second.partial["cycle_time"][~ended].all()
    assert not second.info["picked"][~ended].any()


def test_an_object_is_given_up_before_a_try_where_the_level_allows_it() -> None:
    """The hand then goes on without the dwell that a failed try takes."""
    skips, tries = (cells(grasp={"skip": skip, "tries": 1}) for skip in (True, False))
    skipped, tried = step(skips, choice=RIDE), step(tries, (0.1, 0.1), RIDE)
    assert (skipped.info["tries"] == 0).all()
    assert skipped.partial["cycle_time"].all()
    assert not skipped.info["picked"].any()
    failed = ~tried.info["held"]
    saved = tried.info["cycle_time"] - skipped.info["cycle_time"]
    np.testing.assert_allclose(saved[failed], skips.dwell, atol=0.05)
    assert (step(skips).info["tries"] == 1).all()


def test_an_object_that_hangs_can_be_put_down() -> None:
    core = cells()
    held = step(core).info["held"]
    result = step(core, choice=RIDE)
    assert held.any()
    assert not result.info["picked"][held].any()
    assert np.isnan(result.info["landing_error"][held]).all()


def test_a_further_try_costs_its_time_and_moves_the_object_with_the_belt() -> None:
    once, twice = cells(), cells()
    held = step(once).info["held"]
    step(twice)
    left = twice.tries_left() > 0
    before = twice.picks.pick.copy()
    held_again = step(twice, choice=AGAIN).info["held"]
    rows = held & held_again & left
    assert rows.sum() > 3
    np.testing.assert_allclose((twice.picks.pick - before)[rows, 0], 0.20 * twice.config.belt.speed, atol=1e-12)
    assert (twice.picks.spent[rows] == 0.20).all()
    first, second = (step(core).info["cycle_time"] for core in (once, twice))
    assert (second[rows] - first[rows] > 0.15).all()


def test_a_slower_throw_asks_less_of_the_grip() -> None:
    slow, fast = cells(), cells()
    for core in (slow, fast):
        step(core)
    low, high = step(slow, pace=-1.0), step(fast, pace=1.0)
    rows = low.partial["cycle_time"] & low.info["picked"]
    assert (low.info["pace"][rows] >= 0.18 - 1e-12).all()
    assert (high.info["pace"][rows] <= 0.60 + 1e-12).all()
    assert (low.info["grip_margin"][rows] > high.info["grip_margin"][rows]).mean() > 0.9
    assert (low.info["cycle_time"][rows] > high.info["cycle_time"][rows]).all()


def test_the_gauge_reads_more_where_less_leaks() -> None:
    core = cells(64)
    result = step(core)
    leak, vacuum = result.info["leak"], result.info["vacuum"]
    assert np.corrcoef(np.log(leak), np.log(vacuum))[0, 1] < -0.7
    assert result.info["leak"][result.info["held"]].max() < leak.max()


def test_what_is_hidden_changes_no_observation() -> None:
    core, other = cells(), cells()
    objects = other.picks.objects
    changed = other.picks.replace(
        objects=objects.replace(seal=objects.seal * 2.0, grasp=objects.grasp + 0.01, mass=objects.mass * 3.0)
    )
    other.picks = other.cell.context = changed
    seen, told = core.observe(), other.observe()
    assert same_bits(seen["vector"], told["vector"])
    assert same_bits(seen["image"], told["image"])


def test_gauge_and_scales_are_read_only_with_the_object_under_the_cup() -> None:
    core = cells()
    assert not core.observe()["vector"][:, 25:30].any()
    held = step(core).info["held"]
    gauged = core.observe()["vector"][:, 25:30].any(axis=1)
    assert gauged[held].all()
    assert not gauged[~held].any()


def test_a_mismatch_of_zero_holds_every_object() -> None:
    core = cells(mismatch=0.0)
    assert step(core).info["held"].all()


def test_objects_of_a_group_do_not_overlap_and_the_nearest_to_the_cup_is_grasped() -> None:
    core = cells(32, grasp={"objects": 3})
    groups = core.cell.source.groups
    place = groups.pick[..., :2] - groups.pick[:, :1, :2]
    np.testing.assert_allclose(place, offsets(groups.objects), atol=1e-12)
    gap = np.linalg.norm(place[:, 1:], axis=2)
    smallest = groups.objects.size[..., :2].min(axis=2)
    assert (gap > (smallest[:, :1] + smallest[:, 1:]) / 2.0).all()
    action = np.zeros((32, 6))
    action[:, :2] = np.clip(place[:, 2] / core.config.grasp.reach, -1.0, 1.0)
    core.step(action)
    near = np.abs(place[:, 2]).max(axis=1) < core.config.grasp.reach
    assert near.sum() > 16
    assert same_bits(core.picks.objects.kind[near], groups.objects.kind[near, 2])


@pytest.mark.parametrize("picks", ["independent", "belt"])
def test_flights_and_the_whole_robot_hold_and_drop_the_same_objects(picks: str) -> None:
    cores = [cells(12, seed=3, fidelity=fidelity, grasp={"picks": picks}) for fidelity in ("flight", "full")]
    for _ in range(4):
        flight, full = (step(core, pace=0.3) for core in cores)
        assert same_bits(flight.info["held"], full.info["held"])
        if "dropped" in full.info:
            rows = full.partial["dropped"]
            assert same_bits(flight.info["dropped"][rows], full.info["dropped"][rows])


def test_an_object_that_would_ride_out_of_reach_stays_where_it_can_be_thrown_from() -> None:
    core = cells(64)
    for time, least, most in ((0.2, 0.9, 1.0), (3.0, 0.0, 0.1)):
        ridden = core._ridden(core.picks, np.full(64, time))
        moved = ridden.pick[:, 0] - core.picks.pick[:, 0]
        rides = np.isclose(moved, time * core.config.belt.speed)
        assert least <= rides.mean() <= most
        assert (moved[~rides] == 0.0).all()
        assert ridden.plan.feasible.all()
        assert (ridden.spent == core.picks.spent + time).all()


def test_a_pace_at_which_no_throw_reaches_its_target_is_raised_as_little_as_needed() -> None:
    rules = {"stages": 1, "pace": [0.05, 1.0]}
    slow = step(cells(32, grasp=rules), pace=-1.0).info
    raised = slow["pace"] > 0.05 + 1e-9
    assert 4 < raised.sum() < 32
    assert same_bits(slow["residual_clipped"], raised)
    below: Any = (np.maximum(0.97 * slow["pace"], 0.05) - 0.05) / 0.475 - 1.0
    again = step(cells(32, grasp=rules), pace=below).info["pace"]
    np.testing.assert_allclose(again[raised], slow["pace"][raised], rtol=0.01)


def test_a_place_without_a_throw_is_moved_towards_the_middle_as_little_as_needed() -> None:
    asked, rules = np.array([-0.1, -0.1]), {"stages": 1}
    place = step(cells(64, grasp=rules), asked).info["place"]
    share = place[:, :1] / asked[0]
    np.testing.assert_allclose(place, share * asked, atol=1e-12)
    assert 0 < (share < 1.0 - 1e-9).sum() < 32
    again = step(cells(64, grasp=rules), np.minimum(1.02 * share, 1.0) * asked).info["place"]
    np.testing.assert_allclose(again, place, atol=1e-4)


def test_the_action_of_a_pixel_puts_the_cup_there() -> None:
    env: Any = gym.make("PnTGrasp-v0", level={"base": "grasp", **FLIGHT}).unwrapped
    env.reset(seed=0)
    *_, info = env.step(env.pixel_action(20, 30))
    np.testing.assert_allclose(info["place"], pixel_places()[20, 30], atol=1e-7)
    for row, column in ((-1, 20), (20, 48), (0, 0)):
        with pytest.raises(ActionError, match=r"pixel|picture"):
            env.pixel_action(row, column)


@pytest.mark.parametrize(
    ("level", "words"),
    [
        ({"grasp": {"pace": [0.9, 0.3]}}, "grasp.pace runs from 0.9 to 0.3"),
        ({"grasp": {"skip": True, "picks": "belt"}}, "grasp.skip is true; on the belt"),
        ({"grasp": {"objects": 3, "picks": "belt"}}, "grasp.objects is 3; it must be 1 in a shift"),
        ({"belt": {"tracking": False}}, "grasp.tries is 2; without belt.tracking it must be 1"),
        ({"drift": {"delay": {"even": 0.005}}}, "shows landings from which a drift could be learned"),
    ],
)
def test_a_level_in_which_a_grasp_makes_no_sense_is_refused(level: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        GraspConfig.load({"base": "grasp", **level})
