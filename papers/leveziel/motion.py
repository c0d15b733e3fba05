"""Motions of the robot: straight lines, circles and joint-linear moves under the motors' limits (section VI-B).

The paper gives a largest speed of the prototype's motors and no other limit; users can add an acceleration limit. A
motion goes from rest to rest: a path with a progress u from 0 to 1, scaled in time until the busiest motor just keeps
its limits at the samples. Moves along a line keep theta exactly; joint-linear moves do not (`joint_deviation`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.errors import ConfigError
from pnt_gym.planning import MotionLimits, min_time_scurve
from pnt_gym.robots.gripper import (
    PROTOTYPE,
    Dimensions,
    JointLimits,
    PoseError,
    check_pose,
    forward_kinematics,
    inverse_jacobian,
    inverse_kinematics,
    travel_time,
)
from pnt_gym.robots.gripper.pose import CHUNK, pieces, pose_pairs, pose_rows

CIRCLE_RADIUS: Final = 0.080
"""Radius of the circle in the experiments [m] (section VI-B)."""


@final
@dataclass(frozen=True)
class Profile:
    """Progress along a path from 0 to 1 in a time of 1.

    Raises:
        ConfigError: (a ValueError) an unknown kind, or a ramp outside (0, 0.5].
    """

    kind: Literal["trapezoid", "s-curve"] = "trapezoid"
    """Constant acceleration in the ramps, or an acceleration that rises and falls linearly."""
    ramp: float = 0.25
    """Share of the time in which speed rises, and again in which speed falls."""

    def __post_init__(self) -> None:
        if self.kind not in ("trapezoid", "s-curve"):
            raise ConfigError(f"profile kind is {self.kind!r}; it must be 'trapezoid' or 's-curve'")
        if not 0.0 < self.ramp <= 0.5:
            raise ConfigError(f"profile ramp is {self.ramp}; it must lie in (0, 0.5]")

    def sample(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        """Return progress and its first two derivatives at times (S,) from 0 to 1."""
        # The area under the speed is 1: peak (1 - ramp) = 1.
        peak = 1.0 / (1.0 - self.ramp)
        if self.kind == "s-curve":
            # Two jerk segments fill a ramp, so the highest acceleration is twice the mean acceleration.
            limits = MotionLimits(peak, 2.0 * peak / self.ramp, 4.0 * peak / self.ramp**2)
            return min_time_scurve(1.0, limits).sample(time)
        slope, time_left = peak / self.ramp, 1.0 - time
        early, late = time < self.ramp, time_left < self.ramp
        straight = peak * (time - 0.5 * self.ramp)
        progress = np.where(early, 0.5 * slope * time**2, np.where(late, 1.0 - 0.5 * slope * time_left**2, straight))
        return progress, slope * np.minimum(np.minimum(time, time_left), self.ramp), slope * (1.0 * early - 1.0 * late)


@final
@dataclass(frozen=True, eq=False)
class PoseMotion:
    """A motion at S equally spaced times."""

    time: Floats
    """Times (S,) from 0 [s]."""
    pose: Floats
    """Poses (S, 4): x, y, z [m], theta [rad]."""
    q: Floats
    """Motor angles (S, 4) [rad]."""
    speed: Floats
    """Motor speeds (S, 4) [rad/s]."""
    acceleration: Floats
    """Motor accelerations (S, 4) [rad/s2]."""

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return float(self.time[-1])


@final
@dataclass(frozen=True, eq=False)
class Deviation:
    """Deviation of joint-linear moves from the straight line between their ends."""

    theta: Floats
    """Largest signed difference of the platform's angle from its linear course (...,) [rad]."""
    path: Floats
    """Largest distance of the platform's middle from the line (...,) [m]."""


def line(
    start: ArrayLike,
    end: ArrayLike,
    dimensions: Dimensions = PROTOTYPE,
    *,
    limits: JointLimits | None = None,
    profile: Profile | None = None,
    samples: int = 401,
) -> PoseMotion:
    """Return the straight motion from pose ``start`` to pose ``end``, with theta in proportion to the position.

    Args:
        start: first pose (4,): x, y, z [m], theta [rad].
        end: last pose (4,).
        dimensions: dimensions of the robot.
        limits: limits of the motors; the prototype's speed when not given.
        profile: progress along the way over time.
        samples: number S of times at which the motors keep the limits.

    Raises:
        PoseError: (a ValueError) an argument is not a pose, or the robot cannot take a pose on the way.
        ConfigError: (a ValueError) fewer than 3 samples.
    """
    first, last = _single_row(start, "start"), _single_row(end, "end")
    time, *progress = _sample_progress(profile, samples)
    poses = first + progress[0][:, None] * (last - first)
    slope = np.broadcast_to(last - first, poses.shape)
    return _path_motion(time, poses, slope, np.zeros_like(poses), progress, dimensions, limits or JointLimits())


