"""Drawing of robots by massless geoms that touch nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.engine import GeomType, MjsBody, mujoco
from pnt_gym.palette import Colour

FIXED_GROUP: Final = 1
MOVING_GROUP: Final = 2


@final
@dataclass(frozen=True)
class Brush:
    """Adds geoms to one body; lengths in m, in the body's frame."""

    body: MjsBody
    group: int = MOVING_GROUP

    def box(self, centre: ArrayLike, half_size: ArrayLike, colour: Colour) -> None:
        """Add a box along the body's axes."""
        self._add(mujoco.mjtGeom.mjGEOM_BOX, colour, pos=centre, size=half_size)

    def ball(self, centre: ArrayLike, radius: float, colour: Colour) -> None:
        """Add a sphere."""
        self._add(mujoco.mjtGeom.mjGEOM_SPHERE, colour, pos=centre, size=[radius, 0, 0])

    def capsule(self, start: ArrayLike, end: ArrayLike, radius: float, colour: Colour) -> None:
        """Add a rod with round ends."""
        self._segment(mujoco.mjtGeom.mjGEOM_CAPSULE, start, end, radius, colour)

    def cylinder(self, start: ArrayLike, end: ArrayLike, radius: float, colour: Colour) -> None:
        """Add a rod with flat ends."""
        self._segment(mujoco.mjtGeom.mjGEOM_CYLINDER, start, end, radius, colour)

    def _segment(self, shape: GeomType, start: ArrayLike, end: ArrayLike, radius: float, colour: Colour) -> None:
        ends = np.stack([np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)])
        self._add(shape, colour, fromto=ends.reshape(6), size=[radius, 0, 0])

    def _add(self, shape: GeomType, colour: Colour, **place: ArrayLike) -> None:
        ghost = {"contype": 0, "conaffinity": 0, "mass": 0}
        self.body.add_geom(type=shape, rgba=colour, group=self.group, **ghost, **place)
