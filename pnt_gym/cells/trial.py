"""Planned cycles tried out in the conveyor cell's physics: any hand path, any pick, any target, any item.

The cell draws its picks and plans their throws; here both are given, and the plant only says what comes of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.cells.context import Context
from pnt_gym.cells.items import item_arrays
from pnt_gym.cells.objects import NORMALS, UNIFORMS, Objects, objects_from_draws
from pnt_gym.cells.outcome import Flight, Simulated, lies_in
from pnt_gym.cells.plant import ConveyorPlant
from pnt_gym.cells.scene import CUP_LENGTH
from pnt_gym.config import CellConfig, load
from pnt_gym.engine import mujoco
from pnt_gym.errors import PntGymError
from pnt_gym.planning.arrays import Bools, Floats, Ints, finite_points, finite_rows, length, same_count
from pnt_gym.planning.ballistics import flight_time
from pnt_gym.planning.plan import MIN_REACH, ReleaseBatch
from pnt_gym.planning.trajectory import HandPath
from pnt_gym.planning.workspace import EllipticWorkspace
from pnt_gym.robots.t3kr.geometry import T3KR

OPENING: Final = (0.24, 0.235)
"""Inner opening of the sorting box along x and y in the levels `ideal` and `nominal` [m]."""
BELT_HEIGHT: Final = T3KR.z_min - 0.20
"""The belt is out of the way [m], so that no row depends on another's object; at its usual place under the object it
moves a landing by less than 0.001 mm."""
REST: Final = 1e-6
"""A hand slower than this [m/s] puts its object down; a faster one throws it."""
AGREEMENT: Final = 1e-4
"""Path and plan may differ by this at pick and release [m] or [m/s]."""
CLEAR_AFTER: Final = 0.020
"""Cup and object part at the release; their distance counts from this long after it [s]."""
CLEAR_UNTIL: Final = 0.250
"""By then the object is far from the cup [s]."""
SAMPLING: Final = 0.002
"""Tracking, clearance and workspace are looked at this often [s]."""


@final
@dataclass(frozen=True, eq=False)
class Trials:
    """N cycles as the simulator measured them.

    A thrown object lands where it comes down through the target's height (see `Outcome.landing`), one that is put
    down (released at rest) where it is let go: both are points of its centre of mass.
    """

    landing: Floats
    """x, y (N, 2) [m]."""
    landing_error: Floats
    """Distance of the landing from the target (N,) [m]."""
    landing_along: Floats
    """Landing from the target, along the line from pick to target (N,) [m]."""
    landing_across: Floats
    """Landing from the target, to the left of that line (N,) [m]."""
    in_opening: Bools
    """The landing lies inside the opening (N,)."""
    in_bin: Bools
    """At the end the object lies in the bin for good (N,)."""
    recontact: Bools
    """The cup touched the object after the release (N,)."""
    clearance: Floats
    """Smallest distance of cup and object from 20 ms after the release on (N,) [m]; 0 where they touched. Takes the
    object to go on turning as at its release."""
    peak_torque: Floats
    """Largest motor torque (N,) [N m]."""
    release_tracking: Floats
    """Distance of the hand from its reference at the release (N,) [m]."""
    path_tracking: Floats
    """Largest distance of the hand from its reference on the whole path (N,) [m]."""
    delay: Floats
    """Release later than commanded by this (N,) [s]."""
    final: Floats
    """Centre of mass at the end (N, 3) [m]."""

    def __len__(self) -> int:
        return int(self.landing_error.shape[0])


def run_trials(
    picks: ArrayLike,
    targets: ArrayLike,
    items: Sequence[str],
    path: HandPath,
    release_time: ArrayLike,
    release_position: ArrayLike,
    release_velocity: ArrayLike,
    *,
    mismatch: float,
    timestep: float = 0.0004,
    seed: int | Sequence[int] = 0,
    threads: int = 1,
    opening: tuple[float, float] = OPENING,
) -> Trials:
    """Execute planned cycles with the closed-chain robot, N side by side.

    Picks, targets and path are those of the planner's point mass: the object's centre of mass at mismatch 0, the cup
    tip at mismatch 1. Each target is the centre of a bin's opening. A row's result does not depend on the others.

    Args:
        picks: where the hand starts at rest, object under the cup (N, 3) [m].
        targets: where the objects are to land or are put down (N, 3) [m], all at one height.
        items: name of each object in the catalogue (N,).
        path: N paths of the hand.
        release_time: when the valve is commanded (N,) [s].
        release_position: where the hand then is (N, 3) [m].
        release_velocity: how fast it then moves (N, 3) [m/s]; zero where the object is put down.
        mismatch: strength of all unmodelled effects, 0 (the planner's own world) to 3.
        timestep: physics step [s].
        seed: of the objects' hidden values; row i has its own generator of seed + i, or of seed[i].
        threads: worker threads of the physics; results do not depend on it.
        opening: inner size of the bins along x and y [m].

    Raises:
        PntGymError: shapes disagree, an item is unknown, path and plan contradict each other, a number is out of range,
            or the hand leaves the workspace.
        PhysicsError: the engine warned, or stopped a simulation.
    """
    try:
        pick, target = finite_points(picks, "picks"), finite_points(targets, "targets")
        _check_counts(len(pick), targets=len(target), items=len(items), path=len(path.duration))
        release = _release(pick, target, release_time, release_position, release_velocity)
    except ValueError as error:
        raise PntGymError(str(error)) from None
    _check_plan(pick, target, release, path)
    config = _config(target, items, mismatch, timestep, opening)
    objects = _objects(config, items, _seeds(seed, len(pick)))
    context = _context(config, objects, pick, target, release, opening)
    plant = ConveyorPlant(config, len(pick), threads)
    simulated = plant.fly(context, release, release.time, path)
    return _judge(plant, context, release, path, simulated)


def _check_counts(rows: int, **others: int) -> None:
    if rows == 0:
        raise PntGymError("picks holds no row; give at least one")
    for name, count in others.items():
        same_count("picks", rows, name, count)


def _release(pick: Floats, target: Floats, time: ArrayLike, position: ArrayLike, velocity: ArrayLike) -> ReleaseBatch:
    """The planned releases; an object put down, or let go below the target and falling, has no flight."""
    count = len(pick)
    point, speed = finite_points(position, "release_position"), finite_points(velocity, "release_velocity")
    _check_counts(count, release_position=len(point), release_velocity=len(speed))
    rate = length(speed)
    flat = np.sqrt(speed[:, 0] ** 2 + speed[:, 1] ** 2)
    nothing, never = np.zeros(count), np.zeros(count, dtype=np.bool_)
    return ReleaseBatch(
        position=point,
        velocity=speed,
        direction=speed / np.where(rate > 0.0, rate, 1.0)[:, None],
        speed=rate,
        acceleration=nothing,
        angle=np.arctan2(speed[:, 2], flat),
        azimuth=np.arctan2(speed[:, 1], speed[:, 0]),
        distance=length(point - pick),
        time=finite_rows(time, count, "release_time"),
        flight_time=np.nan_to_num(flight_time(point, speed, target[:, 2])),
        ceiling_active=never,
        workspace_active=never,
        feasible=~never,
        reason=np.zeros(count, dtype=np.int64),
        straight=never,
    )


def _check_plan(pick: Floats, target: Floats, release: ReleaseBatch, path: HandPath) -> None:
    """Raise PntGymError unless pick, release and path belong together and the robot reaches them."""
    reach = length((target - pick) * np.array([1.0, 1.0, 0.0]))
    if not (reach > MIN_REACH).all():
        raise PntGymError(f"row {np.argmin(reach)}: pick and target lie above one another; they must be apart")
    outside = (release.time < 0.0) | (release.time > path.duration)
    if outside.any():
        row = int(np.argmax(outside))
        span = f"the path lasts from 0 to {path.duration[row]:.4f} s"
        raise PntGymError(f"row {row}: release_time is {release.time[row]:.4f} s, but {span}")
    at = path.sample(np.stack([np.zeros_like(release.time), release.time], axis=1))
    _check_same("starts at", at.position[:, 0], "pick", pick)
    _check_same("is at the release at", at.position[:, 1], "release_position", release.position)
    _check_same("has at the release the velocity", at.velocity[:, 1], "release_velocity", release.velocity)
    times = np.arange(0.0, float(path.duration.max()) + SAMPLING, SAMPLING)
    hand = path.sample(times).position
    workspace = EllipticWorkspace(T3KR.workspace_x, T3KR.workspace_y, T3KR.z_min, T3KR.z_max)
    left = workspace.margin(hand) < -AGREEMENT
    if left.any():
        row, sample = (int(i) for i in np.argwhere(left)[0])
        what = "pick" if sample == 0 else "path"
        size = f"|x| / {T3KR.workspace_x}, |y| / {T3KR.workspace_y} elliptic, z from {T3KR.z_min} to {T3KR.z_max} m"
        raise PntGymError(f"row {row}: the {what} at {_point(hand[row, sample])} lies outside the workspace ({size})")


def _check_same(does: str, found: Floats, name: str, expected: Floats) -> None:
    wrong = length(found - expected) > AGREEMENT
    if wrong.any():
        row = int(np.argmax(wrong))
        raise PntGymError(f"row {row}: the path {does} {_point(found[row])}, but {name} is {_point(expected[row])}")


def _point(values: Floats) -> str:
    return "(" + ", ".join(f"{value:.4f}" for value in values) + ")"


def _config(
    target: Floats, items: Sequence[str], mismatch: float, timestep: float, opening: tuple[float, float]
) -> CellConfig:
    """A cell with these items and a bin of its own for every row."""
    height = target[:, 2]
    if height.max() - height.min() > AGREEMENT:
        raise PntGymError(f"targets lie at heights from {height.min()} to {height.max()} m; they must share one")
    x, y = target[:, 0], target[:, 1]
    bins = {
        "rim": float(height[0]),
        "random": {
            "x": (float(x.min()), float(x.max())),
            "y": (float(y.min()), float(y.max())),
            "side": (min(opening), max(opening)),
        },
    }
    level = {"name": "trial", "items": tuple(dict.fromkeys(items)), "belt": {"height": BELT_HEIGHT}, "bins": bins}
    return load(level, mismatch=mismatch, timestep=timestep)


def _seeds(seed: int | Sequence[int], count: int) -> list[int]:
    seeds = [seed + row for row in range(count)] if isinstance(seed, int | np.integer) else list(seed)
    if len(seeds) != count:
        raise PntGymError(f"seed has {len(seeds)} values but picks has {count} rows; give one each, or one number")
    if min(seeds) < 0:
        raise PntGymError(f"seed must not be negative, got {min(seeds)}")
    return seeds


def _objects(config: CellConfig, items: Sequence[str], seeds: list[int]) -> Objects:
    """One object per row, of the kind asked for; its other draws come from its own generator."""
    generators = [np.random.default_rng(seed) for seed in seeds]
    normals = np.stack([g.standard_normal(NORMALS) for g in generators])
    uniforms = np.stack([g.random(UNIFORMS) for g in generators])
    index = np.array([config.items.index(name) for name in items])
    uniforms[:, 0] = (index + 0.5) / len(config.items)
    return objects_from_draws(normals, uniforms, config, item_arrays(config.item_list()))


def _context(
    config: CellConfig,
    objects: Objects,
    pick: Floats,
    target: Floats,
    release: ReleaseBatch,
    opening: tuple[float, float],
) -> Context:
    count = len(pick)
    return Context(
        objects=objects,
        pick=pick,
        target=target,
        opening=np.tile(np.array(opening, dtype=np.float64), (count, 1)),
        bin=np.zeros(count, dtype=np.int64),
        percent=objects.percent,
        plan=release,
        belt_speed=config.belt.speed,
        ceiling=np.full(count, np.inf),
        belt_shift=objects.belt_error * (pick[:, 0] - config.belt.camera_x),
    )


def _judge(
    plant: ConveyorPlant, context: Context, release: ReleaseBatch, path: HandPath, simulated: Simulated
) -> Trials:
    flight, target, bins = simulated.flight, context.target, plant.config.bins
    let_go = flight.position[np.arange(len(target)), flight.release_step]
    placed = release.speed < REST
    landing = np.where(placed[:, None], let_go[:, :2], flight.landing(target[:, 2]))
    miss = landing - target[:, :2]
    along, across = context.to_throw_frame(miss)
    position, velocity = flight.final()
    recontact = flight.recontact()
    return Trials(
        landing=landing,
        landing_error=np.sqrt(along**2 + across**2),
        landing_along=along,
        landing_across=across,
        in_opening=np.asarray((np.abs(miss) <= context.opening / 2).all(axis=1)),
        in_bin=lies_in(position, velocity, target[:, :2], context.opening, bins.rim, bins.rim - bins.depth),
        recontact=recontact,
        clearance=np.where(recontact, 0.0, _clearance(plant, context, simulated)),
        peak_torque=simulated.peak_torque,
        release_tracking=simulated.tracking_error,
        path_tracking=_path_tracking(plant, context, path, simulated),
        delay=context.objects.delay,
        final=position,
    )


def _path_tracking(plant: ConveyorPlant, context: Context, path: HandPath, simulated: Simulated) -> Floats:
    """Largest distance of the hand from its reference (N,) [m]."""
    step = plant.config.timestep
    steps = np.arange(0, simulated.hand.shape[1], max(round(SAMPLING / step), 1), dtype=np.int64)
    planned = path.sample(steps * step + simulated.start[:, None]).position + context.cup_offset[:, None]
    error = length(simulated.hand[:, steps] - planned)
    return np.where(steps <= simulated.flight.last_step[:, None], error, 0.0).max(axis=1)


def _clearance(plant: ConveyorPlant, context: Context, simulated: Simulated) -> Floats:
    """Smallest distance of cup and object while the object falls away (N,) [m]."""
    model, data = plant.scene.model, mujoco.MjData(plant.scene.model)
    cup, thing = model.geom("cup").id, plant.scene.object_geom
    data.geom_xmat[cup] = np.eye(3).ravel()
    found = np.full(len(context.pick), np.inf)
    for row in range(len(found)):
        own = plant.batch.get_model(row)
        turn, steps = _turning(simulated.flight, context, row, plant.config.timestep)
        for rotation, step in zip(turn, steps, strict=True):
            data.geom_xpos[cup] = simulated.hand[row, step] + np.array([0.0, 0.0, CUP_LENGTH / 2])
            data.geom_xpos[thing] = simulated.flight.position[row, step] + rotation @ own.geom_pos[thing]
            data.geom_xmat[thing] = (rotation @ _matrix(own.geom_quat[thing])).ravel()
            gap = float(mujoco.mj_geomDistance(own, data, cup, thing, 0.5, None))
            found[row] = min(found[row], max(gap, 0.0))
    return found


def _turning(flight: Flight, context: Context, row: int, timestep: float) -> tuple[Floats, Ints]:
    """Rotation matrices (K, 3, 3) of one object and the steps (K,) they belong to, while its clearance counts."""
    first = int(flight.release_step[row])
    ends = min(first + round(CLEAR_UNTIL / timestep), int(flight.last_step[row]) + 1)
    steps = np.arange(first + round(CLEAR_AFTER / timestep), ends, max(round(SAMPLING / timestep), 1), dtype=np.int64)
    yaw = np.array([0.0, 0.0, float(context.objects.yaw[row])])
    turn = [_turned(context.objects.spin[row] * (step - first) * timestep) @ _turned(yaw) for step in steps]
    return np.array(turn), steps


def _turned(rotation: Floats) -> Floats:
    """Matrix (3, 3) of a rotation vector [rad]."""
    angle = float(np.linalg.norm(rotation))
    quat = np.zeros(4)
    mujoco.mju_axisAngle2Quat(quat, rotation / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0]), angle)
    return _matrix(quat)


def _matrix(quat: Floats) -> Floats:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quat)
    return matrix.reshape(3, 3)
