"""The accessible space of Miyashita et al. (Fig. 8), and its loss by dynamics and motor."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Final, NamedTuple, final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats, Ints, concatenate_records, take
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.one_joint import Arm, plan_releases
from pnt_gym.planning.one_joint.flight import land
from pnt_gym.planning.one_joint.grasp import acceleration_window

from .cases import ARM, BLOCK

Sizes = tuple[float, float, float]
Counts = tuple[int, int, int]

CELL: Final = (0.02, 0.02, float(np.deg2rad(5.0)))
"""Size of a cell in x, y [m] and phi [rad] (section 4.5)."""
SAMPLES: Final = (160, 120, 64)
"""Sampled angles, speeds and radii of releases; with twice as many of each, the numbers of cells grow by 2 to 6 %."""
TORQUES: Final = (18.0, 4.7, 1.5)
"""Largest torque of the motor: published, its continuous rating, and a weak one [N m]."""
FASTER: Final = (2, 4)
"""Multiples of the motor's largest speed for the reach of the arm alone; twice the last multiple adds 4 % of cells."""
ONE_TURN: Final = 2.0 * np.pi
"""Largest angle that is counted [rad]; with any number of turns the space of a fast arm has no end."""
CONSIDERABLE: Final = 50.0
"""Loss of cells that counts as considerable [%]: less than half of the cells is left."""
SLICES: Final = (60.0, 90.0, 120.0, 150.0, 180.0, 210.0)
"""Angles of the drawn slices [deg]."""
SPAN: Final = 1 << 20
"""Greatest number of cells in any direction, by which three indices become one number."""


@final
@dataclass(frozen=True, eq=False)
class AccessibleSpace:
    """The cells of a grid that throws reach; cell (i, j, k) begins at i, j, k times the cell's size.

    Attributes:
        kinematic: cells within the arm's geometry and largest speed (K, 3).
        grasp: cells with a release whose acceleration window is open (K, 3).
        cells: cells with such a release to which a motion from rest was planned (K, 3).
        u: a release for each of ``cells`` (K, 4).
    """

    kinematic: Ints
    grasp: Ints
    cells: Ints
    u: Floats


class _Landings(NamedTuple):
    """Releases (K, 4), number of the cell in which each lands (K,), share of the arm's range for the run-up (K,)."""

    u: Floats
    key: Ints
    effort: Floats

    def keep_easiest(self) -> _Landings:
        """The release of least effort for each cell."""
        order = np.lexsort((self.effort, self.key))
        return take(self, order[np.diff(self.key[order], prepend=-1) > 0])


def accessible_space(*, arm: Arm = ARM, size: Sizes = CELL, samples: Counts = SAMPLES) -> AccessibleSpace:
    """Return the cells (x, y, phi) that throws reach with no vertical speed, as in Fig. 8.

    A cell counts when a sampled release lands in the cell and a plan from rest exists for the release of least run-up
    among the releases within grasp and torque. For a lower rating of the motor, lower ``arm.torque``.

    Args:
        arm: arm that throws the paper's block.
        size: size of a cell in x, y [m] and phi [rad].
        samples: numbers of sampled angles, speeds and radii of the releases.
    """
    kinematic, candidates = list[Ints](), list[_Landings]()
    for u, radius in _releases(arm, samples):
        landings = _Landings(u, _cell_keys(u, size), _effort(u, radius, arm))
        kinematic.append(np.unique(landings.key))
        candidates.append(take(landings, np.isfinite(landings.effort)).keep_easiest())
    best = concatenate_records(candidates).keep_easiest()
    feasible = plan_releases(best.u, arm=arm).feasible
    return AccessibleSpace(
        _cell_indices(np.unique(np.concatenate(kinematic))),
        _cell_indices(best.key),
        _cell_indices(best.key[feasible]),
        best.u[feasible],
    )


def reachable_cells(times: int, samples: Counts) -> Ints:
    """Cells (K, 3) that an arm reaches with ``times`` the published speed, without limits of torque and grasp."""
    angles, speeds, radii = samples
    faster = replace(ARM, speed=times * ARM.speed)
    keys = [np.unique(_cell_keys(u, CELL)) for u, _ in _releases(faster, (angles, times * speeds, radii))]
    cells = _cell_indices(np.unique(np.concatenate(keys)))
    return cells[cells[:, 2] < round(ONE_TURN / CELL[2])]


