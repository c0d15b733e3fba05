"""Motion of N hands in a throw, in physics steps: release, hand positions, and when the objects are clear of cups."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, in_order, length, take
from pnt_gym.cells.base.bodies import vertical
from pnt_gym.cells.base.plant import step_counts
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.clearance import FORESIGHT, MARGIN, Bodies, Passage, may_touch, predict_passage, touches
from pnt_gym.cells.conveyor.cup.hold import Grips, Parting, grips, picked
from pnt_gym.cells.conveyor.cup.swing import Spring, springs, swing_objects
from pnt_gym.planning.motion.trajectory import HandPath, Samples
from pnt_gym.planning.straight.plan import ReleaseBatch

SETTLING_TIME: Final = 0.35
"""Simulated time after the planned landing, in which the object comes to rest [s]."""
LATEST_FLIGHT: Final = 1.25
"""Factor by which a late release may lengthen the flight."""
KNOT_SPACING: Final = 0.004
"""Interval between samples of the hand's path, which is interpolated in between [s]."""
PARTING_TIME: Final = 0.010
"""Time after the release in which contacts with the cup do not count, because the object is leaving it [s]."""


@final
@dataclass(frozen=True)
class HandCycle:
    """Motion of N hands in a cycle: throw, follow-through, and return to the next pick."""

    release: ReleaseBatch
    """The planned releases."""
    release_time: Floats
    """Time of the valve's command (N,) [s]."""
    path: HandPath
    """Path of the hand from lift to lift."""
    grips: Grips | None = None
    """Grips of the cups until the release; None where they are not computed yet."""


@final
@dataclass(frozen=True)
class ThrowClock:
    """N throws in physics steps: step of the release, last step, and positions of the cup's tip at steps."""

    path: HandPath
    """Path of the planner's points."""
    offset: Floats
    """Cup tips relative to the planner's points (N, 3) [m]."""
    free_at: Floats
    """Times at which the objects are released, on the clock of their paths (N,) [s]."""
    path_delay: Floats
    """Delay of the paths after the physics (N,) [s]: less than a step, so that the release falls on a step."""
    release: Ints
    """First step without grip (N,)."""
    end: Ints
    """First step after the throw (N,)."""
    step: float
    """Length of a physics step [s]."""
    grips: Grips
    """Grips until the release; objects whose pick failed are free from the first step on."""
    parting: Parting
    """State of the objects at their release."""
    lip: float
    """Length of a compliant lip above the tip, which collides with nothing [m]."""
    spring: Spring | None = None
    """The lips as springs; None where no object swings."""

    @classmethod
    def of(cls, context: Context, plans: HandCycle, config: ConveyorConfig, threads: int = 1) -> ThrowClock:
        """The throws of N objects in steps; an object that its cup drops is released at that moment.

        Results do not depend on the number of threads.

        Raises:
            PhysicsError: a throw takes longer than the longest simulated throw.
        """
        step = config.timestep
        grip_results = plans.grips or grips(context, picked(context, config), plans.path, plans.release_time, config)
        let_go: Floats = np.where(grip_results.picked, plans.release_time + context.objects.delay, 0.0)
        free_at: Floats = np.where(grip_results.dropped, grip_results.lost_at * step, let_go)
        release = np.ceil(free_at / step - 1e-9).astype(np.int64)
        shift = release * step - free_at
        settled = free_at + LATEST_FLIGHT * plans.release.flight_time + SETTLING_TIME
        end = step_counts(np.maximum(plans.path.duration + shift, settled), step)
        push = np.where(grip_results.unthrown, 0.0, config.mismatch * context.objects.blow_off)
        parting = Parting.hanging(context.without_spin(grip_results.unthrown), push)
        lip, offset = config.lip_length, context.cup_offset
        clock = cls(plans.path, offset, free_at, shift, release, end, step, grip_results, parting, lip)
        if not (config.swings and any(grip_results.picked.tolist())):
            return clock
        spring = springs(context, config)
        swung = swing_objects(context, spring, parting, clock.hand, release, clock.stride, config, threads)
        return replace(clock, parting=swung, spring=spring)

    @cached_property
    def stride(self) -> int:
        """Steps between two samples of the hand's path."""
        return max(round(KNOT_SPACING / self.step), 1)

    def hand(self, steps: Ints) -> Samples:
        """The planned motion of the cup's tip at the beginning of steps (K,) or (N, K)."""
        motion = self.path.sample(steps * self.step - self.path_delay[:, None])
        motion.position[:] += self.offset[:, None]  # in place: a copy would take as long as the samples
        return motion

    def clear(self, context: Context) -> Ints:
        """First steps (N,) from which on objects cannot touch their cups, by geometry; at most the last step."""
        steps = np.arange(0, max((self.end - self.release).tolist()), self.stride, dtype=np.int64)
        hand, since = self.hand(self.release[:, None] + steps), np.asarray(steps * self.step, dtype=np.float64)
        turned = length(self.parting.rate)[:, None] * since
        way = predict_passage(self.parting, hand.position, hand.velocity, since, np.cos(turned), np.sin(turned))
        possible = may_touch(Bodies.of(context.objects), way, self.stride * self.step, FORESIGHT, self.lip)
        possible[:, 0] = True  # the step of the release, whether clear or not of the solid part above a lip
        last = possible.shape[1] - np.argmax(possible[:, ::-1], axis=1)
        return np.asarray(np.minimum(self.release + last * self.stride, self.end - 1))

    def may_meet(
        self, context: Context, motion: tuple[Floats, Floats, Floats], first: Ints, count: Ints, margin: float = MARGIN
    ) -> Bools:
        """Whether cups may touch flying objects (N,), by geometry and on the safe side.

        Args:
            context: the N picks.
            motion: positions [m], velocities [m/s] (N, K, 3) and attitudes (N, K, 4) of objects every `stride` steps.
            first: steps of the first of these states (N,).
            count: number of steps that count (N,).
            margin: gap below which a touch is possible [m].
        """
        position, velocity, attitude = motion
        steps = np.arange(position.shape[1], dtype=np.int64) * self.stride
        hand = self.hand(first[:, None] + steps)
        way = Passage(position - hand.position, velocity - hand.velocity, vertical(*in_order(attitude)))
        possible = may_touch(Bodies.of(context.objects), way, self.stride * self.step, margin, self.lip)
        return np.asarray((possible & (steps < count[:, None])).any(axis=1))

    def meets(self, context: Context, motion: tuple[Floats, Floats, Floats], count: Ints) -> Bools:
        """Whether cups touch flying objects after the release (N,); arguments as in `may_meet`.

        Contacts while the object leaves the cup do not count.
        """
        touched = self.may_meet(context, motion, self.release, count, 0.0)
        rows = touched.nonzero()[0]
        if rows.size > 0:
            position, _, attitude = motion
            steps = np.arange(position.shape[1], dtype=np.int64) * self.stride
            counts = (steps < count[rows, None]) & (steps * self.step >= PARTING_TIME)
            clock = take(self, rows)
            centre = position[rows] - clock.hand(clock.release[:, None] + steps).position - [0.0, 0.0, self.lip]
            touched[rows] = (touches(take(context.objects, rows), centre, attitude[rows]) & counts).any(axis=1)
        return touched
