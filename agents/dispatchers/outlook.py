"""What a planner is told of lines at a decision: what camera, encoder and the robots' own planner tell.

What objects truly are, what becomes of their throws, and what lies upstream of the camera is not among it.
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
"""Numbers of an object that no sensor reports as they are."""


@final
@dataclass(frozen=True)
class Outlook:
    """N lines with R robots and at most W objects in sight, at a decision; times are from now on."""

    sight: Sight
    """Where objects are, and as what they are seen."""
    objects: Objects
    """Those in sight, as sensors report them (N, W)."""
    worth: Floats
    """What each is worth in a bin that takes it (N, W)."""
    choices: Choices
    """What the robots whose turn it is can do."""
    robot: Ints
    """Whose turn it is (N,)."""
    busy: Floats
    """Until each robot expects to be free (N, R) [s]."""
    hand: Floats
    """Where hands stand then, from the bases (N, R, 3) [m]."""
    speed: float
    """Of the belt [m/s]."""
    chooser: Chooser
    """Knows the robots, and the table of chances."""

    def options(self, line: Ints, x: Floats, robot: Ints, hand: Floats) -> tuple[Options, Floats, Bools]:
        """All that could be done later.

        Args:
            line: lines (P,).
            x: where the objects in sight are then (P, W) [m]; `AWAY` where nobody may take one.
            robot: whose turn it is then (P,).
            hand: where its hand stands (P, 3) [m].

        Returns:
            C options, the value that each is expected to bring (C,), and whether a robot downstream can take the object
            too (C,).
        """
        places = np.broadcast_to(np.arange(x.shape[1]), x.shape)
        sight = Sight(line, places, x, self.sight.seen[line])
        options = self.chooser.options(self.objects, sight, robot, hand)
        at = line[options.row], options.place
        inherited = np.asarray(self.chooser.heirs(robot[options.row], self.sight.seen[at]).any(axis=1))
        return options, self.worth[at] * self.chooser.chance(sight, options), inherited


def outlook(core: LineCore) -> Outlook:
    """The outlook of lines at their coming decisions."""
    cell = core.cell
    state, stream = cell.state, cell.stream
    sight = cell.chooser.sight(state, stream, np.arange(core.count))
    at = sight.line[:, None], sight.which
    return Outlook(
        sight=sight,
        objects=reported(take(stream.objects, at)),
        worth=stream.worth[at],
        choices=state.choices,
        robot=state.robot,
        busy=np.maximum(state.expected - state.clock[:, None], 0.0),
        hand=state.hand,
        speed=core.config.cell.belt.speed,
        chooser=cell.chooser,
    )


def reported(objects: Objects) -> Objects:
    """Objects with what sensors report in the place of what is true; NaN, or -1, where no sensor reports anything.

    The error of the belt's speed stays: the camera sees what it does to the grasp.
    """
    measured = objects.measured
    nothing = np.full(objects.mass.shape, np.nan)
    return replace(
        objects,
        **dict.fromkeys(TRUTH, nothing),
        kind=np.full(objects.kind.shape, -1),
        size=measured.size,
        yaw=measured.yaw,
        grasp=objects.grasp + measured.grasp_noise,
        solref=np.full(objects.solref.shape, np.nan),
        spin=np.full(objects.spin.shape, np.nan),
        measured=replace(measured, grasp_noise=np.zeros_like(measured.grasp_noise)),
        draws=replace(objects.draws, fill=np.zeros_like(objects.draws.fill)),
    )
