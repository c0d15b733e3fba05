"""Objects in pictures and tries at places on them, without a robot: what a cup at a place would hold.

A try needs no throw: the vacuum gauge says whether the object is held, and statics whether the hold would survive a
throw. So tens of thousands of tries take seconds.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.base.grip import Hold
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.grasp.images import draw_images
from pnt_gym.cells.grasp.surfaces import (
    IMAGE,
    TRY,
    Surfaces,
    SurfaceTable,
    draw_surfaces,
    least_force,
    normal_draw,
    object_keys,
    seal_at,
    seal_holds,
    surface_table,
)
from pnt_gym.planning.motion.limits import T3KR_ACCELERATION

SEEN: Final = tuple(name for name in ConveyorConfig.load("waste").items if name != "cork")
"""Kinds on which learners try places; a 20 mm cup does not seal on a round cork of 24 mm."""
UNSEEN: Final = ConveyorConfig.load("unseen").items
LEVELS: Final = {"grasp": SEEN, "grasp_unseen": UNSEEN}
CAMERA: Final = 0.003
"""Error of the outline's middle in a picture, an axis [m]."""
PLACING: Final = 0.004
"""Error of the cup's place, an axis, and again along the belt [m]."""
PERCENT: Final = 45.0
"""Speed setting at which an object that is held should stay under its cup [%]."""
HELD: Final = 0.7
"""Worth of an object that is held, but has to be thrown more slowly than at `PERCENT`, over that of a fast one; assumed
from cycles of 1.0 s and 0.7 s."""


@final
class Tries(NamedTuple):
    """Results of N tries, one an object."""

    held: Bools
    kept: Bools
    """Whether the object is held, and would stay under the cup at `PERCENT`, accelerated in the worst direction."""
    force: Floats
    """Force of the vacuum (N,) [N]."""

    @property
    def worth(self) -> Floats:
        """Worth of the tries for a learner (N,): 1 if kept, `HELD` if held, else 0."""
        return np.where(self.held, np.where(self.kept, 1.0, HELD), 0.0)


@final
@dataclass(frozen=True)
class Scenes:
    """N objects, each in the middle of a picture, as the belt's camera sees the middle."""

    objects: Objects
    surfaces: Surfaces
    images: NDArray[np.uint8]
    """Pictures (N, 5, 48, 48)."""
    middle: Floats
    """True middle of the outline from the middle of the picture (N, 2) [m]."""
    error: Floats
    """True place of the cup from where it was sent (N, 2) [m]."""

    @classmethod
    def draw(cls, level: str, count: int, seed: int) -> Self:
        """Draw objects of the kinds of a level, one of `LEVELS`."""
        planner, table = _planner(level)
        objects = take(planner.draw([np.random.default_rng(seed)], np.arange(1), count), 0)
        rng = np.random.default_rng([seed, 1])
        middle = rng.normal(0.0, CAMERA, (count, 2))
        error = rng.normal(0.0, PLACING, (count, 2)) + rng.normal(0.0, PLACING, (count, 1)) * [1.0, 0.0]
        images = draw_images(table, take(objects, np.s_[:, None]), middle[:, None], object_keys(objects, IMAGE))
        return cls(objects, draw_surfaces(table, objects), images, middle, error)

    def parts(self, size: int) -> Iterator[Scenes]:
        """The scenes in parts of a size, to bound the memory."""
        for begin in range(0, len(self.images), size):
            yield take(self, slice(begin, begin + size))

    @property
    def radius(self) -> Floats:
        """Radii of the cups (N,) [m]."""
        return self.objects.cup_radius

    def try_places(self, places: Floats) -> Tries:
        """Try one place on each object, (N, 2) from the middle of the picture [m]."""
        true = places - self.middle + self.error
        force = seal_at(self.surfaces, self.objects, true[:, None]).force[:, 0]
        held = seal_holds(force, self.objects, normal_draw(object_keys(self.objects, TRY)))
        return Tries(held, held & (self.margins(force[:, None], true[:, None])[:, 0] >= 1.0), force)

    def expected_worth(self, places: Floats) -> Floats:
        """Expected worths (N, P) of tries with the cup at true places (N, P, 2) from the outlines' middles [m]."""
        from pnt_gym.cells.grasp.seal_kernel import TRY as SPREAD  # noqa: PLC0415 - numba takes a while

        force = seal_at(self.surfaces, self.objects, places).force
        least = least_force(self.objects)[:, None]
        held = importlib.import_module("scipy.special").ndtr(np.log(force / least) / SPREAD)
        return held * (HELD + (1.0 - HELD) * (self.margins(force, places) >= 1.0))

    def margins(self, force: Floats, places: Floats) -> Floats:
        """Holding force over load at `PERCENT`, for forces (N, P) [N] at places (N, P, 2) [m] as of `seal_at`."""
        objects, count = self.objects, force.shape[1]
        offset = np.hypot(*np.moveaxis(places - self.surfaces.com[:, None], -1, 0))
        columns = (objects.mass, objects.cup_friction, objects.com_depth, objects.cup_radius)
        mass, friction, depth, radius = (np.repeat(column, count) for column in columns)
        hold = Hold(force.reshape(-1), mass, friction, depth, offset.reshape(-1), radius)
        acceleration = np.full(force.size, T3KR_ACCELERATION * PERCENT / 100.0)
        return hold.least_margin(acceleration).reshape(force.shape)


def _planner(level: str) -> tuple[PickPlanner, SurfaceTable]:
    """What draws the objects of a level, and the surfaces of the level's items."""
    config = ConveyorConfig.load({"base": "waste", "items": list(LEVELS[level])})
    return PickPlanner(config), surface_table(config.item_list())
