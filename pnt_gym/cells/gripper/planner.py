"""Planner of the gripper robot: point and velocity of the release by drag-free ballistics, and time of the opening.

On a belt the claws close while the platform moves with the object; the belt's velocity fades out during the lift.

A throw's straight line must lie within the motors' strokes and speeds. Among a small grid of release points and
elevations, the planner takes the throw with the lowest load on the fastest motor. The command to open comes early, by
the nominal time until the claws no longer touch an object of the planned width.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, length
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.motion import TossPlans, ease, ease_share, fading_travel
from pnt_gym.constants import GRAVITY
from pnt_gym.errors import ConfigError
from pnt_gym.robots.gripper.build import Claws
from pnt_gym.robots.gripper.geometry import Dimensions
from pnt_gym.robots.gripper.indices import singular_angle
from pnt_gym.robots.gripper.jacobian import inverse_jacobian
from pnt_gym.robots.gripper.kinematics import inverse_kinematics
from pnt_gym.robots.gripper.motion import travel_time

_MOVE_TIMES: Final = np.linspace(0.0, 1.0, 13)[1:-1]
_MOVE_SHARES: Final = ease(_MOVE_TIMES)
_MOVE_RATES: Final = 30.0 * (_MOVE_TIMES * (1.0 - _MOVE_TIMES)) ** 2
"""Shares of the path of an eased motion, and speeds over its mean speed."""
_BEND: Final = 10.0 / 3.0**0.5
"""Largest acceleration of an eased motion, over path / time^2."""
_MOVE_TRAVEL: Final = fading_travel(_MOVE_TIMES)
_ROUNDS: Final = 8
"""Iterations of a move's duration while the platform still follows the belt."""
_TOLERANCE: Final = 1.02
"""Factor by which a motor speed may exceed its limit where the iteration has not yet converged."""
_SHORTEST_MOVE: Final = 0.05
_SAMPLES: Final = 5


