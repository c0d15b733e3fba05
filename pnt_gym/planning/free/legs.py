"""The legs of a throw in a free direction: throw, return and approach."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.free.approach import Entry
from pnt_gym.planning.free.release import clearing_time
from pnt_gym.planning.free.rules import HandRules
from pnt_gym.planning.motion.limits import Limits
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.scurve import rest_to_rest
from pnt_gym.planning.motion.transfer import Band, Transfers, fast_transfer

ROOM: Final = 0.002
"""Distance of planned heights below the cap [m], since heights are bounded only at the borders of the pieces."""
EXTRA_MARGIN: Final = 0.08
"""Addition to the margin over the falling object, for the same reason."""
CLEARER: Final = 1.02
"""Planned clear distance as a share of the required distance, for the same reason."""
SLOWER: Final = 1.15
"""Time at which the hand has to be clear, as a share of the least clearing time."""


def throw_leg(picks: Floats, position: Floats, velocity: Floats, limits: Limits, roof: Floats) -> Transfers:
    """Return motions from rest at the picks to the releases, never below the pick or above the roof.

    Args:
        picks: (N, 3) [m].
        position: release points (N, 3) [m]; NaN for none.
        velocity: release velocities (N, 3) [m/s]; NaN for none.
        limits: limits of the norms at all times.
        roof: greatest height of the hand (N,) [m].
    """
    zero = np.zeros(len(picks))
    valid: Bools = np.asarray(np.isfinite(position).all(axis=1))
    way = np.where(valid[:, None], position - picks, 0.0)
    band = Band.level(zero, np.maximum(roof - ROOM - picks[:, 2], 0.0))
    after = np.where(valid[:, None], velocity, 0.0)
    moves = fast_transfer(way, np.zeros_like(way), after, limits, band=band)
    return _select_rows(moves, valid)


class Departure(NamedTuple):
    """Where N hands are at the end of the window."""

    position: Floats
    """Positions (N, 3) [m]; NaN for none."""
    velocity: Floats
    """Velocities, those of the releases (N, 3) [m/s]."""


def return_leg(
    departure: Departure,
    next_picks: Floats,
    limits: Limits,
    roof: Floats,
    rules: HandRules,
    *,
    drift: Floats | None = None,
    shortest: Floats | None = None,
    hover: bool = False,
) -> tuple[Transfers, Segments]:
    """Return motions from the end of the window to above the next picks, and the vertical approaches below.

    Args:
        departure: where the hands are at the end of the window.
        next_picks: next picks (N, 3) [m], at the end of the window if they move.
        limits: limits of the norms at all times.
        roof: greatest height of the hand (N,) [m].
        rules: approach, margin and clear distance.
        drift: velocity of the next picks (N, 3) [m/s]; the approach ends at the picks' places at the hand's arrival.
        shortest: least time above the approach (N,) [s].
        hover: whether the hand stops above the pick; if not, the hand enters the approach in motion.
    """
    count, (start, velocity) = len(next_picks), departure
    valid: Bools = np.asarray(np.isfinite(start).all(axis=1))
    if hover:
        fall, still = np.tile([0.0, 0.0, -rules.approach], (count, 1)), np.zeros((count, 3))
        entry = Entry(still, still, rest_to_rest(fall, limits))
    else:
        entry = Entry.of(limits, count, rules.approach)
    down = entry.down
    way = next_picks + np.array([0.0, 0.0, rules.approach]) - start
    if drift is not None:
        way = way + drift * down.durations.sum(axis=1)[:, None]
    way = np.where(valid[:, None], way, 0.0)
    top = np.where(valid, roof - ROOM - start[:, 2], 0.0)
    margin = (1.0 - min(rules.margin + EXTRA_MARGIN, 1.0)) * GRAVITY
    # The band's object falls from the end of the window on, the true object from the release on: the band is cautious.
    band = Band(
        low=np.minimum(way[:, 2], 0.0),
        high=np.maximum(top, 0.0),
        fall=np.full(count, margin),
        clear=np.full(count, rules.clear_distance * CLEARER),
        by=SLOWER * clearing_time(limits, count, rules.clear_distance),
    )
    before = np.where(valid[:, None], velocity, 0.0)
    turn = _Rotation.of(before)
    moves = fast_transfer(
        turn.rotate(way),
        turn.rotate(before),
        entry.velocity,
        limits,
        braking=entry.acceleration,
        drift=None if drift is None else turn.rotate(drift),
        band=band,
        shortest=shortest,
    )
    back = _Rotation(turn.cosine[:, None], -turn.sine[:, None])
    moves = replace(moves, jerks=back.rotate(moves.jerks))
    return _select_rows(moves, valid), down


class _Rotation(NamedTuple):
    """Rotations about z that turn horizontal velocities into the direction of x."""

    cosine: Floats
    sine: Floats

    @classmethod
    def of(cls, velocity: Floats) -> _Rotation:
        speed = np.sqrt(velocity[:, 0] ** 2 + velocity[:, 1] ** 2)
        moving = speed > 0.0
        divisor = np.where(moving, speed, 1.0)
        return cls(np.where(moving, velocity[:, 0] / divisor, 1.0), velocity[:, 1] / divisor)

    def rotate(self, vectors: Floats) -> Floats:
        """Vectors S + (3,) in the rotated axes."""
        x, y = vectors[..., 0], vectors[..., 1]
        return np.stack([self.cosine * x + self.sine * y, self.cosine * y - self.sine * x, vectors[..., 2]], axis=-1)


def _select_rows(moves: Transfers, rows: Bools) -> Transfers:
    good = moves.feasible & rows
    duration = np.where(good, moves.duration, np.nan)
    return replace(moves, duration=duration, jerks=moves.jerks * good[:, None, None], feasible=good)
