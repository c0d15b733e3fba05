"""N objects without the robot: in the engine with bins and belt, and in the air alone without the engine."""

from __future__ import annotations

from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, length, take, take_rows
from pnt_gym.cells.base import freefall, settle_kernel
from pnt_gym.cells.base.airborne import STATE, Airborne, BinShape, Ground, Solid, Vicinity
from pnt_gym.cells.base.bodies import MODEL_FIELDS, ModelFields, write_object
from pnt_gym.cells.base.parallel import write_in_parts
from pnt_gym.cells.base.plant import simulation_ids
from pnt_gym.cells.base.recorded import Touchdown
from pnt_gym.cells.base.settling import Fall, FallEnd, fall, settle
from pnt_gym.cells.conveyor import scene_kernel
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.hand import ThrowClock
from pnt_gym.cells.conveyor.scene import BOTTOM_PANEL, Surroundings, bin_panels, build_free_scene, floor_height
from pnt_gym.constants import GRAVITY
from pnt_gym.engine import Batch
from pnt_gym.planning.motion.ballistics import landing_point

NEAR_DISTANCE: Final = 0.02
"""Distance from an opening beyond which an object's landing cannot end in that bin [m]."""


def write_models(batch: Any, rows: Ints, scene: Surroundings, context: Context, config: ConveyorConfig) -> None:
    """Write the objects of N throws, the draught and bins that are drawn per throw into some simulations."""
    o, geom, bins = context.objects, scene.object_geom, config.bins
    if scene.has_draught:
        batch.expand("opt.wind")[rows, :2] = context.drift.draught
    write_object(rows, scene.object_body, geom, o.model, ModelFields(*map(batch.expand, MODEL_FIELDS)))
    contacts = scene_kernel.Contacts(o.middle, o.friction, o.rolling_friction, o.solref)
    fields = scene_kernel.ContactFields(*map(batch.expand, scene_kernel.CONTACT_FIELDS))
    scene_kernel.write_contacts(rows, geom, contacts, fields)
    if bins.random is not None:
        bin_fields = scene_kernel.BinFields(*map(batch.expand, scene_kernel.BIN_FIELDS))
        places = rows, scene.bin_bodies[0], scene.bin_geoms[0], context.target
        scene_kernel.place_bins(*places, bin_panels(context.opening, bins), bin_fields)
    if bins.emptied is not None:
        # The bottoms of bins move to the top of their contents; below its bottom a bin is hollow.
        for index, first in enumerate(scene.bin_geoms):
            batch.expand("geom_pos")[rows, first + BOTTOM_PANEL, 2] = -context.depth[:, index] - bins.wall / 2


