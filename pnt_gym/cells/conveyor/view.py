"""Pictures of the conveyor cell."""

from __future__ import annotations

from typing import Any

import numpy as np

from pnt_gym.arrays import Floats, take
from pnt_gym.cells.base.bodies import geom_placement, yaw_attitude
from pnt_gym.cells.base.canvas import Marker
from pnt_gym.cells.base.sorting import Belt
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.engine import mujoco
from pnt_gym.palette import ITEMS


def camera() -> Any:
    """MuJoCo's camera of the standard view: belt, robot and bins from the front right, across the bins."""
    view = mujoco.MjvCamera()
    view.lookat[:] = [-0.04, 0.10, -0.56]
    view.distance, view.azimuth, view.elevation = 2.7, 232.0, -24.0
    return view


def objects_on_belt(upstream: tuple[Objects, Floats] | None, belt: Belt, time: float) -> list[Marker]:
    """Markers of objects with centres (K, 3) [m], moved by the belt for a time [s]; none where `upstream` is None."""
    if upstream is None:
        return []
    objects, centre = upstream
    position = centre + np.array([belt.speed * time, 0.0, 0.0])
    on_belt = np.flatnonzero((position[:, 0] >= belt.x[0]) & (position[:, 0] <= belt.x[1]))
    return object_markers(take(objects, on_belt), position[on_belt], yaw_attitude(objects.yaw[on_belt]))


def object_markers(objects: Objects, centre: Floats, attitude: Floats) -> list[Marker]:
    """Markers of objects (K,), for the centres of their extents (K, 3) [m] and their attitudes (K, 4)."""
    place = geom_placement(objects.shape, objects.extents)
    rgba = ITEMS.take(objects.kind, axis=0, mode="wrap")
    attitude_drawn, frame = np.zeros(4), np.zeros(9)
    markers: list[Marker] = []
    for k in range(len(centre)):
        mujoco.mju_mulQuat(attitude_drawn, attitude[k], place.quat[k])
        mujoco.mju_quat2Mat(frame, attitude_drawn)
        markers.append(Marker(int(place.type[k]), place.size[k], centre[k], frame.copy(), rgba[k]))
    return markers
