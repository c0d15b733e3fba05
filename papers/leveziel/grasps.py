"""Friction grasps of the three objects of Leveziel et al. (section VI-B), lifted by 50 mm in the simulator."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots
from agents.ground.metrics import wilson
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.hidden import Hidden, expected_hidden

from .cases import item_label

GRASPS: Final = 240
"""Number of grasps of each object."""
SEED: Final = 0
LIFT: Final = 0.050
"""Height of the lift [m]."""
LIFT_TIME: Final = 0.25
"""Time of the lift [s]."""
SLIP: Final = 0.0005
"""Way along the pads above which an object counts as slipped [m]."""
LEAST: Final = 0.98
"""Share of the grasps that have to hold."""
PLACE, YAW, SIZE, MASS, FRICTION = 0.004, 8.0, 0.05, 0.30, 0.20
"""Largest errors: place per axis [m], direction [deg], and relative errors of size, mass and friction."""


class Grasps(NamedTuple):
    """Simulation of N grasps of one object."""

    name: str
    yaw: Floats
    """Direction of the object against the pads (N,) [deg]."""
    lifted: Bools
    """Whether the object is lifted by 50 mm at the end (N,)."""
    slip: Floats
    """Way along the pads after leaving the table (N,) [m]."""
    settling: Floats
    """Way along the pads after the closing of the grip (N,) [m]."""

    @property
    def is_held(self) -> Bools:
        """Whether the object is lifted without slip (N,)."""
        return self.lifted & (self.slip < SLIP)


def grasp_findings(grasps: int = GRASPS) -> Findings:
    """Simulation of many grasps and lifts of every object."""
    cell = GripperCell(GripperConfig.load("drop"), grasps)
    records = [simulate_grasps(cell, kind) for kind in range(len(cell.item_names))]
    rows = tuple(row for record in records for row in (_hold_row(record), _settling_row(record)))
    figures = {"leveziel_grasps.svg": grasps_figure(records)}
    return table_findings("Grasps in the simulator", rows, figures, drop="leveziel/grasps/")


def simulate_grasps(cell: GripperCell, kind: int) -> Grasps:
    """Simulate grasps of objects of one kind all over the pick area, each lifted straight up.

    Args:
        cell: a cell of the level `drop`, which simulates one grasp in each of its rows.
        kind: index of the object.
    """
    rng = np.random.default_rng([SEED, kind])
    kinds, table = np.full(cell.count, kind, dtype=np.int64), cell.config.table
    low, high = np.array([table.pick_x, table.pick_y]).T
    place = rng.uniform(low, high, (cell.count, 2))
    hidden = draw_objects(cell, kind, rng)
    plans = cell.planner.plan(kinds, place)
    up = plans.pick + np.array([0.0, 0.0, LIFT])
    # The flight after the opening does not matter, so the simulation does not wait for the flight.
    still = np.zeros(cell.count)
    plans = replace(plans, release=up, move_time=np.full(cell.count, LIFT_TIME), flight_time=still)
    flown = cell.plant.fly(replace(cell.context, kind=kinds, place=place, hidden=hidden), plans)
    rows, step = np.arange(cell.count), cell.config.timestep
    grip_step, open_step = ((time / step).astype(np.int64) for time in (plans.grip_time, plans.open_time))
    along = (flown.flight.position - flown.hand)[..., [0, 2]]
    settling = np.hypot(*(along[rows, open_step] - along[rows, grip_step]).T)
    name = item_label(cell.item_names[kind])
    return Grasps(name, np.rad2deg(hidden.yaw), flown.lifted > LIFT - 0.001, flown.slip, settling)


def draw_objects(cell: GripperCell, kind: int, rng: np.random.Generator) -> Hidden:
    """Hidden values of N objects of one kind, with uniform random errors."""
    item, count, uniform = cell.config.item_list()[kind], cell.count, rng.uniform
    expected = expected_hidden(np.full(count, kind, dtype=np.int64), cell.config)
    return replace(
        expected,
        size=np.array(item.size) * uniform(1.0 - SIZE, 1.0 + SIZE, (count, 1)),
        mass=expected.mass * uniform(1.0 - MASS, 1.0 + MASS, count),
        friction=expected.friction * uniform(1.0 - FRICTION, 1.0 + FRICTION, count),
        offset=uniform(-PLACE, PLACE, (count, 2)),
        yaw=np.deg2rad(uniform(-YAW, YAW, count)),
        delay=np.zeros(count),
    )


def _hold_row(grasps: Grasps) -> Row:
    is_held = grasps.is_held
    rate = wilson(int(is_held.sum()), is_held.size)
    return Row.compared(
        f"leveziel/grasps/{grasps.name}",
        "picked up",
        100.0 * rate.value,
        "%",
        holds=rate.value >= LEAST,
        note=f"of {is_held.size} grasps lifted by 50 mm without slip, that is moved by less than {1e3 * SLIP:g} mm "
        f"along the pads after leaving the table (the most is {1e3 * grasps.slip.max():.2f} mm); places up to "
        f"{1e3 * PLACE:g} mm and directions up to {YAW:g} deg off, sizes {100 * SIZE:.0f} %, masses {100 * MASS:.0f} "
        f"% and friction {100 * FRICTION:.0f} %, seed {SEED}. 95 % interval from {100.0 * rate.low:.1f} %",
        grasps=int(is_held.size),
        lifted=int(grasps.lifted.sum()),
        slip_max_m=float(grasps.slip.max()),
        slip_median_m=float(np.median(grasps.slip)),
    )


def _settling_row(grasps: Grasps) -> Row:
    still = 100.0 * float((grasps.lifted & (grasps.settling < SLIP)).mean())
    askew = "One that lies askew is held at two edges and turns into line with the pads as soon as the table lets it"
    turning = "Round about the vertical, it has nothing to turn into line" if still == 100.0 else askew
    note = (
        f"the most that the same {grasps.settling.size} objects move along the pads from the end of the closing until "
        f"they have been lifted; {still:.1f} % move by less than {1e3 * SLIP:g} mm. {turning}"
    )
    quantity, median = f"leveziel/grasps/{grasps.name}-from-closed-grip", float(np.median(grasps.settling))
    return Row.ours(quantity, float(grasps.settling.max()), "m", note=note, share_still=still, median_m=median)


def grasps_figure(records: list[Grasps]) -> Figure:
    """Drawing of the objects' way along the pads over their direction against the pads."""
    figure, axes = subplots(len(records), 1, (WIDTH, 2.8 * len(records)), sharex=True)
    for panel, record in zip(axes, records, strict=True):
        ways = {"from the closed grip": record.settling, "from leaving the table": record.slip}
        for colour, (name, way) in zip((COLOURS[1], COLOURS[0]), ways.items(), strict=True):
            panel.scatter(record.yaw, 1e3 * way, s=10, alpha=0.7, color=colour, linewidths=0, label=name)
        panel.axhline(1e3 * SLIP, color="black", linestyle="--", linewidth=1, label="counts as slip")
        across = "direction against the pads [°]" if panel is axes[-1] else ""
        dress(panel, across, "way along the pads [mm]", f"{record.name}, {record.yaw.size} grasps")
    axes[0].legend(fontsize=8, loc="upper center")
    return figure
