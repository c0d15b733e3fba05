"""Layouts of a line: places of bins and robots, how far a layout is from a possible one, and lines with a layout."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Final, Literal, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.sorting import Bin
from pnt_gym.cells.line.config import LineConfig

What = Literal["bins", "robots", "all"]
"""What is placed."""
Rectangle = tuple[float, float, float, float]
"""Least and greatest x, least and greatest y [m]."""
CLEAR: Final = 0.0015
"""Gap beside a bin or window that was pushed, so that places may be rounded to whole millimetres [m]."""
NEAR: Final = 50
"""Passes that push along shorter ways only, so that bins stay near their places."""
OTHERWISE: Final = 4
"""Of the later passes, each of this number pushes along longer ways."""
PASSES: Final = 100
"""Most passes in which bins are pushed off each other."""
TOUCH: Final = 1e-9
"""Overlap that counts as touching [m]."""


@final
@dataclass(frozen=True)
class Layout:
    """Places of the bins and robots of a line."""

    bins: Floats
    """Middles of the openings of all sets of bins, from the base of their robots (B, 2) [m]."""
    robots: Floats
    """Places of the robots along the belt (R,) [m]."""


@final
class Grounds:
    """The room in which bins and robots of a line may stand.

    Robots with the same bins share one set, whose bins move together. The middle of an opening stays in the rectangle
    around the reach of the set's robots and today's places, off the belt, off all other bins and out of what is kept
    free.

    Args:
        config: the line.
        what: what is placed; everything else stays.
        keep_out: rectangles in which no bin may stand, from the line's origin.
    """

    def __init__(self, config: LineConfig, what: What = "bins", keep_out: Sequence[Rectangle] = ()) -> None:
        self.config, self._what = config, what
        self._sets = list(dict.fromkeys(robot.bins for robot in config.robots))
        bins = [own or config.cell.bins.fixed for own in self._sets]
        self.names = [one.name for own in bins for one in own]
        """Names of the bins (B,)."""
        self.set_of: Ints = np.repeat(np.arange(len(bins)), [len(own) for own in bins])
        """Set of each bin (B,)."""
        self.today = Layout(np.array([[one.x, one.y] for own in bins for one in own]), config.robot_x())
        # All bins that stand there: those of a set stand beside each of its robots.
        robot_sets = [self._sets.index(robot.bins) for robot in config.robots]
        standing = [(b, r) for r, own in enumerate(robot_sets) for b in np.flatnonzero(self.set_of == own)]
        self._bin, self._robot = np.array(standing, dtype=np.int64).T
        wall, self._half = config.cell.bins.wall, np.array([one.size for own in bins for one in own])[self._bin] / 2.0
        self._gap, self._alike = wall, self._bin[:, None] == self._bin
        reach = np.array([_area(config, np.flatnonzero(np.equal(robot_sets, own))) for own in self.set_of])
        self._low = np.minimum(reach[:, ::2], self.today.bins)
        self._high = np.maximum(reach[:, 1::2], self.today.bins)
        self._keep_out = np.array(keep_out, dtype=np.float64).reshape(-1, 4)

    @property
    def free(self) -> Ints:
        """Places of the numbers that may change, in a vector of all bins and robots; the first robot stays."""
        bins, robots = self.today.bins.size, len(self.today.robots)
        of_bins = np.arange(bins if self._what != "robots" else 0)
        of_robots = np.arange(bins + 1, bins + (robots if self._what != "bins" else 1))
        return np.concatenate([of_bins, of_robots])

    def vector(self, layout: Layout) -> Floats:
        """The numbers of a layout that may change [m]."""
        return np.concatenate([layout.bins.ravel(), layout.robots])[self.free]

    def layout(self, vector: Floats) -> Layout:
        """The layout of a vector, with bins and robots pushed apart as far as there is room, in whole millimetres."""
        whole, count = np.concatenate([self.today.bins.ravel(), self.today.robots]), self.today.bins.size
        whole[self.free] = vector
        bins, robots = whole[:count].reshape(-1, 2), whole[count:]
        (low, high), is_placed = self.config.cell.belt.pick_x, self._what != "bins"
        for index in range(1, len(robots) if is_placed else 1):
            robots[index] = max(robots[index], robots[index - 1] + high - low + CLEAR)
        if self._what != "robots":
            bins = self._pushed(bins, robots)
        return Layout(np.round(bins, 3), np.round(robots, 3))

    def _pushed(self, bins: Floats, robots: Floats) -> Floats:
        """Bins pushed off each other and off what is fixed, inside of their areas (B, 2) [m]."""
        for number in range(1, PASSES + 1):
            # At last also along the other axis, or bins between two others would stay there.
            between, fixed = self._ways(bins, robots, number > NEAR and number % OTHERWISE == 0)
            ways = 0.5 * between.sum(axis=1) + fixed.sum(axis=1)
            if not ways.any():
                break
            moved = np.zeros_like(bins)
            np.add.at(moved, self._bin, ways + CLEAR * np.sign(ways))
            bins = np.clip(bins + moved, self._low, self._high)
        return np.clip(bins, self._low, self._high)

    def _ways(self, bins: Floats, robots: Floats, longest: bool = False) -> tuple[Floats, Floats]:
        """Shortest ways that free each standing bin (S,) from the others (S, S, 2) and from what is fixed (S, F, 2).

        Args:
            bins: middles of the openings (B, 2) [m].
            robots: places of the robots (R,) [m].
            longest: whether ways are along the axis of the longer way.
        """
        middles = bins[self._bin] + np.stack([robots[self._robot], np.zeros(len(self._bin))], axis=-1)
        sign = -1.0 if longest else 1.0
        between = _ways_out(middles, middles, self._half[:, None] + self._half + self._gap, sign)
        between[self._alike] = 0.0
        belt = self.config.cell.belt
        belts = np.array([[x + belt.x[0], x + belt.x[1], *belt.y] for x in robots])
        taken = np.concatenate([belts, self._keep_out])
        sizes = (taken[:, 1::2] - taken[:, ::2]) / 2.0
        centres, distances = (taken[:, ::2] + taken[:, 1::2]) / 2.0, self._half[:, None] + sizes + self._gap
        fixed = _ways_out(middles, centres, distances, sign)
        return between, fixed

    def violation(self, layout: Layout) -> float:
        """How far a layout is from a possible one: the sum of all overlaps and of the ways out of the areas [m]."""
        between, fixed = self._ways(layout.bins, layout.robots)
        outside = np.maximum(self._low - layout.bins, layout.bins - self._high).clip(min=0.0)
        low, high = self.config.cell.belt.pick_x
        windows = (high - low - np.diff(layout.robots)).clip(min=0.0)
        ways = 0.5 * np.abs(between).sum() + np.abs(fixed).sum() + outside.sum() + windows.sum()
        return float(ways)

    def swaps(self, layout: Layout) -> list[Layout]:
        """Layouts in which two bins of a set have changed places."""
        pairs = combinations(range(len(self.set_of)), 2) if self._what != "robots" else ()
        swapped: list[Layout] = []
        for pair in pairs:
            if self.set_of[pair[0]] == self.set_of[pair[1]]:
                bins = layout.bins.copy()
                bins[list(pair)] = bins[list(reversed(pair))]
                swapped.append(self.layout(self.vector(Layout(bins, layout.robots))))
        return swapped

    def nearer(self, way: float) -> Layout:
        """Today's layout with all bins nearer to the belt by a way, as far as there is room."""
        bins, (left, right) = self.today.bins.copy(), self.config.cell.belt.y
        across = bins[:, 1] - (left + right) / 2.0
        room = np.maximum(np.abs(across) - (right - left) / 2.0, 0.0)
        bins[:, 1] -= np.sign(across) * np.minimum(way, room)
        return self.layout(self.vector(Layout(bins, self.today.robots)))

    def crossings(self, layout: Layout) -> list[Layout]:
        """Layouts in which one bin has gone to the other side of the belt."""
        crossed, (left, right) = list[Layout](), self.config.cell.belt.y
        for index in range(len(layout.bins) if self._what != "robots" else 0):
            bins, half = layout.bins.copy(), self._half[self._bin == index][0, 1] + self._gap + CLEAR
            bins[index, 1] = left - half if bins[index, 1] > left else right + half
            crossed.append(self.layout(self.vector(Layout(bins, layout.robots))))
        return crossed

    def differences(self, layout: Layout) -> dict[str, Any]:
        """What a layout changes in the level of its line, in the form of a level's file."""
        sets = {own: self._moved(own, layout.bins[self.set_of == number]) for number, own in enumerate(self._sets)}
        shared = sets.pop((), None)
        robots = [
            robot.model_copy(update={"x": float(x)} | ({"bins": sets[robot.bins]} if robot.bins else {}))
            for robot, x in zip(self.config.robots, layout.robots, strict=True)
        ]
        changed: dict[str, Any] = {}
        if shared is not None and shared != self.config.cell.bins.fixed:
            changed["cell"] = {"bins": {"fixed": [one.model_dump(mode="json", exclude_unset=True) for one in shared]}}
        if tuple(robots) != self.config.robots:
            changed["robots"] = [robot.model_dump(mode="json", exclude_unset=True) for robot in robots]
        return changed

    def _moved(self, own: tuple[Bin, ...], places: Floats) -> tuple[Bin, ...]:
        bins = own or self.config.cell.bins.fixed
        return tuple(one.model_copy(update={"x": x, "y": y}) for one, (x, y) in zip(bins, places.tolist(), strict=True))

    def line(self, layout: Layout) -> LineConfig:
        """The line with a layout.

        Raises:
            ConfigError: the layout describes no possible line.
        """
        whole = self.config.model_dump(exclude_unset=True)
        return LineConfig.load(LineConfig.merge(whole, self.differences(layout)))


