"""N objects without the robot: in the engine with bins and belt, and in the air alone without the engine."""

from __future__ import annotations

from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, length, take
from pnt_gym.cells.base.alone import Fall, Vicinity, fall, settle, write_object
from pnt_gym.cells.base.items import rebound
from pnt_gym.cells.base.plant import Touchdown
from pnt_gym.cells.base.sorting import Bins
from pnt_gym.cells.base.stage import ITEM_RGBA
from pnt_gym.cells.conveyor.config import LIP_GAP, ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.swing import body_constants
from pnt_gym.cells.conveyor.hand import ThrowClock
from pnt_gym.cells.conveyor.scene import (
    BOTTOM_PANEL,
    Surroundings,
    bin_panels,
    build_free_scene,
    floor_height,
)
from pnt_gym.constants import GRAVITY
from pnt_gym.engine import Batch
from pnt_gym.planning.motion.ballistics import landing_point

NEAR_DISTANCE: Final = 0.02
"""Distance from an opening beyond which an object's landing cannot end in that bin [m]."""

PASSAGE_DEPTH: Final = 0.02
"""Depth below the rim to which an object's highest point is followed without the engine [m]; an object that has come
there untouched stays in its bin in nearly all cases."""
AIR_SHARE: Final = 1.25
"""Time of a passage through an opening over that without air; slower objects are simulated in the engine from there."""


def write_models(batch: Any, rows: Ints, scene: Surroundings, context: Context, config: ConveyorConfig) -> None:
    """Write the objects of N throws, the draught and bins that are drawn per throw into some simulations."""
    o, geom, bins = context.objects, scene.object_geom, config.bins
    if config.drift.draught.moves:
        batch.expand("opt.wind")[rows, :2] = context.drift.draught
    write_object(batch, rows, scene.object_body, geom, o.mass, o.inertia, o.placement, o.fluid)
    batch.expand("geom_pos")[rows, geom, 2] = o.com_depth - LIP_GAP - o.size[:, 2] / 2
    # MuJoCo's order: sliding, torsional [m], rolling [m].
    batch.expand("geom_friction")[rows, geom] = np.stack(
        [o.friction, 0.1 * o.rolling_friction, o.rolling_friction], axis=-1
    )
    batch.expand("geom_solref")[rows, geom] = o.solref
    batch.expand("geom_rgba")[rows, geom] = ITEM_RGBA.take(o.kind, axis=0, mode="wrap")
    if bins.random is not None:
        _place_bin(batch, rows, scene, context, bins)
    if bins.emptied is not None:
        _raise_bottoms(batch, rows, scene, context, bins)


def _place_bin(batch: Any, rows: Ints, scene: Surroundings, context: Context, bins: Bins) -> None:
    half, middle = bin_panels(context.opening, bins)
    batch.expand("body_pos")[rows, scene.bin_bodies[0]] = context.target
    geoms = rows[:, None], scene.bin_geoms[0] + np.arange(5)
    batch.expand("geom_size")[geoms] = half
    batch.expand("geom_pos")[geoms] = middle
    batch.expand("geom_rbound")[geoms] = length(half)
    expanded = batch.expand("geom_aabb")
    aabb = np.concatenate([np.zeros_like(half), half], axis=-1)
    expanded[geoms] = aabb.reshape(len(rows), 5, *expanded.shape[2:])


def _raise_bottoms(batch: Any, rows: Ints, scene: Surroundings, context: Context, bins: Bins) -> None:
    """Move the bottoms of bins to the top of their contents; below its bottom a bin is hollow."""
    place = batch.expand("geom_pos")
    for index, first in enumerate(scene.bin_geoms):
        place[rows, first + BOTTOM_PANEL, 2] = -context.depth[:, index] - bins.wall / 2


