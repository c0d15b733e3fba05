"""Hidden values that differ from throw to throw, drawn before the throw from each row's generator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.one_joint.config import OneJointConfig


@final
@dataclass(frozen=True)
class Hidden:
    """Hidden values of N throws."""

    radius: Floats
    """True minus planned radius (N,) [m]."""
    delay: Floats
    """Time from the planned release to the moment at which the part comes free (N,) [s]."""
    noise: Floats
    """Errors of the camera's frames in x, y [m] and phi [rad], (N, F, 3)."""


def draw_hidden(generators: list[np.random.Generator], config: OneJointConfig) -> Hidden:
    """Hidden values of one throw per generator; the number of draws does not depend on the level.

    Args:
        generators: one per row.
        config: level of the cell.
    """
    m, errors, camera = config.mismatch, config.errors, config.camera
    draws = np.stack([g.standard_normal(2 + 3 * camera.frames) for g in generators])
    spread = m * np.array([camera.position, camera.position, np.deg2rad(camera.angle_deg)])
    return Hidden(
        radius=m * (errors.radius + errors.placement * draws[:, 0]),
        delay=np.maximum(m * (errors.delay + errors.timing * draws[:, 1]), 0.0),
        noise=draws[:, 2:].reshape(len(draws), camera.frames, 3) * spread,
    )


def expected_hidden(count: int, config: OneJointConfig) -> Hidden:
    """The hidden values without their random part."""
    m, errors = config.mismatch, config.errors
    return Hidden(
        radius=np.full(count, m * errors.radius),
        delay=np.full(count, m * errors.delay),
        noise=np.zeros((count, config.camera.frames, 3)),
    )
