"""The oracle of grasps: what it foresees comes true, it changes no cell, and it stays above all others."""

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from agents.controllers import make_controller
from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import observed, throw_held_out
from pnt_gym.arrays import take
from pnt_gym.cells.grasp.foresight import Foresight
from tests.tools.throws import same_bits

ROWS = 32
FLIGHT = {"fidelity": "flight"}


@pytest.fixture
def env() -> Iterator[Any]:
    with closing(make_vector("PnTGrasp-v0", {"base": "grasp", **FLIGHT}, ROWS, 1)) as cells:
        yield cells


@pytest.fixture(scope="module")
def foreseen() -> Any:
    """320 picks of the oracle that knows holds and landings."""
    with closing(make_vector("PnTGrasp-v0", {"base": "grasp", **FLIGHT}, ROWS, 1)) as cells:
        return throw_held_out(make_controller("oracle_grasp", cells), cells, 320, 4)


def action(place: Any = (0.0, 0.0), pace: float = 0.0) -> Any:
    """The same action in all rows, with a place in metres."""
    actions = np.zeros((ROWS, 6), dtype=np.float32)
    actions[:, :2] = np.asarray(place) / 0.1
    actions[:, 3] = pace
    return actions


def test_a_foreseen_try_is_the_try_and_its_throw_is_the_throw_but_for_the_jitter(env: Any) -> None:
    env.reset(seed=3)
    core: Any = core_of(env)
    rows = np.arange(ROWS)
    for place in ((0.01, 0.0), (-0.01, 0.005)):  # the second one is a second try where the first one failed
        free = rows[~core.attempts.holds]
        _, holds, vector = Foresight(core).grasp(free, np.tile(place, (len(free), 1)))
        features, *_ = env.step(action(place))
        goes_on = core.attempts.tries[free] > 0
        assert same_bits(core.attempts.holds[free][goes_on], holds[goes_on])
        np.testing.assert_allclose(features["vector"][free][holds], vector[holds], atol=1e-4)  # an action has 32 bits
    kept = free[holds]
    pace = np.full(len(kept), 0.39)
    outcome = Foresight(core).throw(kept, take(core.context, kept), pace, np.zeros((len(kept), 2)))
    *_, info = env.step(action())
    apart = np.abs(outcome.landing_error - info["landing_error"][kept])
    assert np.nanmedian(apart) < 0.01
    assert (outcome.dropped == info["dropped"][kept]).mean() > 0.9


def test_an_oracle_that_looks_ahead_changes_no_cell(env: Any) -> None:
    def steps(looks: bool) -> list[Any]:
        features, info = env.reset(seed=5)
        oracle, seen = make_controller("oracle_grasp", env), []
        for _ in range(4):
            if looks:
                oracle.act(observed(features, info["kind"]))
            features, reward, _, _, info = env.step(action())
            seen += [features["vector"], reward]
        return seen

    assert all(same_bits(one, other) for one, other in zip(steps(True), steps(False), strict=True))


@pytest.mark.nightly
def test_no_other_controller_sorts_as_much_and_none_of_its_throws_drops_an_object(env: Any, foreseen: Any) -> None:
    throws = {"oracle_grasp": foreseen, "fitted_q": throw_held_out(make_controller("fitted_q", env), env, 320, 4)}
    rate = {name: one.sorted.sum() / one.cycle_time.sum() for name, one in throws.items()}
    assert rate["oracle_grasp"] > 1.05 * rate["fitted_q"]
    oracle = throws["oracle_grasp"]
    assert oracle.info["dropped"][oracle.picked].mean() < 0.01
    assert oracle.sorted[oracle.picked].mean() > 0.95


@pytest.mark.nightly
def test_an_oracle_of_holds_drops_nothing_and_sorts_less_than_one_that_knows_landings(env: Any, foreseen: Any) -> None:
    holds, lands = throw_held_out(make_controller("oracle_grasp", env, lands=False), env, 320, 4), foreseen
    assert holds.info["dropped"][holds.picked].mean() < 0.01
    assert holds.picked.mean() >= lands.picked.mean()
    assert holds.sorted[holds.picked].mean() < lands.sorted[lands.picked].mean()
    assert holds.sorted.sum() / holds.cycle_time.sum() < lands.sorted.sum() / lands.cycle_time.sum()


def test_the_oracle_saves_the_time_of_hopeless_tries_where_it_may() -> None:
    level = {"base": "grasp", **FLIGHT, "grasp": {"skip": True}}
    with closing(make_vector("PnTGrasp-v0", level, ROWS, 1)) as cells:
        throws = throw_held_out(make_controller("oracle_grasp", cells), cells, 320, 4)
    skipped = throws.info["tries"] == 0
    assert 0 < skipped.mean() < 0.1
    assert not throws.picked[skipped].any()


def test_its_map_is_zero_where_no_cup_holds(env: Any) -> None:
    features, info = env.reset(seed=2)
    oracle: Any = make_controller("oracle_grasp", env)
    maps = oracle.maps(observed(features, info["kind"]), np.arange(ROWS))
    assert maps.shape == (ROWS, 48, 48)
    assert (maps >= 0.0).all()
    assert (maps[:, 0, 0] == 0.0).all()
    assert (maps.max(axis=(1, 2)) > 0.0).mean() > 0.9


@pytest.mark.parametrize("level", ["grasp_dense", "grasp_plain", {"base": "grasp", "grasp": {"stages": 1}}])
def test_levels_that_it_does_not_know_are_refused(level: Any) -> None:
    with closing(make_vector("PnTGrasp-v0", level, 2, 1)) as cells, pytest.raises(UsageError, match="single objects"):
        make_controller("oracle_grasp", cells)
