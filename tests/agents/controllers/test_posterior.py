"""The filter that knows the physics: it finds the numbers of a cell from landings, and only from what was observed."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import numpy as np
import pytest

from agents.controllers import make_controller
from agents.controllers.posterior import LIPS, NUMBERS, WIDER, Posterior
from agents.fit.model import ThrowModel
from agents.ground.cli import UsageError
from agents.ground.environments import Env, core_of, make_vector
from agents.ground.infos import results
from agents.judging.loop import observed, throw_held_out
from pnt_gym.arrays import Floats, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.observation import SHIFT_TABLE

ROWS = 16


def _cells(rows: int = ROWS, **changes: Any) -> Env:
    return make_vector("PnTAdapt-v0", {"base": "cells", "fidelity": "flight", **changes}, rows, 1)


def _estimates(controller: Posterior) -> Floats:
    """Estimated numbers of the cells (N, NUMBERS)."""
    scores = (controller._filters.belief[..., None] * controller._filters.state).sum(axis=1)
    return controller._mean + controller._sd * scores[:, : len(NUMBERS)]


def test_throws_read_from_observations_are_those_of_the_planner() -> None:
    with closing(_cells()) as env:
        controller, core = make_controller("posterior", env), core_of(env)
        assert isinstance(controller, Posterior)
        features, info = env.reset(seed=1)
        observation = observed(features, info["kind"])
        log = controller._log(SHIFT_TABLE.decode(observation.features), observation.kind)
        context = core.context
        np.testing.assert_allclose(log.release, context.plan.position, atol=1e-6)
        np.testing.assert_allclose(log.velocity, context.plan.velocity, atol=1e-5)
        np.testing.assert_allclose(log.grasp, context.measured_grasp, atol=1e-6)
        np.testing.assert_array_equal(log.percent, context.objects.percent)
        offset = np.full((ROWS, 2), (-0.05, 0.01))
        model = ThrowModel(log, controller._config, draws=0)
        model.aim(offset)
        planned = core.plan((offset / core.correction.scale).astype(np.float32))[0]
        np.testing.assert_allclose(model.releases.position, planned.position, atol=1e-6)


def test_flights_in_the_true_cell_land_as_objects_do() -> None:
    with closing(_cells()) as env:
        controller, core = make_controller("posterior", env), core_of(env)
        assert isinstance(controller, Posterior)
        features, info = env.reset(seed=2)
        misses: list[Floats] = []
        for _ in range(8):
            observation, context = observed(features, info["kind"]), core.context
            log = controller._log(SHIFT_TABLE.decode(observation.features), observation.kind)
            model = ThrowModel(log, controller._config, draws=0)
            predicted = model.landings_in(context.cell, context.drift, np.arange(ROWS)) - log.target
            predicted = np.stack(context.to_throw_frame(predicted), axis=1)
            features, _, _, _, info = env.step(np.zeros((ROWS, 2), dtype=np.float32))
            thrown = results(info, ROWS)
            landed = np.stack([thrown["landing_along"], thrown["landing_across"]], axis=1)
            clean = thrown["picked"] & ~thrown["dropped"] & ~thrown["recontact"]
            misses.append((landed - predicted)[clean])
    miss = np.concatenate(misses)
    assert np.abs(miss.mean(axis=0)).max() < 0.004
    assert miss[:, 0].std() < 0.018
    assert miss[:, 1].std() < 0.006


def test_landings_tell_the_numbers_of_a_cell() -> None:
    with closing(_cells()) as env:
        controller, core = make_controller("posterior", env), core_of(env)
        assert isinstance(controller, Posterior)
        features, info = env.reset(seed=3)
        for _ in range(30):
            features, _, _, _, info = env.step(controller.act(observed(features, info["kind"])))
        cell, estimates = core.context.cell, _estimates(controller)
        true = np.stack([getattr(cell, name) for name in NUMBERS], axis=1)
    error = np.sqrt(((estimates - true) ** 2).mean(axis=0)) / controller._sd
    assert error[NUMBERS.index("tau")] < 0.3
    assert error[NUMBERS.index("encoder")] < 0.6
    assert error[NUMBERS.index("blow_off")] < 0.7


def test_the_error_falls_over_a_shift_and_below_that_of_a_filter_of_delays() -> None:
    rows = 8
    with closing(_cells(rows)) as env:
        picks = rows * core_of(env).cell.episode
        errors = {
            name: throw_held_out(make_controller(name, env), env, picks, 4).landing_error.reshape(-1, rows)
            for name in ("posterior", "kalman")
        }
    assert np.nanmean(errors["posterior"][10:]) < 0.8 * np.nanmean(errors["kalman"][10:])
    assert np.nanmean(errors["posterior"][10:]) < 0.7 * np.nanmean(errors["posterior"][:3])


def test_rows_do_not_know_of_each_other_and_shifts_are_forgotten() -> None:
    with closing(_cells(picks_per_shift=4)) as env:
        together, alone = make_controller("posterior", env), make_controller("posterior", env)
        features, info = env.reset(seed=5)
        for step in range(6):
            observation = observed(features, info["kind"])
            action = together.act(observation)
            np.testing.assert_allclose(alone.act(take(observation, slice(2, 3)))[0], action[2], atol=1e-6)
            if step == 4:  # the second shift
                fresh = make_controller("posterior", env).act(observation)
                np.testing.assert_array_equal(fresh, action)
            features, _, _, _, info = env.step(action)


def test_unseen_landings_teach_nothing() -> None:
    with closing(_cells(feedback={"unseen": 1.0})) as env:
        controller = make_controller("posterior", env)
        assert isinstance(controller, Posterior)
        features, info = env.reset(seed=6)
        for _ in range(3):
            features, _, _, _, info = env.step(controller.act(observed(features, info["kind"])))
        assert not controller._filters.state.any()
        np.testing.assert_allclose(controller._filters.belief, 1.0 / LIPS)


@pytest.mark.parametrize(
    ("level", "options", "said"),
    [
        ({"base": "cells", "planner": "free_direction"}, {}, "planner is 'free_direction'"),
        ({"base": "cells", "grip": {"safety": 2.0}}, {}, "set grip.safety of the level to null"),
        ("cells", {"prior": "day"}, "prior is 'day', whose section `cells` has no range of "),
    ],
)
def test_what_it_cannot_know_is_one_sentence(level: Any, options: dict[str, Any], said: str) -> None:
    with closing(make_vector("PnTAdapt-v0", level, 1, 1)) as env, pytest.raises(UsageError, match=said):
        make_controller("posterior", env, **options)


def test_the_priors_are_the_ranges_of_the_level_made_wider() -> None:
    with closing(_cells()) as env:
        controller, ranges = make_controller("posterior", env), ConveyorConfig.load("cells").cells.ranges
        assert isinstance(controller, Posterior)
    for name, mean, deviation in zip(NUMBERS, controller._mean, controller._sd, strict=True):
        draws = np.random.default_rng(0).uniform(*ranges[name], 100_000)
        assert mean == pytest.approx(draws.mean(), abs=0.02 * deviation)
        assert deviation == pytest.approx(WIDER * draws.std(), rel=0.01)
    assert np.log(controller._stiffness).mean() == pytest.approx(np.log(ranges["stiffness"]).mean())
