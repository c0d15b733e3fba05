"""What the gripper robot plans: where and how fast to let go by drag-free ballistics, and when to open the claws.

A throw's straight line has to lie within the motors' strokes and their speeds. Of a small grid of release points and
elevations, the throw that asks least of the fastest motor is taken. The claws are told to open early, by the nominal
time until they no longer touch an object of the planned width.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.cells.tray.config import TrayConfig
from pnt_gym.cells.tray.motion import TossPlans, eased, eased_share
from pnt_gym.planning.arrays import Bools, Floats, Ints, length
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.robots.gripper4.build import PROTOTYPE_BUILD
from pnt_gym.robots.gripper4.geometry import PROTOTYPE
from pnt_gym.robots.gripper4.jacobian import inverse_jacobian
from pnt_gym.robots.gripper4.kinematics import inverse_kinematics
from pnt_gym.robots.gripper4.motion import travel_time

_MOVE_TIMES: Final = np.linspace(0.0, 1.0, 13)[1:-1]
_MOVE_SHARES: Final = eased(_MOVE_TIMES)
_MOVE_RATES: Final = 30.0 * (_MOVE_TIMES * (1.0 - _MOVE_TIMES)) ** 2
"""Shares of the way of an eased motion, and its speeds over the mean one."""
_SHORTEST_MOVE: Final = 0.05
_SAMPLES: Final = 5


@final
class TossPlanner:
    """Plans picks and tosses of one cell.

    Args:
        config: the cell.
    """

    def __init__(self, config: TrayConfig) -> None:
        self.config = config
        self.targets = config.tray.centres(len(config.things))
        grip, claws = config.grip, PROTOTYPE_BUILD.claws
        self._top = claws.length + claws.pad[2] / 2.0 + grip.clearance
        contact = claws.contact_theta(np.array([t.size[1] for t in config.things]))
        wide = np.full_like(contact, np.deg2rad(grip.open_deg))
        closed, released = contact - np.deg2rad(grip.squeeze_deg), contact + np.deg2rad(grip.release_deg)
        self.theta = np.stack([wide, closed, contact, released], axis=-1)
        self.hang = self._top - np.array([t.height for t in config.things]) / 2.0
        share = eased_share(grip.squeeze_deg / (grip.squeeze_deg + grip.release_deg))
        self.lead = grip.opening * share
        motion = config.motion
        grid = np.meshgrid(motion.release_x, np.deg2rad(motion.elevation_deg), indexing="ij")
        self._grid = [axis.ravel() for axis in grid]

    def plan(self, kind: Ints, place: Floats, correction: Floats | None = None) -> TossPlans:
        """Plans for objects as they are seen.

        Args:
            kind: which of the config's things (N,).
            place: where they lie (N, 2) [m].
            correction: release point along the throw and to its left [m], and opening later [s] (N, 3); none when not
                given.
        """
        count, hang = len(kind), self.hang[kind]
        shift = np.zeros((count, 3)) if correction is None else np.asarray(correction, dtype=np.float64)
        release, velocity, flight = self._throw(kind)
        pick = np.column_stack([place, np.full(count, self.config.table.height + self._top)])
        speed, motion, grip = length(velocity), self.config.motion, self.config.grip
        is_drop = self.config.task == "drop"
        full = np.ones(count)
        plans = TossPlans(
            pick=pick,
            release=release,
            velocity=velocity,
            target=self.targets[kind],
            hang=hang,
            ramp=1.5 * speed / motion.acceleration,
            before=full * (motion.rest + self.lead if is_drop else motion.before),
            after=full * (grip.opening if is_drop else motion.after),
            closing=full * grip.closing,
            grip_time=full * (grip.closing + grip.hold),
            move_time=full,
            theta=self.theta[kind],
            opening=full * grip.opening,
            lead=full * self.lead,
            shift=shift[:, 2].copy(),
            flight_time=flight,
            feasible=np.ones(count, dtype=np.bool_),
        )
        ahead = plans.heading
        plans.release[:] += shift[:, :1] * ahead
        plans.release[:, :2] += shift[:, 1:2] * np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1)
        plans.move_time[:], reached = self._move_time(plans)
        plans.feasible[:] = reached & self._fits(plans)
        return plans

    def return_time(self, plans: TossPlans) -> Floats:
        """Time from the end of the line back above the pick at the motors' full speed, NaN out of reach (N,) [s]."""
        released = plans.theta[:, 3:]
        return travel_time(np.hstack([plans.end, released]), np.hstack([plans.pick, plans.theta[:, :1]]), PROTOTYPE)

    def _throw(self, kind: Ints) -> tuple[Floats, Floats, Floats]:
        """Release points (N, 3) [m], velocities (N, 3) [m/s] and flight times (N,) [s]."""
        target, hang = self.targets[kind], self.hang[kind]
        if self.config.task == "drop":
            release = target.copy()
            release[:, 2] = self.config.motion.drop_height
            return release, np.zeros_like(release), _fall(release[:, 2] - hang - target[:, 2], np.zeros_like(hang))
        release, velocity = self._candidates(target, hang)
        load = self._speed_share(kind, release, velocity)
        rows, best = np.arange(len(kind)), load.argmin(axis=1)
        release, velocity = release[rows, best], velocity[rows, best]
        return release, velocity, _fall(release[:, 2] - hang - target[:, 2], velocity[:, 2])

    def _candidates(self, target: Floats, hang: Floats) -> tuple[Floats, Floats]:
        """Release points and velocities (N, G, 3) that lead to the targets."""
        x, elevation = self._grid
        motion, shape = self.config.motion, (len(target), x.size)
        release = np.empty((*shape, 3))
        release[..., 0], release[..., 2] = x, motion.height
        release[..., 1] = motion.release_y * target[:, 1:2]
        way = target[:, None] - release
        way[..., 2] += hang[:, None]
        distance = np.hypot(way[..., 0], way[..., 1])
        drop = -way[..., 2]
        cos, tan = np.cos(elevation), np.tan(elevation)
        # The drag-free parabola through release and target at this elevation.
        level = distance * np.sqrt(GRAVITY / (2.0 * (distance * tan + drop)))
        velocity = way * (level / distance)[..., None]
        velocity[..., 2] = level * np.broadcast_to(np.sin(elevation) / cos, shape)
        return release, velocity

    def _speed_share(self, kind: Ints, release: Floats, velocity: Floats) -> Floats:
        """Largest motor speed on each candidate's line over the limit (N, G); infinite out of reach."""
        speed, motion = length(velocity), self.config.motion
        ramp = 0.75 * speed / motion.acceleration
        times = np.stack([-ramp - motion.before, np.zeros_like(ramp), ramp + motion.after], axis=-1)
        points = release[..., None, :] + times[..., None] * velocity[..., None, :]
        theta = np.broadcast_to(self.theta[kind][:, None, [1, 2, 3]], points.shape[:-1])
        poses = np.concatenate([points, theta[..., None]], axis=-1)
        rate = np.concatenate([velocity, np.zeros_like(velocity[..., :1])], axis=-1)
        fastest = _motor_speed(poses, rate[..., None, :]).max(axis=-1)
        return np.where(np.isnan(fastest), np.inf, fastest / PROTOTYPE_BUILD.servo.speed)

    def _move_time(self, plans: TossPlans) -> tuple[Floats, Bools]:
        """How long the move to the line takes at the allowed motor speed (N,) [s], and whether it is in reach."""
        way = plans.start - plans.pick
        points = plans.pick[:, None] + _MOVE_SHARES[:, None] * way[:, None]
        theta = np.broadcast_to(plans.theta[:, None, 1:2], (*points.shape[:-1], 1))
        rate = np.concatenate([way, np.zeros_like(way[:, :1])], axis=-1)[:, None] * _MOVE_RATES[:, None]
        fastest = _motor_speed(np.concatenate([points, theta], axis=-1), rate).max(axis=-1)
        reached = ~np.isnan(fastest)
        allowed = self.config.motion.speed_share * PROTOTYPE_BUILD.servo.speed
        return np.maximum(np.where(reached, fastest / allowed, 1.0), _SHORTEST_MOVE), reached

    def _fits(self, plans: TossPlans) -> Bools:
        """Whether the line is in reach with claws closed and open, and slow enough for the motors (N,)."""
        share = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
        points = plans.start[:, None] + share * (plans.end - plans.start)[:, None]
        rate = np.concatenate([plans.velocity, np.zeros_like(plans.velocity[:, :1])], axis=-1)[:, None]
        allowed = self.config.motion.line_speed_share * PROTOTYPE_BUILD.servo.speed
        fits = np.isfinite(plans.flight_time)
        for column in (1, 3):
            theta = np.broadcast_to(plans.theta[:, None, column : column + 1], (*points.shape[:-1], 1))
            fastest = _motor_speed(np.concatenate([points, theta], axis=-1), rate).max(axis=-1)
            fits &= ~np.isnan(fastest) & (np.nan_to_num(fastest, nan=np.inf) <= allowed)
        wide = np.concatenate([plans.pick, plans.theta[:, :1]], axis=-1)
        return fits & ~np.isnan(inverse_kinematics(wide, PROTOTYPE, strokes=True)[:, 0])


def _motor_speed(poses: Floats, rate: Floats) -> Floats:
    """Fastest motor (...,) [rad/s] in poses (..., 4) that move at a rate (..., 4); NaN out of reach."""
    q = inverse_kinematics(poses, PROTOTYPE, strokes=True)
    speeds = (inverse_jacobian(poses, PROTOTYPE) @ np.broadcast_to(rate, poses.shape)[..., None])[..., 0]
    return np.where(np.isnan(q[..., 0]), np.nan, np.abs(speeds).max(axis=-1))


def _fall(drop: Floats, up: Floats) -> Floats:
    """Time to fall by `drop` [m] after starting upwards at `up` [m/s]; NaN when it never gets there [s]."""
    return (up + np.sqrt(np.maximum(up**2 + 2.0 * GRAVITY * drop, 0.0))) / GRAVITY
