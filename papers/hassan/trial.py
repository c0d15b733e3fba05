"""Planned cycles simulated in the conveyor cell's physics: any hand path, any pick, any target, any item.

The conveyor cell draws its picks and plans their throws. A trial gets picks and plans as arguments and only simulates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from pnt_gym.arrays import Bools, Floats, Ints, finite_points, finite_rows, length
from pnt_gym.cells.base.flight import ObjectFlight
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context, ThrowBins
from pnt_gym.cells.conveyor.hand import HandCycle
from pnt_gym.cells.conveyor.objects.drawing import NORMALS, UNIFORMS, objects_from_draws
from pnt_gym.cells.conveyor.outcome import PlannedResults, judge
from pnt_gym.cells.conveyor.plant import ConveyorPlant, FullSimulation
from pnt_gym.cells.conveyor.scene import CUP_LENGTH
from pnt_gym.engine import mujoco
from pnt_gym.errors import PntGymError
from pnt_gym.planning.motion.ballistics import flight_time
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows
from pnt_gym.planning.motion.trajectory import HandPath
from pnt_gym.planning.straight.plan import MIN_REACH, Reason, ReleaseBatch
from pnt_gym.robots.t3kr.geometry import T3KR

OPENING: Final = (0.24, 0.235)
"""Inner opening of the sorting box along x and y in the levels `ideal` and `nominal` [m]."""
BELT_HEIGHT: Final = T3KR.z_min - 0.20
"""Height of the belt in a trial [m], so low that no row depends on the object of another row. A belt at its usual
height under the object moves a landing by less than 0.001 mm."""
REST: Final = 1e-6
"""Release speed [m/s] below which the hand puts its object down and does not throw."""
AGREEMENT: Final = 1e-4
"""Greatest difference of path and plan at pick and release [m] or [m/s]."""
CLEAR_AFTER: Final = 0.020
"""Time after the release from which the distance of cup and object counts [s]; at the release they touch."""
CLEAR_UNTIL: Final = 0.250
"""Time after the release up to which the distance counts [s]; later the object is far from the cup."""
TIMESTEP: Final = 0.0004
"""Physics step [s]: the robot's control rate."""
SAMPLING: Final = 0.002
"""Time step at which tracking, clearance and workspace are checked [s]."""


@final
@dataclass(frozen=True, eq=False)
class Trials:
    """Simulated results of N cycles.

    The landing of a thrown object is the point at which its centre of mass falls through the target's height (see
    `Outcome.landing`). The landing of an object that is put down (released at rest) is its centre of mass at release.
    """

    landing: Floats
    """Landing point x, y (N, 2) [m]."""
    landing_error: Floats
    """Distance of the landing from the target (N,) [m]."""
    landing_along: Floats
    """Landing less target, along the direction from pick to target (N,) [m]."""
    landing_across: Floats
    """Landing less target, to the left of the direction from pick to target (N,) [m]."""
    in_opening: Bools
    """Whether the landing lies inside the opening (N,)."""
    in_bin: Bools
    """Whether the object rests in the bin at the end (N,)."""
    recontact: Bools
    """Whether the cup touched the object after the release (N,)."""
    clearance: Floats
    """Smallest distance of cup and object from 20 ms after the release on (N,) [m]; 0 where they touched. The object
    is assumed to keep its rotation rate of the release."""
    peak_torque: Floats
    """Largest motor torque (N,) [N m]."""
    release_tracking: Floats
    """Distance of the hand from its reference at the release (N,) [m]."""
    path_tracking: Floats
    """Largest distance of the hand from its reference on the whole path (N,) [m]."""
    delay: Floats
    """Time from the release command to the release (N,) [s]."""
    final: Floats
    """Centre of mass of the object at the end (N, 3) [m]."""

    def __len__(self) -> int:
        return int(self.landing_error.shape[0])


