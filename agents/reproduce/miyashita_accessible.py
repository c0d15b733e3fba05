"""The accessible space of Miyashita et al. 2010 (Fig. 8): how much of it dynamics and motor take away."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.miyashita_cases import ARM
from pnt_gym.planning.one_joint.accessible import CELL, AccessibleSpace, accessible_space

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pnt_gym.planning.arrays import Ints

TORQUES: Final = (18.0, 4.7, 1.5)
"""Largest torque of the motor: published, its continuous rating, and a weak one [N m]."""
SAMPLES: Final = (160, 120, 64)
"""Releases sampled for the other motors and arms; the counts grow by 2 to 4 % from here to twice as many of each."""
SLICES: Final = (60.0, 90.0, 120.0, 150.0, 180.0, 210.0)
"""Angles of the drawn slices [deg]."""


def accessible_findings(samples: tuple[int, int, int] = SAMPLES) -> Findings:
    """Counts of cells at three torques, and the slices of the space."""
    rows = [_claim(samples)]
    rows += [_motor(torque, samples) for torque in TORQUES]
    rows.append(_whole_arm(samples))
    figures = {"miyashita_accessible.svg": svg(slices_figure(samples))}
    return Findings(tuple(rows), {"miyashita_accessible": {"cell": CELL, "samples": samples}}, figures)


@cache
def _space(torque: float, samples: tuple[int, int, int]) -> AccessibleSpace:
    # The torque left at full speed is half of the largest one, as with the published motor.
    return accessible_space(
        arm=replace(ARM, torque=torque, torque_at_speed=torque * ARM.torque_at_speed / ARM.torque), samples=samples
    )


def _claim(samples: tuple[int, int, int]) -> Row:
    space = _space(TORQUES[0], samples)
    lost = 100.0 * (1.0 - len(space.cells) / len(space.kinematic))
    return Row(
        "miyashita/claim/accessible-space-much-narrower",
        "considerably narrower",
        f"{lost:.1f} % fewer",
        "-",
        "differs",
        f"dy = 0, cells of 2 cm x 2 cm x 5 deg: {len(space.cells)} with grasp, torque and a motion from rest, "
        f"{len(space.kinematic)} with reach and largest speed alone; what bounds the space of the published motor is "
        "its speed and the arm's length",
        {"cells": len(space.cells), "kinematic": len(space.kinematic)},
    )


def _motor(torque: float, samples: tuple[int, int, int]) -> Row:
    space = _space(torque, samples)
    share = 100.0 * len(space.cells) / len(space.kinematic)
    return Row(
        f"miyashita/accessible/torque-{torque:g}",
        None,
        float(len(space.cells)),
        "-",
        "ours",
        f"cells with dy = 0 at a largest torque of {torque:g} N m, {share:.0f} % of those that reach and speed allow; "
        f"{len(space.grasp)} if only the release has to keep grasp and torque",
        {"kinematic": len(space.kinematic), "release_only": len(space.grasp)},
    )


def _whole_arm(samples: tuple[int, int, int]) -> Row:
    """The whole half arm as the largest radius: what the length of the block's edge on the plate costs."""
    longer = ARM.length + 2.0 * 0.03
    # A plate as heavy about the pivot as the published one.
    arm = replace(ARM, length=longer, thickness=ARM.thickness * (ARM.length / longer) ** 3)
    space = accessible_space(arm=arm, samples=samples)
    return Row(
        "miyashita/accessible/overhanging-block",
        None,
        float(len(space.cells)),
        "-",
        "ours",
        f"cells if the block's middle may lie at the very end of the arm, 0.31 m instead of 0.28 m; "
        f"{len(space.kinematic)} by reach and speed alone",
        {"kinematic": len(space.kinematic), "release_only": len(space.grasp)},
    )


def slices_figure(samples: tuple[int, int, int]) -> Figure:
    """Cells of some angles in the plane, by what they need (Fig. 8 drawn as slices)."""
    figure, axes = subplots(2, 3, (12.0, 6.6), sharex=True, sharey=True)
    strong, weak = _space(TORQUES[0], samples), _space(TORQUES[1], samples)
    layers = (
        (strong.kinematic, "#d9d9d9", "reach and speed allow it"),
        (strong.cells, COLOURS[0], f"with grasp and {TORQUES[0]:g} N m"),
        (weak.cells, COLOURS[1], f"with grasp and {TORQUES[1]:g} N m"),
    )
    for panel, angle in zip(axes, SLICES, strict=True):
        at = round(np.deg2rad(angle) / CELL[2])
        for cells, colour, label in layers:
            _cells(panel, cells[cells[:, 2] == at, :2], colour, label)
        panel.add_patch(_arm())
        panel.plot(0.0, 0.0, "o", color="black", markersize=3)
        if angle == 150.0:
            panel.plot(0.0, 0.4, "*", color=COLOURS[3], markersize=9, label="the paper's goal")
        panel.set_title(f"arriving at {angle:.0f}° to {angle + 5.0:.0f}°", fontsize=10)
        panel.set_aspect("equal")
        panel.grid(alpha=0.3)
    for panel in axes[3:]:
        panel.set_xlabel("x [m]")
    for panel in axes[::3]:
        panel.set_ylabel("y [m]")
    handles, labels = axes[SLICES.index(150.0)].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, ncols=4, loc="outside lower center", markerscale=1.6)
    figure.suptitle("where a block can be with no vertical speed; the circle is the arm's reach", fontsize=11)
    return figure


def _cells(axes: Axes, cells: Ints, colour: str, label: str) -> None:
    """Fill cells (K, 2) of the plane."""
    from matplotlib.colors import ListedColormap  # noqa: PLC0415 - heavy, needed for drawings only

    axes.scatter([], [], s=25, marker="s", color=colour, label=label, linewidths=0)
    low, high = np.array([-30, -20]), np.array([50, 40])
    filled = np.full(tuple(high - low), np.nan)
    filled[tuple((cells - low).T)] = 1.0
    (left, bottom), (right, top) = low * CELL[0], high * CELL[0]
    axes.imshow(
        filled.T, cmap=ListedColormap([colour]), extent=(left, right, bottom, top), origin="lower", interpolation="none"
    )


def _arm() -> object:
    from matplotlib.patches import Circle  # noqa: PLC0415 - heavy, needed for drawings only

    return Circle((0.0, 0.0), 0.5 * ARM.length, fill=False, color="black", linewidth=0.8, linestyle=":")


PARTS = (Part("accessible", accessible_findings),)
