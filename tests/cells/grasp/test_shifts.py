"""Shifts of unrelated picks: what stays for a shift, and what observations tell of the last step."""

import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.drawn import drawn_kinds
from pnt_gym.cells.grasp.observation import LAST
from pnt_gym.errors import ConfigError
from tests.tools.throws import same_bits

PICKS = 8
LEVEL = {"base": "grasp_shift", "picks_per_shift": PICKS, "drawn": {"kinds": 30}, "grasp": {"kinds": 3}}
RIDE = -1.0


def vector(count: int = 6, **level: Any) -> Any:
    return gym.make_vec("PnTGrasp-v0", num_envs=count, level={**LEVEL, **level}, threads=1)


def actions(count: int, choice: float = 0.0, place: Any = (0.0, 0.0)) -> Any:
    action = np.zeros((count, 6), dtype=np.float32)
    action[:, :2], action[:, 2] = place, choice
    return action


def run_shift(env: Any, seed: int) -> tuple[list[Any], list[Any]]:
    """True kinds and errors of the cup of two shifts of which every object is given up."""
    env.reset(seed=seed)
    kinds, errors = list[Any](), list[Any]()
    for _ in range(2 * PICKS):
        context = env.unwrapped.core.context
        kinds.append(context.objects.kind.copy())
        errors.append(context.drift.camera.copy())
        env.step(actions(env.num_envs, RIDE))
    return kinds, errors


def test_a_shift_has_a_few_kinds_of_its_own_and_one_error_of_the_cup() -> None:
    kinds, errors = (np.array(values) for values in run_shift(vector(), 3))
    for row in range(6):
        first, second = kinds[:PICKS, row], kinds[PICKS:, row]
        assert len(set(first)) <= 3
        assert len(set(second)) <= 3
        assert set(first) != set(second)
        assert len(np.unique(errors[:PICKS, row], axis=0)) == 1
        assert not np.allclose(errors[0, row], errors[PICKS, row])
    assert 0.005 < errors.std() < 0.03


def test_the_first_kind_of_a_shift_comes_most_often() -> None:
    kinds, _ = run_shift(vector(64, picks_per_shift=40), 1)
    counts = [np.sort(np.unique(row[:PICKS], return_counts=True)[1])[::-1] for row in np.array(kinds).T]
    assert 0.42 < np.mean([count[0] for count in counts]) / PICKS < 0.68  # 1 / (1 + 1/2 + 1/3) = 0.55, and luck


def test_a_row_of_a_batch_is_the_single_environment_to_the_bit() -> None:
    batch, random = vector(3), np.random.default_rng(0)
    seen, _ = batch.reset(seed=5)
    single = gym.make("PnTGrasp-v0", level=LEVEL, threads=1)
    alone, _ = single.reset(seed=6)
    for _ in range(10):
        assert all(same_bits(seen[name][1], alone[name]) for name in ("image", "vector", "last"))
        action = random.uniform(-1.0, 1.0, (3, 6)).astype(np.float32) * np.float32(0.2)
        seen = batch.step(action)[0]
        alone = single.step(action[1])[0]


def test_a_copy_continues_the_shift() -> None:
    env = vector(2)
    env.reset(seed=1)
    env.step(actions(2))
    other = pickle.loads(pickle.dumps(env))
    for _ in range(6):
        ours, theirs = env.step(actions(2))[0], other.step(actions(2))[0]
        assert all(same_bits(ours[name], theirs[name]) for name in ours)


