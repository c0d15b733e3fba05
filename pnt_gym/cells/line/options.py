"""Options of a line's robots: every object that a robot can meet, into every bin that takes the object, as planned.

Times and feasibility are those of the conveyor's planner, so a chosen option is executed with the same values.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.state import PicksAndThrows
from pnt_gym.planning.motion.limits import LimitRows

UNAVAILABLE_X: Final = 1e6
"""Position along the belt of objects that the robot cannot take [m]."""


@final
@dataclass(frozen=True)
class Options(PicksAndThrows):
    """Possible picks and throws, S = (C,), in the order of their lines."""

    row: Ints
    """Index of the line among K lines."""
    place: Ints
    """Index of the object among the line's objects in sight."""


class Sight(NamedTuple):
    """Objects that camera and encoder know in K lines: W objects each, the most downstream first."""

    line: Ints
    """Indices of the lines (K,)."""
    object_index: Ints
    """Indices of the objects in their streams (K, W)."""
    x: Floats
    """Position along the belt (K, W) [m]; `UNAVAILABLE_X` where the object may not be taken."""
    kind: Ints
    """Item as which the camera classifies the object (K, W)."""


class ThrowCandidates(NamedTuple):
    """Objects near C robots, each for one bin and one speed setting, in the order of the lines."""

    indices: Ints
    """Line among K lines, object among the line's objects in sight, site and setting, (4, C)."""
    x: Floats
    """Position of the object from the robot's base (C,) [m]."""


@final
class Sites:
    """Bins and speed settings of all kinds of robots in one table each.

    Args:
        configs: the kinds of robots, each as a conveyor cell.
        kind_of: kind of each robot (R,).
    """

    def __init__(self, configs: Sequence[ConveyorConfig], kind_of: Ints) -> None:
        bins = [len(config.bins.fixed) for config in configs]
        settings = [len(config.limits.percent) for config in configs]
        first_bins, first_settings = np.cumsum([0, *bins]), np.cumsum([0, *settings])
        self.kind: Ints = np.repeat(np.arange(len(configs)), bins)
        """Kind of robots that has each site (B,)."""
        self.bin: Ints = np.arange(first_bins[-1]) - first_bins[self.kind]
        """Index of each site among the bins of its robots (B,)."""
        self.centre = np.array([[b.x, b.y, c.bins.rim] for c in configs for b in c.bins.fixed]).reshape(-1, 3)
        """Middle of each site's opening (B, 3) [m]."""
        self.accepts = np.ascontiguousarray(np.concatenate([config.acceptance().T for config in configs]))
        """Whether each site takes each item (B, items)."""
        self.percent = np.concatenate([np.array(config.limits.percent, dtype=np.float64) for config in configs])
        """Speed settings (S,) [%]."""
        columns = first_bins[kind_of], first_bins[kind_of + 1], first_settings[kind_of], first_settings[kind_of + 1]
        self.ranges = np.ascontiguousarray(np.stack(columns, axis=1), dtype=np.int64)
        """Each robot's first site and the index after its last site, and the same of its settings (R, 4)."""
        self.most = int(max(config.acceptance().sum(axis=1).max() * len(config.limits.percent) for config in configs))
        """Largest number of candidates with one object."""


class OptionPlanner(ABC):
    """Abstract: plans the options among candidates."""

    tables: tuple[Floats, Floats, Floats] | None = None
    """Numbers of a cell, settings, and centres of the bins' openings, with which `decision_kernel` plans the same
    options; None where the kernel cannot."""

    @abstractmethod
    def plan(self, candidates: ThrowCandidates, sight: Sight, hand: Floats, objects: Objects) -> Options:
        """ThrowCandidates that can be met in time and thrown, with their plans.

        Args:
            candidates: candidates of the deciding robots of K lines.
            sight: sight of these lines.
            hand: positions at which the robots' hands stand still, from their bases (K, 3) [m].
            objects: objects of all N lines (N, M).
        """


@final
class MoverPlanner(OptionPlanner):
    """Plans options by the planners of the robots' conveyor cells, whatever their movers are.

    Args:
        planners: the planner of each kind of robots.
        sites: bins and speed settings of all kinds.
        horizon: time within which an object may be taken [s].
    """

    def __init__(self, planners: Sequence[PickPlanner], sites: Sites, horizon: float) -> None:
        self._planners, self._sites, self._horizon = planners, sites, horizon

    def plan(self, candidates: ThrowCandidates, sight: Sight, hand: Floats, objects: Objects) -> Options:
        """Options of all kinds of robots, merged in the order of the lines."""
        kind, parts = self._sites.kind[candidates.indices[2]], list[tuple[Ints, Ints, Ints, Floats]]()
        for index, planner in enumerate(self._planners):
            kind_candidates = take(candidates, np.s_[..., kind == index])
            parts.append(self._plan(planner, kind_candidates, sight, hand, objects))
        row, place, bins, numbers = (np.concatenate(values) for values in zip(*parts, strict=True))
        order = np.argsort(row, kind="stable")
        return Options(bin=bins[order], numbers=numbers[order], row=row[order], place=place[order])

    def _plan(
        self, planner: PickPlanner, candidates: ThrowCandidates, sight: Sight, hand: Floats, objects: Objects
    ) -> tuple[Ints, Ints, Ints, Floats]:
        """Row, place, bin and numbers of the options of one kind of robots."""
        row, place, site, setting = candidates.indices
        belt, mover, dwell = planner.config.belt, planner.mover, planner.config.motion.dwell
        index, bins = (sight.line[row], sight.object_index[row, place]), self._sites.bin[site]
        percent = self._sites.percent[setting]
        height = planner.height(objects.size[index], objects.known_depth[index])
        points = np.stack([candidates.x, objects.draws.lane_y[index], height], axis=-1)
        meeting = mover.reach(ThrowMotion.resting(hand[row]), points, LimitRows.t3kr(percent))
        met = np.flatnonzero(meeting.feasible & (meeting.time <= self._horizon))
        throws = replace(take(objects, (index[0][met], index[1][met])), percent=percent[met])
        context, feasible = planner.plan_into(throws, meeting.position[met], bins[met])
        rows, pick, target = met[feasible], context.pick[feasible], context.target[feasible]
        motion = mover.throw(
            pick, take(context.plan, feasible), take(context.throw_limits, feasible), take(context.ceiling, feasible)
        )
        lift = meeting.time[rows] + dwell
        leave = lift + (belt.pick_x[1] - pick[:, 0]) / belt.speed
        away = target[:, :2] - pick[:, :2]
        columns = percent[rows], pick, away, lift, meeting.wait[rows], leave, motion.stop_time, motion.stop
        return row[rows], place[rows], bins[rows], np.column_stack(columns)