def circle(
    centre: ArrayLike = (0.0, 0.0, -0.2),
    theta: float | None = None,
    dimensions: Dimensions = PROTOTYPE,
    *,
    radius: float = CIRCLE_RADIUS,
    limits: JointLimits | None = None,
    profile: Profile | None = None,
    samples: int = 401,
) -> PoseMotion:
    """Return a full turn in a horizontal plane, counter-clockwise from the point furthest along +x.

    Centre (3,) and radius are in m. The halves keep the angle theta [rad], home's angle when not given. Further
    arguments are the same as in `line`.

    Raises:
        PoseError: (a ValueError) the centre is no point, the radius is not positive, or the circle leaves the reach.
        ConfigError: (a ValueError) fewer than 3 samples.
    """
    middle = _single_row(centre, "centre", 3)
    if not (np.isfinite(radius) and radius > 0.0):
        raise PoseError(f"radius is {radius} m; it must be positive and finite")
    angle = dimensions.home_theta if theta is None else float(theta)
    time, *progress = _sample_progress(profile, samples)
    turn = 2.0 * np.pi * progress[0]
    zero = np.zeros_like(turn)
    spoke = radius * np.column_stack([np.cos(turn), np.sin(turn), zero, zero])
    rim = radius * np.column_stack([-np.sin(turn), np.cos(turn), zero, zero])
    poses = np.append(middle, angle) + spoke
    # Derivatives of the pose by progress, of which 1 is a whole turn.
    slope, bend = 2.0 * np.pi * rim, -((2.0 * np.pi) ** 2) * spoke
    return _path_motion(time, poses, slope, bend, progress, dimensions, limits or JointLimits())


def joint_move(
    start: ArrayLike,
    end: ArrayLike,
    dimensions: Dimensions = PROTOTYPE,
    *,
    limits: JointLimits | None = None,
    profile: Profile | None = None,
    samples: int = 401,
) -> PoseMotion:
    """Return the synchronised point-to-point motion of the motors from pose ``start`` (4,) to pose ``end`` (4,).

    Arguments and errors as `line`. The platform leaves the straight line and its angle changes on the way.
    """
    first, last = ends = np.stack([_single_row(start, "start"), _single_row(end, "end")])
    check_pose(ends, dimensions, theta_limits=False)
    time, *progress = _sample_progress(profile, samples)
    q_first, q_last = inverse_kinematics(ends, dimensions)
    share, rate, growth = (values[:, None] for values in progress)
    way = q_last - q_first
    q = q_first + share * way
    # A start on the straight line keeps Newton's method in the assembly mode of both ends.
    pose = forward_kinematics(q, dimensions, start=first + share * (last - first))
    if np.isnan(pose).any():
        raise PoseError(f"the joint-linear move from {first.tolist()} to {last.tolist()} runs through a singularity")
    return _scale_time(time, pose, q, rate * way, growth * way, limits or JointLimits())


