"""Motions of Choe et al. 2023 simulated with the closed-chain robot in MuJoCo: the timed paths, and Fig. 4.

In Fig. 4 the robot carries an object out of one box and into another over the ellipse. The boxes stand in the
conveyor's cell, the object in the left box. The walls are as high as the vertical parts of the path are long: the
paper adds vertical lines to clear walls.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple, final

import numpy as np

from agents.ground.drawings import WIDTH, Axes, Figure, dress, subplots, svg
from agents.ground.tables import Grid
from agents.reproduce.finding import Findings, Row
from pnt_gym.arrays import Bools, Floats, concatenate_records
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.base.plant import roll_out
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.hand import HandCycle
from pnt_gym.engine import Batch, mujoco
from pnt_gym.planning.motion.trajectory import HandPath, JerkTrajectory
from pnt_gym.robots.specification import set_options
from pnt_gym.robots.t3kr.geometry import T3KR
from pnt_gym.robots.t3kr.kinematics import closed_pose
from pnt_gym.robots.t3kr.model import add_t3kr, control_columns, qpos_columns
from pnt_gym.robots.t3kr.references import exact_references, joint_knots

from .cases import long_cases, motion

TIMESTEP: Final = 0.0004
"""Step of the engine [s]."""
SETTLE: Final = 0.1
"""Simulated time after the end of the motion [s]."""
PLAYED: Final = ("rectangle", "ellipse-50mm-strict", "ellipse-50mm-relaxed", "lame-50mm-level")
FROM: Final = (-0.16, 0.10)
TO: Final = (0.12, 0.42)
"""Centres (x, y) of the boxes [m]."""
SIDE: Final = 0.22
RIM: Final = -0.70
DEPTH: Final = 0.205
OVER_RIM: Final = -0.10
"""Height of the release above the rim [m]; negative: inside the box."""
LEVEL: Final[dict[str, Any]] = {
    "base": "ideal",
    "planner": "ellipse",
    "bins": {
        "rim": RIM,
        "depth": DEPTH,
        "fixed": [
            {"name": name, "x": x, "y": y, "size": [SIDE, SIDE]} for name, (x, y) in (("one", FROM), ("other", TO))
        ],
    },
    "motion": {"placing": {"over_rim": OVER_RIM, "vertical": 0.23, "reserve": 0.0}, "ceiling": 0.25},
}
OBJECTS: Final = 12


def motion_findings() -> Findings:
    """Tracking error and motor torque of four motions over the long way."""
    cases = [long_cases()[name] for name in PLAYED]
    errors, torques = play([motion(case) for case in cases])
    rows: list[Row] = []
    lines: list[list[str]] = []
    for case, error, torque in zip(cases, errors, torques, strict=True):
        largest, last = float(error.max()), f"{1e6 * float(error[-1]):.2f} micrometres"
        rule = "continuous acceleration" if case.joints == "strict" else "acceleration steps at the tangent points"
        name = f"choe/simulated/{case.name}"
        note = f"{case.label}, {rule}, motors with feed-forward, robot without an object"
        end = f"largest distance of the hand from its reference; {last} in the end"
        limit = f"largest of a motor, {T3KR.torque_limit:g} allowed"
        rows.append(Row.ours(f"{name}/tracking", largest, "m", note=f"{note}: {end}"))
        rows.append(Row.ours(f"{name}/torque", torque, "N m", note=f"{note}: {limit}"))
        lines.append([case.name.replace("-", " "), f"{largest:.5f} m", last, f"{torque:.0f} N m"])
    header = ("path", "tracking", "in the end", f"torque, {T3KR.torque_limit:g} N m allowed")
    return Findings(tuple(rows), grids=(Grid("The motions carried out by the robot in MuJoCo", header, lines),))


def play(paths: list[HandPath]) -> tuple[Floats, Floats]:
    """Simulate motions of one row each, all in one batch.

    Returns:
        Distance of the hand from its reference (N, steps) [m] and the largest motor torque (N,) [N m].

    Raises:
        PhysicsError: the engine warned.
    """
    spec = mujoco.MjSpec()
    handles = add_t3kr(spec)
    set_options(spec, TIMESTEP)
    model = spec.compile()
    steps = int(np.ceil((max(float(path.duration[0]) for path in paths) + SETTLE) / TIMESTEP))
    times = TIMESTEP * np.arange(steps + 1)
    reference = concatenate_records([path.sample(times) for path in paths])
    control = np.ones((len(paths), steps, model.nu + model.neq))
    knots = joint_knots(*(part[:, :-1] for part in reference))
    control[:, :, control_columns(model, handles)] = exact_references(knots)
    batch = Batch(model, len(paths), nthread=1)
    batch.bind("qpos")[:, qpos_columns(model, handles)] = closed_pose(
        reference.position[:, 0], handles.rods_per_arm, handles.geometry
    )
    out = roll_out(batch, control, np.full(len(paths), steps), ("qpos", "actuator_force"))
    columns = [int(model.joint(f"platform_{axis}").qposadr[0]) for axis in "xyz"]
    error = np.linalg.norm(out["qpos"][:, :, columns] - reference.position[:, 1:], axis=2)
    return error, np.abs(out["actuator_force"]).max(axis=(1, 2))


@final
class CarriedObjects(NamedTuple):
    """Simulation of N objects that the robot carries out of one box and into the other, at M moments."""

    core: Core
    path: HandPath
    """Planned path of the point that the planner moves."""
    release_time: Floats
    """(N,) [s]"""
    place: Floats
    """Simulated centre of mass of each object (N, M, 3) [m]."""
    is_held: Bools
    """Whether the cup holds the object at each moment (N, M)."""
    touched: Bools
    """Whether each object touched anything while the cup held it (N,)."""
    arrived: Bools
    """Whether each object lies in the other box at the end and the cup did not touch it after release (N,)."""

    @property
    def under_pick(self) -> Floats:
        """Height of the planner's point above the lowest point of each object (N,) [m]."""
        return self.core.cell.context.pick[:, 2] - self.core.config.belt.height


