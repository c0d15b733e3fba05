"""What measurements share: seeded cells and their throws."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from agents.controllers.oracle import Oracle
from agents.controllers.protocol import Observation
from agents.ground.infos import results
from agents.results.study import Amount, Settings
from pnt_gym.arrays import Floats
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.cell import ConveyorCell, Picks
from pnt_gym.cells.conveyor.config import ConveyorConfig

Infos: TypeAlias = dict[str, NDArray[Any]]
CELLS = 50
"""Rows side by side unless a plan has other settings; a part of what a seed means."""
MEAN_OF_RAYLEIGH: Final = np.sqrt(np.pi / 2.0)
"""Mean distance of a point with normal coordinates of deviation 1."""


def make_seeded_cells(config: ConveyorConfig, picks: Picks, cells: int, seed: int) -> Core:
    """Cells of one thread whose first picks are drawn; the same seed gives the same objects."""
    core = Core(ConveyorCell(config, cells, picks, 1))
    core.reset(np.arange(cells), generators(cells, seed), seeded=True)
    return core


def generators(count: int, seed: int) -> list[np.random.Generator]:
    """A generator for each of `count` rows."""
    return [np.random.default_rng([seed, row]) for row in range(count)]


def infos(core: Core, act: Callable[[int], Any], count: int) -> Infos:
    """Infos of `count` throws, with the actions that `act` gives for each step; landings are those of throws."""
    steps = [results(core.step(act(step)).info, core.count) for step in range(-(-count // core.count))]
    return {name: np.concatenate([info[name] for info in steps])[:count] for name in steps[0]}


def zero_actions(core: Core) -> Callable[[int], Floats]:
    """Actions that leave every throw as the planner made it."""
    zero = np.zeros((core.count, *core.action_space.shape))
    return lambda _: zero


def oracle_actions(core: Core, error: float = 0.0) -> Callable[[int], Floats]:
    """Actions of the suite's oracle, with normal errors added whose mean size is `error` [m]."""
    if core.correction is None:
        raise RuntimeError(f"level {core.config.name!r}: actions {core.action_mode!r} do not shift the landing")
    oracle, scale = Oracle(core, core.correction), core.correction.scale
    random = np.random.default_rng(0)  # the same errors, but for their size, in every case

    def act(_: int) -> Floats:
        actions = oracle.act(Observation(core.cell.observe(), core.cell.context.kind))
        errors = error / MEAN_OF_RAYLEIGH * random.standard_normal(actions.shape)
        return np.clip(actions + errors / scale, -1.0, 1.0)

    return act


def throw(level: Settings, amount: Amount, act: Callable[[Core], Callable[[int], Any]] = zero_actions) -> Infos:
    """Infos of independent throws on a level, with the actions that `act` gives for the cells."""
    core = make_seeded_cells(ConveyorConfig.load(level), "independent", CELLS, amount.seed)
    return infos(core, act(core), amount.throws)


def distance(info: Infos, reference: Infos) -> Floats:
    """How far the same throws land from one another, along and across (2, K) [m], where no cup touched again."""
    untouched = ~(info["recontact"] | reference["recontact"])
    return np.stack([info[name] - reference[name] for name in ("landing_along", "landing_across")])[:, untouched]
