"""Ceilings of the order of picks: no order is above the bound, and the order of one who knows all is near it."""

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from agents.dispatchers import registry
from agents.dispatchers.clairvoyant import SHARES, Clairvoyant, ShiftSearch
from agents.dispatchers.prices import find_bound
from agents.dispatchers.registry import line_core
from agents.dispatchers.search import shift_values
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from pnt_gym.cells.line.core import LineCore
from tests.tools.nightly import with_nightly

LEVELS: list[dict[str, Any]] = [
    {"base": "single", "duration": 20.0},
    {"base": "speed", "duration": 25.0},
    {"base": "skills3_burst", "duration": 15.0},
]
SEEDS = np.arange(2) + 40


def values(level: dict[str, Any], name: str) -> Any:
    """Values of a controller in the shifts of the seeds (2,), one after the other."""
    with closing(make_vector("PnTLine-v0", level, 1, 1)) as env:
        controller = registry.make(name, line_core(env))
        controller.reset(0)
        found = [shift_values(controller, env, SEEDS[k : k + 1]) for k in range(len(SEEDS))]
    return np.concatenate(found) * level["duration"] / 60.0


def bounds(level: dict[str, Any], *, is_drawn: bool) -> Any:
    """Bounds of the shifts of the seeds (2,)."""
    with closing(make_vector("PnTLine-v0", level, len(SEEDS), 1)) as env:
        seeds: Any = SEEDS.tolist()  # a seed for each row, which the annotation of the base class does not say
        env.reset(seed=seeds)
        cell = line_core(env).cell
        return np.array(
            [find_bound(cell.chooser.tables, riders, is_drawn=is_drawn).value for riders in cell.stream.riders]
        )


@pytest.mark.parametrize("level", with_nightly(LEVELS, LEVELS[:1]), ids=[level["base"] for level in LEVELS])
def test_no_order_is_above_the_bound_and_foresight_is_near_it(level: dict[str, Any]) -> None:
    bound = bounds(level, is_drawn=True)
    for name in ("random", "fifo", "price", "index"):
        assert (values(level, name) <= bound).all()
    clairvoyant = values(level, "clairvoyant")
    assert (clairvoyant <= bound).all()
    assert clairvoyant.sum() > 0.9 * bound.sum()
    assert clairvoyant.sum() > values(level, "price").sum()


def test_who_knows_no_draw_is_below_the_bound_of_expected_values() -> None:
    level = LEVELS[0]
    expected, drawn = bounds(level, is_drawn=False), bounds(level, is_drawn=True)
    assert values(level, "price").mean() < expected.mean() < drawn.mean()


def orders(core: LineCore) -> Iterator[float]:
    """Values of all orders of a line's shift."""
    cell = core.cell
    pending = [(cell.state, 0.0)]
    while pending:
        state, value = pending.pop()
        if state.clock[0] >= core.config.duration:
            yield value
            continue
        for choice in np.flatnonzero(state.choices["real"][0]):
            cell.state = state.copy()
            brought = cell.take(np.array([choice]))
            pending.append((cell.state, value + float(brought.value[0])))


@pytest.mark.parametrize("seed", [1, 3, 5])
def test_the_best_of_all_orders_lies_between_foresight_and_bound(seed: int) -> None:
    level = {"base": "value", "duration": 5.0, "arrivals": {"rate": 1.0}}
    with closing(make_vector("PnTLine-v0", level, 1, 1)) as env:
        core = line_core(env)
        env.reset(seed=seed)
        tables, riders, state = core.cell.chooser.tables, core.cell.stream.riders[0].copy(), core.cell.state.copy()
        best = max(orders(core))
        bound = find_bound(tables, riders, is_drawn=True)
        found, _ = ShiftSearch(tables, riders, bound, 0.9).search(state)
    assert found <= best + 1e-9
    assert best <= bound.value + 1e-9
    assert found > 0.9 * best > 0.0


def test_what_foresight_plans_is_what_the_line_does() -> None:
    level = LEVELS[2]
    with closing(make_vector("PnTLine-v0", level, 1, 1)) as env:
        core = line_core(env)
        env.reset(seed=7)
        tables, riders = core.cell.chooser.tables, core.cell.stream.riders[0].copy()
        bound = find_bound(tables, riders, is_drawn=True)
        planned = max(
            ShiftSearch(tables, riders, bound, share).search(core.cell.state.take(np.array([0])))[0] for share in SHARES
        )
        worked = shift_values(Clairvoyant("clairvoyant", core), env, np.array([7]))
    assert worked[0] * level["duration"] / 60.0 == pytest.approx(planned)


def test_simulated_throws_cannot_be_foreseen() -> None:
    level = {**LEVELS[0], "throws": "flight"}
    with closing(make_vector("PnTLine-v0", level, 1, 1)) as env, pytest.raises(UsageError, match="--throws table"):
        registry.make("clairvoyant", line_core(env))
