"""Search for the settings of rules and planners of a line, on work shifts of their own.

Every setting works the same shifts, so that the comparison is of settings and not of luck.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.line.config import LineConfig

from ..controllers.protocol import Controller, Observation
from ..dispatchers import settings as tuned
from ..ground.environments import Env, make_vector
from ..policies.scorer import NAMES, Scorer
from . import decisions, registry
from .decisions import Progress, work_single_shifts
from .registry import ENV, GUIDED, line_core
from .rules import ScoreController

PATIENCE: Final = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0)
"""Candidate patiences of ATC and price [s]."""
SHARE: Final = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)
"""Candidate shares of its value that a choice loses if a robot downstream can take it too."""
COARSE: Final = ((0.5, 1.0, 2.0, 5.6, 16.0), (0.0, 0.2, 0.4, 0.6, 0.8, 0.95))
"""Candidate patiences and shares with which the search for price begins."""
SHARES: Final = (0.5, 0.65, 0.8, 0.9)
"""Candidate shares for the beam, which takes a thousand times as long as a rule."""
TRUST: Final = (1.0, 2.0, 4.0, 8.0)
"""Candidate weights of a plan's worth beside the scores, for guided_beam."""
AROUND: Final = (0.8, 1.25)
"""Factors on the price of time, at the best share."""
PRICE: Final = (0.6, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5)
"""Candidate prices of a robot's second, as factors on the tuned ATC rule's value per second."""
POPULATION: Final = 16
"""Indices in each generation of a search."""
EACH: Final = 16
"""Shifts on which a generation is compared; every generation has new shifts."""
SEARCHED_SHIFTS: Final = POPULATION * EACH
"""Shifts that a generation of a search works."""
ROWS: Final = 512
"""Lines in one environment at most."""
Settings = dict[str, Any]


@final
@dataclass(frozen=True)
class SettingsResult:
    """Settings with their results."""

    settings: Settings
    value: Floats
    """Value per minute of each shift (S,)."""


@final
class ControllerBlocks(Controller):
    """Several controllers with a block of lines each; each sees observations of its own lines only.

    Args:
        controllers: C controllers, for C x S lines.
    """

    name = "beside"

    def __init__(self, controllers: Sequence[Controller]) -> None:
        self._controllers = controllers

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """Choices of all controllers (C x S,)."""
        parts = np.split(observation.features, len(self._controllers))
        blocks = zip(self._controllers, parts, strict=True)
        return np.concatenate(
            [np.asarray(controller.act(decisions.observe(part)), dtype=np.int64) for controller, part in blocks]
        )


def shift_values(controller: Controller, env: Env, seeds: Ints, progress: Progress | None = None) -> Floats:
    """Value per minute of one shift in each line (N,), by the seeds of the lines' streams (N,)."""
    value = np.full(env.num_envs, np.nan)
    for step in work_single_shifts(controller.act, env, seeds, progress):
        is_last = step.over & (step.shift == 0)
        if is_last.any():
            value[is_last] = step.info["final_info"]["shift_value_per_min"][is_last]
    return value


