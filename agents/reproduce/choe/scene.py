"""Fig. 4 of Choe et al. 2023: out of one box and into another over the ellipse, carried out by the robot in MuJoCo.

The boxes stand in the conveyor's cell, the object in the left one. Its walls are as high as the vertical part of the
path is long, which is what the paper's vertical lines are for.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.hand import HandCycle
from pnt_gym.planning.motion.trajectory import HandPath, JerkTrajectory

from ...ground.drawings import Axes, Figure, dress, subplots, svg
from ...ground.tables import Grid
from ..finding import Findings, Row

FROM: Final = (-0.16, 0.10)
TO: Final = (0.12, 0.42)
"""Middles of the boxes [m]."""
SIDE: Final = 0.22
RIM: Final = -0.70
DEPTH: Final = 0.205
OVER_RIM: Final = -0.10
"""The object is let go this far above the rim: inside the box [m]."""
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


@final
class Carried(NamedTuple):
    """N objects carried out of one box and into the other."""

    core: Core
    path: HandPath
    """Planned, of the planner's points."""
    release_time: Floats
    """(N,) [s]"""
    place: Floats
    """Centre of mass in the simulator (N, M, 3) [m]."""
    held: Bools
    """While it is held (N, M)."""
    touched: Bools
    """Which objects touched anything while they were held (N,)."""
    arrived: Bools
    """Which lie in the other box at the end, untouched by the cup after they were let go (N,)."""

    @property
    def under_pick(self) -> Floats:
        """How far the lowest point of each object is below the planner's point (N,) [m]."""
        return self.core.cell.context.pick[:, 2] - self.core.config.belt.height


def scene_findings() -> Findings:
    """Whether the robot clears the walls, and the drawing."""
    carried = carry(LEVEL)
    note = f"{OBJECTS} objects of level ideal, walls {DEPTH:g} m high, vertical parts of 0.23 m, full physics"
    low = carried.path.sample(np.linspace(0.0, 1.0, 801) * carried.release_time[:, None]).position
    clear = over_walls(low, low[..., 2] - carried.under_pick[:, None])
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


def carry(level: dict[str, Any]) -> Carried:
    """Carry objects out of one box and into the other, by the method of a level."""
    core = Core(ConveyorCell(ConveyorConfig.load(level), OBJECTS, "independent"))
    core.reset(np.arange(OBJECTS), [np.random.default_rng([0, row]) for row in range(OBJECTS)], seeded=True)
    cell = core.cell
    pick = cell.context.pick.copy()
    pick[:, :2] = FROM
    cell.context, good = cell.planner.plan(cell.context.objects, pick)
    if not (good & (cell.context.bin == 1)).all():
        raise RuntimeError("not all objects are brought from one box to the other")
    context, mover = cell.context, cell.planner.mover
    motion = mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)
    back = mover.back(motion, np.roll(context.pick, 1, axis=0), context.limits)
    path = JerkTrajectory.concatenate(motion.pick, [motion.segments, back])
    plans = HandCycle(context.plan, motion.release_time, path)
    seen = cell.plant.follow(context, plans).flight
    held = np.arange(seen.position.shape[1]) < seen.release_step[:, None]
    touched = (seen.any_touch & held).any(axis=1)
    came, rim = cell.plant.fly(context, plans).touchdown, context.target[:, 2]
    lies = came.lies_in(context.target[:, :2], context.opening, rim, rim - core.config.bins.depth)
    return Carried(core, path, motion.release_time, seen.position, held, touched, lies & ~came.recontact)


def over_walls(place: Floats, lowest: Floats) -> float:
    """How high points (N, K, 3), whose objects reach down to heights (N, K), at least are above walls [m]."""
    room = [np.abs(place[..., :2] - middle).max(axis=2) - SIDE / 2.0 for middle in (FROM, TO)]
    wall = 0.5 * SIDE  # no object reaches farther than half a box
    near = [np.abs(one) < wall for one in room]
    outside = [one > -1e-9 for one in room]
    return float(np.min(lowest[(near[0] & outside[0]) | (near[1] & outside[1])]) - RIM)


def scene_figure(carried: Carried, row: int = 0) -> Figure:
    """The way of one object, seen from the side."""
    figure, (axes,) = subplots(1, 1, (7.0, 5.0))
    start, way = np.array(FROM), np.subtract(TO, FROM)
    length = float(np.hypot(*way))
    planned = carried.path.sample(np.linspace(0.0, 1.0, 400) * carried.release_time[row, None]).position[row]
    flown = carried.place[row][carried.held[row]]
    for place, said, style in ((planned, "hand, planned", "-"), (flown, "object, simulated", "--")):
        axes.plot((place[:, :2] - start) @ way / length, place[:, 2], style, label=said)
    _boxes(axes, way / length, length)
    _corners(axes, planned, (planned[:, :2] - start) @ way / length)
    dress(axes, "along the way [m]", "height [m]", "Out of one box and into another", legend="lower center")
    axes.set_aspect("equal")
    return figure


def _boxes(axes: Axes, along: Floats, length: float) -> None:
    """Walls and bottoms of both boxes, cut along the way."""
    half = SIDE / 2.0 / float(np.abs(along).max())
    for middle in (0.0, length):
        sides = np.array([-half, -half, half, half]) + middle
        axes.plot(sides, [RIM, RIM - DEPTH, RIM - DEPTH, RIM], color="black", linewidth=2.0)


def _corners(axes: Axes, planned: Floats, along: Floats) -> None:
    """The paper's names of the ends of the vertical parts."""
    upright = np.flatnonzero(np.abs(along - along[0]) < 1e-6)[-1], np.flatnonzero(np.abs(along - along[-1]) < 1e-6)[0]
    for index, name in zip((0, *upright, len(along) - 1), ("P1", "T1", "T2", "P2"), strict=True):
        axes.plot(along[index], planned[index, 2], "o", color="black", markersize=4)
        axes.annotate(name, (float(along[index]), float(planned[index, 2])), (6, 0), textcoords="offset points")