@final
class TossPlanner:
    """Plans picks and tosses of one cell.

    Args:
        config: level of the cell.
    """

    def __init__(self, config: GripperConfig) -> None:
        self.config = config
        self.dimensions, build = config.robot.parts()
        self.motor_speed = build.servo.speed
        self.targets = config.tray.centres(len(config.items))
        grip, claws = config.grip, build.claws
        _check(config, claws, self.dimensions)
        # Check that the open claws need no angle outside the range of the platform's halves.
        grip, (low, high) = config.grip, np.rad2deg(self.dimensions.theta)
        singular = float(np.rad2deg(singular_angle(self.dimensions.home[:3], self.dimensions)))
        valid = f"the platform's halves turn from {low:g} to {high:g} deg"
        if singular <= high:
            high, valid = singular, f"{valid}, and from {singular:.1f} deg on the motors lose hold of them"
        if not low <= grip.open_deg <= high:
            raise ConfigError(f"cell {config.name!r}: grip.open_deg is {grip.open_deg:g} deg; {valid}")
        for item in config.item_list():
            angle = float(np.rad2deg(claws.contact_theta(np.asarray(item.size[1])))) + grip.release_deg
            if angle > high:
                raise ConfigError(
                    f"cell {config.name!r}: grip.release_deg is {grip.release_deg:g} deg, which opens the claws to "
                    f"{angle:.1f} deg around the {item.name}; {valid}"
                )
        self._top = claws.length + claws.pad[2] / 2.0 + grip.clearance
        self._belt = config.table.speed * config.table.travel
        contact = claws.contact_theta(np.array([i.size[1] for i in config.item_list()]))
        wide = np.full_like(contact, np.deg2rad(grip.open_deg))
        closed, released = contact - np.deg2rad(grip.squeeze_deg), contact + np.deg2rad(grip.release_deg)
        self.theta = np.stack([wide, closed, contact, released], axis=-1)
        self.hang = self._top - np.array([i.height for i in config.item_list()]) / 2.0
        share = ease_share(grip.squeeze_deg / (grip.squeeze_deg + grip.release_deg))
        self.lead = grip.opening * share
        motion = config.motion
        grid = np.meshgrid(motion.release_x, np.deg2rad(motion.elevation_deg), indexing="ij")
        self._grid = [axis.ravel() for axis in grid]

    def plan(self, kind: Ints, place: Floats, correction: Floats | None = None) -> TossPlans:
        """Plans for objects at their observed places.

        Args:
            kind: index of the cell's item (N,).
            place: places of the objects, on a belt when the claws begin to close (N, 2) [m].
            correction: release point along the throw and to its left [m], and delay of the opening [s] (N, 3); none
                when not given.
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
            belt=np.tile(self._belt, (count, 1)),
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
        heading = plans.heading
        left = np.stack([-heading[:, 1], heading[:, 0], np.zeros(count)], axis=-1)
        plans = replace(plans, release=release + shift[:, :1] * heading + shift[:, 1:2] * left)
        # Duration of the move to the line at the allowed motor speed (N,) [s]; 1 out of reach.
        still = replace(plans, belt=np.zeros_like(plans.belt))
        # Without a belt, speeds are proportional to 1 / time, so one iteration is exact.
        time = self._next_move_time(still, np.ones_like(plans.move_time))
        for _ in range(_ROUNDS if self._belt.any() else 0):
            time = self._next_move_time(plans, time)
        plans = replace(plans, move_time=time)
        return replace(plans, feasible=~np.any(list(self.faults(plans).values()), axis=0))

    def faults(self, plans: TossPlans) -> dict[str, Bools]:
        """Possible faults of plans, and whether each plan has them (N,)."""
        motion, motor_limit = self.config.motion, self.motor_speed
        # Speed of the fastest motor on the line, claws closed and open (N,) [rad/s]; NaN out of reach.
        share = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
        points = plans.start[:, None] + share * (plans.end - plans.start)[:, None]
        speeds = [
            self._speed(points, np.broadcast_to(theta, (*points.shape[:-1], 1)), plans.velocity[:, None])
            for theta in (plans.theta[:, None, 1:2], plans.theta[:, None, 3:4])
        ]
        move, line = self._move_speed(plans, plans.move_time), np.maximum(*speeds)
        # Speed of the fastest motor, claws open or closed, at the beginning of closing and of the lift.
        points, rate = np.repeat(plans.pick[:, None], 2, axis=1), plans.belt[:, None]
        later = points + plans.grip_time[:, None, None] * rate
        first, last = (self._speed(places, plans.theta[:, :2, None], rate) for places in (points, later))
        return {
            "the robot does not reach the grip": np.isnan(first),
            "the belt carries the object out of the robot's reach before it is gripped": np.isnan(last),
            "the motors are too slow to follow the belt": np.maximum(first, last) > motion.speed_share * motor_limit,
            "the way from the grip to the throw leaves the robot's reach": np.isnan(move),
            "the motors are too slow to leave the belt": move > _TOLERANCE * motion.speed_share * motor_limit,
            "no throw leads there": ~np.isfinite(plans.flight_time),
            "the throw leaves the robot's reach": np.isnan(line),
            "the motors are too slow for the throw": line > motion.line_speed_share * motor_limit,
        }

    def return_time(self, plans: TossPlans) -> Floats:
        """Time from the end of the line back above the pick at full motor speed, NaN out of reach (N,) [s]."""
        released = plans.theta[:, 3:]
        end, pick = np.hstack([plans.end, released]), np.hstack([plans.pick, plans.theta[:, :1]])
        return travel_time(end, pick, self.dimensions, speed=self.motor_speed)

    def _throw(self, kind: Ints) -> tuple[Floats, Floats, Floats]:
        """Release points (N, 3) [m], velocities (N, 3) [m/s] and flight times (N,) [s]."""
        target, hang = self.targets[kind], self.hang[kind]
        if self.config.task == "drop":
            release = target.copy()
            release[:, 2] = self.config.motion.drop_height
            return release, np.zeros_like(release), _fall(release[:, 2] - hang - target[:, 2], np.zeros_like(hang))
        # Release points and velocities (N, G, 3) whose drag-free flights meet the targets.
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
        # Largest motor speed on each candidate's line over its limit (N, G); infinite out of reach.
        speed, motion = length(velocity), self.config.motion
        ramp = 0.75 * speed / motion.acceleration
        times = np.stack([-ramp - motion.before, np.zeros_like(ramp), ramp + motion.after], axis=-1)
        points = release[..., None, :] + times[..., None] * velocity[..., None, :]
        theta = np.broadcast_to(self.theta[kind][:, None, [1, 2, 3]], points.shape[:-1])
        fastest = self._speed(points, theta[..., None], velocity[..., None, :])
        load = np.where(np.isnan(fastest), np.inf, fastest / self.motor_speed)
        rows, best = np.arange(len(kind)), load.argmin(axis=1)
        release, velocity = release[rows, best], velocity[rows, best]
        return release, velocity, _fall(release[:, 2] - hang - target[:, 2], velocity[:, 2])

    def _next_move_time(self, plans: TossPlans, time: Floats) -> Floats:
        """Next iterate of a move's duration, from motor speed and path at the present duration (N,) [s]."""
        motion = self.config.motion
        fastest = self._move_speed(plans, time)
        load = np.where(np.isnan(fastest), 1.0, fastest / (motion.speed_share * self.motor_speed))
        shortest = np.full_like(time, _SHORTEST_MOVE)
        if motion.move_acceleration is not None:
            way = length(plans.start - plans.pick - replace(plans, move_time=time).belt_travel)
            shortest = np.maximum(shortest, np.sqrt(_BEND * way / motion.move_acceleration))
        return np.maximum(time * load, shortest)

    def _move_speed(self, plans: TossPlans, time: Floats) -> Floats:
        """Speed of the fastest motor on a move of given duration (N,) [rad/s]; NaN out of reach."""
        plans_at_time = replace(plans, move_time=time)
        way, long, belt = (
            plans_at_time.start - plans_at_time.pick - plans_at_time.belt_travel,
            time[:, None],
            plans.belt[:, None],
        )
        points = plans.pick[:, None] + (plans.grip_time[:, None] + long * _MOVE_TRAVEL)[..., None] * belt
        points = points + _MOVE_SHARES[:, None] * way[:, None]
        theta = np.broadcast_to(plans.theta[:, None, 1:2], (*points.shape[:-1], 1))
        rate = way[:, None] * _MOVE_RATES[:, None] / long[..., None] + (1.0 - _MOVE_SHARES)[:, None] * belt
        return self._speed(points, theta, rate)

    def _speed(self, points: Floats, theta: Floats, rate: Floats) -> Floats:
        """Fastest motor's speed (...,) [rad/s] at points (..., S, 3) of velocities (..., S or 1, 3), or NaN."""
        rate = np.concatenate([rate, np.zeros_like(rate[..., :1])], axis=-1)
        # Fastest motor's speed (...,) [rad/s] in poses (..., 4) that move at rates (..., 4); NaN out of reach.
        poses = np.concatenate([points, theta], axis=-1)
        q = inverse_kinematics(poses, self.dimensions, strokes=True)
        speeds = (inverse_jacobian(poses, self.dimensions) @ np.broadcast_to(rate, poses.shape)[..., None])[..., 0]
        return np.where(np.isnan(q[..., 0]), np.nan, np.abs(speeds).max(axis=-1)).max(axis=-1)


