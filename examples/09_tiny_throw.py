"""One throw from pick to landing in plain NumPy: plan, hand, late release and flight, equal to the suite's `flight`.

Read it from `plan` to `throw`. At the end it throws the first throws of the level `nominal_plain` beside the suite,
which reads the hidden values of its objects for it. Lengths are in m, times in s, angles in rad; z points up.
"""

from typing import Any, NamedTuple, TypeAlias

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import pnt_gym  # noqa: F401

Floats: TypeAlias = NDArray[np.float64]
GRAVITY, AIR_DENSITY, AIR_VISCOSITY = 9.81, 1.2, 1.8e-5
WINDOW, ROOF = 0.080, 0.10  # s at constant velocity after the release; m above the pick, for the release at most
STEP = 0.001  # of the flight [s]


class Limits(NamedTuple):
    """What the hand can do at most."""

    speed: float
    acceleration: float
    jerk: float


class Thing(NamedTuple):
    """A thing to throw, with all that the planner does not know of it."""

    mass: float  # kg
    half: Floats  # half lengths along its three axes [m]
    gyration: float  # inertia over m (b^2 + c^2), with the half lengths b and c
    drag: float  # Cd times a factor of the shape, on the area that meets the flow
    middle: float  # height of its middle above its centre of mass [m]
    hanging: Floats  # centre of mass, seen from the planner's point at the cup [m]
    yaw: float  # rad
    spin: Floats  # angular velocity after the release, in its own axes [rad/s]
    delay: float  # of its release after the command [s]


class Plan(NamedTuple):
    """A throw as planned, for a point without air that is let go at once."""

    ahead: Floats  # unit vector of the hand's line
    angle: float  # elevation of the line
    distance: float  # from the pick to the release, P_r
    speed: float  # at the release, V_r
    time: float  # of the release


class Throw(NamedTuple):
    """A throw as it happens."""

    plan: Plan
    flight: Floats  # places, one a millisecond (N, 3)
    landing: Floats  # where it comes down through the height of the target (2,)


def run_up(speed: Any, limits: Limits) -> Any:
    """The shortest way on which a hand at rest reaches a speed, with no acceleration left at its end."""
    _, most, jerk = limits
    return np.where(jerk * speed <= most**2, speed * np.sqrt(speed / jerk), speed / 2 * (speed / most + most / jerk))


def plan(pick: Floats, target: Floats, limits: Limits) -> Plan:
    """The quickest throw: each line above the target has one release that hits; the earliest of these wins."""
    way = target - pick
    reach, rise = float(np.hypot(way[0], way[1])), way[2]
    low, high = max(np.arctan2(rise, reach), 0.0) + 1e-6, np.radians(89.0)
    for _ in range(4):  # each time 200 times as fine between the neighbours of the best
        angle = np.linspace(low, high, 401)
        length, flight = reach / np.cos(angle), np.sqrt(2 * (reach * np.tan(angle) - rise) / GRAVITY)
        slow, fast = np.zeros(401), np.full(401, limits.speed)
        for _ in range(50):  # a faster hand needs a longer way, and leaves more of it to the flight
            speed = (slow + fast) / 2
            short = run_up(speed, limits) + speed * flight <= length
            slow, fast = np.where(short, speed, slow), np.where(short, fast, speed)
        distance = length - fast * flight
        peak = np.minimum(np.sqrt(limits.jerk * fast), limits.acceleration)
        time = distance / fast + (fast / peak + peak / limits.jerk) / 2
        best = int(np.argmin(np.where(distance * np.sin(angle) <= ROOF, time, np.inf)))
        low, high = angle[max(best - 1, 0)], angle[min(best + 1, 400)]
    ahead = np.array([*(way[:2] / reach * np.cos(angle[best])), np.sin(angle[best])])
    return Plan(ahead, float(angle[best]), float(distance[best]), float(fast[best]), float(time[best]))


def hand(time: float, plan: Plan, limits: Limits) -> tuple[float, float]:
    """Way and speed of the hand on its line: run-up, a window at constant velocity, and a stop."""
    peak = min(np.sqrt(limits.jerk * plan.speed), limits.acceleration)
    ramp = peak / limits.jerk
    flat = plan.speed / peak - ramp
    cruise = plan.time - 2 * ramp - flat + WINDOW
    way = speed = acceleration = 0.0
    for length, jerk in zip([ramp, flat, ramp, cruise, ramp, flat, ramp], [1, 0, -1, 0, -1, 0, 1], strict=True):
        t, j = min(time, length), jerk * limits.jerk
        way += speed * t + acceleration * t**2 / 2 + j * t**3 / 6
        speed += acceleration * t + j * t**2 / 2
        acceleration, time = acceleration + j * t, time - t
    return way, speed


def skew(vector: Floats) -> Floats:
    """Matrix of a vector whose product with a second vector is the cross product of both."""
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def turned(angle: Floats) -> Floats:
    """Rotation matrix of a rotation vector, by Rodrigues' formula."""
    size = np.linalg.norm(angle)
    cross = skew(angle / max(size, 1e-12))
    return np.eye(3) + np.sin(size) * cross + (1 - np.cos(size)) * cross @ cross