def scene_findings() -> Findings:
    """Whether the robot carries objects over the walls and into the other box, and a drawing of one way."""
    carried = carry(LEVEL)
    across = np.hypot(*np.subtract(TO, FROM))
    note = (
        f"a scene of ours, as the paper gives no lengths for Fig. 4: boxes {1000 * across:.0f} mm apart, vertical "
        f"parts of 0.23 m and a crest of the cell's own, neither the example of 300 x 50 mm nor its rule; {OBJECTS} "
        f"objects of level ideal, walls {DEPTH:g} m high, full physics"
    )
    low = carried.path.sample(np.linspace(0.0, 1.0, 801) * carried.release_time[:, None]).position
    clear = wall_clearance(low, low[..., 2] - carried.under_pick[:, None])
    rows = (
        Row.ours("choe/fig-4/clearance", clear, "m", note=f"{note}: lowest point of an object above a wall it passes"),
        Row.ours("choe/fig-4/touched", float(carried.touched.mean()), "-", note=f"{note}: touched a wall on the way"),
        Row.ours("choe/fig-4/arrived", float(carried.arrived.mean()), "-", note=f"{note}: lie in the other box"),
    )
    lines = [
        ["least clearance over a wall", f"{1000.0 * clear:.0f} mm"],
        ["touched a wall", f"{carried.touched.sum()} of {OBJECTS}"],
        ["came to lie in the other box", f"{carried.arrived.sum()} of {OBJECTS}"],
    ]
    grid = Grid("Out of one box and into another", ("carried over the ellipse", "in the simulator"), lines)
    return Findings(rows, figures={"choe_scene.svg": svg(scene_figure(carried))}, grids=(grid,))


