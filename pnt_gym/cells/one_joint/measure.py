"""Camera measurement of a flight (Miyashita et al., section 6.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.flight import Flight
from pnt_gym.planning.one_joint import arrival, fit_flight

CONTACT_TIME: Final = 0.020
"""Time after the release from which the stoppers no longer push the part; the camera films from there on [s]."""
MIN_FRAMES: Final = 8
"""Frames that are kept even if the part touches something earlier."""
MIN_CONTACT_FLIGHT: Final = 0.5
"""Least recorded time of a part that leaves by contact, whose arrival at the goal the plan does not predict [s]."""


@final
@dataclass(frozen=True)
class Frames:
    """The camera's frames of N flights; rows that end early are padded with empty frames."""

    time: Floats
    """Time since the release (N, F) [s]."""
    pose: Floats
    """Pose x, y [m], phi [rad] with the camera's noise (N, F, 3); 0 in empty frames."""
    is_valid: Bools
    """Whether the frame shows the part (N, F)."""


def film(flight: Flight, flight_time: Floats, noise: Floats, config: OneJointConfig) -> Frames:
    """Frames of N flights from the release until the planned arrival or the first touch.

    The number of frames is bounded: a slow camera films a long flight, a fast camera films its beginning.

    Args:
        flight: the simulated throws.
        flight_time: planned flight time (N,) [s].
        noise: errors of the frames (N, F, 3); F bounds the number of frames.
        config: level with the camera and the kind of release.
    """
    stride = max(round(1.0 / (config.camera.rate * flight.step)), 1)
    skipped = CONTACT_TIME if config.release == "contact" else 0.0
    first = flight.clock.release_step + round(skipped / flight.step)
    index = first[:, None] + stride * np.arange(noise.shape[1], dtype=np.int64)
    inside = index < flight.pose.shape[1]
    index = np.where(inside, index, 0)
    time = np.take_along_axis(flight.time, index, axis=1) - flight.release_time[:, None]
    in_flight = np.take_along_axis(flight.free, index, axis=1) & (time <= flight_time[:, None])
    first_frames: Bools = np.arange(noise.shape[1], dtype=np.int64) < MIN_FRAMES
    is_valid: Bools = inside & (in_flight | first_frames)
    pose = np.take_along_axis(flight.pose, index[..., None], axis=1) + noise
    return Frames(np.where(is_valid, time, 0.0), np.where(is_valid[..., None], pose, 0.0), is_valid)


def estimated_state(flight: Flight, flight_time: Floats, goal: Floats, noise: Floats, config: OneJointConfig) -> Floats:
    """States x, y, phi, dy (N, 4) nearest to the goals, estimated from the camera's frames (Appendix).

    Args:
        flight: the simulated throws.
        flight_time: planned flight time (N,) [s].
        goal: goals (N, 4).
        noise: errors of the frames (N, F, 3).
        config: level with the camera, the kind of release, and the weights of the distance.
    """
    frames = film(flight, flight_time, noise, config)
    x, y, phi = (np.ascontiguousarray(frames.pose[..., k]) for k in range(3))
    fit = fit_flight(frames.time, x, y, phi, frames.is_valid)
    return arrival(fit, goal, config.scale.weights(), np.zeros(len(goal))).z
