"""Lookahead planners: beam search over the decisions that follow a choice, by camera, encoder and planner.

True properties of objects, results of throws, and objects upstream of the camera are not included.

An `Outlook` holds all of the planners' knowledge: chances come from the table, and other robots are free when expected.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, take
from pnt_gym.cells.line.choosing import Chooser, Sight
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.rows import CHOICES, IDLE_TIME, UNAVAILABLE_X, Choice, Rider, Seen
from pnt_gym.rows import Rows1, Rows2

from ..controllers.protocol import Controller, Observation
from . import rules
from .rules import ScoreController, choice_mask


@final
@dataclass(frozen=True)
class Outlook:
    """N lines with R robots and at most W objects in sight, at a decision; times are from now on."""

    sight: Sight
    """Positions and classified items of the objects in sight."""
    riders: Rows2[Rider]
    """Objects in sight, as sensors report them (N, W)."""
    choices: Rows2[Choice]
    """Choices of the deciding robots."""
    robot: Ints
    """Index of the deciding robot (N,)."""
    speed: float
    """Speed of the belt [m/s]."""
    chooser: Chooser
    """Finds options by the robots' planner and the table of chances."""

    def options(self, line: Ints, x: Floats, robot: Ints, hand: Floats) -> tuple[Rows1[Choice], Bools]:
        """Options at later decisions.

        Args:
            line: indices of the lines (P,).
            x: positions of the objects in sight at that time (P, W) [m]; `UNAVAILABLE_X` where the object may not
                be taken.
            robot: index of the deciding robot at that time (P,).
            hand: position of the robot's hand (P, 3) [m].

        Returns:
            C options, and whether a robot downstream can take the object too (C,).
        """
        seen = Seen.zeros(*x.shape, index=np.arange(x.shape[1]), x=x, kind=self.sight.seen["kind"][line])
        options = self.chooser.options(self.riders, Sight(line, seen), robot, hand)
        kind = seen["kind"][options["line"], options["place"]]
        return options, np.asarray(self.chooser.heirs(robot[options["line"]], kind).any(axis=1))


def observe(core: LineCore) -> Outlook:
    """Outlook of lines at their coming decisions."""
    cell = core.cell
    sight = cell.chooser.sight(cell.state, cell.stream, np.arange(core.count))
    riders = take(cell.stream.riders, (sight.line[:, None], sight.seen["index"]))
    # Objects with measured values instead of true ones; NaN, or -1, where no sensor measures.
    reported = riders.copy()
    reported["height"], reported["kind"] = riders["measured_height"], -1
    reported["seal"] = reported["luck"] = np.nan
    return Outlook(
        sight=sight,
        riders=reported,
        choices=cell.state.choices,
        robot=cell.state.robot,
        speed=core.config.cell.belt.speed,
        chooser=cell.chooser,
    )


MAX_DECISIONS: Final = 24
"""Decisions of one plan at most."""


@final
@dataclass(frozen=True)
class PartialPlans:
    """B partial plans for N lines, from now on."""

    line: Ints
    """Index of the plan's line (B,)."""
    first: Ints
    """The choice with which the plan begins (B,)."""
    free: Floats
    """Time at which the deciding robot is free again (B,) [s]."""
    hand: Floats
    """Position of the robot's hand at `free` (B, 3) [m]."""
    taken: Bools
    """Whether the plan takes each object in sight (B, W)."""
    value: Floats
    """Expected value of the plan (B,)."""
    spent: Floats
    """Time of the robot that the plan takes (B,) [s]."""


