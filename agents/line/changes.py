"""What could mend a line: one thing changed at a time, and what each change brings over the same shifts."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, Final, TypeAlias

import numpy as np

from pnt_gym.cells.base.sorting import Bin
from pnt_gym.cells.conveyor.robot import RobotSheet, sheet_names
from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig
from pnt_gym.engine import mute_warnings
from pnt_gym.errors import ConfigError, PntGymError

from ..ground import metrics
from ..ground.metrics import Interval
from ..ground.tables import throws_bar
from .estimate import estimate
from .plans import Conditions, Planned, line_up, widen

EVEN: Final = 20.0
"""Regularity of an even stream."""
BURSTS: Final = 1.0
"""Regularity below which a stream comes in bursts."""
NEARER: Final = 0.10
"""Way of bins towards the belt [m]."""
NARROWER: Final = 0.75
"""Width of narrower lanes over that of the line's lanes."""
SLOWER: Final = 0.75
"""Speed of a slower belt over that of the line."""
LOWER: Final = 0.5
"""Percentage of lower limits over that of the line."""
FASTER: Final = 1.25
"""Percentage of higher limits over that of the line."""
Differences: TypeAlias = dict[str, Any]


@dataclass(frozen=True)
class Change:
    """A line with one thing changed."""

    what: str
    """What is changed."""
    to: str
    """The value that it has then; empty where `what` says all."""
    config: LineConfig


@dataclass(frozen=True)
class Gain:
    """What a change brings, over the same shifts."""

    what: str
    to: str
    recovery: float
    """Recovery of the changed line."""
    points: Interval
    """Recovery of the changed line less that of the line as it is, as a share of all objects."""
    money_per_hour: float | None

    @property
    def words(self) -> str:
        """The change in words, to stand after "with"."""
        return f"{self.what} {self.to}" if self.to else self.what


def possible_changes(line: LineConfig, item: str) -> list[Change]:
    """All possible lines that differ from a line in one thing; the bins of an item are swapped with other bins."""
    changes = list[Change]()
    kinds = _robots(line), _swaps(line, item), _nearer(line), _lanes(line), _paces(line), _stream(line), _ideals(line)
    for what, to, differences in chain(*kinds):
        try:
            changes.append(Change(what, to, LineConfig.load(line, chances=None, **differences)))
        except ConfigError:
            continue
    return changes


def try_changes(
    line: LineConfig,
    changes: Sequence[Change],
    conditions: Conditions,
    release: str | None = None,
) -> list[Gain]:
    """What changes of a line bring over the same shifts by flights, the best first.

    A changed line that cannot be judged is left out: no robot reaches a bin, or the engine gives up.
    """
    gains = list[Gain]()
    with warnings.catch_warnings(), mute_warnings(), throws_bar(quiet=conditions.quiet) as bar:
        warnings.simplefilter("ignore", UserWarning)  # what is out of reach after a change, its gain says
        before = estimate(line, conditions, conditions.throws, release=release)
        for change in bar.track(changes, description="changes"):
            try:
                changed = estimate(change.config, conditions, conditions.throws, before.table, release).planned
            except PntGymError:
                continue
            gains.append(gain(change, changed, before.planned))
    return sorted(gains, key=lambda each: each.points.value, reverse=True)


def gain(change: Change, changed: Planned, line: Planned) -> Gain:
    """What a change brings: recoveries paired by shift, with the spread of the counts behind both tables."""
    paired = metrics.difference(changed.recovery, line.recovery)
    spread = 0.0
    if changed.config.digest() != line.config.digest():
        spread = float(np.hypot(changed.row["recovery_counts"], line.row["recovery_counts"]))
    return Gain(
        change.what, change.to, float(changed.row["recovery"]), widen(paired, spread), changed.row["money_per_hour"]
    )


def _robots(line: LineConfig) -> Iterator[tuple[str, str, Differences]]:
    """One more robot, all skills, and robots by the other data sheets that ship."""
    robots = [robot.model_dump(mode="json") for robot in line.robots]
    if len(robots) < MOST_ROBOTS:
        more = line_up(line, len(robots) + 1)
        yield "one more robot", "", {"robots": [robot.model_dump(mode="json") for robot in more]}
    if any(robot["skills"] for robot in robots):
        yield "all skills for every robot", "", {"robots": [{**robot, "skills": []} for robot in robots]}
    own = {sheet.name for sheet in line.sheets()}
    for name in sheet_names():
        sheet = RobotSheet.model_validate(name)
        if own != {sheet.name}:
            same = [{**robot, "robot": None} for robot in robots]
            yield "robots", name, {"robots": same, **cell_differences(line, robot=name, fidelity="flight")}