def test_the_next_observation_tells_the_last_try_and_the_last_landing() -> None:
    env = vector(16)
    seen, _ = env.reset(seed=2)
    assert not seen["last"].any()
    thrown = 0
    for _ in range(10):
        seen, _, _, cut, info = env.step(actions(16, 0.0, (0.05, 0.0)))
        last, over = LAST.decode(seen["last"]), info["_cycle_time"] if "_cycle_time" in info else np.zeros(16, bool)
        goes_on = ~cut
        tried = last["tried"] > 0.5
        np.testing.assert_allclose(
            last["vacuum"][tried & goes_on & ~over], info["vacuum"][tried & goes_on & ~over], rtol=1e-5
        )
        if not over.any():
            continue
        np.testing.assert_allclose(
            last["shift_gone"][over & goes_on] * PICKS, info["pick_in_shift"][over & goes_on] + 1, atol=1e-4
        )
        flew = over & goes_on & (last["thrown"] > 0.5)
        thrown += flew.sum()
        landed = flew & (last["last_seen"] > 0.5)
        np.testing.assert_allclose(last["last_along"][landed], info["seen_along"][landed], atol=1e-5)
        assert (info["picked"][flew]).all()
    assert thrown > 10


def test_rows_that_wait_for_others_keep_their_place_in_the_shift() -> None:
    """Of two rows, one throws three objects while the other gives up one after each try."""
    env = vector(2)
    env.reset(seed=4)
    core = env.unwrapped.core
    for _ in range(4):
        action = actions(2)
        action[0, 2] = RIDE
        env.step(action)
    gone = np.rint(core.context.before.gone * PICKS)
    assert gone[0] == 4
    assert gone[1] == 2


def test_an_error_of_the_cup_moves_where_it_comes_down() -> None:
    """A cup that is sent as far the other way is where it was without the error."""
    error = {"drift": {"camera": {"normal": 0.015}}, "spread": {"grasp": 0.0, "belt_speed": 0.0}}
    bent, straight = vector(32, **error), vector(32, **{**error, "drift": {"camera": {"normal": 0.0}}})
    bent.reset(seed=1)
    straight.reset(seed=1)
    camera = bent.unwrapped.core.context.drift.camera
    moved = bent.step(actions(32, place=camera / 0.1))[4]["vacuum"]
    plain = straight.step(actions(32))[4]["vacuum"]
    left = bent.unwrapped.core.attempts.tries > 0
    np.testing.assert_allclose(moved[left], plain[left], rtol=1e-6)


def test_classifiers_see_nothing_in_drawn_kinds_and_other_levels_have_no_last_try() -> None:
    env = vector()
    _, info = env.reset(seed=0)
    assert not info["kind"].any()
    assert "last" not in gym.make("PnTGrasp-v0").observation_space.spaces  # type: ignore[attr-defined]


def test_drawn_kinds_come_instead_of_a_levels_items_and_are_those_of_their_seed() -> None:
    config = GraspConfig.load({"base": "grasp", "drawn": {"kinds": 12, "seed": 4}})
    assert config.items == tuple(f"drawn_{k}" for k in range(12))
    assert config.item_list() == drawn_kinds(12, 4, 0.75)
    assert drawn_kinds(12, 4)[:5] == drawn_kinds(5, 4)
    assert drawn_kinds(5, 3) != drawn_kinds(5, 4)
    assert GraspConfig.load(config) == config
    assert all(item.mass >= 0.75 * item.size[0] * item.size[1] for item in config.item_list())


@pytest.mark.parametrize(
    ("level", "said"),
    [
        ({"base": "grasp", "drift": {"camera": {"normal": 0.01}}}, "only grasp.picks: shift shows landings"),
        ({"base": "grasp", "cells": {"drag": [0.8, 1.2]}}, "only grasp.picks: shift shows landings"),
        ({"base": "grasp", "grasp": {"kinds": 3}}, "without grasp.picks: shift it must be null"),
        ({**LEVEL, "grasp": {"kinds": 31}}, "the level has 30 items, so it must be at most as many"),
        ({**LEVEL, "grasp": {"objects": 3}}, "it must be 1 in a shift"),
        ({**LEVEL, "grasp": {"picks": "belt", "skip": True, "kinds": None}}, "grasp.skip is true; on the belt"),
        ({**LEVEL, "drawn": {"kinds": 1001}}, "drawn.kinds"),
        ({**LEVEL, "picks_per_shift": 1}, "where a camera sees landings it must be 2 to"),
    ],
)
def test_levels_that_make_no_sense_are_refused(level: Any, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        gym.make("PnTGrasp-v0", level=level)
