"""Search for the settings of rules and planners of a line, on work shifts of their own.

Every setting works the same shifts, so that the comparison is of settings and not of luck.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.line.config import LineConfig

from ..controllers.protocol import Controller, Observation
from ..dispatchers import settings as tuned
from ..dispatchers.registry import ENV, GUIDED, line_controller, the_line
from ..ground.environments import Env, make_vector
from .decisions import Progress, observed_line, single_shifts

PATIENCE: Final = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0)
"""Candidate patiences of ATC and price [s]."""
SHARE: Final = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)
"""Candidate shares of its value that a choice loses if a robot downstream can take it too."""
COARSE: Final = ((0.5, 1.0, 2.0, 5.6, 16.0), (0.0, 0.2, 0.4, 0.6, 0.8, 0.95))
"""Candidates of both, with which the search for price begins."""
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
"""Shifts on which a generation is compared, new ones every time."""
SEARCHED_SHIFTS: Final = POPULATION * EACH
"""Shifts that a generation of a search works."""
ROWS: Final = 512
"""Lines in one environment at most."""
Settings = dict[str, Any]


@final
@dataclass(frozen=True)
class Tried:
    """Settings with their results."""

    settings: Settings
    value: Floats
    """Value per minute of each shift (S,)."""


@final
class Beside(Controller):
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
        each = zip(self._controllers, parts, strict=True)
        return np.concatenate([np.asarray(one.act(observed_line(part)), dtype=np.int64) for one, part in each])


def gained(controller: Controller, env: Env, seeds: Ints, progress: Progress | None = None) -> Floats:
    """Value per minute of one shift in each line (N,), by the seeds of the lines' streams (N,)."""
    value = np.full(env.num_envs, np.nan)
    for one in single_shifts(controller.act, env, seeds, progress):
        ended = one.over & (one.shift == 0)
        if ended.any():
            value[ended] = one.info["final_info"]["shift_value_per_min"][ended]
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

    def apart(self, shifts: int, number: int) -> Bench:
        """Bench with other shifts, which differ from those here and between numbers."""
        first = int(self.seeds[-1]) + 1 + number * shifts
        return Bench(self.level, np.arange(first, first + shifts), self._progress)

    def beside(self, controllers: Sequence[Controller]) -> Floats:
        """Value per minute of controllers that use only the observation (C, S)."""
        values: list[Floats] = []
        most = max(ROWS // len(self.seeds), 1)
        for first in range(0, len(controllers), most):
            some = controllers[first : first + most]
            with closing(make_vector(ENV, self.level, len(some) * len(self.seeds), 1)) as env:
                found = gained(Beside(some), env, np.tile(self.seeds, len(some)), self._progress)
            values.append(found.reshape(len(some), -1))
        return np.concatenate(values)

    def rules(self, name: str, tried: Iterable[Settings]) -> list[Tried]:
        """Results of a rule with several settings."""
        given = list(tried)
        with closing(make_vector(ENV, self.level, 1, 1)) as env:
            core = the_line(env)
            values = self.beside([line_controller(name, core, **settings) for settings in given])
        return [Tried(settings, value) for settings, value in zip(given, values, strict=True)]

    def planners(self, name: str, tried: Iterable[Settings]) -> list[Tried]:
        """Results of a planner with several settings, one after the other."""
        found: list[Tried] = []
        for settings in tried:
            with closing(make_vector(ENV, self.level, len(self.seeds), 1)) as env:
                controller = line_controller(name, the_line(env), **settings)
                found.append(Tried(settings, gained(controller, env, self.seeds, self._progress)))
        return found


def best(tried: Sequence[Tried]) -> Tried:
    """The settings with the highest mean value; the first one of equals."""
    return max(tried, key=lambda one: float(one.value.mean()))


def atc(bench: Bench) -> list[Tried]:
    """Results of the rule `atc` with every patience."""
    return bench.rules("atc", [{"patience": k} for k in PATIENCE])


def price(bench: Bench, patience: float) -> list[Tried]:
    """Results of `price`: a coarse grid, then every share at the best patience, then every patience at the best share.

    With different skills of the robots there are several local optima, and the one near ATC's own patience may be the
    worse.

    Args:
        bench: bench of the comparison.
        patience: patience of the tuned ATC rule [s], which equals `price` without robots downstream.
    """
    if len(bench.level.robots) == 1:
        return bench.rules("price", [{"patience": patience, "share": 0.0}])
    given: list[Settings] = [{"patience": k, "share": s} for k in (patience, *COARSE[0]) for s in COARSE[1]]
    found = bench.rules("price", [one for i, one in enumerate(given) if one not in given[:i]])
    for name, values in (("share", SHARE), ("patience", PATIENCE)):
        known = [one.settings for one in found]
        new = [{**best(found).settings, name: value} for value in values]
        new = [one for one in new if one not in known]
        found += bench.rules("price", new) if new else []
    return found


def planner(bench: Bench, name: str, rate: float) -> list[Tried]:
    """Results of beam search with several prices of time, about the tuned ATC rule's value per second [1/s].

    `price_beam`: several shares at that price, then several prices at the best share. `guided_beam`: several trusts, at
    the price and share of `price_beam` and with the guide of the level.
    """
    if name == GUIDED:
        guide = {key: value for key, value in tuned.settings(bench.level.name, name).items() if key == "guide"}
        return bench.planners(name, [{**guide, "trust": trust} for trust in TRUST])
    if name != "price_beam":
        return bench.planners(name, [{"price": round(rate * factor, 3)} for factor in PRICE])
    found = bench.planners(name, [{"price": round(rate, 3), "share": share} for share in SHARES])
    share = best(found).settings["share"]
    return found + bench.planners(name, [{"price": round(rate * factor, 3), "share": share} for factor in AROUND])
