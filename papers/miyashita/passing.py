"""Flights of parts past pallets, by the geometry of both (Miyashita et al., section 6.3)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.one_joint.pallets import Pallet, place_boxes
from pnt_gym.cells.one_joint.parts import Part, block
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.one_joint.landing import release_states_batch

MARGIN: Final = 0.005
"""Least distance from other pallets at which a part passes them [m]."""
SAMPLES: Final = 240
"""Poses along a flight that are checked against walls; a part moves less than 8 mm between two poses."""


def flight_poses(u: Floats, half_height: float, samples: int = SAMPLES) -> Floats:
    """Poses x, y, phi (N, samples, 3) from release to arrival (Eq. 11).

    Args:
        u: release states theta_t [rad], theta'_t [rad/s], l_t [m], t_f [s] (N, 4).
        half_height: d of the part [m].
        samples: at even steps of time, both ends included.
    """
    theta, omega, radius, flight = (u[:, k, None] for k in range(4))
    # Angle of the line from the pivot to the centre of mass at the release.
    angle = theta + np.arcsin(half_height / radius)
    cos, sin = np.cos(angle), np.sin(angle)
    t = flight * np.linspace(0.0, 1.0, samples)
    x = radius * (cos - omega * sin * t)
    y = radius * (sin + omega * cos * t) - 0.5 * GRAVITY * t**2
    return np.stack([x, y, theta + omega * t], axis=-1)


def clearance(u: Floats, part: Part, pallets: Sequence[Pallet]) -> Floats:
    """Least distance of thrown parts from pallets during the whole flight (N,) [m].

    Separating axes of the part's boxes and the walls give a lower bound of the distance for each pose, exact where
    sides face each other; an overlap counts negative, by its depth. Between two poses a part may come nearer by 1 mm.
    Infinite if there are no pallets.

    Args:
        u: release states (N, 4), as in `flight_poses`.
        part: the thrown part.
        pallets: pallets along the way, without the target.
    """
    swept = place_boxes(np.array(part.boxes), flight_poses(u, part.half_height))
    nearest = np.full(len(u), np.inf)
    for walls in (pallet.walls for pallet in pallets):
        nearest = np.minimum(nearest, gaps(swept[..., None, :], walls).min(axis=(1, 2, 3)))
    return nearest


def clear_vertical_speeds(goal: Pallet, speeds: Floats, part: Part, pallets: Sequence[Pallet]) -> Bools:
    """Vertical speeds at which a throw to a goal passes the other pallets (S,), as section 6.3 chooses them.

    Args:
        goal: the target pallet; its own vertical speed is not used.
        speeds: vertical speeds at the arrival (S,) [m/s].
        part: the thrown part.
        pallets: all pallets, from which the part stays away by `MARGIN`; the target may be among them.
    """
    goals = np.tile(goal.state, (len(speeds), 1))
    goals[:, 3] = speeds
    release = release_states_batch(goals, block=block(part))
    clear = np.zeros(len(speeds), dtype=np.bool_)
    obstacles = [p for p in pallets if p.name != goal.name]
    clear[release.feasible] = clearance(release.u[release.feasible], part, obstacles) > MARGIN
    return clear


def gaps(a: Floats, b: Floats) -> Floats:
    """Largest gap along a separating axis between boxes (..., 5) and boxes (..., 5) (...,) [m]; negative: overlap."""
    turn = b[..., 4] - a[..., 4]
    cos, sin = np.abs(np.cos(turn)), np.abs(np.sin(turn))
    separations: list[Floats] = []
    for frame, box in ((a, b), (b, a)):
        dx, dy = box[..., 0] - frame[..., 0], box[..., 1] - frame[..., 1]
        along, across = np.cos(frame[..., 4]), np.sin(frame[..., 4])
        u = np.abs(dx * along + dy * across) - frame[..., 2] - box[..., 2] * cos - box[..., 3] * sin
        v = np.abs(dy * along - dx * across) - frame[..., 3] - box[..., 2] * sin - box[..., 3] * cos
        separations.append(np.maximum(u, v))
    return np.maximum(separations[0], separations[1])