@final
class Throws(NamedTuple):
    """N planned cycles of the hand, each with an object to throw or to put down.

    Picks, targets and path are points of the planner's point mass: the object's centre of mass at mismatch 0, the cup
    tip at mismatch 1.
    """

    picks: ArrayLike
    """First points of the hand at rest, with the object under the cup (N, 3) [m]."""
    targets: ArrayLike
    """Centres of the bins' openings (N, 3) [m], all at the same height."""
    items: Sequence[str]
    """Name of each object in the catalogue (N,)."""
    path: HandPath
    """N paths of the hand."""
    release_time: ArrayLike
    """Time of the release command to the valve (N,) [s]."""
    release_position: ArrayLike
    """Position of the hand at the release time (N, 3) [m]."""
    release_velocity: ArrayLike
    """Velocity of the hand at the release time (N, 3) [m/s]; zero where the object is put down."""


def run_trials(throws: Throws, *, mismatch: float, seeds: Sequence[int] | None = None, threads: int = 1) -> Trials:
    """Simulate N planned cycles with the closed-chain robot in one batch; no row depends on other rows.

    Args:
        throws: the cycles.
        mismatch: strength of all unmodelled effects, 0 (the planner's own world) to 3.
        seeds: seeds of each object's hidden values (N,); 0, 1, ... when not given.
        threads: worker threads of the physics, on which results do not depend.

    Raises:
        PntGymError: shapes disagree, an item is unknown, path and plan contradict each other, a number is out of range,
            or the hand leaves the workspace.
        PhysicsError: the engine warned, or stopped a simulation.
    """
    items, path = throws.items, throws.path
    pick, target = finite_points(throws.picks, "picks"), finite_points(throws.targets, "targets")
    seeds = range(len(pick)) if seeds is None else seeds
    _check_counts(len(pick), targets=len(target), items=len(items), path=len(path.duration), seeds=len(seeds))
    release = _release_batch(pick, target, throws)
    _check_plan(pick, target, release, path)
    config = _trial_config(target, items, mismatch)
    context = trial_context(config, items, seeds, pick, target, release)
    plant = ConveyorPlant(config, len(pick), threads)
    followed = plant.follow(context, HandCycle(release, release.time, path))
    return _measure_trials(plant, context, release, path, followed)


def trial_context(
    config: ConveyorConfig,
    items: Sequence[str],
    seeds: Sequence[int],
    pick: Floats,
    target: Floats,
    release: ReleaseBatch,
    ceiling: float = np.inf,
) -> Context:
    """The cell's context for given picks, targets and releases instead of random ones.

    Item ``items[i]`` lies at ``pick[i]``; its other random values come from a generator with the seed ``seeds[i]``.
    No release may lie above ``ceiling`` [m].
    """
    if min(seeds) < 0:
        raise PntGymError(f"seed must not be negative, got {min(seeds)}")
    generators, count = [np.random.default_rng(seed) for seed in seeds], len(pick)
    normals = np.stack([generator.standard_normal(NORMALS) for generator in generators])
    uniforms = np.stack([generator.random(UNIFORMS) for generator in generators])
    index = np.array([config.items.index(name) for name in items])
    # The first uniform draw chooses the item; the middle of an item's share chooses that item despite rounding.
    uniforms[:, 0] = (index + 0.5) / len(config.items)
    objects = objects_from_draws(normals, uniforms, config, item_arrays(config.item_list()))
    return Context.new(
        objects,
        pick,
        ThrowBins(target, np.tile(OPENING, (count, 1)), np.zeros(count, dtype=np.int64)),
        np.full((count, 1), config.bins.depth),
        throw_limits=LimitRows.t3kr(objects.percent),
        plan=release,
        ceiling=np.full(count, ceiling),
        belt=config.belt,
    )


def _check_counts(rows: int, **counts: int) -> None:
    if rows == 0:
        raise PntGymError("picks holds no row; give at least one")
    for name, count in counts.items():
        if count != rows:
            raise PntGymError(f"picks has {rows} rows but {name} has {count}; give one row each")