def joint_deviation(
    start: ArrayLike, end: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, samples: int = 65
) -> Deviation:
    """Return the deviation of joint-linear moves from straight lines; NaN where an end is out of reach.

    The deviation is read at `samples` equal joint steps, ends included; start and end are poses (..., 4) of one shape.

    Raises:
        PoseError: (a ValueError) the shapes differ or are wrong, or a number is not finite.
        ConfigError: (a ValueError) fewer than 3 samples.
    """
    shape, first, last = pose_pairs(start, end)
    _check_samples(samples)
    theta, path = np.empty(len(first)), np.empty(len(first))
    share = np.linspace(0.0, 1.0, samples)[:, None]
    for piece in pieces(len(first), max(1, CHUNK // share.size)):
        a, b = first[piece, None], last[piece, None]
        q_a, q_b = inverse_kinematics(a, dimensions), inverse_kinematics(b, dimensions)
        straight = a + share * (b - a)
        poses = forward_kinematics(q_a + share * (q_b - q_a), dimensions, start=straight)
        turn = poses[..., 3] - straight[..., 3]
        worst = np.abs(turn).argmax(axis=1)[:, None]
        theta[piece] = np.take_along_axis(turn, worst, axis=1)[:, 0]
        path[piece] = _line_distance(poses[..., :3] - a[..., :3], (b - a)[..., :3]).max(axis=1)
    return Deviation(theta.reshape(shape), path.reshape(shape))


def closing_time(position: ArrayLike = (0.0, 0.0, -0.2), dimensions: Dimensions = PROTOTYPE) -> Floats:
    """Return the time in which the gripper closes from home's angle when only `MOTOR_SPEED` limits the motors.

    Args:
        position: fixed position of the platform's middle (..., 3) [m].
        dimensions: dimensions of the robot.

    Returns:
        Times (...,) [s]; NaN where out of reach.

    Raises:
        PoseError: (a ValueError) the shape is not (..., 3), or a number is not finite.
    """
    shape, rows = pose_rows(position, "position", 3)
    ends = dimensions.home_theta, dimensions.theta[0]
    start, end = (np.column_stack([rows, np.full(len(rows), angle)]) for angle in ends)
    return travel_time(start, end, dimensions).reshape(shape)


def _path_motion(
    time: Floats, poses: Floats, slope: Floats, bend: Floats, progress: list[Floats], dims: Dimensions, top: JointLimits
) -> PoseMotion:
    """The motion on a path, given by poses and their first two derivatives by progress, (S, 4) each.

    With q' and q'' the derivatives by progress u, motor speed is q' u' and acceleration q'' u'^2 + q' u''.
    """
    check_pose(poses, dims, theta_limits=False)
    q = inverse_kinematics(poses, dims)
    rate = _motor_rate(poses, slope, dims)
    # q'': the change of q' along the path, by central differences over a short way.
    step = 1e-5
    forward = _motor_rate(poses + step * slope, slope + step * bend, dims)
    backward = _motor_rate(poses - step * slope, slope - step * bend, dims)
    curve = (forward - backward) / (2.0 * step)
    if not np.isfinite(curve).all():
        raise PoseError("the path touches the edge of the reach, where a motor would need infinite speed")
    speed, acceleration = progress[1][:, None], progress[2][:, None]
    return _scale_time(time, poses, q, rate * speed, curve * speed * speed + rate * acceleration, top)


def _motor_rate(poses: Floats, slope: Floats, dims: Dimensions) -> Floats:
    """Derivative q' of the motor angles (S, 4) by progress."""
    return (inverse_jacobian(poses, dims) @ slope[..., None])[..., 0]


def _scale_time(
    time: Floats, pose: Floats, q: Floats, speed: Floats, acceleration: Floats, limits: JointLimits
) -> PoseMotion:
    """The motion of duration 1, scaled in time until it just keeps the limits; a rest takes no time."""
    # A motion that takes k times as long has speeds over k and accelerations over k^2.
    duration = max(
        float(np.abs(speed).max()) / limits.speed, float(np.sqrt(np.abs(acceleration).max() / limits.acceleration))
    )
    scale = 1.0 / duration if duration > 0.0 else 0.0
    return PoseMotion(time * duration, pose, q, speed * scale, acceleration * scale * scale)


def _sample_progress(profile: Profile | None, samples: int) -> tuple[Floats, Floats, Floats, Floats]:
    _check_samples(samples)
    time = np.linspace(0.0, 1.0, samples)
    return time, *(profile or Profile()).sample(time)


def _check_samples(samples: int) -> None:
    if samples < 3:
        raise ConfigError(f"samples is {samples}; a motion needs at least 3")


def _single_row(value: ArrayLike, name: str, width: int = 4) -> Floats:
    shape, rows = pose_rows(value, name, width)
    if shape:
        raise PoseError(f"{name} must have shape ({width},), got {(*shape, width)}")
    return rows[0]


def _line_distance(offset: Floats, way: Floats) -> Floats:
    """Distances (N, S) [m] of points (N, S, 3) from the line through the origin along ``way`` (N, 1, 3)."""
    length = np.sqrt((way * way).sum(axis=-1, keepdims=True))
    unit = way / np.where(length > 0.0, length, 1.0)
    perpendicular = offset - (offset * unit).sum(axis=-1, keepdims=True) * unit
    return np.sqrt((perpendicular * perpendicular).sum(axis=-1))
