"""Objects in pictures and tries at places on them, without a robot: what a cup at a place would hold.

A try needs no throw: the gauge says whether the object is held, and gauge and scales say how fast the grip lets the
object be thrown. These are the labels from which rules and networks learn, and tens of thousands of tries take seconds.
To judge places, statics with the hidden mass, centre of mass and place of the cup say whether the hold would survive.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final, NamedTuple, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.conveyor.context import Context, belt_shift
from pnt_gym.cells.conveyor.cup.hold import Hold
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.grasp.config import GraspConfig, Surface
from pnt_gym.cells.grasp.drawn import draw_kind
from pnt_gym.cells.grasp.images import PictureMaker
from pnt_gym.cells.grasp.rows import Surfaces
from pnt_gym.cells.grasp.surfaces import (
    TRY,
    draw_surfaces,
    later_keys,
    least_force,
    normal_draw,
    object_keys,
    outline_errors,
    seal_at,
    seal_holds,
    surface_table,
)
from pnt_gym.planning.motion.limits import T3KR_ACCELERATION

from .gauge import allowed_acceleration

PERCENT: Final = 45.0
"""Speed setting at which an object that is held should stay under its cup [%]."""
TOGETHER: Final = 20_000
"""Tries that are made at once, to bound the memory."""
HELD: Final = 0.7
"""Worth of an object that is held, but has to be thrown more slowly than at `PERCENT`, over that of a fast one; assumed
from cycles of 1.0 s and 0.7 s."""


@final
class Tries(NamedTuple):
    """Results of N tries, one an object."""

    held: Bools
    kept: Bools
    """Whether the object is held, and would stay under the cup at `PERCENT`, accelerated in the worst direction."""
    vacuum: Floats
    """Force of the vacuum by the gauge (N,) [N]."""
    allowed: Bools
    """Whether gauge and scales allow a throw at `PERCENT`, as the pace by the gauge does."""

    @property
    def worth(self) -> Floats:
        """Worth of the tries as sensors say it (N,): 1 if held and allowed at `PERCENT`, `HELD` if held, else 0."""
        return np.where(self.held, np.where(self.allowed, 1.0, HELD), 0.0)


@final
@dataclass(frozen=True)
class Scenes:
    """N objects, each in the middle of a picture, as the belt's camera sees the middle."""

    config: GraspConfig
    objects: Objects
    surfaces: Surfaces
    middle: Floats
    """True middle of the outline from the middle of the picture (N, 2) [m]."""
    error: Floats
    """True place of the cup from where it was sent (N, 2) [m]."""

    @classmethod
    def draw(cls, level: str | GraspConfig, count: int, seed: int) -> Self:
        """Draw objects of a level with surfaces."""
        config = level if isinstance(level, GraspConfig) else GraspConfig.load(level)
        random = np.random.default_rng(seed)
        objects, pick = PickPlanner(config).draw_picks([random], np.zeros(count, dtype=np.int64))
        error = -objects.grasp
        error[:, 0] -= belt_shift(objects, pick, config.belt)
        return cls.of(config, objects, error)

    @classmethod
    def of_picks(cls, config: GraspConfig, picks: Context) -> Self:
        """The objects of picks."""
        return cls.of(config, picks.objects, -picks.grasp)

    @classmethod
    def of(cls, config: GraspConfig, objects: Objects, error: Floats) -> Self:
        """Objects whose cups miss their places by errors (N, 2) [m]."""
        surfaces = draw_surfaces(surface_table(config.item_list()), objects)
        return cls(config, objects, surfaces, outline_errors(objects, config), error)

    @cached_property
    def images(self) -> NDArray[np.uint8]:
        """Pictures of the objects (N, 5, 48, 48)."""
        maker, count = PictureMaker(self.config, surface_table(self.config.item_list())), len(self.error)
        return maker.draw(take(self.objects, np.arange(count)[:, None]), np.zeros((count, 1, 2)))

    @property
    def surface(self) -> Surface:
        """Rules by which a cup holds."""
        return self.config.surface or Surface()

    @property
    def placing(self) -> tuple[float, float]:
        """Standard deviation of the cup's place across and along the belt [m]."""
        spread, belt = self.config.spread, self.config.belt
        ridden = sum(belt.pick_x) / 2.0 - belt.camera_x
        return spread.grasp, float(np.hypot(spread.grasp, spread.belt_speed * ridden))

    def parts(self, size: int) -> Iterator[Scenes]:
        """The scenes in parts of a size, to bound the memory."""
        for begin in range(0, len(self.error), size):
            yield take(self, slice(begin, begin + size))

    @property
    def radius(self) -> Floats:
        """Radii of the cups (N,) [m]."""
        return self.objects.cup_radius

    def try_places(self, places: Floats) -> Tries:
        """Try one place on each object, (N, 2) from the middle of the picture [m]."""
        true = places - self.middle + self.error
        force = seal_at(self.surfaces, self.objects, true[:, None]).force[:, 0]
        held = seal_holds(force, self.objects, normal_draw(object_keys(self.objects, TRY)), self.surface)
        kept = held & (self.margins(force[:, None], true[:, None])[:, 0] >= 1.0)
        vacuum = self.objects.measured.seal * (force / self.objects.seal)
        # Gauge and scales allow a throw by what they measure.
        objects, seen = self.objects, self.objects.measured
        offset = np.hypot(*places.T)
        hold = Hold(vacuum, seen.mass, objects.cup_friction, seen.size[:, 2] / 2.0, offset, objects.cup_radius)
        allowed = allowed_acceleration(hold) >= T3KR_ACCELERATION * PERCENT / 100.0
        return Tries(held, kept, vacuum, allowed)

    def worths_of_tries(self, rows: Ints, places: Floats) -> Floats:
        """Worths (T,) of tries at places of some objects (T,), (T, 2) from the middles of their pictures [m]."""
        parts = (slice(begin, begin + TOGETHER) for begin in range(0, len(rows), TOGETHER))
        return np.concatenate([take(self, rows[part]).try_places(places[part]).worth for part in parts])

    def worth(self, places: Floats) -> Floats:
        """Expected worths (N, P) of tries with the cup at true places (N, P, 2) from the outlines' middles [m]."""
        force = seal_at(self.surfaces, self.objects, places).force
        least = least_force(self.objects, self.surface)[:, None]
        held = importlib.import_module("scipy.special").ndtr(np.log(force / least) / self.surface.spread)
        return held * (HELD + (1.0 - HELD) * (self.margins(force, places) >= 1.0))

    def margins(self, force: Floats, places: Floats) -> Floats:
        """Holding force over load at `PERCENT`, for forces (N, P) [N] at places (N, P, 2) [m] as of `seal_at`."""
        acceleration = np.full(force.size, T3KR_ACCELERATION * PERCENT / 100.0)
        return self._hold(force, self._distance(places)).least_margin(acceleration).reshape(force.shape)

    def strength(self, places: Floats, number: Ints) -> tuple[Floats, Floats]:
        """What each object's try of a number would give at places, with the luck of that try.

        Args:
            places: places of the cups from the pictures' middles, the same for all objects (P, 2) [m].
            number: numbers of the tries, from 0 (N,).

        Returns:
            The accelerations that the holds survive in any direction (N, P) [m/s2], -inf where the cup does not hold;
            and the distances of the cups from the centres of mass (N, P) [m].
        """
        true = places - self.middle[:, None] + self.error[:, None]
        force, distance = seal_at(self.surfaces, self.objects, true).force, self._distance(true)
        luck = normal_draw(later_keys(object_keys(self.objects, TRY), number))
        known = force / max(self.config.mismatch, 1e-9)
        holds = seal_holds(known, self.objects, np.repeat(luck[:, None], len(places), axis=1), self.surface)
        strength = self._hold(force, distance).acceleration(1.0).reshape(force.shape)
        return np.where(holds, strength, -np.inf), distance

    def _distance(self, places: Floats) -> Floats:
        """Distances (N, P) [m] of places (N, P, 2) from the centres of mass."""
        return np.hypot(*np.moveaxis(places - self.surfaces.com[:, None], -1, 0))

    def _hold(self, force: Floats, distance: Floats) -> Hold:
        """True objects under cups by forces (N, P) [N] at distances (N, P) [m] from the centres of mass, row by row."""
        objects = self.objects
        columns = (objects.mass, objects.cup_friction, objects.com_depth, objects.cup_radius)
        mass, friction, depth, radius = (np.repeat(column, force.shape[1]) for column in columns)
        return Hold(force.reshape(-1), mass, friction, depth, distance.reshape(-1), radius)


def with_drawn_kinds(level: str, count: int, seed: int) -> GraspConfig:
    """A level with a number of drawn kinds beside its own."""
    config = GraspConfig.load(level)
    kinds = [draw_kind(f"drawn_{k}", np.random.default_rng([seed, k])) for k in range(count)]
    names = [kind["name"] for kind in kinds]
    return GraspConfig.load({"base": level, "items": [*config.items, *names], "extra_items": kinds})