def carried_air(half: Floats) -> Floats:
    """Volume of the air that moves with an ellipsoid along each of its axes (Lamb), by quadrature [m3]."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    ratio = (1 + nodes) / (1 - nodes)  # from 0 to infinity
    squares, s = half**2, (half.max() * ratio[:, None]) ** 2
    steps = weights * 4 * half.max() ** 2 * ratio / (1 - nodes) ** 2
    k = half.prod() * ((steps / np.sqrt((squares + s).prod(axis=1))) @ (1 / (squares + s)))
    return 4 / 3 * np.pi * half.prod() * k / (2 - k)


def air(thing: Thing, velocity: Floats, spin: Floats, carried: Floats) -> tuple[Floats, Floats]:
    """Force and torque of the air about the centre of mass, all in the axes of the thing; an ellipsoid stands for it.

    Drag on the area that meets the flow, friction on the rest, Kutta lift and Magnus lift: the model of MuJoCo.
    """
    velocity = velocity + skew(spin) @ [0, 0, thing.middle]
    speed, (a, b, c), (x, y, z) = np.linalg.norm(velocity), np.sort(thing.half), thing.half
    tilted = (np.prod(thing.half) / thing.half) ** 2 * velocity
    met = np.pi * np.sqrt(tilted @ tilted / (tilted @ velocity))
    ball, kutta, magnus = 2 / 3 * (a + b + c), 0.4, 0.7
    drag = thing.drag * (met + 0.02 * (np.pi * b * c - met))
    force = -(AIR_DENSITY * speed * drag + 3 * np.pi * AIR_VISCOSITY * ball) * velocity
    share = kutta * met * (tilted @ velocity) / (speed * (tilted @ tilted))
    force += AIR_DENSITY * share * skew(skew(tilted) @ velocity) @ velocity
    force += AIR_DENSITY * magnus * 4 / 3 * np.pi * a * b * c * skew(spin) @ velocity
    swept = 8 / 15 * np.pi * np.array([x * max(y, z) ** 4, y * max(z, x) ** 4, z * max(x, y) ** 4])
    torque = -AIR_DENSITY * np.linalg.norm(spin * swept) * spin
    moved = AIR_DENSITY * carried * velocity  # momentum of the air that the thing carries with it
    force, torque = force + skew(moved) @ spin, torque + skew(moved) @ velocity
    return force, torque + skew([0, 0, thing.middle]) @ force


def fly(thing: Thing, place: Floats, velocity: Floats, rim: float, share: float) -> Floats:
    """Places of a released thing (N, 3), step by step until it has come down through the height of a rim."""
    turn, spin = turned(np.array([0.0, 0.0, thing.yaw])), thing.spin
    inertia = thing.gyration * thing.mass * ((thing.half**2).sum() - thing.half**2)
    places, carried = [place], carried_air(thing.half)
    while not (places[-1][2] < rim and velocity[2] < 0):
        force, torque = (share * part for part in air(thing, turn.T @ velocity, spin, carried))
        velocity = velocity + STEP * (turn @ force / thing.mass - [0, 0, GRAVITY])
        places.append(places[-1] + STEP * velocity)
        spin = spin + STEP * (torque - skew(spin) @ (inertia * spin)) / inertia
        turn = turn @ turned(STEP * spin)
    return np.array(places)


def throw(thing: Thing, pick: Floats, target: Floats, limits: Limits, share: float = 1.0) -> Throw:
    """Throw a thing from the planner's point at its pick (3,) to the middle of an opening (3,), in a share of air."""
    planned = plan(pick, target, limits)
    way, speed = hand(planned.time + thing.delay, planned, limits)  # the vacuum lets go late, the hand has moved on
    flight = fly(thing, pick + way * planned.ahead + thing.hanging, speed * planned.ahead, target[2], share)
    return Throw(planned, flight, np.array([np.interp(-target[2], -flight[-2:, 2], flight[-2:, k]) for k in range(2)]))


def coming(core: Any, row: int = 0) -> tuple[Thing, Floats, Floats, Limits]:
    """Arguments of `throw` for the coming throw of a cell of the suite, with the hidden values of its object."""
    c = core.cell.context
    o, limits = c.objects, Limits(*(float(values[row]) for values in c.throw_limits))
    thing = Thing(
        mass=o.mass[row],
        half=o.extents[row] / 2,
        gyration=[0.27, 0.38, 0.38][o.shape[row]],
        drag=[0.50, 0.64, 0.64][o.shape[row]] * o.drag[row],
        middle=o.com_depth[row] - 0.0005 - o.size[row, 2] / 2,  # half a millimetre lies between cup and thing
        hanging=c.hanging[row] + c.cup_offset[row],
        yaw=o.yaw[row],
        spin=turned(np.array([0.0, 0.0, -o.yaw[row]])) @ o.spin[row],
        delay=o.delay[row],
    )
    return thing, c.pick[row], c.target[row], limits


if __name__ == "__main__":
    env = gym.make("PnTRelease-v0", level={"base": "nominal_plain", "fidelity": "flight"})
    for seed in range(3):
        env.reset(seed=seed)
        core: Any = env.unwrapped.core
        thing, pick, target, limits = coming(core)
        done, there = throw(thing, pick, target, limits), core.preview(np.zeros((1, 2)), jitter=True).landing[0]
        miss, apart = (1000 * np.linalg.norm(done.landing - place) for place in (target[:2], there))
        print(
            f"{1000 * thing.mass:.0f} g: release after {1000 * done.plan.distance:.0f} mm at {done.plan.speed:.2f} m/s"
            f", lands {miss:.0f} mm from the target and {apart:.2f} mm from the landing of the suite"
        )
