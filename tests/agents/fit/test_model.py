"""Predictions of logged throws: those of the simulation where nothing is hidden, else those that gauges allow."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.fit.hidden import draw_hidden, standard_draws
from agents.fit.log import ThrowLog
from agents.fit.model import ThrowModel
from agents.fit.parameters import PARAMETERS, level_at, priors, values_at
from agents.ground.cli import UsageError
from pnt_gym.arrays import take
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig
from tests.tools.fitting import QUIET, WASTE, level, throw, usual_log

OFF = {"bias": {"camera": [0.004, -0.006], "encoder": 0.006, "drag": 0.1, "delay": 0.001}}


@pytest.mark.parametrize("changes", [{}, OFF, {"mismatch": 0.6, **OFF}, {"cup": {"stiffness": None, "peel": False}},
                                     {"cup": {"blow_off": 0.25}}])  # fmt: skip
def test_where_nothing_is_hidden_predictions_are_the_simulated_landings(changes: dict[str, object]) -> None:
    config = level(**{**QUIET, **changes, "spread": {**QUIET["spread"], "spin": 0.0}})
    log, record = throw(config, 24)
    rows = log.has_landing & ~record.throws.info["recontact"]
    predicted = ThrowModel(log, config, 2).landings(config)
    assert rows.sum() > 10
    np.testing.assert_allclose(predicted[rows], log.landing[rows], atol=5e-4)


def test_quick_landings_change_from_cell_to_cell_as_landings_do() -> None:
    model = ThrowModel(usual_log(), WASTE, 2)
    configs = [level_at(WASTE, values) for values in ({}, {"valve": 0.007}, {"tau": 0.013}, {"stiffness": 2.0},
                                                    {"blow_off": 0.2})]  # fmt: skip
    quick = model.quick_landings(configs)
    slow = np.stack([model.landings(config) for config in configs])
    rows = usual_log().has_landing
    assert np.abs((quick - slow)[:, rows]).max() > 2e-4  # longer steps land elsewhere
    change, true = ((landing - landing[0])[1:, rows] for landing in (quick, slow))
    assert np.abs(true).max() > 5e-3
    assert np.abs(change - true).mean() < 3e-4
    draws = ThrowModel(usual_log(), WASTE, 2).outcomes(WASTE).landing.reshape(-1, 2, 2)
    assert np.abs(draws.mean(axis=1) - slow[0])[rows].mean() < np.abs(draws.mean(axis=1) - quick[0])[rows].mean()


def test_a_level_takes_every_parameter_and_gives_it_back() -> None:
    parameters = priors(WASTE)
    assert [p.name for p in parameters] == [p.name for p in PARAMETERS]
    z = np.array([0.5, -1.0, 0.8, 0.7, 1.2, -0.4, 0.9, -1.1])
    values = values_at(parameters, z)
    config = level_at(WASTE, values)
    for parameter in parameters:
        assert parameter.read(config) == pytest.approx(values[parameter.name]), parameter.name
        assert parameter.score(values[parameter.name]) == pytest.approx(z[parameters.index(parameter)])
    assert ConveyorConfig.load(config) == config  # within the ranges of a level


def test_a_valve_below_zero_is_early_in_the_search_and_legal_in_the_level() -> None:
    """Trap: a search that clips the valve at zero stops there; a level cannot have it below."""
    config = level_at(WASTE, {"valve": -0.002})
    assert (config.suction.valve, config.bias.delay) == (0.0, -0.002)
    assert ConveyorConfig.load(config) == config
    log = take(usual_log(), np.flatnonzero(usual_log().has_landing)[:12])
    model = ThrowModel(log, WASTE, 2)
    early, zero = (model.landings(level_at(WASTE, {"valve": v})) for v in (-0.002, 0.0))
    later = model.landings(level_at(WASTE, {"valve": 0.002}))
    np.testing.assert_allclose(zero - early, later - zero, atol=2e-3)
    assert np.abs(zero - early).max() > 2e-3


def test_the_mean_of_draws_is_not_the_flight_of_the_mean() -> None:
    """Trap: without the shift between them a fit is off by a millimetre or two."""
    log = take(usual_log(), usual_log().has_landing)
    model = ThrowModel(log, WASTE, 64)
    outcomes, middle = model.outcomes(WASTE), model.landings(WASTE)
    mean = outcomes.landing.reshape(len(log), 64, 2).mean(axis=1)
    assert 2e-4 < np.abs(mean - middle).mean() < 1e-2
    again = ThrowModel(log, WASTE, 64).outcomes(WASTE)
    np.testing.assert_array_equal(again.landing, outcomes.landing)  # the same draws whenever a cost is computed


def test_hidden_values_follow_their_gauges_and_the_catalogue_without_gauges() -> None:
    log = usual_log()
    blind = replace(
        log, mass=np.full_like(log.mass, np.nan), seal=np.full_like(log.seal, np.nan),
        size=np.full_like(log.size, np.nan), yaw=np.full_like(log.yaw, np.nan),
        grasp=np.full_like(log.grasp, np.nan),
    )  # fmt: skip
    draws = standard_draws(len(log), 256)
    seen, unseen = (draw_hidden(part, WASTE, draws) for part in (log, blind))
    table = item_arrays(WASTE.item_list())

    def spread(values: np.ndarray) -> float:
        return float(np.log(values).reshape(len(log), 256).std(axis=1).mean())

    assert spread(seen.mass) == pytest.approx(0.09, abs=0.02)  # of 0.22 in the catalogue and 0.10 of the gauge
    assert spread(unseen.seal) == pytest.approx(0.40, abs=0.03)
    assert spread(seen.seal) == pytest.approx(0.097, abs=0.01)
    middle = np.exp(np.log(unseen.seal).reshape(len(log), 256).mean(axis=1))
    np.testing.assert_allclose(middle, table.seal_force[log.kind], rtol=0.03)
    np.testing.assert_allclose(seen.size[:, 2], np.repeat(log.size[:, 2], 256), rtol=1e-4)
    offset = seen.grasp[:, 0] + seen.belt_error * (np.repeat(log.pick[:, 0], 256) - WASTE.belt.camera_x)
    assert offset.reshape(len(log), 256).std(axis=1).mean() == pytest.approx(0.0036, abs=3e-4)
    rods = table.shape[seen.row % 1 + log.kind[seen.row]] == 1
    np.testing.assert_array_equal(seen.size[rods, 1], seen.size[rods, 2])


def test_draws_of_hidden_values_hold_the_truth_as_often_as_they_should() -> None:
    """The true masses, seals and grasps of simulated objects lie within the central 90 % of their draws."""
    from contextlib import closing  # noqa: PLC0415

    from agents.judging.trials import open_trial  # noqa: PLC0415

    with closing(open_trial("PnTRelease-v0", WASTE, 300, 1)) as trial:
        trial.env.reset(seed=3)
        context = trial.core.context
        log = ThrowLog.of(context, trial.core.plan(np.zeros((300, 2)))[0])
    drawn = draw_hidden(log, WASTE, standard_draws(300, 128))
    o = context.objects
    for true, values in ((o.mass, drawn.mass), (o.seal, drawn.seal), (o.size[:, 0], drawn.size[:, 0]),
                         (o.grasp[:, 1], drawn.grasp[:, 1]), (o.com_depth, drawn.com_depth)):  # fmt: skip
        low, high = np.quantile(values.reshape(300, 128), (0.05, 0.95), axis=1)
        assert ((low <= true) & (true <= high)).mean() == pytest.approx(0.9, abs=0.06)


def test_levels_that_have_no_hidden_parameters_are_refused() -> None:
    with pytest.raises(UsageError, match="has mismatch 0"):
        priors(level(mismatch=0.0))
    with pytest.raises(UsageError, match="free: unknown parameter 'speed'; known are valve"):
        priors(WASTE, ["speed"])
    with pytest.raises(UsageError, match="tau is 0 in level 'custom'; a free one must be above 0"):
        priors(level(suction={"tau": 0.0}), ["tau"])
    priors(level(suction={"tau": 0.0}), ["valve"])
    with pytest.raises(UsageError, match="no parameter is free"):
        priors(level(cup={"stiffness": None}), ["stiffness"])
    with pytest.raises(UsageError, match="planner is 'ellipse'"):
        ThrowModel(usual_log(), level(planner="ellipse"))


@pytest.mark.parametrize("sd", [0, 0.0, -1.0, 1e-12, 4.1, 1e300, 10**400, np.nan, np.inf, None, "x", True, [1.0]])
def test_a_prior_has_a_range_on_both_sides(sd: Any) -> None:
    assert priors(WASTE, ["tau"], {"tau": 4.0})[0].sd == 4.0
    with pytest.raises(UsageError, match=r"the prior of tau is .*; it must be a .* from 4e-07 to 4,"):
        priors(WASTE, None, {"tau": sd})


@pytest.mark.parametrize("free", [5, "valve", {"valve": 1}, ["valve", 5], [["valve"]], b"valve"])
def test_free_parameters_are_a_list_of_names(free: Any) -> None:
    with pytest.raises(UsageError, match=r"must be a list of names|unknown parameter"):
        priors(WASTE, free)
