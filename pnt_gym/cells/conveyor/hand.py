"""What N hands do in a throw, in physics steps: when they let go, where they are, and when the objects are clear."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.base.plant import step_counts
from pnt_gym.cells.base.rotations import vertical
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.clearance import FORESIGHT, MARGIN, Passage, foreseen, touches
from pnt_gym.cells.conveyor.cup.hold import Grips, grips, picked
from pnt_gym.cells.conveyor.cup.parting import Parting
from pnt_gym.cells.conveyor.cup.swing import swung
from pnt_gym.planning.motion.trajectory import HandPath, Samples
from pnt_gym.planning.straight.plan import ReleaseBatch

SETTLE: Final = 0.35
"""Simulated after the planned landing, so that the object comes to lie [s]."""
LATEST_FLIGHT: Final = 1.25
"""A late release may lengthen the flight by this factor."""
KNOT_SPACING: Final = 0.004
"""The hand is looked at this often, and interpolated in between [s]."""
PARTING: Final = 0.010
"""While an object leaves the cup, a touch is none [s]."""


@final
@dataclass(frozen=True)
class HandCycle:
    """What N hands do: throw, follow through, and go to their next picks."""

    release: ReleaseBatch
    """The planned releases."""
    release_time: Floats
    """When the valve is commanded (N,) [s]."""
    path: HandPath
    """From lift to lift."""
    grips: Grips | None = None
    """How the cups hold on the way; None where nobody has looked."""


@final
@dataclass(frozen=True)
class ThrowClock:
    """N throws on the clock of the physics: its steps, and the way of the cup's tip."""

    path: HandPath
    """Of the planner's points."""
    offset: Floats
    """Of the cup's tips from them (N, 3) [m]."""
    free_at: Floats
    """When the objects are let go, on the clock of their paths (N,) [s]."""
    shift: Floats
    """Paths begin this much later than the physics (N,) [s]: less than a step, so that the release falls on a step."""
    release: Ints
    """First step without grip (N,)."""
    end: Ints
    """First step after the throw (N,)."""
    step: float
    """Of the physics [s]."""
    grips: Grips
    """Which objects are lost before they are let go, and which were never held: those are free from the first."""
    parting: Parting
    """How the objects leave their cups."""
    lip: float
    """Length of a lip that yields and touches nothing, above the tip [m]."""

    @classmethod
    def of(cls, thrown: Context, plans: HandCycle, config: ConveyorConfig) -> ThrowClock:
        """The throws of N objects; one that is lost on the way is let go there.

        Raises:
            PhysicsError: a throw takes longer than any that is simulated.
        """
        step = config.timestep
        held = plans.grips or grips(thrown, picked(thrown, config), plans.path, plans.release_time, config)
        let_go: Floats = np.where(held.picked, plans.release_time + thrown.objects.delay, 0.0)
        free_at: Floats = np.where(held.dropped, held.lost_at * step, let_go)
        release = np.ceil(free_at / step - 1e-9).astype(np.int64)
        shift = release * step - free_at
        settled = free_at + LATEST_FLIGHT * plans.release.flight_time + SETTLE
        end = step_counts(np.maximum(plans.path.duration + shift, settled), step)
        push = np.where(held.unthrown, 0.0, config.mismatch * config.cup.blow_off)
        parting = Parting.hanging(thrown.lost(held.unthrown), push)
        lip, offset = config.lip_length, thrown.cup_offset
        clock = cls(plans.path, offset, free_at, shift, release, end, step, held, parting, lip)
        if not (config.swings and held.picked.any()):
            return clock
        return replace(clock, parting=swung(thrown, parting, clock.hand, release, clock.stride, config))

    @property
    def stride(self) -> int:
        """Steps between two looks at the hand."""
        return max(round(KNOT_SPACING / self.step), 1)

    @property
    def _solid(self) -> Floats:
        """Where the solid part of the cup begins, from its tip (3,) [m]."""
        return np.array([0.0, 0.0, self.lip])

    def hand(self, steps: Ints) -> Samples:
        """The planned motion of the cup's tip at the beginning of steps (K,) or (N, K)."""
        motion = self.path.sample(steps * self.step - self.shift[:, None])
        return motion._replace(position=motion.position + self.offset[:, None])

    def clear(self, thrown: Context) -> Ints:
        """First steps (N,) from which on no object should meet its cup any more, at the latest the last one."""
        steps = np.arange(0, int((self.end - self.release).max()), self.stride, dtype=np.int64)
        hand, since = self.hand(self.release[:, None] + steps), np.asarray(steps * self.step, dtype=np.float64)
        passage = foreseen(self.parting, (hand.position, hand.velocity), since)
        passage = replace(passage, apart=passage.apart - self._solid)
        possible = passage.may_touch(thrown.objects, self.stride * self.step, FORESIGHT)
        possible[:, 0] = True  # it is let go there, clear or not of the solid part above a lip
        last = possible.shape[1] - np.argmax(possible[:, ::-1], axis=1)
        return np.asarray(np.minimum(self.release + last * self.stride, self.end - 1))

    def may_meet(
        self, thrown: Context, seen: tuple[Floats, Floats, Floats], first: Ints, count: Ints, margin: float = MARGIN
    ) -> Bools:
        """Whether cups may touch objects that were seen flying (N,).

        Args:
            thrown: the N objects.
            seen: their positions [m], velocities [m/s] (N, K, 3) and attitudes (N, K, 4), every `stride` steps.
            first: steps at which that begins (N,).
            count: steps that count (N,).
            margin: more room than geometry asks for [m].
        """
        position, velocity, attitude = seen
        steps = np.arange(position.shape[1], dtype=np.int64) * self.stride
        hand = self.hand(first[:, None] + steps)
        passage = Passage(position - hand.position - self._solid, velocity - hand.velocity, vertical(attitude))
        possible = passage.may_touch(thrown.objects, self.stride * self.step, margin)
        return np.asarray((possible & (steps < count[:, None])).any(axis=1))

    def meets(self, thrown: Context, seen: tuple[Floats, Floats, Floats], count: Ints) -> Bools:
        """Whether cups touch objects that were seen flying from their release on (N,); see `may_meet`.

        What touches while it leaves the cup, is none.
        """
        met = self.may_meet(thrown, seen, self.release, count, 0.0)
        rows = np.flatnonzero(met)
        if rows.size > 0:
            position, _, attitude = seen
            steps = np.arange(position.shape[1], dtype=np.int64) * self.stride
            counts = (steps < count[rows, None]) & (steps * self.step >= PARTING)
            own = take(self, rows)
            apart = position[rows] - own.hand(own.release[:, None] + steps).position - self._solid
            met[rows] = (touches(take(thrown.objects, rows), apart, attitude[rows]) & counts).any(axis=1)
        return met