@final
class Lookahead:
    """Beam search for the best plans of several decisions.

    Args:
        price: value of a second of a robot's time, in the comparison of plans of different length [1/s].
        share: share of its value that an object loses if a robot downstream can take it too, as in the rule
            `price`.
        width: plans that are kept for each line.
        per_choice: keep `width` plans for each first choice instead of each line.
        horizon: time until which a complete plan keeps its robot busy [s].
        depth: decisions after the first one, at most.
    """

    def __init__(
        self,
        *,
        price: float = 1.0,
        share: float = 0.0,
        width: int = 20,
        per_choice: bool = False,
        horizon: float = 4.0,
        depth: int = MAX_DECISIONS,
    ) -> None:
        self._price, self._share = price, share
        self._width, self._per_choice = width, per_choice
        self._horizon, self._depth = horizon, depth

    def plans(self, outlook: Outlook, among: Bools) -> PartialPlans:
        """The best plans that begin with some of the choices (N, CHOICES) of each line."""
        plans = self._begin(outlook, among)
        for _ in range(self._depth):
            incomplete = np.flatnonzero(plans.free < self._horizon)
            if incomplete.size == 0:
                break
            complete = take(plans, np.setdiff1d(np.arange(len(plans.line)), incomplete))
            # The best plans of each line, or of each first choice.
            extended = concatenate_records([complete, *self._extend(outlook, take(plans, incomplete))])
            group = extended.line * CHOICES + extended.first if self._per_choice else extended.line
            plans = take(extended, self.best(extended, self._width, group))
        return plans

    def worth(self, plans: PartialPlans) -> Floats:
        """Figure of merit of plans (B,)."""
        return plans.value - self._price * plans.spent

    def best(self, plans: PartialPlans, count: int, group: Ints) -> Ints:
        """Indices of the best `count` plans of each group; `group` gives each plan's group (B,)."""
        order = np.lexsort((-self.worth(plans), group))
        groups = group[order]
        place = np.arange(len(order)) - np.searchsorted(groups, groups)
        return order[place < count]

    def _begin(self, outlook: Outlook, among: Bools) -> PartialPlans:
        """Plans of one decision: some of the choices."""
        line, first = np.nonzero(among)
        chosen = take(outlook.choices, (line, first))
        cycle, hand = chosen["cycle"], chosen["stop"]
        is_taken = outlook.sight.seen["index"][line] == chosen["index"][:, None]
        value = chosen["value"] * chosen["chance"]
        value *= 1.0 - self._share * (chosen["heirs"] > 0.0)
        return PartialPlans(line, first.astype(np.int64), cycle, hand, is_taken, value, cycle)

    def _extend(self, outlook: Outlook, plans: PartialPlans) -> list[PartialPlans]:
        """Plans extended by every possible next decision; plans without one wait for a moment."""
        x = outlook.sight.seen["x"][plans.line] + outlook.speed * plans.free[:, None]
        x = np.where(plans.taken, UNAVAILABLE_X, x)
        options, inherited = outlook.options(plans.line, x, outlook.robot[plans.line], plans.hand)
        parents, cycle = take(plans, options["line"]), options["cycle"]
        free, is_taken = parents.free + cycle, parents.taken.copy()
        is_taken[np.arange(len(options)), options["place"]] = True
        value = parents.value + options["value"] * options["chance"] * (1.0 - self._share * inherited)
        extended = replace(
            parents, free=free, hand=options["stop"], taken=is_taken, value=value, spent=parents.spent + cycle
        )
        waiting = take(plans, np.setdiff1d(np.arange(len(plans.line)), options["line"]))
        return [extended, replace(waiting, free=waiting.free + IDLE_TIME, spent=waiting.spent + IDLE_TIME)]


@final
class Beam(Controller):
    """Controller that takes the first decision of the best plan.

    Args:
        name: name in tables.
        core: core of the lines.
        options: see `Lookahead`.
    """

    def __init__(self, name: str, core: LineCore, **options: Any) -> None:
        self.name, self._core, self._ahead = name, core, Lookahead(**options)

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """The first decision of the best plan of each line (N,)."""
        line_outlook = observe(self._core)
        plans = self._ahead.plans(line_outlook, line_outlook.choices["real"])
        best = self._ahead.best(plans, 1, plans.line)
        choice = np.zeros(len(line_outlook.robot), dtype=np.int64)
        choice[plans.line[best]] = plans.first[best]
        return choice


@final
class GuidedBeam(Controller):
    """Lookahead from the few choices that a scorer prefers; the plans' worth is added to the scores.

    Args:
        name: name in tables.
        core: core of the lines.
        guide: controller whose scores are used.
        few: choices for which plans are made.
        trust: weight of a plan's worth beside the scores.
        width: plans that are kept for each choice.
        horizon: horizon of plans [s]; shorter than that of `Beam`, since the scores contain some of the later
            value.
        options: see `Lookahead`.
    """

    def __init__(
        self,
        name: str,
        core: LineCore,
        guide: ScoreController,
        *,
        few: int = 4,
        trust: float = 5.0,
        width: int = 5,
        horizon: float = 3.0,
        **options: Any,
    ) -> None:
        self.name, self.trust, self._core, self._guide, self._few = name, trust, core, guide, few
        self._ahead = Lookahead(width=width, per_choice=True, horizon=horizon, **options)

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """The best of the preferred choices of each line (N,)."""
        features = observation.features
        scores: Floats = np.where(choice_mask(features), self._guide.scores(features), -np.inf)
        place = np.argsort(np.argsort(-scores, axis=1, kind="stable"), axis=1)
        among = (place < self._few) & choice_mask(features)
        plans = self._ahead.plans(observe(self._core), among)
        worth = np.full(scores.shape, -np.inf)
        np.maximum.at(worth, (plans.line, plans.first), self._ahead.worth(plans))
        return rules.best(np.where(among, scores + self.trust * np.where(among, worth, 0.0), -np.inf))
