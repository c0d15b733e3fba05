"""Knowledge of a planner about lines at a decision, from camera, encoder and the robots' own planner.

True properties of objects, results of throws, and objects upstream of the camera are not included.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.line.choosing import Chooser
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.options import Options, Sight
from pnt_gym.cells.line.state import Choices

TRUTH: Final = (
    "mass", "drag", "com_depth", "seal", "delay", "jitter", "friction", "cup_friction", "rolling_friction",
    "pick_chance", "pick_draw",
)  # fmt: skip
"""Fields of an object that no sensor measures."""


@final
@dataclass(frozen=True)
class Outlook:
    """N lines with R robots and at most W objects in sight, at a decision; times are from now on."""

    sight: Sight
    """Positions and classified items of the objects in sight."""
    objects: Objects
    """Objects in sight, as sensors report them (N, W)."""
    worth: Floats
    """Value of each object in a bin that takes the object (N, W)."""
    choices: Choices
    """Choices of the deciding robots."""
    robot: Ints
    """Index of the deciding robot (N,)."""
    speed: float
    """Speed of the belt [m/s]."""
    chooser: Chooser
    """Finds options by the robots' planner and the table of chances."""

    def options(self, line: Ints, x: Floats, robot: Ints, hand: Floats) -> tuple[Options, Floats, Bools]:
        """Options at later decisions.

        Args:
            line: indices of the lines (P,).
            x: positions of the objects in sight at that time (P, W) [m]; `UNAVAILABLE_X` where the object may not
                be taken.
            robot: index of the deciding robot at that time (P,).
            hand: position of the robot's hand (P, 3) [m].

        Returns:
            C options, the expected value of each (C,), and whether a robot downstream can take the object too (C,).
        """
        places = np.broadcast_to(np.arange(x.shape[1]), x.shape)
        sight = Sight(line, places, x, self.sight.kind[line])
        options = self.chooser.options(self.objects, sight, robot, hand)
        at = line[options.row], options.place
        inherited = np.asarray(self.chooser.heirs(robot[options.row], self.sight.kind[at]).any(axis=1))
        return options, self.worth[at] * self.chooser.chance(sight, options), inherited


def observe_outlook(core: LineCore) -> Outlook:
    """Outlook of lines at their coming decisions."""
    cell = core.cell
    state, stream = cell.state, cell.stream
    sight = cell.chooser.sight(state, stream, np.arange(core.count))
    objects = sight.line[:, None], sight.object_index
    return Outlook(
        sight=sight,
        objects=report_objects(take(stream.objects, objects)),
        worth=stream.worth[objects],
        choices=state.choices,
        robot=state.robot,
        speed=core.config.cell.belt.speed,
        chooser=cell.chooser,
    )


def report_objects(objects: Objects) -> Objects:
    """Objects with measured values instead of true ones; NaN, or -1, where no sensor measures.

    The error of the belt's speed stays, because the camera sees its effect on the grasp.
    """
    measured = objects.measured
    missing = np.full(objects.mass.shape, np.nan)
    return replace(
        objects,
        **dict.fromkeys(TRUTH, missing),
        kind=np.full(objects.kind.shape, -1),
        size=measured.size,
        yaw=measured.yaw,
        grasp=objects.grasp + measured.grasp_noise,
        solref=np.full(objects.solref.shape, np.nan),
        spin=np.full(objects.spin.shape, np.nan),
        measured=replace(measured, grasp_noise=np.zeros_like(measured.grasp_noise)),
        draws=replace(objects.draws, fill=np.zeros_like(objects.draws.fill)),
    )
