"""A line as solids at moments of a shift: boxes, balls and cylinders, from the scene that pictures of lines have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from typing import Final, Self, final

import numpy as np
from scipy.spatial.transform import Rotation

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.canvas import Marker
from pnt_gym.cells.base.view import Scene
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.view import LineView
from pnt_gym.engine import MjModel, mujoco

from ..dispatchers.registry import ENV
from ..pictures.stage import Stage

RATE: Final = 20
"""Frames of a film per second."""
CONTROLLER: Final = "price"
"""The controller that a film shows, that of the figures."""
FIXED: Final = "fixed"
"""Layer of solids that stand still."""
MOVING: Final = "moving"
"""Layer of the robots' moving parts."""
OBJECTS: Final = "objects"
"""Layer of objects, marks of the belt and dots behind flying objects."""
_TYPES: Final = {
    int(mujoco.mjtGeom.mjGEOM_BOX.value): "box",
    int(mujoco.mjtGeom.mjGEOM_SPHERE.value): "ball",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID.value): "ball",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER.value): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE.value): "cylinder",
}
"""Shape of each of MuJoCo's types of geoms; a rounded rod is drawn as a cylinder."""


@final
@dataclass(frozen=True)
class Solids:
    """N solids of one shape."""

    position: Floats
    """Middles (N, 3) [m]."""
    wxyz: Floats
    """Attitudes as quaternions (N, 4)."""
    half: Floats
    """Half extents along the solids' own axes (N, 3) [m]."""
    rgba: Floats
    """Colours and opacities (N, 4)."""

    @classmethod
    def of(cls, types: Ints, size: Floats, position: Floats, frame: Floats, rgba: Floats) -> dict[str, Self]:
        """Solids by shape, from columns of MuJoCo's geoms; geoms of other types are left out."""
        groups: dict[str, Self] = {}
        shapes = np.array([_TYPES.get(int(kind), "") for kind in types])
        for shape in ("box", "ball", "cylinder"):
            rows = shapes == shape
            half = size[rows].copy()
            if shape == "cylinder":
                half = half[:, [0, 0, 1]]
            elif shape == "ball":  # a sphere has one radius
                half = np.where((half[:, 1:2] > 0.0) & (half[:, 2:3] > 0.0), half, half[:, :1])
            wxyz = (
                Rotation.from_matrix(frame[rows].reshape(-1, 3, 3)).as_quat(scalar_first=True) if rows.any() else None
            )
            groups[shape] = cls(position[rows], np.zeros((0, 4)) if wxyz is None else wxyz, half, rgba[rows])
        return groups


Frame3D = Mapping[str, Mapping[str, Solids]]
"""Solids of a moment by layer and shape."""


def _geoms(model: MjModel) -> tuple[Bools, Bools]:
    """Which geoms are drawn and stand still, and which are drawn and move."""
    is_drawn = (model.geom_rgba[:, 3] > 0.0) & (model.geom_group < 3)
    stands = model.body_weldid[model.geom_bodyid] == 0
    return is_drawn & stands, is_drawn & ~stands


def moving_solids(scene: Scene) -> Frame3D:
    """Solids of a scene that move."""
    model, data, markers = scene
    return {MOVING: _model_solids(model, data, _geoms(model)[1]), OBJECTS: _marker_solids(markers)}


def _model_solids(model: MjModel, data: object, rows: Bools) -> Mapping[str, Solids]:
    xpos, xmat = np.asarray(data.geom_xpos), np.asarray(data.geom_xmat)  # pyright: ignore[reportAttributeAccessIssue]
    columns = model.geom_type, model.geom_size, xpos, xmat, model.geom_rgba
    return Solids.of(*(np.asarray(column)[rows].astype(np.float64) for column in columns))  # pyright: ignore[reportArgumentType]


def _marker_solids(markers: Sequence[Marker]) -> Mapping[str, Solids]:
    if not markers:
        return Solids.of(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 9)), np.zeros((0, 4)))
    columns = ([getattr(marker, name) for marker in markers] for name in ("type", "size", "position", "frame", "rgba"))
    return Solids.of(*(np.array(column) for column in columns))


@final
@dataclass(frozen=True)
class Still:
    """A line at the begin of a shift, and from where its robots reach their bins."""

    fixed: Mapping[str, Solids]
    moment: Frame3D
    origin: float
    """Where the scene's x counts from, along the belt [m]."""
    cell: LineCell

    @classmethod
    def of(cls, line: LineConfig) -> Self:
        """The line at the first decision of a shift."""
        cell = LineCell(LineConfig.load(line, throws="flight", chances=None), 1)
        view = LineView(cell)
        cell.reset(np.arange(1), [np.random.default_rng(0)])
        scene = view.scene(float(cell.state.clock[0]))
        model, data, _ = scene
        fixed = _model_solids(model, data, _geoms(model)[0])
        return cls(fixed, moving_solids(scene), line.robots[0].x, cell)


def play(line: LineConfig, seconds: float) -> Iterator[Frame3D]:
    """Frames of the begin of a shift of a line, with simulated flights."""
    flights = LineConfig.load(line, throws="flight", chances=None)
    with closing(Stage(CONTROLLER, ENV, flights, 0)) as stage:
        yield from islice(frames(stage), round(seconds * RATE))


def frames(stage: Stage) -> Iterator[Frame3D]:
    """Frames of the shifts that a controller works on a stage with one line."""
    for _ in stage.steps:
        for scene in stage.view.scenes(RATE):
            yield moving_solids(scene)
