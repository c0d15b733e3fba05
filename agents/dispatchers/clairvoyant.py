"""Orders of picks by one who knows the shift: every object, and how each attempt ends.

Nobody can know this. The value that such an order reaches is below the best possible one, as `prices` bounds it above,
so that both enclose what the best order is worth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.line import simulate
from pnt_gym.cells.line.choosing import MOST_LOOKS
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.links import EMPTY, THROWN
from pnt_gym.cells.line.rows import CHOICES, Choice, LineState, Outcome, Result, Rider, Tables
from pnt_gym.rows import Rows1, Rows2

from ..controllers.protocol import Controller, Observation
from ..ground.cli import UsageError
from .prices import Bound, Prices, best_ways, find_bound

SHARES: Final = (0.85, 0.9, 0.95, 1.0)
"""Shares of the bound's prices at which shifts are searched; at the full prices much seems equally good."""
WIDTH: Final = 128
"""Beginnings of a shift that the search keeps."""
FEW: Final = 8
"""Decisions that it tries for each of them."""


@final
@dataclass(frozen=True)
class Beginnings:
    """B beginnings of one shift."""

    state: LineState
    value: Floats
    """Value that each beginning has brought (B,)."""
    hope: Floats
    """The same with the prices of the objects that are left, and with what each robot's best way still brings (B,)."""
    ahead: Floats
    """What each robot's best way still brings (B, R)."""
    mark: Ints
    """Sum of the marks of all attempts, which tells apart beginnings that tried or took different objects (B,)."""


@final
@dataclass(frozen=True)
class Decided:
    """What the choices of B beginnings bring, each field (B, CHOICES)."""

    results: Rows2[Result]
    value: Floats
    ahead: Floats
    """What the deciding robot's best way brings after the choice."""
    hope: Floats
    """`Beginnings.hope` after the choice."""


@final
class ShiftSearch:
    """Search for the best order of one shift.

    Args:
        tables: tables of the line.
        riders: the objects of the shift (M,).
        bound: upper bound of the shift, by draws.
        share: share of the bound's prices that counts.
    """

    def __init__(self, tables: Tables, riders: Rows1[Rider], bound: Bound, share: float) -> None:
        self._tables, self._riders, self._bound = tables, riders, bound
        self._prices = Prices(*(share * prices for prices in bound.prices))
        self._ways = best_ways(bound.network, self._prices, len(tables.stations))
        passages, stations = bound.network.passages, tables.stations
        self._failures = np.zeros(len(riders))
        self._failures[passages["index"]] = passages["failures"]
        sites = stations["end_site"] - stations["first_site"]
        settings = stations["end_setting"] - stations["first_setting"]
        shape = len(stations), len(riders), int(sites.max()), int(settings.max()), 2
        self._passage: Ints = np.full(shape, -1)
        """Rows of passages by robot, object, bin, speed setting, and whether the cup seals."""
        robot = passages["robot"]
        site = passages["site"] - stations["first_site"][robot]
        setting = passages["setting"] - stations["first_setting"][robot]
        self._passage[robot, passages["index"], site, setting, (passages["seal"] > 0.0).astype(np.int64)] = np.arange(
            len(passages)
        )
        self._marks = np.random.default_rng(0).integers(2**62, size=(2, len(riders)), dtype=np.int64)
        """Random marks of attempts that fail and of attempts that take an object, by object (2, M)."""
        self._copies: Rows2[Rider] = take(riders[None], np.zeros(WIDTH, dtype=np.int64))

    def search(self, state: LineState) -> tuple[float, list[int]]:
        """The value of the best shift that is found, and its choices, one for each decision.

        Args:
            state: the line at its first decision (1,).
        """
        robots = len(self._tables.stations)
        first = self._ways.later[:, 0]
        hope = np.array([first.sum() + self._prices.taken.sum()])
        ahead, mark = np.broadcast_to(first, (1, robots)).copy(), np.zeros(1, dtype=np.int64)
        begun = Beginnings(state, np.zeros(1), hope, ahead, mark)
        steps: list[tuple[Ints, Ints]] = []
        while not self._is_over(begun.state).all():
            begun, parent, choice = self._extend(begun)
            steps.append((parent, choice))
        best, choices = int(np.argmax(begun.value)), list[int]()
        value = float(begun.value[best])
        for parent, choice in reversed(steps):
            choices.append(int(choice[best]))
            best = int(parent[best])
        return value, choices[::-1]

    def _is_over(self, state: LineState) -> Bools:
        return np.asarray(state.clock >= self._tables.line["duration"][0])

    def _extend(self, begun: Beginnings) -> tuple[Beginnings, Ints, Ints]:
        """The most hopeful beginnings with one decision more, with the indices of their parents and choices."""
        decided, over = self._decide(begun), self._is_over(begun.state)
        hope = np.where(over[:, None], -np.inf, decided.hope)
        hope[over, 0] = begun.hope[over]
        choices, picked = begun.state.choices, decided.results["picked"].astype(np.int64)
        tried = np.where(choices["real"] & ~over[:, None], self._marks[picked, choices["index"]], 0)
        mark = begun.mark[:, None] + tried
        kept = _most_hopeful(hope, mark)
        parent, choice = np.divmod(kept, CHOICES)
        robot, goes_on = begun.state.robot[parent], ~over[parent]
        ahead, each = begun.ahead[parent].copy(), np.arange(len(parent))
        ahead[each, robot] = np.where(goes_on, decided.ahead[parent, choice], ahead[each, robot])
        value = begun.value[parent] + np.where(goes_on, decided.value[parent, choice], 0.0)
        state, rows = begun.state.take(parent), np.flatnonzero(goes_on)
        chosen = take(choices, (parent[rows], choice[rows]))
        moved = self._move(state.take(rows), chosen, take(decided.results, (parent[rows], choice[rows])))
        state.put(rows, moved)
        return Beginnings(state, value, hope.ravel()[kept], ahead, mark.ravel()[kept]), parent, choice

    def _move(self, state: LineState, chosen: Rows1[Choice], results: Rows1[Result]) -> LineState:
        """States (K,) after their decisions, at the next ones."""
        riders, rows = self._copies[: len(chosen)], np.arange(len(chosen))
        simulate.end_cycles(self._tables, state, riders, chosen, results, Outcome.empty(len(chosen)))
        simulate.advance(self._tables, state, riders, rows, MOST_LOOKS)
        return state

    def _decide(self, begun: Beginnings) -> Decided:
        """What the choices of some beginnings bring."""
        state, tables, prices, ways = begun.state, self._tables, self._prices, self._ways
        choices, clock, robot = state.choices, state.clock[:, None], state.robot
        results = Result.none(*choices.shape)
        simulate.predict(tables, state, self._copies[: len(choices)], choices, results)
        index, picked = choices["index"], results["picked"]
        in_time = clock + choices["cycle"] <= tables.line["duration"][0]
        value = np.where(results["sorted"] & in_time, self._riders["worth"][index], 0.0)
        moment, is_known = self._moments(state, picked)
        before = begun.ahead[np.arange(len(robot)), robot][:, None]
        ahead = np.where(picked, ways.after[THROWN, moment], ways.after[EMPTY, moment])
        failed = prices.failed[index]
        gain = np.where(picked, value - prices.taken[index] - self._failures[index] * failed, failed)
        # A choice without a moment brings nothing; it counts where there is no other one.
        may_do = is_known | ~is_known.any(axis=1, keepdims=True)
        gain, ahead = np.where(is_known, gain, 0.0), np.where(is_known, ahead, before)
        hope = np.where(may_do, begun.hope[:, None] - before + gain + ahead, -np.inf)
        return Decided(results, np.where(choices["real"], value, 0.0), ahead, hope)

    def _moments(self, state: LineState, picked: Bools) -> tuple[Ints, Bools]:
        """Rows of the moments of choices (B, CHOICES), and whether there is one."""
        choices, robot, step = state.choices, state.robot[:, None], self._bound.step
        passages, stations = self._bound.network.passages, self._tables.stations
        percent = self._tables.settings["percent"]
        own = stations["first_setting"][robot][..., None] + np.arange(self._passage.shape[3])
        setting = np.abs(percent[np.minimum(own, len(percent) - 1)] - choices["percent"][..., None]).argmin(axis=-1)
        passage = self._passage[robot, choices["index"], choices["bin"], setting, picked.astype(np.int64)]
        at = (
            np.floor((state.clock[:, None] + choices["lift"]) / step).astype(np.int64) - passages["first_step"][passage]
        )
        at = np.clip(at, 0, passages["count"][passage] - 1)
        is_known = choices["real"] & (passage >= 0)
        return np.where(is_known, passages["first_row"][passage] + at, 0), is_known


