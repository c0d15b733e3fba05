"""The minimum-time throw in a free direction, planned as one motion from pick to next pick.

One programme optimises five legs: throw, window, clearing (until hand and falling object are apart), return, and
vertical approach. Release point, release velocity and flight time are unknowns like the motion. The straight throw of
Hassan et al. 2022 is one of the programme's feasible motions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, NamedTuple, final

import numpy as np

from benchmarks.studies.legs import Leg, add_leg, add_rest, hermite, join, keep_inside, set_guess, solve
from papers.choe.planning.casadi_module import load_casadi
from pnt_gym.arrays import Floats, Point, vector
from pnt_gym.constants import GRAVITY
from pnt_gym.errors import PlanningError, PntGymError
from pnt_gym.planning.free.rules import HandRules
from pnt_gym.planning.motion.limits import MotionLimits
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.trajectory import JerkTrajectory
from pnt_gym.planning.straight.frame import Frame

ROUNDING: Final = 1e-9
"""Excess of a height over a bound that counts as rounding [m]."""
INTERVALS: Final = {"throw": 28, "clearing": 16, "return": 30, "approach": 10}
"""Intervals of constant jerk per leg; twice as many intervals gain less than 0.5 %."""
ITERATIONS: Final = 300
"""Most iterations of a solve."""
STARTS: Final = ((0.62, 1.0), (0.74, 1.0), (0.35, 0.9))
"""First guesses: elevation of the release velocity [rad] and its share of the speed limit."""


class NoMotionFound(PntGymError):
    """No motion within the bounds exists, or the solver finds none."""


@final
@dataclass(frozen=True, eq=False)
class FreeThrow:
    """One throw in a free direction, from rest at the pick to rest at the next pick.

    Attributes:
        path: the motion of the hand, one row.
        release_time: time of the release [s].
        position: release point (3,) [m].
        velocity: release velocity (3,) [m/s].
        flight_time: time from the release to the target [s].
        legs: duration of each leg by name [s].
    """

    path: JerkTrajectory
    release_time: float
    position: Floats
    velocity: Floats
    flight_time: float
    legs: dict[str, float]

    @property
    def duration(self) -> float:
        """Time from pick to next pick [s]."""
        return float(self.path.duration[0])


class _ThrowTask(NamedTuple):
    pick: Floats
    aim: Floats
    next_pick: Floats
    ceiling: float
    rules: HandRules
    limits: tuple[float, float, float]

    @property
    def roof(self) -> float:
        return self.ceiling + self.rules.hand_cap


def fastest_throw(
    pick: Point,
    target: Point,
    next_pick: Point,
    limits: MotionLimits,
    *,
    ceiling: float,
    rules: HandRules,
) -> FreeThrow:
    """Return the fastest throw that IPOPT finds within limits and rules at all times.

    Args:
        pick: point at which the hand rests with the object (3,) [m].
        target: point at which the object has to land (3,) [m].
        next_pick: point at which the hand comes to rest (3,) [m].
        limits: one set of limits, kept as norms.
        ceiling: greatest height of the release [m], above the pick. After the release the hand stays above the top
            of the approach, or above the middle between pick and ceiling where the middle is lower.
        rules: rules that bind the hand.

    Raises:
        ValueError: an input is not finite, the pick is not below the ceiling, the next pick or the top of its approach
            is above the greatest height of the hand, or one of these points is outside the workspace.
        NoMotionFound: the solver found no throw within all bounds.
        PntGymError: casadi is not installed.
    """
    task = _throw_task(pick, target, next_pick, limits, ceiling, rules)
    throws = [throw for start in STARTS if (throw := _solve(task, *start)) is not None]
    if not throws:
        raise NoMotionFound(
            f"no throw from {task.pick.tolist()} to {task.aim.tolist()} with a release below {ceiling:.3f} m was found "
            f"at a speed limit of {task.limits[0]:.3g} m/s"
        )
    return min(throws, key=lambda throw: throw.duration)


def _throw_task(
    pick: Point,
    target: Point,
    next_pick: Point,
    limits: MotionLimits,
    ceiling: float,
    rules: HandRules,
) -> _ThrowTask:
    first, last = vector(pick, "pick"), vector(next_pick, "next_pick")
    if not np.isfinite(ceiling):
        raise PlanningError(f"ceiling must be finite [m], got {ceiling}")
    if not first[2] < ceiling:
        raise PlanningError(f"pick lies at z = {first[2]:.4g} m; it must lie below the ceiling at {ceiling:.4g} m")
    approach_top = last + np.array([0.0, 0.0, rules.approach])
    roof = ceiling + rules.hand_cap
    for name, point in (("pick", first), ("next_pick", last), ("next_pick + approach", approach_top)):
        if rules.workspace is not None and rules.workspace.margin(point) < -ROUNDING:
            raise PlanningError(f"{name} {point.tolist()} lies outside the workspace")
        if point[2] > roof + ROUNDING:
            raise PlanningError(
                f"{name} lies at z = {point[2]:.4g} m, above ceiling + hand_cap, where the hand may be at most: "
                f"{roof:.4g} m"
            )
    frame = Frame.of(first[None], vector(target, "target")[None], 0.0)
    reach = float(frame.reach[0])
    if reach <= 0.0:
        raise PlanningError(f"target {list(target)} lies at the pick; there is nothing to throw")
    aim = first + np.array([reach * frame.cosine[0], reach * frame.sine[0], frame.rise[0]])
    return _ThrowTask(first, aim, last, ceiling, rules, limits.numbers())


def _solve(task: _ThrowTask, elevation: float, share: float) -> FreeThrow | None:
    ca = load_casadi()
    opti: Any = ca.Opti()
    legs = {name: add_leg(opti, INTERVALS[name], task.limits) for name in ("throw", "clearing", "return")}
    line = (task.next_pick[0], task.next_pick[1])
    legs["approach"] = add_leg(opti, INTERVALS["approach"], task.limits, line=line)
    flight = opti.variable()
    _fix_ends(opti, task, legs)
    _add_flight(opti, task, legs, flight)
    _keep_clear(opti, task, legs)
    _bound_heights(opti, task, legs)
    opti.set_initial(flight, _set_first_guess(opti, task, legs, elevation, share))
    solution = solve(opti, legs.values(), ITERATIONS)
    if solution is None:
        return None
    return _read_throw(task, legs, solution, flight)


def _fix_ends(opti: Any, task: _ThrowTask, legs: dict[str, Leg]) -> None:
    """Let the hand rest at both picks, join the legs, and fix the heights of the vertical approach."""
    throw, clearing, back, down = (legs[name] for name in INTERVALS)
    opti.subject_to(throw.position[:, 0] == task.pick)
    add_rest(opti, throw, 0)
    # In the window after the release the velocity is constant.
    opti.subject_to(throw.acceleration[:, -1] == 0)
    window = task.rules.window
    opti.subject_to(clearing.position[:, 0] == throw.position[:, -1] + window * throw.velocity[:, -1])
    opti.subject_to(clearing.velocity[:, 0] == throw.velocity[:, -1])
    opti.subject_to(clearing.acceleration[:, 0] == 0)
    join(opti, clearing, back)
    join(opti, back, down)
    opti.subject_to(down.position[2, 0] == task.next_pick[2] + task.rules.approach)
    opti.subject_to(down.position[2, -1] == task.next_pick[2])
    add_rest(opti, down, -1)


def _add_flight(opti: Any, task: _ThrowTask, legs: dict[str, Leg], flight: Any) -> None:
    """Let the flight from the release end at the aim (Hassan et al. 2022, Eq. 8), with the object falling."""
    throw = legs["throw"]
    start, velocity = throw.position[:, -1], throw.velocity[:, -1]
    fall = np.array([0.0, 0.0, -0.5 * GRAVITY])
    opti.subject_to(start + flight * velocity + fall * flight**2 == task.aim)
    # The object comes down on its target: v_z - g t is not positive there.
    opti.subject_to(velocity[2] <= GRAVITY * flight)
    opti.subject_to(flight >= 0.01)
    opti.subject_to(start[2] <= task.ceiling)


def _keep_clear(opti: Any, task: _ThrowTask, legs: dict[str, Leg]) -> None:
    """Let the hand stay above the falling object by the margin until both are apart sideways.

    The gap z_hand - z_0 - v_z t + (1 - margin) g t^2 / 2 is a cubic in every interval, and its Bernstein coefficients
    are bounded.
    """
    ca = load_casadi()
    throw, clearing, back = legs["throw"], legs["clearing"], legs["return"]
    start, velocity = throw.position[:, -1], throw.velocity[:, -1]
    count, step = INTERVALS["clearing"], clearing.step
    elapsed = task.rules.window + step * np.arange(count + 1)[None]
    share = 0.5 * (1.0 - task.rules.margin) * GRAVITY
    gap = clearing.position[2, :] - start[2] - velocity[2] * elapsed + share * elapsed**2
    slope = clearing.velocity[2, :] - velocity[2] + 2.0 * share * elapsed
    opti.subject_to(gap[:, 1:].T >= 0)
    opti.subject_to((gap[:, 1:-1] + step * slope[:, 1:-1] / 3.0).T >= 0)
    opti.subject_to((gap[:, 1:] - step * slope[:, 1:] / 3.0).T >= 0)
    # Sideways the object flies on with the velocity of its release.
    away = back.position[:2, 0] - start[:2] - velocity[:2] * elapsed[0, -1]
    opti.subject_to(ca.sumsqr(away) >= task.rules.clear_distance**2)


def _bound_heights(opti: Any, task: _ThrowTask, legs: dict[str, Leg]) -> None:
    """Bound the hand by a floor before and a floor after the release, by the roof and by the workspace.

    The floor after the release is the top of the approach, or the middle between pick and ceiling where the middle is
    lower: a hand that releases below the top of the approach could not be above that top at once.
    """
    opti.subject_to(task.pick[2] <= legs["throw"].control_points(2)[:, 1:].T)
    top, middle = task.next_pick[2] + task.rules.approach, 0.5 * (task.pick[2] + task.ceiling)
    low = middle if middle < top - ROUNDING else top
    opti.subject_to(low <= legs["return"].control_points(2)[:, :-1].T)
    opti.subject_to(low <= legs["clearing"].control_points(2).T)
    for name in ("throw", "clearing", "return"):
        if np.isfinite(task.roof):
            opti.subject_to(task.roof >= legs[name].control_points(2).T)
        if task.rules.workspace is not None:
            keep_inside(opti, legs[name], task.rules.workspace)


def _set_first_guess(opti: Any, task: _ThrowTask, legs: dict[str, Leg], elevation: float, share: float) -> float:
    """Set the first guess, cubics over a release at the ceiling, and return the flight time of that release [s]."""
    way = task.aim[:2] - task.pick[:2]
    reach = float(np.sqrt(way @ way))
    height = task.ceiling - task.aim[2]
    speed = share * task.limits[0]
    rise = speed * np.sin(elevation)
    # Time in which an object that leaves the ceiling falls to the height of the aim.
    flight = (rise + np.sqrt(max(rise**2 + 2.0 * GRAVITY * height, 1e-4))) / GRAVITY
    # The release lies between pick and aim: at most nine tenths of the way are flown.
    level = min(speed * np.cos(elevation), 0.9 * reach / flight)
    direction = way / reach
    velocity = np.array([*(level * direction), rise])
    point = np.array([*(task.aim[:2] - level * flight * direction), task.ceiling])
    hover = point + 0.06 * velocity
    approach_top = task.next_pick + np.array([0.0, 0.0, task.rules.approach])
    zero, falling = np.zeros(3), np.array([0.0, 0.0, -0.3 * speed])
    guesses = {
        "throw": (task.pick, zero, point, velocity),
        "clearing": (point, velocity, hover, zero),
        "return": (hover, zero, approach_top, falling),
        "approach": (approach_top, falling, task.next_pick, zero),
    }
    # Time to full speed: V / A, and A / J for the rise and fall of the acceleration.
    ramp = task.limits[0] / task.limits[1] + task.limits[1] / task.limits[2]
    for name, (first, before, last, after) in guesses.items():
        time = ramp + 1.5 * float(np.sqrt(np.sum((last - first) ** 2))) / task.limits[0]
        path = hermite(first, before, last, after, time, INTERVALS[name])
        set_guess(opti, legs[name], time, path, task.limits)
    return float(flight)


def _read_throw(task: _ThrowTask, legs: dict[str, Leg], solution: Any, flight: Any) -> FreeThrow:
    parts = {name: leg.values(solution) for name, leg in legs.items()}
    window = Segments(np.full((1, 1), task.rules.window), np.zeros((1, 1, 3)))
    path = JerkTrajectory.concatenate(
        task.pick[None], [parts["throw"], window, parts["clearing"], parts["return"], parts["approach"]]
    )
    release = INTERVALS["throw"]
    return FreeThrow(
        path=path,
        release_time=float(path.knot_times[0, release]),
        position=path.knots.position[0, release],
        velocity=path.knots.velocity[0, release],
        flight_time=float(solution.value(flight)),
        legs={"window": task.rules.window, **{name: float(part.durations.sum()) for name, part in parts.items()}},
    )