def _swaps(line: LineConfig, item: str) -> Iterator[tuple[str, str, Differences]]:
    """The first bin that takes an item swapped with a bin of the same robots that does not."""
    for owner, bins in _bin_sets(line).items():
        one = next((bin_ for bin_ in bins if bin_.takes(item)), None)
        for other in bins:
            if one is None or other.takes(item):
                continue
            places = {one.name: other, other.name: one}
            swapped = tuple(_moved(bin_, places.get(bin_.name, bin_)) for bin_ in bins)
            whose = f" of robot {owner}" if owner else ""
            yield "a swap of bins", f"{one.name} and {other.name}{whose}", place_bins(line, {owner: swapped})


def _nearer(line: LineConfig) -> Iterator[tuple[str, str, Differences]]:
    """All bins nearer to the belt."""
    sets = _bin_sets(line)
    middle = float(np.mean(line.cell.belt.lane_y))
    nearer = {
        owner: tuple(bin_.model_copy(update={"y": bin_.y + NEARER * float(np.sign(middle - bin_.y))}) for bin_ in bins)
        for owner, bins in sets.items()
    }
    yield "bins nearer to the belt by", f"{1000 * NEARER:.0f} mm", place_bins(line, nearer)


def _bin_sets(line: LineConfig) -> dict[str, tuple[Bin, ...]]:
    """Bins of each robot that has bins of its own, by the robot's name; under "" those that other robots share."""
    own = {robot.name: robot.bins for robot in line.robots if robot.bins}
    return own if len(own) == len(line.robots) else {"": line.cell.bins.fixed, **own}


def _moved(bin_: Bin, place: Bin) -> Bin:
    """A bin at the place of another bin."""
    return bin_.model_copy(update={"x": place.x, "y": place.y})


def place_bins(line: LineConfig, sets: Mapping[str, Sequence[Bin]]) -> Differences:
    """Differences of a line with other bins, by the names of the robots that have them; "" for the shared ones."""
    dumped = {owner: [bin_.model_dump(mode="json") for bin_ in bins] for owner, bins in sets.items()}
    robots = [
        robot.model_dump(mode="json") | ({"bins": dumped[robot.name]} if robot.name in dumped else {})
        for robot in line.robots
    ]
    return {"robots": robots, **(section_differences(line, "bins", fixed=dumped[""]) if "" in dumped else {})}


def _lanes(line: LineConfig) -> Iterator[tuple[str, str, Differences]]:
    """Lanes that are narrower, on the side of the bins."""
    (right, left), bins = line.cell.belt.lane_y, [bin_ for bins in _bin_sets(line).values() for bin_ in bins]
    away = (1.0 - NARROWER) * (left - right)
    is_left = np.mean([bin_.y for bin_ in bins]) > (right + left) / 2.0
    lanes = (right + away, left) if is_left else (right, left - away)
    yield "lanes narrower on the far side by", f"{1000 * away:.0f} mm", section_differences(line, "belt", lane_y=lanes)


def _paces(line: LineConfig) -> Iterator[tuple[str, str, Differences]]:
    """A slower belt with as many objects a minute, and lower or higher limits of the robots."""
    speed, percents = SLOWER * line.cell.belt.speed, line.cell.limits.percent
    yield "a belt at", f"{speed:.2f} m/s", section_differences(line, "belt", speed=speed)
    for share in (LOWER, FASTER):
        changed = tuple(dict.fromkeys(min(round(share * percent), 100) for percent in percents))
        if changed != percents:
            text = f"{' and '.join(f'{each:g}' for each in changed)} %"
            yield "limits of", text, section_differences(line, "limits", percent=changed)


def _stream(line: LineConfig) -> Iterator[tuple[str, str, Differences]]:
    """Half of the stream, and a stream without bursts."""
    arrivals = line.arrivals.model_dump(mode="json")
    yield "half as many objects", "", {"arrivals": {**arrivals, "rate": line.arrivals.rate / 2.0}}
    if line.arrivals.regularity < BURSTS:
        yield "an even stream", "", {"arrivals": {**arrivals, "regularity": EVEN}}


def _ideals(line: LineConfig) -> Iterator[tuple[str, str, Differences]]:
    """Parts of the cell that never fail: cups, camera, bins and robots."""
    cell = line.cell
    if cell.pick.fails:
        yield "cups that always seal", "", section_differences(line, "pick", fails=False)
    if cell.classifier.confusion:
        yield "a camera that never errs", "", section_differences(line, "classifier", confusion={})
    if cell.bins.emptied is not None:
        yield "bins that are never full", "", section_differences(line, "bins", emptied=None)
    if line.down:
        yield "no standstill", "", {"down": ()}


def cell_differences(line: LineConfig, **changes: Any) -> Differences:
    """Differences of a line whose cell has other values."""
    return {"cell": line.cell.model_dump(mode="json", exclude_unset=True) | changes}


def section_differences(line: LineConfig, name: str, **changes: Any) -> Differences:
    """Differences of a line whose cell has other values in one of its sections."""
    return cell_differences(
        line, **{name: getattr(line.cell, name).model_dump(mode="json", exclude_unset=True) | changes}
    )
