"""Equation 11 of Miyashita et al. and its derivative, without checks."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY


def land(u: Floats, half_height: float) -> Floats:
    """Return the landing states z (..., 4) of releases ``u`` (..., 4) by Eq. 11, without checks; NaN gives NaN."""
    angle, speed, radius, time = u[..., 0], u[..., 1], u[..., 2], u[..., 3]
    polar_angle = angle + np.arcsin(half_height / radius)
    across, up = radius * np.cos(polar_angle), radius * np.sin(polar_angle)
    rise = across * speed
    return np.stack(
        [
            across - up * speed * time,
            up + time * (rise - 0.5 * GRAVITY * time),
            angle + speed * time,
            rise - GRAVITY * time,
        ],
        axis=-1,
    )


def landing_jacobian(u: Floats, half_height: float) -> Floats:
    """Return dz/du (..., 4, 4) of Eq. 11 at the releases ``u`` (..., 4)."""
    angle, speed, radius, time = u[..., 0], u[..., 1], u[..., 2], u[..., 3]
    offset = np.arcsin(half_height / radius)
    cosine, sine = np.cos(angle + offset), np.sin(angle + offset)
    across, up, turn = radius * cosine, radius * sine, speed * time
    # d(offset)/dl = -d / (l r)
    bend = -half_height / (radius * np.sqrt(radius * radius - half_height * half_height))
    across_l, up_l = cosine - up * bend, sine + across * bend
    zero, unit = np.zeros_like(angle), np.ones_like(angle)
    rows = [
        [-up - across * turn, -up * time, across_l - up_l * turn, -up * speed],
        [across - up * turn, across * time, up_l + across_l * turn, across * speed - GRAVITY * time],
        [unit, time, zero, speed],
        [-up * speed, across, across_l * speed, zero - GRAVITY],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