def _release_batch(pick: Floats, target: Floats, throws: Throws) -> ReleaseBatch:
    """The planned releases; an object that is put down, or falls from below the target's height, has no flight."""
    count, point = len(pick), finite_points(throws.release_position, "release_position")
    speed = finite_points(throws.release_velocity, "release_velocity")
    _check_counts(count, release_position=len(point), release_velocity=len(speed))
    zero = np.zeros(count)
    return ReleaseBatch.from_velocities(
        pick,
        point,
        speed,
        speed,
        acceleration=zero,
        time=finite_rows(throws.release_time, count, "release_time"),
        flight_time=np.nan_to_num(flight_time(point, speed, target[:, 2])),
        ceiling_active=zero > 0.0,
        reason=np.full(count, int(Reason.FEASIBLE)),
    )


def _check_plan(pick: Floats, target: Floats, release: ReleaseBatch, path: HandPath) -> None:
    """Raise PntGymError unless pick, release and path agree and lie within the robot's workspace."""
    # The throw's direction is that of its horizontal way, which must not vanish.
    reach = length((target - pick) * np.array([1.0, 1.0, 0.0]))
    if not (reach > MIN_REACH).all():
        raise PntGymError(f"row {np.argmin(reach)}: pick and target lie above one another; they must be apart")
    outside = (release.time < 0.0) | (release.time > path.duration)
    if outside.any():
        row = int(np.argmax(outside))
        span = f"the path lasts from 0 to {path.duration[row]:.4f} s"
        raise PntGymError(f"row {row}: release_time is {release.time[row]:.4f} s, but {span}")
    samples = path.sample(np.stack([np.zeros_like(release.time), release.time], axis=1))
    _check_same("starts at", samples.position[:, 0], "pick", pick)
    _check_same("is at the release at", samples.position[:, 1], "release_position", release.position)
    _check_same("has at the release the velocity", samples.velocity[:, 1], "release_velocity", release.velocity)
    times = np.arange(0.0, float(path.duration.max()) + SAMPLING, SAMPLING)
    hand = path.sample(times).position
    workspace = EllipticWorkspace(T3KR.workspace_x, T3KR.workspace_y, T3KR.z_min, T3KR.z_max)
    is_outside = workspace.margin(hand) < -AGREEMENT
    if is_outside.any():
        row, sample = (int(i) for i in np.argwhere(is_outside)[0])
        place = "pick" if sample == 0 else "path"
        size = f"|x| / {T3KR.workspace_x}, |y| / {T3KR.workspace_y} elliptic, z from {T3KR.z_min} to {T3KR.z_max} m"
        raise PntGymError(
            f"row {row}: the {place} at {_format_point(hand[row, sample])} lies outside the workspace ({size})"
        )


def _check_same(verb: str, actual: Floats, name: str, expected: Floats) -> None:
    differs = length(actual - expected) > AGREEMENT
    if differs.any():
        row = int(np.argmax(differs))
        raise PntGymError(
            f"row {row}: the path {verb} {_format_point(actual[row])}, but {name} is {_format_point(expected[row])}"
        )


def _format_point(values: Floats) -> str:
    return "(" + ", ".join(f"{value:.4f}" for value in values) + ")"


def _trial_config(target: Floats, items: Sequence[str], mismatch: float) -> ConveyorConfig:
    """Configuration of a conveyor cell with these items and a bin at every row's target."""
    low, high = target.min(axis=0), target.max(axis=0)
    if high[2] - low[2] > AGREEMENT:
        raise PntGymError(f"targets lie at heights from {low[2]} to {high[2]} m; they must share one")
    # A bin that is drawn per throw can stand at each row's target, in one model for all rows.
    random = {"x": (low[0], high[0]), "y": (low[1], high[1]), "side": (min(OPENING), max(OPENING))}
    bins = {"rim": target[0, 2], "random": random}
    # The plain level leaves out failed picks, soft cups, neighbours and fillings.
    level = {"name": "trial", "base": "nominal_plain", "items": tuple(dict.fromkeys(items)), "bins": bins}
    level["belt"] = {"height": BELT_HEIGHT}
    return ConveyorConfig.load(level, mismatch=mismatch, timestep=TIMESTEP)