def _area(config: LineConfig, robots: Ints) -> Rectangle:
    """Where the middles of bins may lie: the rectangle around what all of some robots reach."""
    low, high = np.full(2, -np.inf), np.full(2, np.inf)
    for reach in (config.sheets()[index].reach for index in robots):
        centre, axes = np.array([reach.x, reach.y]), np.array(reach.semi_axes)
        low, high = np.maximum(low, centre - axes), np.minimum(high, centre + axes)
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _ways_out(middles: Floats, others: Floats, distances: Floats, sign: float) -> Floats:
    """Ways along one axis that free rectangles (S,) from others (F,), zero where they do not overlap (S, F, 2).

    Args:
        middles: middles of the rectangles (S, 2) [m].
        others: middles of the others (F, 2) [m].
        distances: distances along each axis at which they touch (S, F, 2) [m].
        sign: 1 for the shorter of the two ways, -1 for the longer one.
    """
    apart = middles[:, None] - others
    depth = distances - np.abs(apart)
    signs = np.where(apart == 0.0, np.where(np.arange(len(middles)) % 2, 1.0, -1.0)[:, None, None], np.sign(apart))
    is_taken = np.equal(np.arange(2), (sign * depth).argmin(axis=-1)[..., None])
    overlaps = (depth > TOUCH).all(axis=-1, keepdims=True)
    return np.where(is_taken & overlaps, signs * depth, 0.0)
