"""Pallets that catch the thrown parts (Miyashita et al., section 6.3).

A pallet stands still in the plane of the throw. Its walls are boxes in the frame of its goal, the pose of a part that
lies in the pallet: u along the part, v across the part. All parts are thrown upside down, so gravity holds them to the
+v side. The paper prints neither the shape nor the place of its pallets, except the goal (0, 0.4 m, 150 deg, 0 m/s).

The sorting pockets stand around that goal so that no wall is in the sweep of the arm, the flight to the second pocket
passes below the first, and the flight to the third passes below the second. A steeper throw comes from too high and
hits the previous pallet. Each pocket is open towards the arriving part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.one_joint.parts import AITCH, BAR, BLOCK, TEE, Boxes, Part, add_boxes, turn_quaternion
from pnt_gym.engine import MjSpec, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.palette import DARK_WOOD, STEEL, WOOD, Colour

PALLET_DEPTH: Final = 0.050
"""Depth across the plane: a centimetre more than the parts on either side [m]."""
WALL: Final = 0.006
"""Thickness of a pocket's boards [m]."""
LIP: Final = 0.0025
"""Height of the board at the entry; the board keeps the part from sliding out [m]."""
LIP_PLAY, BACK_PLAY = 0.006, 0.004
"""Room before and behind a part that lies exactly at the goal, 10 mm in all [m]."""
BACK: Final = 0.016
"""Height of the board that stops the part, about half the block; a throw 2 cm too high passes over the board [m]."""
SWEEP: Final = 0.320
"""Distance from the pivot that the arm and the parts on it never reach: the outer top corner of an H whose edge ends
with the plate is at 0.313 m, and a part may lie some millimetres too far out [m]."""

_BACKBOARD: Final = 0.29
"""Plane that the brackets reach, behind the arm and every flight [m]."""


@final
@dataclass(frozen=True)
class Pallet:
    """Walls around a goal.

    Raises:
        ConfigError: a number is not finite, a box has no size, or there is no box.
    """

    name: str
    goal: tuple[float, float, float, float]
    """State x, y [m], phi [rad, not wrapped], dy [m/s] of the arriving part; at rest the part lies at x, y, phi."""
    boxes: Boxes
    """Walls in the goal's frame: centre u, v, half sizes along the box's own axes [m], and the angle of the box
    [rad]."""
    depth: float = PALLET_DEPTH
    """Depth across the plane [m]."""
    rgba: Colour = WOOD

    def __post_init__(self) -> None:
        boxes = np.array(self.boxes, dtype=np.float64)
        if boxes.ndim != 2 or not np.isfinite(boxes).all() or not np.isfinite(self.goal).all():
            raise ConfigError(f"pallet {self.name!r} needs a finite goal and at least one box of 5 finite numbers.")
        if not (boxes[:, 2:4] > 0.0).all() or not self.depth > 0.0:
            raise ConfigError(f"pallet {self.name!r} has a box without size; half sizes and depth must be positive.")

    @property
    def pose(self) -> Floats:
        """Pose x, y [m] and phi [rad] of a part that lies in the pallet (3,)."""
        return np.array(self.goal[:3])

    @property
    def state(self) -> Floats:
        """x, y [m], phi [rad] and dy [m/s] of the goal (4,)."""
        return np.array(self.goal)

    @cached_property
    def walls(self) -> Floats:
        """The boxes in the world (K, 5): centre x, y, half sizes [m], angle [rad]."""
        return place_boxes(np.array(self.boxes), self.pose)


def pocket(part: Part) -> Boxes:
    """Walls of a pocket for a part that arrives upside down and moving along its u axis: bottom, back, lip.

    Args:
        part: a part whose underside and top are flat.
    """
    top, length, half = max(v for _, v in part.outline), part.half_length, WALL / 2
    low, high = -length - LIP_PLAY - WALL, length + BACK_PLAY + WALL
    return (
        ((low + high) / 2, top + half, (high - low) / 2, half, 0.0),
        (high - half, top - BACK / 2, half, BACK / 2, 0.0),
        (low + half, top - LIP / 2, half, LIP / 2, 0.0),
    )


