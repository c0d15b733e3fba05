"""Shapes of an arm's links, which pictures show and which touch nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.engine import MjData, MjModel, MjsBody, MjSpec, mujoco
from pnt_gym.palette import PAINT, STEEL
from pnt_gym.robots.arm.rows import Link
from pnt_gym.robots.brush import MOVING_GROUP
from pnt_gym.rows import Rows

MODEL_GREY: Final = (0.5, 0.5, 0.5, 1.0)
"""The engine's colour of shapes without one."""


@final
@dataclass(frozen=True)
class Shape:
    """A primitive or a mesh of a link, for pictures, in the link's frame."""

    link: int
    """Index of the link; -1 for what stands still."""
    type: int
    """mjtGeom of the shape."""
    size: Floats
    place: Floats
    attitude: Floats
    """Quaternion (4,)."""
    colour: Floats
    mesh: tuple[Floats, Ints] | None
    """Vertices (K, 3) [m] and faces (F, 3) of a mesh."""


def shapes_of(
    model: MjModel, data: MjData, owner: Sequence[int], links: Rows[Link], placed: tuple[Floats, Floats]
) -> Iterator[Shape]:
    """Shapes of all bodies, with all joints at 0, each in the frame of the link that moves it."""
    base, frame = placed
    anchors = np.cumsum(links["offset"], axis=0)
    plane = int(mujoco.mjtGeom.mjGEOM_PLANE)
    for geom in range(int(model.ngeom)):
        kind, link = int(model.geom_type[geom]), owner[int(model.geom_bodyid[geom])]
        if kind == plane:
            continue
        place = base + frame @ data.geom_xpos[geom] - (anchors[link] if link >= 0 else 0.0)
        attitude = np.zeros(4)
        mujoco.mju_mat2Quat(attitude, (frame @ data.geom_xmat[geom].reshape(3, 3)).ravel())
        colour = model.geom_rgba[geom].copy()
        if np.allclose(colour, MODEL_GREY):
            colour = np.array(PAINT if link >= 0 else STEEL)
        mesh = _mesh(model, int(model.geom_dataid[geom])) if kind == int(mujoco.mjtGeom.mjGEOM_MESH) else None
        yield Shape(link, kind, model.geom_size[geom].copy(), place, attitude, colour, mesh)


def _mesh(model: MjModel, mesh: int) -> tuple[Floats, Ints]:
    """Vertices and faces of a mesh."""
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    vertices = model.mesh_vert[first : first + count].astype(np.float64)
    return vertices, model.mesh_face[face : face + faces].astype(np.int64)


def draw(spec: MjSpec, bodies: Sequence[MjsBody], base: MjsBody, shapes: Sequence[Shape]) -> None:
    """Add the shapes to the bodies of the links, or to the base."""
    for number, shape in enumerate(shapes):
        body = bodies[shape.link] if shape.link >= 0 else base
        more = {}
        if shape.mesh is not None:
            name = f"shape_{number}"
            vertices, faces = shape.mesh
            spec.add_mesh(name=name, uservert=vertices.ravel(), userface=faces.ravel().astype(np.int32))
            more = {"meshname": name}
        body.add_geom(
            type=mujoco.mjtGeom(shape.type), size=shape.size, pos=shape.place, quat=shape.attitude, rgba=shape.colour,
            contype=0, conaffinity=0, mass=0, group=MOVING_GROUP, **more,
        )  # fmt: skip
