"""Tries to grasp N objects: where the cups are, whether they hold, and what the picks become by them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, join_columns, replace_rows, take
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.drawing import release_delay, spin_at_grasp
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.grasp.config import GraspConfig, Surface
from pnt_gym.cells.grasp.surfaces import (
    TRY,
    draw_surfaces,
    later_keys,
    normal_draw,
    object_keys,
    outline_errors,
    seal_at,
    seal_holds,
    surface_table,
)
from pnt_gym.planning.motion.roots import bisect
from pnt_gym.rows import Columns, Pair, field

_HALVINGS: Final = 12
"""Bisection steps of a place or a pace without a feasible throw: resolution 1/4096."""


@final
class LastTry(Columns):
    """What the last step of a cell did, for the next observation in a shift; zeros before the first step."""

    tried: Bools = field("-", "whether the step was a try to grasp")
    held: Bools = field("-", "whether the object hung under the cup after it")
    vacuum: Floats = field("N", "force of the vacuum in the try by the gauge; 0 without a try")
    place: Pair = field("m", "place of the cup in the try, from the picture's middle; 0 without a try")
    thrown: Bools = field("-", "whether the step threw an object")
    pace: Floats = field("-", "largest acceleration of the throw, as a share of the robot's; 0 without a throw")
    dropped: Bools = field("-", "whether the object left the cup on the way to its release")

    @classmethod
    def after(cls, grasped: Bools, attempts: Attempts, thrown: Bools, info: Mapping[str, Any]) -> Self:
        """What a step did.

        Args:
            grasped: which rows tried (N,).
            attempts: the tries after the step (N,).
            thrown: which rows' objects hung and were thrown (N,).
            info: the results of the rows that ended their picks.
        """
        none = np.zeros(len(grasped))
        return cls.of(
            len(grasped), tried=grasped, held=attempts.holds, vacuum=np.where(grasped, attempts.vacuum, 0.0),
            place=np.where(grasped[:, None], attempts.place, 0.0), thrown=thrown,
            pace=np.where(thrown, info.get("pace", none), 0.0), dropped=thrown & (info.get("dropped", none) > 0.0),
        )  # fmt: skip


@final
class Attempts(Columns):
    """Where N cells stand between the first try to grasp an object and its throw."""

    holds: Bools = field("-", "whether the object hangs under the cup")
    tries: Ints = field("-", "number of tries that are over")
    last: Pair = field("m", "place of the cup in the last try, from the outline's middle; 0 before the first")
    place: Pair = field("m", "place of the cup in the last try, from the picture's middle; 0 before the first")
    failed: Pair = field("m", "place of the last try that failed, from the picture's middle; 0 where none did")
    vacuum: Floats = field("N", "force of the vacuum in the last try by the gauge; NaN before the first")
    leak: Floats = field("-", "true leak in the last try, over that of the item's own surface; NaN before the first")

    @classmethod
    def none(cls, count: int) -> Self:
        """No try yet in `count` cells."""
        return cls.of(count, vacuum=np.nan, leak=np.nan)

    def then(self, holds: Bools, last: Floats, place: Floats, vacuum: Floats, leak: Floats) -> Attempts:
        """The tries after one more in every cell; arguments as the fields."""
        failed = np.where(holds[:, None], self.failed, place)
        return Attempts.of(
            len(holds), holds=holds, tries=self.tries + 1, last=last, place=place, failed=failed, vacuum=vacuum,
            leak=leak,
        )  # fmt: skip


def tries_left(config: GraspConfig, tries: Ints, picks: Context) -> Ints:
    """Numbers of tries that are left of N picks (N,): of the level, and until the object leaves the window.

    Args:
        config: the cell.
        tries: numbers of tries that are over (N,).
        picks: the picks.
    """
    rules = config.grasp
    left = rules.tries - tries
    if rules.retry == 0.0:
        return left
    way = config.belt.pick_x[1] - picks.pick[:, 0]
    later = np.floor(way / (config.belt.speed * rules.retry)).astype(np.int64)
    return np.where(tries > 0, np.minimum(left, np.maximum(later, 0)), left)


@final
class Grasper:
    """Grasps objects at places of the cup.

    Args:
        config: the cell.
        planner: plans the throws.
    """

    def __init__(self, config: GraspConfig, planner: PickPlanner) -> None:
        self._config, self._planner = config, planner
        self.surfaces = surface_table(config.item_list())

    def grasp(self, context: Context, place: Floats, number: Ints) -> tuple[Context, Floats, Floats]:
        """Grasp objects.

        Args:
            context: N picks, before any try.
            place: places of the cups from the pictures' middles (N, 2) [m].
            number: numbers of the objects' tries, from 0 (N,).

        Returns:
            The picks, in which the objects hang under the cups or the picks fail; the places (N, 2) [m], of which
            those without a throw are moved towards the pictures' middles; and the true leaks under the lips (N,), 1
            where all of an object seals alike.
        """
        grasped, leak = self._grasped(context, place, number)
        bad = np.flatnonzero(~grasped.plan.feasible)
        if bad.size == 0:
            return grasped, place, leak
        rows, asked, numbers = take(context, bad), place[bad], number[bad]

        def at(share: Floats) -> tuple[Context, Floats]:
            return self._grasped(rows, share[:, None] * asked, numbers)

        share, _ = bisect(lambda part: at(part)[0].plan.feasible, np.zeros(len(bad)), np.ones(len(bad)), _HALVINGS)
        nearer, nearer_leak = at(share)
        moved = replace_rows(place, bad, share[:, None] * asked)
        return replace_rows(grasped, bad, nearer), moved, replace_rows(leak, bad, nearer_leak)

    def with_pace(self, context: Context, pace: Floats) -> tuple[Context, Bools]:
        """Grasped picks with throws at shares of the robot's acceleration (N,), and which throws are faster than asked.

        A throw that is too slow to reach its target is as slow as reaches it.
        """
        asked = self._plan(context, pace)
        fast = ~asked.plan.feasible
        bad = np.flatnonzero(fast)
        if bad.size == 0:
            return asked, fast
        rows = take(context, bad)
        slowest, _ = bisect(
            lambda share: self._plan(rows, share).plan.feasible, np.ones(len(bad)), pace[bad], _HALVINGS
        )
        return replace_rows(asked, bad, self._plan(rows, slowest)), fast

    def _plan(self, context: Context, pace: Floats) -> Context:
        """The picks with throws at shares of the robot's acceleration (N,), feasible or not."""
        return self._planner.plan_at(context, context.pick, pace * self._planner.config.robot.acceleration)

    def _grasped(self, context: Context, place: Floats, number: Ints) -> tuple[Context, Floats]:
        """The picks with the cups at places, and their throws at the fastest pace, feasible or not; and the leaks."""
        config, objects = self._config, context.objects
        grasp, leak = objects.grasp - place, np.ones(len(place))
        if config.surface is None:
            from scipy.special import ndtr  # noqa: PLC0415  # pyright: ignore[reportMissingTypeStubs] - a heavy import

            # Draws whether the cups seal: the objects' own in the first tries, and new ones in later tries.
            later = ndtr(normal_draw(later_keys(object_keys(objects, TRY), number)))
            draw = np.where(number == 0, objects.pick_draw, later)
            objects = objects.replace(grasp=grasp, spin=self._spin(context, grasp), pick_draw=draw)
        else:
            surfaces, unseen = draw_surfaces(self.surfaces, objects), outline_errors(objects, config)
            # The drawn grasp offset is where the camera takes the middle to be, from the cup of a grasp of zero.
            cup = place - (context.grasp + unseen)
            seals = seal_at(surfaces, objects, cup[:, None])
            force, leak = seals.force[:, 0], seals.leak[:, 0]
            holds, unseen = self._holds(objects, force, number, config.surface), unseen + surfaces.com
            spin = self._spin(context, grasp + unseen, force)
            objects = self._seal(objects, grasp + unseen, force, unseen, holds).replace(spin=spin)
        pick = context.pick + join_columns(place[:, 0], place[:, 1], 0.0)
        fastest = self._planner.config.robot.limits(objects.percent).acceleration
        return self._planner.plan_at(context.replace(objects=objects), pick, fastest), leak

    def _spin(self, context: Context, grasp: Floats, seal: Floats | None = None) -> Floats:
        """Spins (N, 3) [rad/s] of picks with other grasp offsets (N, 2) [m] and seals (N,) [N], drift included."""
        drifted = context.objects.replace(grasp=context.objects.grasp + context.unseen)
        return spin_at_grasp(drifted, grasp + context.unseen, self._config, seal)

    def _holds(self, objects: Objects, force: Floats, number: Ints, surface: Surface) -> Bools:
        """Whether seals of a force (N,) [N] hold their objects in the tries of some numbers (N,)."""
        draw = normal_draw(later_keys(object_keys(objects, TRY), number))
        # What a seal must hold scales with the mismatch, like every effect that the planner does not model.
        return seal_holds(force / max(self._config.mismatch, 1e-9), objects, draw, surface)

    def _seal(self, objects: Objects, grasp: Floats, force: Floats, unseen: Floats, holds: Bools) -> Objects:
        """Objects that hang with a grasp offset (N, 2) [m], by seals of a force (N,) [N] that hold or not (N,).

        Of the grasp offset the sensors do not see a part, `unseen` (N, 2) [m].
        """
        config, seen = self._config, objects.measured
        before, after = (
            release_delay(seal, objects.mass, objects.valve, objects.tau, config.suction)
            for seal in (objects.seal, force)
        )
        return objects.replace(
            grasp=grasp,
            seal=force,
            delay=np.maximum(objects.delay + config.mismatch * (after - before), 0.0),
            pick_draw=np.where(holds, 1.0, -1.0),
            measured=seen.replace(seal=seen.seal * (force / objects.seal), grasp_noise=seen.grasp_noise - unseen),
        )