def _most_hopeful(hope: Floats, mark: Ints) -> Ints:
    """Places of the most hopeful of some decisions (B, CHOICES), counted row by row.

    Of each beginning a few count, and of those with the same marks the best one: others differ in the order of attempts
    alone.
    """
    rank = np.argsort(np.argsort(-hope, axis=1, kind="stable"), axis=1)
    some = np.where(rank < FEW, hope, -np.inf).ravel()
    order = np.argsort(-some, kind="stable")
    order = order[some[order] > -np.inf]
    first = np.unique(mark.ravel()[order], return_index=True)[1]
    return np.asarray(order[np.sort(first)][:WIDTH])


@final
class Clairvoyant(Controller):
    """Takes the decisions of the best order that is found for each shift in advance.

    Args:
        name: name in tables.
        core: core of the lines.

    Raises:
        UsageError: no table decides the throws of the line, so that nobody can know how they end.
    """

    def __init__(self, name: str, core: LineCore) -> None:
        if core.config.throws != "table":
            raise UsageError(
                f"controller {name!r} knows the results of throws by their table, and level {core.config.name!r} has "
                f"throws {core.config.throws!r}; use it with --throws table"
            )
        self.name, self._core = name, core
        self.bounds: dict[int, float] = {}
        """Upper bound of the value of the present shift, by line."""
        self._shifts: dict[int, tuple[NDArray[np.float64], list[int]]] = {}
        """Places of the objects, and coming choices in reversed order, by line."""

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """The planned choice of each line (N,)."""
        return np.array([self._next(line) for line in range(len(observation.kind))], dtype=np.int64)

    def _next(self, line: int) -> int:
        cell = self._core.cell
        x = cell.stream.x[line]
        places, choices = self._shifts.get(line, (None, []))
        if places is None or not choices or not np.array_equal(places, x):
            choices = self._plan(line)[::-1]
            self._shifts[line] = x.copy(), choices
        return choices.pop()

    def _plan(self, line: int) -> list[int]:
        """Choices of the best order that is found for the shift of a line."""
        cell = self._core.cell
        tables, riders = cell.chooser.tables, cell.stream.riders[line]
        bound, begin = find_bound(tables, riders, is_drawn=True), np.array([line])
        self.bounds[line] = bound.value
        found = [ShiftSearch(tables, riders, bound, share).search(cell.state.take(begin)) for share in SHARES]
        return max(found, key=lambda one: one[0])[1]
