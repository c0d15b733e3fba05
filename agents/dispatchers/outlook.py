"""Knowledge of a planner about lines at a decision, from camera, encoder and the robots' own planner.

True properties of objects, results of throws, and objects upstream of the camera are not included.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.line.choosing import Chooser, Sight
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.rows import Choice, Rider, Seen
from pnt_gym.rows import Rows1, Rows2


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


def observe_outlook(core: LineCore) -> Outlook:
    """Outlook of lines at their coming decisions."""
    cell = core.cell
    sight = cell.chooser.sight(cell.state, cell.stream, np.arange(core.count))
    riders = take(cell.stream.riders, (sight.line[:, None], sight.seen["index"]))
    return Outlook(
        sight=sight,
        riders=report_riders(riders),
        choices=cell.state.choices,
        robot=cell.state.robot,
        speed=core.config.cell.belt.speed,
        chooser=cell.chooser,
    )


def report_riders(riders: Rows2[Rider]) -> Rows2[Rider]:
    """Objects with measured values instead of true ones; NaN, or -1, where no sensor measures."""
    reported = riders.copy()
    reported["height"], reported["kind"] = riders["measured_height"], -1
    reported["seal"] = reported["luck"] = np.nan
    return reported