def carry(level: dict[str, Any]) -> CarriedObjects:
    """Simulate objects that a level's planner carries out of one box and into the other."""
    cell = ConveyorCell(ConveyorConfig.load(level), OBJECTS, "independent")
    core = Core(cell)
    core.reset(np.arange(OBJECTS), [np.random.default_rng([0, row]) for row in range(OBJECTS)], seeded=True)
    pick = cell.context.pick.copy()
    pick[:, :2] = FROM
    cell.context, feasible = cell.planner.plan(cell.context.objects, pick)
    if not (feasible & (cell.context.bin == 1)).all():
        raise RuntimeError("not all objects are brought from one box to the other")
    context, mover = cell.context, cell.planner.mover
    motion = mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)
    back = mover.back(motion, np.roll(context.pick, 1, axis=0), context.limits)
    path = JerkTrajectory.concatenate(motion.pick, [motion.segments, back])
    plans = HandCycle(context.plan, motion.release_time, path)
    flight = cell.plant.follow(context, plans).flight
    is_held = np.arange(flight.position.shape[1]) < flight.release_step[:, None]
    touched = (flight.any_touch & is_held).any(axis=1)
    landing, rim = cell.plant.fly(context, plans).touchdown, context.target[:, 2]
    in_box = landing.lies_in(context.target[:, :2], context.opening, rim, rim - core.config.bins.depth)
    return CarriedObjects(
        core, path, motion.release_time, flight.position, is_held, touched, in_box & ~landing.recontact
    )


def wall_clearance(place: Floats, lowest: Floats) -> float:
    """Least height above a wall [m] of objects at points (N, K, 3) whose lowest points are at heights (N, K)."""
    distances = [np.abs(place[..., :2] - middle).max(axis=2) - SIDE / 2.0 for middle in (FROM, TO)]
    wall = 0.5 * SIDE  # no object reaches farther than half a box
    near = [np.abs(distance) < wall for distance in distances]
    outside = [distance > -1e-9 for distance in distances]
    return float(np.min(lowest[(near[0] & outside[0]) | (near[1] & outside[1])]) - RIM)


def scene_figure(carried: CarriedObjects) -> Figure:
    """Drawing of the way of the first object, seen from the side."""
    figure, (axes,) = subplots(1, 1, (WIDTH, 5.0))
    start, way = np.array(FROM), np.subtract(TO, FROM)
    length = float(np.hypot(*way))
    hand_path = carried.path.sample(np.linspace(0.0, 1.0, 400) * carried.release_time[0, None]).position[0]
    object_path = carried.place[0][carried.is_held[0]]
    for place, label, style in ((hand_path, "hand, planned", "-"), (object_path, "object, simulated", "--")):
        axes.plot((place[:, :2] - start) @ way / length, place[:, 2], style, label=label)
    _draw_boxes(axes, way / length, length)
    _draw_corners(axes, hand_path, (hand_path[:, :2] - start) @ way / length)
    dress(axes, "along the way [m]", "height [m]", "Out of one box and into another", legend="upper left")
    axes.set_aspect("equal")
    return figure


def _draw_boxes(axes: Axes, along: Floats, length: float) -> None:
    """Draw walls and bottoms of both boxes in the section along the way."""
    half = SIDE / 2.0 / float(np.abs(along).max())
    for middle in (0.0, length):
        sides = np.array([-half, -half, half, half]) + middle
        axes.plot(sides, [RIM, RIM - DEPTH, RIM - DEPTH, RIM], color="black", linewidth=2.0)


def _draw_corners(axes: Axes, planned: Floats, along: Floats) -> None:
    """Mark the ends of the vertical parts with the paper's names."""
    upright = np.flatnonzero(np.abs(along - along[0]) < 1e-6)[-1], np.flatnonzero(np.abs(along - along[-1]) < 1e-6)[0]
    for index, name in zip((0, *upright, len(along) - 1), ("P1", "T1", "T2", "P2"), strict=True):
        axes.plot(along[index], planned[index, 2], "o", color="black", markersize=4)
        axes.annotate(name, (float(along[index]), float(planned[index, 2])), (6, 0), textcoords="offset points")