def stack_pose(pose: Floats) -> Floats:
    """Poses (..., 3) of a T whose stem is in the upper slot of an H at poses (..., 3), both upside down (Fig. 16b)."""
    rise = AITCH.half_height + BAR - TEE.half_height
    x, y, phi = (pose[..., k] for k in range(3))
    return np.stack([x + rise * np.sin(phi), y - rise * np.cos(phi), phi], axis=-1)


def _goal(x: float, y: float, phi_deg: float, dy: float) -> tuple[float, float, float, float]:
    return x, y, float(np.deg2rad(phi_deg)), dy


SORTING: Final = (
    Pallet("pallet_1", _goal(0.0, 0.40, 150.0, 0.0), pocket(BLOCK)),
    Pallet("pallet_2", _goal(-0.25, 0.30, 180.0, -0.80), pocket(BLOCK)),
    Pallet("pallet_3", _goal(-0.40, 0.10, 195.0, -1.70), pocket(BLOCK)),
)
"""Three pockets for the block. The first goal is the paper's; the others are ours, see the module's text."""
_UNDER: Final = AITCH.half_height + (BAR - TEE.half_height)
STAND: Final = Pallet(
    "stand",
    _goal(0.42, -0.06, 189.0, -2.20),
    tuple((-u, _UNDER - v, a, b, turn) for u, v, a, b, turn in TEE.boxes),
    depth=AITCH.depth,
    rgba=DARK_WOOD,
)
"""Pallet of the assembly, and the goal of the H.

The boxes are a T fixed upside down under the H: its stem in the H's slot, the H's legs on its bar (Fig. 16a).

The part must not turn much while the stem enters the slot, so the goal is low, where the fall is fast: 15 mm take 7 ms
and 3 deg. The goal lies to the right of the arm's sweep, where the falling part is 15 cm away from the rising one. The
slots stand 9 deg off the vertical, the direction in which a throw arrives there at -2.20 m/s.
"""
TEE_GOAL: Final = (*(float(value) for value in stack_pose(STAND.pose)), -2.12)
"""Goal of the T when the H lies exactly in its place."""
ASSEMBLY: Final = ((AITCH, STAND.goal), (TEE, TEE_GOAL))
"""The two throws of an assembly in their order: part and goal."""


def add_pallets(spec: MjSpec, pallets: Sequence[Pallet]) -> None:
    """Add a static body with the pallet's name to a mujoco.MjSpec for each pallet, and a bracket for pictures."""
    for pallet in pallets:
        x, y, phi = pallet.goal[:3]
        body = spec.worldbody.add_body(name=pallet.name, pos=[x, 0, y], quat=turn_quaternion(phi))
        add_boxes(body, pallet.boxes, pallet.depth, pallet.rgba)
        u, v, _, half_v, _ = pallet.boxes[0]
        body.add_geom(
            name=f"{pallet.name}_bracket",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.008, (_BACKBOARD - pallet.depth / 2) / 2, half_v * 0.8],
            pos=[u, (_BACKBOARD + pallet.depth / 2) / 2, v],
            rgba=STEEL,
            mass=0,
            contype=0,
            conaffinity=0,
            group=1,
        )


def place_boxes(boxes: Floats, pose: Floats) -> Floats:
    """Boxes (K, 5) of a frame that stands at poses (..., 3), in the world (..., K, 5)."""
    x, y, phi = (pose[..., k, None] for k in range(3))
    cos, sin = np.cos(phi), np.sin(phi)
    u, v, half_u, half_v, angle = np.moveaxis(boxes, -1, 0)
    columns = x + cos * u - sin * v, y + sin * u + cos * v, half_u, half_v, phi + angle
    return np.stack(np.broadcast_arrays(*columns), axis=-1)
