"""Rows of `perf.py` and their figures: calls that are timed in turn, so that what is compared sees the same noise."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

from agents.ground.cli import option

Place = tuple[str | int, ...]
"""Of a figure in the results: keys, and positions in lists."""
PER_SECOND: Final = {"s": 1.0, "ms": 1e3, "us": 1e6}
WALL, CPU = 0, 1
"""Clocks of a turn: of the wall, and of the processor by all threads."""


class Seconds(NamedTuple):
    """Duration of a turn by both clocks [s]."""

    wall: float = 0.0
    cpu: float = 0.0

    def and_of(self, call: Callable[[], object]) -> Seconds:
        """This duration and that of a call."""
        wall, cpu = time.perf_counter(), time.process_time()
        call()
        return Seconds(self.wall + time.perf_counter() - wall, self.cpu + time.process_time() - cpu)


@dataclass(frozen=True)
class Options:
    """What a command line asks of all cases."""

    repeats: Annotated[int | None, option("each timing's own", "N")] = None
    """Turns of every timing."""
    quick: bool = False
    """Smaller batches and a tenth of the turns."""
    cells: int = 64
    """Cells of a vector environment."""
    threads: tuple[int, ...] = (1, 2)
    """Physics threads to compare."""
    level: Annotated[str | None, option("waste at the conveyor, single at a line, nominal elsewhere", "NAME")] = None
    """Level of the vector environments."""
    before: Annotated[Path | None, option("no comparison", "DIR")] = None
    """Checkout of older code, which the cases `before/...` time in turn with this code."""

    def size(self, usual: int) -> int:
        """Rows of a batch, or turns."""
        return max(usual // 10, 1) if self.quick else usual


@dataclass(frozen=True)
class Timing:
    """A figure of time.

    Attributes:
        place: of the figure.
        call: what is timed, or the place of a timing that has the same call; of a call that returns `Seconds` these
            count, the rest of the call does not.
        unit: s, ms or us for an item, "1/s" for items per second, "x" for a ratio.
        count: items per call, known after the last turn if it is a function.
        repeats: turns after the first one, which warms up; calls that repeat as often take turns.
        statistic: of the times of all turns.
        clock: `WALL` or `CPU`.
        over: place of the timing whose time for an item is 1 in a ratio.
    """

    place: Place
    call: Callable[[], object] | Place
    unit: str = "us"
    count: float | Callable[[], float] = 1.0
    repeats: int = 7
    statistic: Callable[[list[float]], float] = min
    clock: int = WALL
    over: Place = ()


@dataclass(frozen=True)
class Count:
    """A figure that is no time, or a mapping of such figures; a function is called after the last turn."""

    place: Place
    value: Any


Row = Timing | Count
Times = dict[Place, list[Seconds]]
"""Duration of every turn of a call."""


def figures(rows: Iterable[Row], options: Options) -> dict[Place, Any]:
    """The figures of a case by their places."""
    rows = list(rows)
    timings = {row.place: row for row in rows if isinstance(row, Timing)}
    times, values = times_in_turn(timings.values(), options), dict[Place, Any]()
    for row in rows:
        value = _figure(row, timings, times) if isinstance(row, Timing) else row.value
        value = value() if callable(value) else value
        values |= {(*row.place, key): v for key, v in value.items()} if isinstance(value, dict) else {row.place: value}
    return values


def times_in_turn(timings: Iterable[Timing], options: Options) -> Times:
    """Times of all calls; those that repeat as often take turns, others would only fill their caches."""
    calls = {row.place: (row.call, row.repeats) for row in timings if callable(row.call)}
    times: Times = {place: [] for place in calls}
    for repeats in dict.fromkeys(repeats for _, repeats in calls.values()):
        for _ in range(1 + (options.repeats or options.size(repeats))):
            for place in (place for place, (_, count) in calls.items() if count == repeats):
                times[place].append(_duration(calls[place][0]))
    return {place: turns[1:] for place, turns in times.items()}


def _duration(call: Callable[[], object]) -> Seconds:
    """The seconds that a call returns, or those that the call takes."""
    results = list[object]()
    whole = Seconds().and_of(lambda: results.append(call()))
    return results[0] if isinstance(results[0], Seconds) else whole


def nest(values: Mapping[Place, Any]) -> dict[str, Any]:
    """Figures as JSON holds them."""
    root: dict[Any, Any] = {}
    for place, value in values.items():
        node = root
        for key in place[:-1]:
            node = node.setdefault(key, {})
        node[place[-1]] = value
    return _with_lists(root)


def _with_lists(node: Any) -> Any:
    """Figures with lists in place of mappings by position."""
    if not isinstance(node, dict):
        return node
    parts = {key: _with_lists(value) for key, value in node.items()}
    return list(parts.values()) if all(isinstance(key, int) for key in parts) else parts


def _figure(row: Timing, timings: Mapping[Place, Timing], times: Times) -> float:
    """The figure in its unit."""
    item = _item_seconds(row, row.clock, timings, times)
    if row.unit == "x":
        return item / _item_seconds(timings[row.over], row.clock, timings, times)
    return 1.0 / item if row.unit == "1/s" else PER_SECOND[row.unit] * item


def _item_seconds(row: Timing, clock: int, timings: Mapping[Place, Timing], times: Times) -> float:
    """Seconds for an item by a clock."""
    origin = row
    while not callable(origin.call):
        origin = timings[origin.call]
    count = row.count() if callable(row.count) else row.count
    return row.statistic([turn[clock] for turn in times[origin.place]]) / count