def _releases(arm: Arm, samples: Counts) -> Iterator[tuple[Floats, Floats]]:
    """Releases (K, 4) whose flights end at their highest point, and radii (K,), for each sampled angle of the arm."""
    ranges = (arm.angle, (0.0, arm.speed), (0.0, arm.largest_radius(BLOCK)))
    angles, speeds, radii = (
        low + (high - low) * (np.arange(count) + 0.5) / count
        for (low, high), count in zip(ranges, samples, strict=True)
    )
    speed, radius = (axis.ravel() for axis in np.meshgrid(speeds, radii, indexing="ij"))
    for angle in angles:
        time = (radius * np.cos(angle) - BLOCK.half_height * np.sin(angle)) * speed / GRAVITY
        u = np.stack([np.full_like(time, angle), speed, np.hypot(radius, BLOCK.half_height), time], axis=1)
        yield u[time > 0.0], radius[time > 0.0]


def _effort(u: Floats, radius: Floats, arm: Arm) -> Floats:
    """Share (K,) of the arm's range below the release that a run-up at the strongest acceleration takes.

    The share is omega^2 / (2 a_max (theta - theta_min)), and infinite where no acceleration keeps grasp and torque.
    """
    window = acceleration_window(u[:, 0], u[:, 1], radius, arm, BLOCK)
    effort = u[:, 1] ** 2 / (2.0 * np.maximum(window.high, 1e-9) * (u[:, 0] - arm.angle[0]))
    return np.where(window.is_open, effort, np.inf)


def _cell_keys(u: Floats, size: Sizes) -> Ints:
    """Number (K,), not negative, of the cell in which each release (K, 4) lands."""
    cell = np.floor(land(u, BLOCK.half_height)[:, :3] / np.array(size)).astype(np.int64) + SPAN // 2
    return (cell[:, 0] * SPAN + cell[:, 1]) * SPAN + cell[:, 2]