@final
class Bench:
    """Work shifts of a level on which settings are compared.

    Args:
        level: level; its throws go by the table here, whatever the level says.
        seeds: seeds of the shifts (S,).
        progress: called with the number of completed shifts.
    """

    def __init__(self, level: LineConfig, seeds: Ints, progress: Progress | None = None) -> None:
        self.level, self.seeds, self._progress = level, seeds, progress

    def other_shifts(self, shifts: int, number: int) -> Bench:
        """Bench with shifts that this bench does not have; each number gives separate shifts."""
        first = int(self.seeds[-1]) + 1 + number * shifts
        return Bench(self.level, np.arange(first, first + shifts), self._progress)

    def compare(self, controllers: Sequence[Controller]) -> Floats:
        """Value per minute of controllers that use only the observation (C, S)."""
        values: list[Floats] = []
        block_size = max(ROWS // len(self.seeds), 1)
        for first in range(0, len(controllers), block_size):
            block = controllers[first : first + block_size]
            with closing(make_vector(ENV, self.level, len(block) * len(self.seeds), 1)) as env:
                shift_value = shift_values(
                    ControllerBlocks(block), env, np.tile(self.seeds, len(block)), self._progress
                )
            values.append(shift_value.reshape(len(block), -1))
        return np.concatenate(values)

    def try_rule(self, name: str, settings_list: Iterable[Settings]) -> list[SettingsResult]:
        """Results of a rule with several settings."""
        candidates = list(settings_list)
        with closing(make_vector(ENV, self.level, 1, 1)) as env:
            core = line_core(env)
            values = self.compare([registry.make(name, core, **settings) for settings in candidates])
        return [SettingsResult(settings, value) for settings, value in zip(candidates, values, strict=True)]

    def try_planner(self, name: str, settings_list: Iterable[Settings]) -> list[SettingsResult]:
        """Results of a planner with several settings, one after the other."""
        results: list[SettingsResult] = []
        for settings in settings_list:
            with closing(make_vector(ENV, self.level, len(self.seeds), 1)) as env:
                controller = registry.make(name, line_core(env), **settings)
                results.append(SettingsResult(settings, shift_values(controller, env, self.seeds, self._progress)))
        return results


def best(results: Sequence[SettingsResult]) -> SettingsResult:
    """The settings with the highest mean value; the first one of equals."""
    return max(results, key=lambda one: float(one.value.mean()))


def atc(bench: Bench) -> list[SettingsResult]:
    """Results of the rule `atc` with every patience."""
    return bench.try_rule("atc", [{"patience": k} for k in PATIENCE])


def price(bench: Bench, patience: float) -> list[SettingsResult]:
    """Results of `price`: a coarse grid, every share at the best patience, every patience at the best share.

    With different skills of the robots there are several local optima, and the one near ATC's own patience may be the
    worse.

    Args:
        bench: bench of the comparison.
        patience: patience of the tuned ATC rule [s], which equals `price` without robots downstream.
    """
    if len(bench.level.robots) == 1:
        return bench.try_rule("price", [{"patience": patience, "share": 0.0}])
    grid: list[Settings] = [{"patience": k, "share": s} for k in (patience, *COARSE[0]) for s in COARSE[1]]
    results = bench.try_rule("price", [candidate for i, candidate in enumerate(grid) if candidate not in grid[:i]])
    for name, values in (("share", SHARE), ("patience", PATIENCE)):
        known_settings = [candidate.settings for candidate in results]
        new = [{**best(results).settings, name: value} for value in values]
        new = [candidate for candidate in new if candidate not in known_settings]
        results += bench.try_rule("price", new) if new else []
    return results


def planner(bench: Bench, name: str, rate: float) -> list[SettingsResult]:
    """Results of beam search with several prices of time, about the tuned ATC rule's value per second [1/s].

    `price_beam`: several shares at that price, then several prices at the best share. `guided_beam`: several trusts, at
    the price and share of `price_beam` and with the guide of the level.
    """
    if name == GUIDED:
        guide = {key: value for key, value in tuned.settings(bench.level.name, name).items() if key == "guide"}
        return bench.try_planner(name, [{**guide, "trust": trust} for trust in TRUST])
    if name != "price_beam":
        return bench.try_planner(name, [{"price": round(rate * factor, 3)} for factor in PRICE])
    results = bench.try_planner(name, [{"price": round(rate, 3), "share": share} for share in SHARES])
    share = best(results).settings["share"]
    return results + bench.try_planner(name, [{"price": round(rate * factor, 3), "share": share} for factor in AROUND])


WEIGHED: Final = tuple(name for name in NAMES if name != "real")
"""Entries of a choice that an index can weigh."""
SPREAD: Final = 0.15
"""Standard deviation of the weights in the first generation about their initial values."""


def weights(
    bench: Bench, patience: float, generations: int, seed: int, begin: Mapping[str, float] | None = None
) -> list[SettingsResult]:
    """Results of the index at the end of a search and of the initial one, with their settings of `index`.

    Args:
        bench: bench on which both are compared in the end; the search uses other shifts.
        patience: patience of the rule [s].
        generations: generations of the search.
        seed: seed of the search.
        begin: initial weights, zero for entries not listed; without any the index is the ATC rule.
    """
    cma: Any = importlib.import_module("cma")  # an extra without types, which only this search needs
    first = np.array([(begin or {}).get(name, 0.0) for name in WEIGHED])
    # For cma the seed 0 means the time of day.
    search = cma.CMAEvolutionStrategy(first, SPREAD, {"popsize": POPULATION, "seed": seed + 1, "verbose": -9})
    for generation in range(generations):
        candidates = search.ask()
        shifts = bench.other_shifts(EACH, generation)
        settings = [_settings(patience, weights) for weights in candidates]
        values = shifts.compare([ScoreController("index", Scorer.linear(**each)) for each in settings])
        search.tell(candidates, (-values.mean(axis=1)).tolist())
    settings_pair = [
        _settings(patience, search.result.xfavorite),
        {"patience": patience, "weights": dict(begin or {})},
    ]
    values = bench.compare([ScoreController("index", Scorer.linear(**settings)) for settings in settings_pair])
    return [SettingsResult(settings, value) for settings, value in zip(settings_pair, values, strict=True)]


def _settings(patience: float, weights: Floats) -> Settings:
    """Settings of a controller `index`."""
    return {
        "patience": patience,
        "weights": {name: round(float(w), 3) for name, w in zip(WEIGHED, weights, strict=True)},
    }