@final
class FreeObjects:
    """N objects without the robot.

    Args:
        config: the cell.
        count: number of simulations N.
        threads: worker threads; results do not depend on it.
    """

    def __init__(self, config: ConveyorConfig, count: int, threads: int) -> None:
        self._config, self._threads = config, threads
        self._scene = build_free_scene(config)
        belt = config.belt
        (min_x, max_x), (min_y, max_y) = belt.x, belt.y
        self._ground = Ground.zeros(
            1, floor=floor_height(config), belt=belt.height, min_x=min_x, max_x=max_x, min_y=min_y, max_y=max_y
        )
        self.batch = Batch(self._scene.model, nsim=count, nthread=threads)
        self._qpos, self._qvel = self.batch.bind("qpos"), self.batch.bind("qvel")

    def fall(self, rows: Ints, context: Context, qpos: Floats, qvel: Floats, steps: Ints) -> Fall:
        """Simulate N objects in the engine, in some of the simulations, from states qpos (N, 7) and qvel (N, 6).

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """
        self._write(rows, context, qpos, qvel)
        spin, rim = context.objects.inertia / context.objects.mass[:, None], context.target[:, 2]
        return fall(self.batch, (self._qpos, self._qvel), rows, spin, steps, rim, self._config.timestep)

    def predict_landings(self, context: Context, clock: ThrowClock) -> tuple[Touchdown, Bools]:
        """Landings of N objects after planned releases, and which objects the cup touches again (N,).

        An object that crosses the rim's height near an opening flies on until it may touch a rim or a wall, or is sure
        to stay in the bin; from a possible touch on it is simulated in the engine. An object that is sure to stay
        where it is counts as lying where it was judged, and an object that misses all openings where it crosses the
        rim's height.

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """
        rim = context.target[:, 2].copy()
        flying = Airborne(context.objects.body, context.drift.draught, self._config.mismatch)
        landing, records, steps = cross_rims(flying, clock, rim, self._threads)
        position = np.concatenate([landing, rim[:, None]], axis=1)
        velocity = np.zeros_like(position)
        touched = clock.meets(context, (records[..., :3], records[..., 7:10], records[..., 3:7]), steps)
        # Which landings (N, 2) are near the opening of the throw's bin, or of any fixed one (N,).
        bins = [(context.target[:, :2], context.opening)]
        bins += [(np.array([b.x, b.y]), np.array(b.size)) for b in self._config.bins.fixed]
        near = [(np.abs(landing - centre) <= size / 2.0 + NEAR_DISTANCE).all(axis=1) for centre, size in bins]
        rows = (np.any(near, axis=0) & ~touched).nonzero()[0]
        if rows.size > 0:
            level = context.target[:, 2] + farthest_points(context)
            # Last moments (N,) at which objects at heights (N, K) [m] are above levels (N,) [m].
            height = records[..., 2]
            above = ~(height < level[:, None])
            last = np.maximum(height.shape[1] - 1 - np.argmax(above[:, ::-1], axis=1), 0)
            first = (last * above.any(axis=1))[rows]
            remaining = (clock.end - clock.release)[rows] - first * clock.stride
            thrown, falling = take_rows(context, rows, len(rim)), take_rows(flying, rows, len(rim))
            end = self.settle(rows, thrown, falling, records[rows, first], remaining)
            position[rows], velocity[rows] = end.position, end.velocity
        return Touchdown(landing, position, velocity, np.zeros_like(touched)), touched

    def settle(self, rows: Ints, context: Context, flying: Airborne, state: Floats, steps: Ints) -> FallEnd:
        """Ends of the falls of N objects in some of the simulations.

        Args:
            rows: the simulations.
            context: the N picks.
            flying: the objects.
            state: states entirely above the rims (N, STATE).
            steps: number of steps until each throw ends (N,).

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """

        def write(index: Ints, state: Floats) -> None:
            self._write(rows[index], take_rows(context, index, count), state[:, :7], state[:, 7:])

        # Bodies of N objects, and what they may meet.
        body = flying.body
        o, fixed, count = context.objects, self._config.bins.fixed, len(body)
        bins, solid, rebounds = BinShape.empty(count, max(len(fixed), 1)), Solid.empty(count), np.empty(count)
        openings = np.array([(b.x, b.y, b.size[0] / 2.0, b.size[1] / 2.0) for b in fixed])
        drawn = np.concatenate([context.target[:, :2], context.opening / 2.0], axis=1)[:, None]
        for index, name in enumerate(("x", "y", "half_x", "half_y")):
            bins[name] = (openings if fixed else drawn)[..., index]
        bins["depth"] = context.depth
        settle_kernel.fill_rebounds(np.ascontiguousarray(o.solref), self._config.timestep, rebounds)
        solid["shape"], solid["half"], solid["height"] = o.shape, o.extents / 2.0, body["height"]
        solid["spin"] = body["inertia"] / body["mass"][:, None]
        solid["rebound"], solid["farthest"] = rebounds, farthest_points(context)
        ground = take(self._ground, np.zeros(count, dtype=np.int64))
        vicinity = Vicinity(solid, bins, context.target[:, 2].copy(), ground)
        motion, step = (self._qpos, self._qvel), self._config.timestep
        return settle(self.batch, motion, rows, (flying, vicinity), state, steps, step, write)

    def _write(self, rows: Ints, context: Context, qpos: Floats, qvel: Floats) -> None:
        """Set up some of the simulations with the objects of N picks in states qpos (N, 7) and qvel (N, 6)."""
        batch = self.batch
        write_models(batch, rows, self._scene, context, self._config)
        batch.set_const(simulation_ids(batch, rows))
        batch.state[rows] = 0.0
        self._qpos[rows], self._qvel[rows] = qpos, qvel


def cross_rims(flying: Airborne, clock: ThrowClock, rim: Floats, threads: int = 1) -> tuple[Floats, Floats, Ints]:
    """Where N released objects cross the heights of rims (N,) [m], in the air alone.

    Returns:
        The crossings (N, 2) [m], the states every `clock.stride` steps until then (N, K, STATE), and the number of
        steps (N,).
    """
    step, stride, parting, steps = clock.step, clock.stride, clock.parting, np.zeros(len(rim), dtype=np.int64)
    # States at the release from the planned hands; the engine's velocities belong to the middle of the step before.
    hand = clock.path.sample(clock.free_at[:, None] - np.array([0.0, step / 2.0]))
    place = hand.position[:, 0] + clock.offset + parting.centre
    state = np.concatenate([place, parting.attitude, hand.velocity[:, 1] + parting.velocity, parting.rate], axis=1)
    records = np.empty((len(rim), int((clock.end - clock.release).max()) // stride + 2, STATE))
    flights = state, flying, rim, step, stride, records, steps
    if threads > 1:
        write_in_parts(freefall.fly_down, flights, len(rim), threads)
    else:
        freefall.fly_down(*flights)
    # The last step undone: semi-implicit Euler moves by the velocity at the step's end.
    before = state[:, :3] - step * state[:, 7:10], state[:, 7:10] + np.array([0.0, 0.0, GRAVITY * step])
    landing = landing_point(*before, rim)[:, :2]
    return np.where(np.isfinite(landing), landing, state[:, :2]), records, steps


def farthest_points(context: Context) -> Floats:
    """Largest distance of a point of each object from its centre of mass (N,) [m]."""
    full, depth = context.objects.extents, context.objects.com_depth
    # Half the diagonal plus the offset.
    return length(full) / 2.0 + np.abs(depth - full[:, 2] / 2.0)