@final
class FreeObjects:
    """N objects without the robot.

    Args:
        config: the cell.
        count: number of simulations N.
        threads: worker threads; results do not depend on it.
    """

    def __init__(self, config: ConveyorConfig, count: int, threads: int) -> None:
        self._config = config
        self._scene = build_free_scene(config)
        self._ground = np.array([floor_height(config), config.belt.height, *config.belt.x, *config.belt.y])
        self.batch = Batch(self._scene.model, nsim=count, nthread=threads)

    def fall(self, rows: Ints, context: Context, qpos: Floats, qvel: Floats, steps: Ints) -> Fall:
        """Simulate N objects in the engine, in some of the simulations, from states qpos (N, 7) and qvel (N, 6).

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """
        self._write(rows, context, qpos, qvel)
        return fall(self.batch, rows, self._scene.object_body, steps, context.target[:, 2], self._config.timestep)

    def predict_landings(self, context: Context, clock: ThrowClock) -> tuple[Touchdown, Bools]:
        """Landings of N objects after planned releases, and which objects the cup touches again (N,).

        An object that crosses the rim's height near an opening flies on until it may touch a rim or a wall, or is sure
        to stay in the bin; from a possible touch on it is simulated in the engine. An object that is sure to stay
        where it is counts as lying where it was judged, and an object that misses all openings where it crosses the
        rim's height.

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """
        count, stride, step, rim = len(context.pick), clock.stride, clock.step, context.target[:, 2].copy()
        state, body, length = _release_states(clock), body_constants(context), int((clock.end - clock.release).max())
        records, steps = self._fly(state, body, context, rim, length // stride + 2, stride)
        # The last step undone: semi-implicit Euler moves by the velocity at the step's end.
        before = state[:, :3] - step * state[:, 7:10], state[:, 7:10] + np.array([0.0, 0.0, GRAVITY * step])
        landing = landing_point(*before, rim)[:, :2]
        landing = np.where(np.isfinite(landing), landing, state[:, :2])
        position = np.concatenate([landing, rim[:, None]], axis=1)
        velocity = np.zeros_like(position)
        touched = clock.meets(context, (records[..., :3], records[..., 7:10], records[..., 3:7]), steps)
        rows = np.flatnonzero(self._near(context, landing) & ~touched)
        if rows.size > 0:
            radius = farthest_points(context)
            first = _last_moment_above(context.target[:, 2] + radius, records[..., 2])[rows]
            remaining = (clock.end - clock.release)[rows] - first * stride
            vicinity = self._vicinity(take(context, rows), body[rows], radius[rows])
            position[rows], velocity[rows] = self._land(
                rows, take(context, rows), body[rows], vicinity, records[rows, first], remaining
            )
        return Touchdown(landing, position, velocity, np.zeros(count, dtype=np.bool_)), touched

    def _fly(
        self, state: Floats, body: Floats, context: Context, floor: Floats, length: int, stride: int
    ) -> tuple[Floats, Ints]:
        """Let N objects fly on from states (N, STATE), overwritten, until they sink below heights `floor` (N,) [m].

        Returns the states every `stride` steps (N, `length`, STATE), and the numbers of steps (N,).
        """
        from pnt_gym.cells.base.freefall import STATE, fly_down  # noqa: PLC0415 - compiles, where nothing is kept

        records, steps = np.empty((len(state), length, STATE)), np.empty(len(state), dtype=np.int64)
        air, wind = self._config.mismatch, context.drift.draught
        fly_down(state, body, wind, floor, air, self._config.timestep, stride, records, steps)
        return records, steps

    def _land(
        self, rows: Ints, context: Context, body: Floats, vicinity: Vicinity, state: Floats, steps: Ints
    ) -> tuple[Floats, Floats]:
        """Last positions [m] and velocities [m/s] (K, 3) of objects near bins.

        Args:
            rows: the simulations of the K objects.
            context: the K picks.
            body: constants of the objects (K, BODY).
            vicinity: the objects and what they may meet.
            state: states entirely above the rims (K, STATE).
            steps: number of steps until each throw ends (K,).
        """
        from pnt_gym.cells.base.settle_kernel import follow_to_contact  # noqa: PLC0415 - compiles

        step = self._config.timestep
        floor = vicinity.rim - vicinity.solid[:, -1] - PASSAGE_DEPTH
        length = _passage_steps(state, floor, step)
        records, counts = self._fly(state.copy(), body, context, floor, length, 1)
        last, certain = np.empty_like(counts), np.empty(len(rows), dtype=np.bool_)
        follow_to_contact(records, counts, *vicinity, steps, step, last, certain)
        state = records[np.arange(len(rows)), last]
        position, velocity, unsure = state[:, :3].copy(), np.zeros((len(rows), 3)), np.flatnonzero(~certain)
        if unsure.size > 0:
            falling, start = rows[unsure], state[unsure]
            self._write(falling, take(context, unsure), start[:, :7], start[:, 7:])
            remaining = (steps - last)[unsure]
            position[unsure], velocity[unsure] = settle(self.batch, falling, take(vicinity, unsure), remaining, step)
        return position, velocity

    def _write(self, rows: Ints, context: Context, qpos: Floats, qvel: Floats) -> None:
        """Set up some of the simulations with the objects of N picks in states qpos (N, 7) and qvel (N, 6)."""
        batch = self.batch
        write_models(batch, rows, self._scene, context, self._config)
        batch.set_const(rows)
        batch.state[rows] = 0.0
        batch.bind("qpos")[rows], batch.bind("qvel")[rows] = qpos, qvel

    def _vicinity(self, context: Context, body: Floats, radius: Floats) -> Vicinity:
        """What N objects may meet, with their bodies (N, BODY) and farthest points (N,) [m]."""
        o, fixed, count = context.objects, self._config.bins.fixed, len(radius)
        bins = np.empty((count, max(len(fixed), 1), 5))
        openings = [(b.x, b.y, b.size[0] / 2.0, b.size[1] / 2.0) for b in fixed]
        drawn = np.concatenate([context.target[:, :2], context.opening / 2.0], axis=1)[:, None]
        bins[..., :4] = np.array(openings) if openings else drawn
        bins[..., 4] = context.depth
        shape, mass, middle = o.shape[:, None], body[:, :1], body[:, 4:5]
        columns = shape, o.extents / 2.0, middle, body[:, 1:4] / mass, rebound(o.solref)[:, None], radius[:, None]
        ground = np.tile(self._ground, (count, 1))
        return Vicinity(np.concatenate(columns, axis=1), bins, context.target[:, 2].copy(), ground)

    def _near(self, context: Context, landing: Floats) -> Bools:
        """Which landings (N, 2) are near the opening of the throw's bin, or of any fixed one (N,)."""
        bins = [(context.target[:, :2], context.opening)]
        bins += [(np.array([b.x, b.y]), np.array(b.size)) for b in self._config.bins.fixed]
        near = [(np.abs(landing - centre) <= size / 2.0 + NEAR_DISTANCE).all(axis=1) for centre, size in bins]
        return np.any(near, axis=0)


def farthest_points(context: Context) -> Floats:
    """Largest distance of a point of each object from its centre of mass (N,) [m]."""
    full, depth = context.objects.extents, context.objects.com_depth
    # Half the diagonal plus the offset.
    return length(full) / 2.0 + np.abs(depth - full[:, 2] / 2.0)


def _passage_steps(state: Floats, floor: Floats, step: float) -> int:
    """Number of records in which all objects fall from states (N, STATE) to heights (N,) [m] in spite of the air."""
    sinking, height = np.maximum(-state[:, 9], 0.0), np.maximum(state[:, 2] - floor, 0.0)
    time = (np.sqrt(sinking**2 + 2.0 * GRAVITY * height) - sinking) / GRAVITY
    return int(np.ceil(AIR_SHARE * time.max() / step)) + 2


def _last_moment_above(level: Floats, height: Floats) -> Ints:
    """Last moments (N,) at which objects at heights (N, K) [m] are above levels (N,) [m]."""
    below = height < level[:, None]
    return np.maximum(height.shape[1] - 1 - np.argmax(~below[:, ::-1], axis=1), 0) * (~below).any(axis=1)


def _release_states(clock: ThrowClock) -> Floats:
    """States of objects at their release from the planned hands (N, STATE)."""
    # The engine's velocities belong to the middle of the step before.
    times, parting = clock.free_at[:, None] - np.array([0.0, clock.step / 2.0]), clock.parting
    hand = clock.path.sample(times)
    place = hand.position[:, 0] + clock.offset + parting.centre
    return np.concatenate([place, parting.attitude, hand.velocity[:, 1] + parting.velocity, parting.rate], axis=1)
