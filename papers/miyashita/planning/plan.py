"""The plan of one throw as the spline motion with the largest margins (Miyashita et al., section 4)."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import chain
from types import ModuleType
from typing import Final, Literal, NamedTuple, final, get_args

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.errors import PlanningError
from pnt_gym.planning.one_joint.batch import plan_releases
from pnt_gym.planning.one_joint.family import Objective
from pnt_gym.planning.one_joint.feasibility import ThrowReason, UnreachableGoal, arm_radius
from pnt_gym.planning.one_joint.landing import four_columns, release_states, release_states_batch
from pnt_gym.planning.one_joint.margins import margin_units, motion_margins
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.parameters import Arm, Block
from pnt_gym.planning.one_joint.shapes import INTERVALS
from pnt_gym.planning.one_joint.weights import WeightName, weights_of

from .programme import LEAST, Programme, Throw, Weighing

Guesses = Literal["family", "random"]

PLACES: Final = (2, 5, 5, 12)
"""Places per interval at which limits are kept; the next number where a solution violates a limit at 1 kHz."""
FEW: Final = 2
"""Number of places above which a retry also raises the least margin by the violation between the places."""
MORE_STARTS: Final = 12
"""Number of further first guesses while no guess has led to a motion."""
SWING: Final = 30.0
"""Greatest acceleration of a random first guess's swing backwards [rad/s2]."""
ITERATIONS: Final = 150
PRECISION: Final = 1e-7


class _Solution(NamedTuple):
    """A motion that keeps every limit at 1 kHz."""

    motion: ArmMotion
    margins: Floats
    cost: float
    message: str


@final
@dataclass(frozen=True, eq=False)
class ThrowPlan:
    """One planned throw.

    Attributes:
        goal: landing state (4,) = x, y [m], phi [rad], dy [m/s].
        u: release (4,) = theta_t [rad], omega_t [rad/s], l_t [m], t_f [s].
        radius: r of the block along the arm [m].
        motion: motion of the arm, one row.
        margins: smallest margins at 1 kHz (6,), as shares.
        delta: smallest margins in [N, N m, N m, rad, rad/s, N m], with Delta M_A negative (Eq. 27).
        cost: value that the solver minimised.
        starts: number of first guesses.
        solved: number of first guesses that led to a motion within every limit.
        iterations: iterations of the solver over all first guesses.
        message: the solver's message on the returned motion.
    """

    goal: Floats
    u: Floats
    radius: float
    motion: ArmMotion
    margins: Floats
    delta: Floats
    cost: float
    starts: int
    solved: int
    iterations: int
    message: str


def plan_throw(
    goal: ArrayLike,
    *,
    arm: Arm | None = None,
    block: Block | None = None,
    weights: WeightName | ArrayLike = "balanced",
    objective: Objective = "squares",
    static_start: bool = True,
    guesses: Guesses = "family",
    starts: int = 2,
    seed: int = 0,
) -> ThrowPlan:
    """Return the throw to a goal whose motion keeps the largest margins.

    The objective is not concave, so SLSQP, a sequential quadratic programme as in the paper, finds the best motion near
    its first guess. The first guesses are the best motions of the family in `batch`, for the given objective and for
    the smallest margin, and then random motions. The best solution is returned. Without a solution, further random
    guesses follow.

    Args:
        goal: landing state x, y [m], phi [rad], dy [m/s].
        arm: the arm; the paper's arm when not given.
        block: the block; the paper's block when not given.
        weights: a name or six numbers, for the objective "squares" (Eq. 28).
        objective: "squares", or "max_min" to maximise the smallest margin of grasp and torque.
        static_start: whether the block must rest by itself before the throw.
        guesses: "random" leaves the family out, as the paper does.
        starts: number of first guesses.
        seed: seed of the random guesses.

    Raises:
        UnreachableGoal: no release reaches the goal, or no motion from rest leads to a release.
        ValueError: the goal is not four finite numbers, or an option is unknown.
    """
    target = four_columns(goal, "goal")
    if target.shape != (4,):
        raise PlanningError(f"goal must have shape (4,), got {target.shape}; plan_throws takes many")
    _check_options(objective, guesses, starts)
    arm, block = arm or Arm(), block or Block()
    weighing = Weighing(objective, weights_of(weights))
    u = _find_release(target, arm, block)
    radius = float(arm_radius(u, block.half_height))
    throw = Throw(float(u[0]), float(u[1]), radius)
    family = _family_guesses(u, arm, block, weighing, static_start) if guesses == "family" else iter(())
    programme = partial(Programme, throw, arm, block, weighing, static_start=static_start)
    solutions, attempts, iterations = _collect_solutions(
        chain(family, _random_guesses(arm, seed)), partial(_attempt_solve, programme), starts
    )
    if not solutions:
        raise UnreachableGoal(target, (f"{ThrowReason.NO_MOTION.sentence} ({attempts} first guesses)",))
    best = min(solutions, key=lambda solution: solution.cost)
    newton = best.margins * margin_units(arm, block)
    counts = (attempts, len(solutions), iterations)
    return ThrowPlan(target, u, radius, best.motion, best.margins, newton, best.cost, *counts, best.message)


