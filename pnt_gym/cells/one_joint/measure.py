"""What the camera sees of a flight (Miyashita et al. 2010, section 6.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.flight import Flight
from pnt_gym.planning.one_joint import arrival, fit_flight

CLEAR: Final = 0.020
"""A part that leaves by contact is watched from this long after the release on, when nothing pushes it [s]."""
LEAST: Final = 8
"""Frames that are kept even of a part that is touched before."""
PUSHED: Final = 0.5
"""A part that leaves by contact passes its goal when it will, whatever flight was planned: it is recorded for this long
at least [s]."""


@final
@dataclass(frozen=True)
class Frames:
    """The camera's frames of N flights; rows that end early are padded with frames in which nothing is seen."""

    time: Floats
    """Since the release (N, F) [s]."""
    pose: Floats
    """x, y [m], phi [rad] with the camera's noise (N, F, 3); 0 where nothing is seen."""
    seen: Bools
    """(N, F)"""


def least_flight(config: OneJointConfig) -> float:
    """How long a flight must be recorded however short it was planned [s]."""
    return PUSHED if config.release == "contact" else LEAST / config.camera.rate


def watch(flight: Flight, flight_time: Floats, noise: Floats, config: OneJointConfig) -> Frames:
    """Film N flights from the release until the planned arrival or the first touch.

    Frames beyond the noise's are not taken: a slow camera sees a long flight, a fast one its beginning.

    Args:
        flight: the simulated throws.
        flight_time: planned (N,) [s].
        noise: errors of the frames (N, F, 3); their number bounds that of the frames.
        config: camera and release.
    """
    stride = max(round(1.0 / (config.camera.rate * flight.step)), 1)
    skipped = CLEAR if config.release == "contact" else 0.0
    first = flight.clock.release_step + round(skipped / flight.step)
    index = first[:, None] + stride * np.arange(noise.shape[1], dtype=np.int64)
    inside = index < flight.pose.shape[1]
    index = np.where(inside, index, 0)
    time = np.take_along_axis(flight.time, index, axis=1) - flight.release_time[:, None]
    flies = np.take_along_axis(flight.free, index, axis=1) & (time <= flight_time[:, None])
    kept: Bools = np.arange(noise.shape[1], dtype=np.int64) < LEAST
    seen: Bools = inside & (flies | kept)
    pose = np.take_along_axis(flight.pose, index[..., None], axis=1) + noise
    return Frames(np.where(seen, time, 0.0), np.where(seen[..., None], pose, 0.0), seen)


def estimated_state(flight: Flight, flight_time: Floats, goal: Floats, noise: Floats, config: OneJointConfig) -> Floats:
    """States x, y, phi, dy (N, 4) in which N flights pass nearest to their goals, as the camera tells (Appendix).

    Args:
        flight: the simulated throws.
        flight_time: planned (N,) [s].
        goal: (N, 4).
        noise: errors of the frames (N, F, 3).
        config: camera, release, and the weights of the distance.
    """
    frames = watch(flight, flight_time, noise, config)
    x, y, phi = (np.ascontiguousarray(frames.pose[..., k]) for k in range(3))
    fitted = fit_flight(frames.time, x, y, phi, frames.seen)
    return arrival(fitted, goal, config.scale.weights(), np.zeros(len(goal))).z
