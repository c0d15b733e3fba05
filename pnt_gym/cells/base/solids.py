"""Shapes of pictures, made by numbers: closed surfaces inside a cube from -1 to 1, which pictures stretch to a size."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Self, final

import numpy as np

from pnt_gym.arrays import Floats, Ints

AROUND: Final = 32
"""Vertices around the axis of a turned shape."""
SQUARE: Final = 9.0
"""Exponent of the rounded square of turned shapes with four sides; 2 is a circle."""
Profile = Sequence[tuple[float, float]]


@final
@dataclass(frozen=True)
class TexturedSolid:
    """Triangles with a normal and a place in a texture at each vertex.

    Attributes:
        vertices: places (V, 3), from -1 to 1.
        normals: directions (V, 3) of length 1.
        texture: places in the texture (V, 2), from 0 to 1.
        faces: indices of the corners of each triangle (F, 3).
    """

    vertices: Floats
    normals: Floats
    texture: Floats
    faces: Ints

    @classmethod
    def of(cls, vertices: Floats, texture: Floats) -> Self:
        """Surface of a grid of places (R, C, 3) with places in a texture (R, C, 2); C runs around, R along."""
        rows, columns = vertices.shape[:2]
        corner: Ints = np.arange(rows * columns, dtype=np.int64).reshape(rows, columns)[:-1, :-1].reshape(-1, 1)
        one, other = np.array([0, 1, columns + 1]), np.array([0, columns + 1, columns])
        faces: Ints = np.concatenate([corner + one, corner + other])
        corners = vertices.reshape(-1, 3)
        normal = np.zeros_like(corners)
        a, b, c = (corners[faces[:, k]] for k in range(3))
        for k in range(3):
            np.add.at(normal, faces[:, k], np.cross(b - a, c - a))
        grid = normal.reshape(vertices.shape)
        grid[:, 0] = grid[:, -1] = grid[:, 0] + grid[:, -1]  # the seam has one normal
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        return cls(corners, normal, texture.reshape(-1, 2), faces)


def turned(profile: Profile, corner: float = 2.0, *, planar: bool = False, bumps: float = 0.0) -> TexturedSolid:
    """A profile turned about the z axis.

    Args:
        profile: height and radius of the profile's points, from the bottom to the top; a point that stands twice is a
            sharp edge.
        corner: exponent of the cross section; 2 is a circle, `SQUARE` a rounded square.
        planar: whether the texture is laid on from above; else it is wound around, from the bottom up.
        bumps: height of dents all over the surface.
    """
    points = np.array(profile, dtype=np.float64)
    angle = np.linspace(0.0, 2.0 * np.pi, AROUND + 1)
    across = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across /= (np.abs(across) ** corner).sum(axis=1, keepdims=True) ** (1.0 / corner)
    grid = np.concatenate(
        [points[:, 1, None, None] * across, np.broadcast_to(points[:, 0, None, None], (len(points), AROUND + 1, 1))],
        axis=2,
    )
    if bumps > 0.0:
        grid = grid * (1.0 - bumps * _dents(grid))[..., None]
    if planar:
        texture = (grid[..., :2] + 1.0) / 2.0
    else:
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        texture = np.stack(np.broadcast_arrays(angle / (2.0 * np.pi), (along / along[-1])[:, None]), axis=2)
    return TexturedSolid.of(grid, texture)


def _dents(grid: Floats) -> Floats:
    """Depth of dents at places (R, C, 3), 0 to 1 (R, C): folds along random directions, without a seam."""
    rng = np.random.default_rng(5)
    waves = [np.abs(np.sin(grid @ rng.normal(0.0, 3.2, 3) + rng.uniform(0.0, 6.0))) for _ in range(7)]
    return np.asarray(np.mean(waves, axis=0) + 0.5 * np.min(waves, axis=0))


def _edges(*points: tuple[float, float]) -> Profile:
    """A profile whose points are sharp edges."""
    return [point for point in points for _ in range(2)]


def _dense(profile: Profile, count: int) -> Profile:
    """A profile with more points between its own, for shapes with dents."""
    points = np.array(profile, dtype=np.float64)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at: Floats = np.linspace(0.0, float(along[-1]), count)
    heights, radii = (np.asarray(np.interp(at, along, points[:, column]), dtype=np.float64) for column in (0, 1))
    return [(float(height), float(radius)) for height, radius in zip(heights, radii, strict=True)]


_BOX: Final = (
    (-1.0, 0.0),
    (-1.0, 0.90),
    (-0.97, 0.97),
    (-0.90, 1.0),
    (0.90, 1.0),
    (0.97, 0.97),
    (1.0, 0.90),
    (1.0, 0.0),
)
_BALL: Final = tuple((float(-np.cos(t)), float(np.sin(t))) for t in np.linspace(0.0, np.pi, 25))
_CAN: Final = (
    *_edges((-0.95, 0.0), (-0.95, 0.78)), (-1.0, 0.82), (-0.98, 0.86), (-0.84, 1.0), (0.84, 1.0), (0.97, 0.86),
    *_edges((1.0, 0.84), (1.0, 0.80), (0.95, 0.77), (0.95, 0.0)),
)  # fmt: skip
_BOTTLE: Final = (
    (-1.0, 0.0), (-1.0, 0.70), (-0.98, 0.92), (-0.92, 1.0), (-0.30, 1.0), (-0.26, 0.96), (-0.20, 0.96), (-0.16, 1.0),
    (0.30, 1.0), (0.45, 0.92), (0.62, 0.66), (0.74, 0.42), *_edges((0.80, 0.38), (0.80, 0.46), (0.98, 0.46)),
    (1.0, 0.42), (1.0, 0.0),
)  # fmt: skip
_CUP: Final = (
    (-1.0, 0.0), (-1.0, 0.70), (-0.96, 0.76), (0.84, 0.94), *_edges((0.86, 1.0), (1.0, 1.0), (1.0, 0.92)), (0.98, 0.0),
)  # fmt: skip
_TIN: Final = (
    *_edges((-0.94, 0.0), (-0.94, 0.92), (-1.0, 0.95), (-1.0, 1.0), (-0.95, 1.0), (-0.93, 0.96), (0.93, 0.96)),
    *_edges((0.95, 1.0), (1.0, 1.0), (1.0, 0.95), (0.94, 0.92), (0.94, 0.0)),
)  # fmt: skip
_TRAY: Final = (
    (-1.0, 0.0), *_edges((-1.0, 0.74)), (0.82, 0.92), *_edges((0.86, 1.0), (1.0, 1.0), (1.0, 0.90)),
    *_edges((-0.80, 0.68)), (-0.80, 0.0),
)  # fmt: skip
_LID: Final = (
    *_edges((-1.0, 0.0), (-1.0, 1.0)), (0.6, 1.0), (1.0, 0.94), *_edges((1.0, 0.84), (0.55, 0.80)), (0.55, 0.0),
)  # fmt: skip
_BELLOWS: Final = (
    (-1.0, 0.80), (-0.96, 1.0), (-0.80, 0.84), (-0.62, 0.62), (-0.50, 0.62), (-0.36, 0.90), (-0.28, 0.90),
    (-0.14, 0.60), (-0.02, 0.60), (0.12, 0.84), (0.20, 0.84), *_edges((0.34, 0.56), (0.34, 0.70), (1.0, 0.70)),
    (1.0, 0.0),
)  # fmt: skip

_ROD: Final = (
    (-1.0, 0.0), *_edges((-1.0, 0.93)), (-0.94, 1.0), (0.94, 1.0), *_edges((1.0, 0.93)), (1.0, 0.0),
)  # fmt: skip

SOLIDS: Final[Mapping[str, Callable[[], TexturedSolid]]] = MappingProxyType({
    "block": lambda: turned(_BOX, SQUARE, planar=True),
    "rod": lambda: turned(_ROD),
    "ball": lambda: turned(_BALL),
    "crumpled_ball": lambda: turned(_dense(_BALL, 40), bumps=0.30),
    "crumpled_block": lambda: turned(_dense(_BOX, 40), SQUARE, planar=True, bumps=0.20),
    "can": lambda: turned(_CAN),
    "bottle": lambda: turned(_BOTTLE),
    "cup": lambda: turned(_CUP),
    "tin": lambda: turned(_TIN),
    "tray": lambda: turned(_TRAY, SQUARE, planar=True),
    "lid": lambda: turned(_LID, planar=True),
    "bellows": lambda: turned(_BELLOWS),
})  # fmt: skip
"""The shapes by name."""