def _measure_trials(
    plant: ConveyorPlant, context: Context, release: ReleaseBatch, path: HandPath, followed: FullSimulation
) -> Trials:
    """Results of the simulated throws as the cell judges them; an object that is put down lands at its release."""
    count, flight = len(release.speed), followed.flight
    accepts = plant.config.acceptance()
    outcome = judge(followed.flown, context, plant.config, accepts, path.duration, PlannedResults.without_belt(count))
    release_point = flight.position[np.arange(count), flight.release_step, :2]
    landing = np.where((release.speed < REST)[:, None], release_point, outcome.landing)
    miss = landing - context.target[:, :2]
    along, across = context.to_throw_frame(miss)
    return Trials(
        landing=landing,
        landing_error=np.sqrt(along**2 + across**2),
        landing_along=along,
        landing_across=across,
        in_opening=np.asarray((np.abs(miss) <= context.opening / 2).all(axis=1)),
        in_bin=outcome.in_bin,
        recontact=outcome.recontact,
        clearance=np.where(outcome.recontact, 0.0, _clearance(plant, context, followed)),
        peak_torque=outcome.peak_torque,
        release_tracking=outcome.tracking_error,
        path_tracking=_path_tracking(plant, context, path, followed),
        delay=context.objects.delay,
        final=outcome.final,
    )


def _path_tracking(plant: ConveyorPlant, context: Context, path: HandPath, followed: FullSimulation) -> Floats:
    """Largest distance of the hand from its reference (N,) [m]."""
    step = plant.config.timestep
    steps = np.arange(0, followed.hand.shape[1], max(round(SAMPLING / step), 1), dtype=np.int64)
    planned = path.sample(steps * step + followed.start[:, None]).position + context.cup_offset[:, None]
    error = length(followed.hand[:, steps] - planned)
    return np.where(steps <= followed.flight.last_step[:, None], error, 0.0).max(axis=1)


def _clearance(plant: ConveyorPlant, context: Context, followed: FullSimulation) -> Floats:
    """Smallest distance of cup and object while the object falls away (N,) [m]."""
    model, data = plant.scene.model, mujoco.MjData(plant.scene.model)
    cup, object_geom = model.geom("cup").id, plant.scene.object_geom
    # The platform stays level, and with it the cup.
    data.geom_xmat[cup] = np.eye(3).ravel()
    clearances = np.full(len(context.pick), np.inf)
    for row in range(len(clearances)):
        row_model = plant.batch.get_model(row)
        turn, steps = _rotations(followed.flight, context, row, plant.config.timestep)
        matrices = (turn * Rotation.from_quat(row_model.geom_quat[object_geom], scalar_first=True)).as_matrix()
        # The record holds the centre of mass; the geom's middle is offset from it in the object's axes.
        centre = followed.flight.position[row, steps] + turn.apply(row_model.geom_pos[object_geom])
        for step, place, matrix in zip(steps, centre, matrices, strict=True):
            # The hand's position is the tip of the cup, half a cup below the cup's middle.
            data.geom_xpos[cup] = followed.hand[row, step] + np.array([0.0, 0.0, CUP_LENGTH / 2])
            data.geom_xpos[object_geom], data.geom_xmat[object_geom] = place, matrix.ravel()
            gap = float(mujoco.mj_geomDistance(row_model, data, cup, object_geom, 0.5, None))
            clearances[row] = min(clearances[row], max(gap, 0.0))
    return clearances


def _rotations(flight: ObjectFlight, context: Context, row: int, timestep: float) -> tuple[Rotation, Ints]:
    """Rotations of one object at K steps after the release, and these steps (K,), while the clearance counts."""
    first = int(flight.release_step[row])
    ends = min(first + round(CLEAR_UNTIL / timestep), int(flight.last_step[row]) + 1)
    steps = np.arange(first + round(CLEAR_AFTER / timestep), ends, max(round(SAMPLING / timestep), 1), dtype=np.int64)
    # The record holds no attitudes, so the rate at the release is kept, about a fixed axis.
    spun = context.objects.spin[row] * ((steps - first) * timestep)[:, None]
    return Rotation.from_rotvec(spun) * Rotation.from_euler("z", float(context.objects.yaw[row])), steps