def _check(config: GripperConfig, claws: Claws, dimensions: Dimensions) -> None:
    """Check that every item fits between the open claws, and is wide enough for the closed ones.

    Raises:
        ConfigError: an item is too wide or too narrow.
    """
    grip = config.grip
    tightest = float(np.rad2deg(dimensions.theta[0]))
    open_gap, closed_gap = claws.gap(np.deg2rad(grip.open_deg)), claws.gap(np.deg2rad(tightest + grip.squeeze_deg))
    for item in config.item_list():
        width = item.size[1]
        if width >= open_gap:
            raise ConfigError(
                f"cell {config.name!r}: the {item.name} is {width:.4g} m wide; the claws open to {open_gap:.4g} m"
            )
        if width < closed_gap:
            raise ConfigError(
                f"cell {config.name!r}: the {item.name} is {width:.4g} m wide; claws that squeeze by "
                f"{grip.squeeze_deg:g} deg hold no less than {closed_gap:.4g} m"
            )


def _fall(drop: Floats, up: Floats) -> Floats:
    """Time to fall by `drop` [m] after starting upwards at `up` [m/s]; the time of the apex if never so low [s]."""
    # Root of up t - g t^2 / 2 = -drop.
    return (up + np.sqrt(np.maximum(up**2 + 2.0 * GRAVITY * drop, 0.0))) / GRAVITY