def _cell_indices(key: Ints) -> Ints:
    """Indices (K, 3) of cells from their numbers (K,)."""
    return np.stack([key // SPAN**2, key // SPAN % SPAN, key % SPAN], axis=1) - SPAN // 2


def accessible_findings(samples: Counts = SAMPLES) -> Findings:
    """Numbers of cells by the bound on the space, at three torques, and a drawing of slices of the space."""
    cells_by_speed = {times: reachable_cells(times, samples) for times in FASTER}
    rows = [
        claim_row(cells_by_speed[FASTER[-1]], samples),
        *(_baseline_row(times, cells, samples) for times, cells in cells_by_speed.items()),
        *(_motor_row(torque, samples) for torque in TORQUES),
        _whole_arm_row(samples),
    ]
    figures = {"miyashita_accessible.svg": slices_figure(cells_by_speed[FASTER[-1]], samples)}
    data = {"miyashita_accessible": {"cell": CELL, "samples": samples}}
    return table_findings("Accessible space", rows, figures, data, drop="miyashita/")


@cache
def _space(torque: float, samples: Counts) -> AccessibleSpace:
    # The torque at full speed is the same share of the largest torque as with the published motor.
    at_speed = torque * ARM.torque_at_speed / ARM.torque
    return accessible_space(arm=replace(ARM, torque=torque, torque_at_speed=at_speed), samples=samples)


def _loss(cells: Ints, baseline: Ints) -> float:
    """Share of the baseline's cells that are lost [%]."""
    return 100.0 * (1.0 - len(cells) / len(baseline))


def claim_row(arm_cells: Ints, samples: Counts) -> Row:
    """Row on the claim that motor and dynamic grasp take most of the cells (K, 3) that the arm alone reaches."""
    space = _space(TORQUES[0], samples)
    loss, dynamics = _loss(space.cells, arm_cells), _loss(space.cells, space.kinematic)
    return Row.compared(
        "miyashita/claim/accessible-space-much-narrower",
        "considerably narrower",
        f"{loss:.1f} % fewer",
        "-",
        holds=loss >= CONSIDERABLE,
        note=f"dy = 0, cells of 2 cm x 2 cm x 5 deg: the arm's range and length alone reach {len(arm_cells)} within "
        f"one turn; the motor and the dynamic grasp leave {len(space.cells)}, and a loss of {CONSIDERABLE:.0f} % or "
        f"more counts as considerable. Most of it is the motor's speed, which alone leaves {len(space.kinematic)}; "
        f"torque, grasp and a motion from rest take {dynamics:.1f} % of those",
        cells=len(space.cells),
        kinematic=len(space.kinematic),
        reach=len(arm_cells),
        lost=loss,
    )


def _baseline_row(times: int, cells: Ints, samples: Counts) -> Row:
    space = _space(TORQUES[0], samples)
    note = (
        f"cells with dy = 0 within one turn by the arm's range and length, if it could turn {times} times as fast "
        f"as it does, {4 * times} pi rad/s: {_loss(space.kinematic, cells):.0f} % of them are lost to the motor's "
        f"speed, {_loss(space.cells, cells):.0f} % to speed, torque and grasp"
    )
    return Row.ours(f"miyashita/accessible/reach-{4 * times}pi", float(len(cells)), "-", note=note)


def _motor_row(torque: float, samples: Counts) -> Row:
    space = _space(torque, samples)
    share_left = 100.0 - _loss(space.cells, space.kinematic)
    return Row.ours(
        f"miyashita/accessible/torque-{torque:g}",
        float(len(space.cells)),
        "-",
        note=f"cells with dy = 0 at a largest torque of {torque:g} N m, {share_left:.0f} % of those that reach and "
        f"speed allow; {len(space.grasp)} if only the release has to keep grasp and torque",
        kinematic=len(space.kinematic),
        release_only=len(space.grasp),
    )


def _whole_arm_row(samples: Counts) -> Row:
    """Row with the cells of an arm whose largest radius is its whole half length, with the block overhanging."""
    longer = ARM.length + 2.0 * BLOCK.half_length
    # A thinner plate with the same inertia about the pivot as the published plate.
    arm = replace(ARM, length=longer, thickness=ARM.thickness * (ARM.length / longer) ** 3)
    space = accessible_space(arm=arm, samples=samples)
    return Row.ours(
        "miyashita/accessible/overhanging-block",
        float(len(space.cells)),
        "-",
        note=f"cells if the block's middle may lie at the very end of the arm, 0.31 m instead of 0.28 m; "
        f"{len(space.kinematic)} by reach and speed alone",
        kinematic=len(space.kinematic),
        release_only=len(space.grasp),
    )


def slices_figure(arm_cells: Ints, samples: Counts) -> Figure:
    """Drawing of Fig. 8 as slices: cells of some angles in the plane, by the bound that admits them."""
    from matplotlib.patches import Circle  # noqa: PLC0415 - heavy, needed for drawings only

    figure, axes = subplots(3, 2, (WIDTH, 8.0), sharex=True, sharey=True)
    strong, weak = _space(TORQUES[0], samples), _space(TORQUES[1], samples)
    layers = (
        (arm_cells, "#dedede", f"reach alone (to {4 * FASTER[-1]}π rad/s)"),
        (strong.kinematic, "#8c8c8c", "and the motor's speed"),
        (strong.cells, COLOURS[0], f"with grasp and {TORQUES[0]:g} N m"),
        (weak.cells, COLOURS[1], f"with grasp and {TORQUES[1]:g} N m"),
    )
    for panel, angle in zip(axes, SLICES, strict=True):
        index = round(np.deg2rad(angle) / CELL[2])
        for cells, colour, label in layers:
            _fill(panel, cells[cells[:, 2] == index, :2], colour, label)
        panel.add_patch(Circle((0.0, 0.0), 0.5 * ARM.length, fill=False, color="black", linewidth=0.8, linestyle=":"))
        panel.plot(0.0, 0.0, "o", color="black", markersize=3)
        if angle == 150.0:
            panel.plot(0.0, 0.4, "*", color=COLOURS[3], markersize=9, label="the paper's goal")
        dress(panel, "x [m]", "y [m]", f"arriving at {angle:.0f}° to {angle + 5.0:.0f}°")
        panel.set_aspect("equal")
        panel.label_outer()
    handles, labels = axes[SLICES.index(150.0)].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, ncols=2, loc="outside lower center", markerscale=1.6)
    figure.suptitle("where a block can be with no vertical speed; the circle is the arm's reach", fontsize=11)
    return figure


def _fill(axes: Axes, cells: Ints, colour: str, label: str) -> None:
    """Fill those cells (K, 2) of the plane that lie in the picture."""
    from matplotlib.colors import ListedColormap  # noqa: PLC0415 - heavy, needed for drawings only

    axes.scatter([], [], s=25, marker="s", color=colour, label=label, linewidths=0)
    low, high = np.array([-35, -20]), np.array([50, 40])
    inside = ((cells >= low) & (cells < high)).all(axis=1)
    filled = np.full(tuple(high - low), np.nan)
    filled[tuple((cells[inside] - low).T)] = 1.0
    (left, bottom), (right, top) = low * CELL[0], high * CELL[0]
    axes.imshow(
        filled.T, cmap=ListedColormap([colour]), extent=(left, right, bottom, top), origin="lower", interpolation="none"
    )