def _collect_solutions(
    guesses: Iterator[Floats], attempt: Callable[[Floats], tuple[_Solution | None, int]], starts: int
) -> tuple[list[_Solution], int, int]:
    """Solutions from ``starts`` first guesses (more while none succeeds), number of guesses, and solver iterations."""
    solutions: list[_Solution] = []
    attempts = iterations = 0
    for accelerations in guesses:
        if attempts >= (starts if solutions else starts + MORE_STARTS):
            break
        solution, count = attempt(accelerations)
        attempts, iterations = attempts + 1, iterations + count
        solutions += [solution] if solution else []
    return solutions, attempts, iterations


def _check_options(objective: str, guesses: str, starts: int) -> None:
    for name, value, kind in (
        ("objective", objective, Objective),
        ("guesses", guesses, Guesses),
    ):
        if value not in get_args(kind):
            raise PlanningError(f"{name} is {value!r}; it must be {' or '.join(map(repr, get_args(kind)))}")
    if starts < 1:
        raise PlanningError(f"starts is {starts}; it must be at least 1")


def _find_release(goal: Floats, arm: Arm, block: Block) -> Floats:
    """The feasible release without an extra turn (Eq. 29).

    Raises:
        UnreachableGoal: no such release exists; the reasons belong to the releases without extra turns.
    """
    releases = release_states_batch(goal[None], arm=arm, block=block)
    if releases.feasible[0]:
        return releases.u[0]
    all_releases = release_states(goal, block.half_height, arm=arm, block=block)
    why = [
        ", ".join(reasons)
        for reasons, turns in zip(all_releases.reasons, all_releases.turns, strict=True)
        if turns == 0
    ]
    raise UnreachableGoal(goal, tuple(why) or (ThrowReason.NO_RELEASE.sentence,))


def _family_guesses(u: Floats, arm: Arm, block: Block, weighing: Weighing, static_start: bool) -> Iterator[Floats]:
    """Accelerations at the borders (n + 1,) of the best motions of the family."""
    for objective in dict.fromkeys((weighing.objective, "max_min")):
        plans = plan_releases(
            u[None], arm=arm, block=block, objective=objective, weights=weighing.weights, static_start=static_start
        )
        if plans.feasible[0]:
            yield _accelerations(plans.motion)


def _random_guesses(arm: Arm, seed: int) -> Iterator[Floats]:
    """Random accelerations at the borders (n + 1,), half of them with a swing backwards at first."""
    generator = np.random.default_rng(seed)
    strongest = arm.torque / arm.inertia
    while True:
        shape = strongest * generator.uniform(0.1, 0.9) * generator.uniform(0.5, 1.5, INTERVALS + 1)
        swing = int(generator.integers(1, INTERVALS - 1)) if generator.random() < 0.5 else 0
        shape[:swing] = -generator.uniform(0.0, SWING)
        yield shape


def _accelerations(motion: ArmMotion) -> Floats:
    """Accelerations at the borders (n + 1,): second differences of the control points over Delta t^2."""
    return np.diff(motion.knots[0], 2) / motion.time_step[0] ** 2


def _attempt_solve(make_programme: Callable[..., Programme], accelerations: Floats) -> tuple[_Solution | None, int]:
    """Solve from a first guess, with limits at more places and larger margins while the check at 1 kHz fails.

    Returns:
        The motion, or None, and the solver's iterations.
    """
    iterations, least = 0, LEAST
    for places in PLACES:
        programme = make_programme(per_interval=places, least=least)
        x, cost, success, count, message = solve(programme, programme.start(accelerations))
        iterations += count
        if not success:
            break
        motion = programme.motion(x)
        margins = motion_margins(motion, np.array([programme.throw.radius]), programme.arm, programme.block)[0]
        if (margins > 0.0).all():
            return _Solution(motion, margins, cost, message), iterations
        accelerations = _accelerations(motion)
        least += max(-2.0 * float(margins.min()), LEAST) if places > FEW else 0.0
    return None, iterations


def solve(programme: Programme, start: Floats) -> tuple[Floats, float, bool, int, str]:
    """X of a programme by SLSQP from a first guess (K,), its cost, whether x is a solution, iterations, and message."""
    optimize: ModuleType = importlib.import_module("scipy.optimize")

    # scipy calls the values and the Jacobian of the constraints in turn at the same x, so the last pair is kept.
    @lru_cache(maxsize=1)
    def constraints(place: bytes) -> tuple[Floats, Floats]:
        return programme.constraints(np.frombuffer(place))

    def values(x: Floats) -> Floats:
        return constraints(x.tobytes())[0]

    def jacobian(x: Floats) -> Floats:
        return constraints(x.tobytes())[1]

    result = optimize.minimize(
        programme.cost,
        start,
        jac=True,
        method="SLSQP",
        bounds=programme.bounds(),
        constraints=[{"type": "ineq", "fun": values, "jac": jacobian}],
        options={"maxiter": ITERATIONS, "ftol": PRECISION},
    )
    x = np.asarray(result.x, dtype=np.float64)
    feasible = bool(values(x).min() > -PRECISION)
    return x, float(result.fun), bool(result.success) and feasible, int(result.nit), str(result.message)
