"""Workspace of Leveziel et al. (Fig. 5 and the video): sections with kappa, shares, extent, singularities.

Sections are drawn through the position that the paper's Fig. 6 names; its Fig. 5 does not name the planes of its cuts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final, NamedTuple

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots, tile_panels
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Bools, Floats
from pnt_gym.robots.gripper import inverse_kinematics, kappa, singular_angle, singularity

from .cases import (
    AROUND,
    CENTRE,
    HOME_THETA,
    PAPER_COUNT,
    PAPER_STEP,
    PIXEL,
    SIDE,
    is_reachable,
    lowest_pose,
    millimetres,
    poses_at,
    reduced,
)
from .scan import scan_workspace

PLANES: Final = {"x-y": (0, 1), "x-z": (0, 2), "y-z": (1, 2)}
"""Sections by name, and the indices of their two coordinates."""
WHERE: Final = {"x-y": "z = -200 mm", "x-z": "y = 0", "y-z": "x = 0"}
TURNED: Final = (-60.0, -30.0, 0.0, 30.0, 45.0, 55.0)
"""Angles of the halves at which kappa is drawn anew, from the paper's video [deg]."""
ROUND_STEPS: Final = (0.004, 0.0045, 0.005)
"""Round grid steps at which positions are counted [m]."""
LEAST: Final = 0.3
"""Published bound of kappa at -45 deg."""
BOUND: Final = f"> {LEAST:g}"
GOOD, POOR, DEAD = 0.5, 0.1, 0.01
"""Thresholds of kappa: rows give shares over the first and under the second; below the third kappa is close to zero."""
MAJORITY: Final = 50.0
"""Share above which the paper's word "majority" holds [%]."""
COLOUR_MAP: Final = "viridis"
FULL, REDUCED = COLOURS[0], "black"
"""Boundaries without and with the motors' strokes, in the paper's colours."""
PALE: Final = 0.45
"""Opacity of the colours where the strokes forbid the pose."""
LARGEST: Final = 0.65
"""kappa at the upper end of the colours."""


class Section(NamedTuple):
    """A plane section of the workspace; arrays (M, K) over `across` (M,) and `up` (K,) [m]."""

    across: Floats
    up: Floats
    kappa: Floats
    full: Bools
    reduced: Bools

    @property
    def pixel(self) -> float:
        """Spacing of the section's points [m]."""
        return float(self.across[1] - self.across[0])


def workspace_findings(step: float = PAPER_STEP, pixel: float = PIXEL) -> Findings:
    """Sections and shares of kappa at -45 deg, the number of positions, and singular positions."""
    sections = {name: section(name, HOME_THETA, pixel) for name in PLANES}
    rows = (
        *_size_rows(step),
        *_kappa_rows(step),
        *_share_rows(sections),
        _positive_angle_row(step, pixel),
        *_singularity_rows(step),
    )
    figures = {"leveziel_workspace.svg": sections_figure(sections), "leveziel_theta.svg": angles_figure(2.0 * pixel)}
    space = reduced(step)
    data = {"step": step, "positions": len(space.positions), "extent": space.extent.tolist()}
    return table_findings("Workspace and manipulability", rows, figures, {"leveziel_workspace": data}, drop="leveziel/")


def section(name: str, theta: float, pixel: float) -> Section:
    """Kappa over a plane section through the centre, and masks of the full and the reduced workspace."""
    across, up = (_axis(k, pixel) for k in PLANES[name])
    positions = np.tile(np.array(CENTRE), (across.size, up.size, 1))
    first, second = PLANES[name]
    positions[..., first], positions[..., second] = across[:, None], up[None, :]
    poses = poses_at(positions, theta)
    return Section(across, up, kappa(poses), np.isfinite(inverse_kinematics(poses)[..., 0]), is_reachable(poses))


def _axis(coordinate: int, pixel: float) -> Floats:
    low, high = (-0.31, 0.0) if coordinate == 2 else (-SIDE, SIDE)
    return pixel * np.arange(round(low / pixel), round(high / pixel) + 1, dtype=np.float64)


def _size_rows(step: float) -> Iterator[Row]:
    space = reduced(step)
    full = scan_workspace(step, reduced=False)
    counts = {f"{1e3 * s:g} mm": len(reduced(s).positions) for s in ROUND_STEPS}
    counts_elsewhere = {
        f"{1e3 * s:g} mm, {degrees} deg": len(scan_workspace(s, np.deg2rad(degrees)).positions)
        for s, degrees in ((0.0045, -60), (0.0048, -30), (0.005, 0))
    }
    ends = zip("xyz", *(1e3 * space.extent), strict=True)
    yield Row.missing(
        "leveziel/workspace/positions",
        float(PAPER_COUNT),
        "-",
        reproduced=float(len(space.positions)),
        note=f"positions of the reduced workspace at -45 deg with a step of {1e3 * step:.2f} mm; neither step nor "
        f"angle is printed, and round steps give {_format_counts(counts)} at -45 deg and "
        f"{_format_counts(counts_elsewhere)} elsewhere",
        counts=counts,
        counts_at_other_angles=counts_elsewhere,
    )
    note = (
        f"of the reduced workspace at -45 deg, {100.0 * space.volume / full.volume:.0f} % of the full one below the "
        "base"
    )
    yield Row.ours("leveziel/workspace/volume", space.volume, "m3", note=note, full=full.volume)
    yield Row.ours(
        "leveziel/workspace/extent",
        ", ".join(f"{axis} {low:.0f} to {high:.0f} mm" for axis, low, high in ends),
        "-",
        note=f"of the reduced workspace at -45 deg on a grid of {1e3 * step:.2f} mm",
        extent=space.extent.tolist(),
    )


def _format_counts(counts: dict[str, int]) -> str:
    return ", ".join(f"{count:,} ({name})" for name, count in counts.items())


def _kappa_rows(step: float) -> Iterator[Row]:
    values = kappa(reduced(step).poses)
    least, largest = float(values.min()), float(values.max())
    tip, anywhere = lowest_pose(kappa, HOME_THETA)
    share = float(100.0 * (values > GOOD).mean())
    note = f"at -45 deg over the {len(values):,} positions of the reduced workspace"
    yield Row.compared("leveziel/fig-5/smallest-kappa", BOUND, least, "-", holds=least > LEAST, note=note)
    yield Row.compared(
        "leveziel/fig-5/smallest-kappa-anywhere",
        BOUND,
        anywhere,
        "-",
        holds=anywhere > LEAST,
        statement="leveziel/fig-5/smallest-kappa",
        note=f"between these positions, in the extreme tip ({millimetres(tip)}) mm where three motors stand at the "
        "ends of their strokes; below 0.3 for some millimetres only",
        position=tip.tolist(),
    )
    note = "share of the reduced workspace at -45 deg, by volume, where kappa exceeds 0.5"
    yield Row.compared(
        "leveziel/fig-5/over-0.5", "majority", share, "%", holds=share > MAJORITY, note=note, largest=largest
    )


def _share_rows(sections: Mapping[str, Section]) -> Iterator[Row]:
    for name, cut in sections.items():
        values = cut.kappa[cut.reduced]
        share = float(100.0 * (values > GOOD).mean())
        yield Row.compared(
            f"leveziel/fig-5/over-0.5-in-{name}",
            "majority of the surface",
            share,
            "%",
            holds=share > MAJORITY,
            note=f"of the reduced workspace's section at {WHERE[name]}; from {values.min():.3f} to {values.max():.3f}",
            smallest=float(values.min()),
            area_m2=float(cut.reduced.sum()) * cut.pixel**2,
        )


def _positive_angle_row(step: float, pixel: float) -> Row:
    quarter, negative = float(np.deg2rad(45.0)), (-90.0, -75.0, -60.0, -45.0, -30.0, -15.0)
    smallest = {f"{a:.0f}": float(kappa(reduced(2.0 * step, float(np.deg2rad(a))).poses).min()) for a in negative}
    dead = float(kappa(reduced(step, quarter).poses).min())
    cut = section("x-y", quarter, pixel)
    poor = 100.0 * float((cut.kappa[cut.reduced] < POOR).mean())
    axis = cut.kappa[:, cut.up.size // 2][cut.reduced[:, cut.up.size // 2]]
    return Row.compared(
        "leveziel/video/kappa-at-45-deg",
        "close to zero in central areas",
        dead,
        "-",
        holds=dead < DEAD,
        note=f"smallest in the reduced workspace at +45 deg, close to zero below {DEAD:g}; {poor:.0f} % of its section "
        f"at z = -200 mm are below {POOR:g}, on both sides of the line y = 0, where kappa stays at {axis.min():.2f} to "
        f"{axis.max():.2f}. At angles of -90 to -15 deg it is {min(smallest.values()):.2f} at least",
        smallest_at_negative_angles=smallest,
        poor_percent=poor,
    )


def _singularity_rows(step: float) -> Iterator[Row]:
    angles = singular_angle(reduced(step).positions)
    poses = np.column_stack([reduced(step).positions, angles])[np.isfinite(angles)]
    place, first = first_singular()
    anywhere = float(np.rad2deg(first))
    centre = float(singular_angle(CENTRE))
    before, after = (float(singularity([*CENTRE, centre + turn]).value) for turn in (-0.01, 0.01))
    yield Row.compared(
        "leveziel/video/first-singular-angle",
        45.0,
        float(np.rad2deg(poses[is_reachable(poses), 3].min())),
        "deg",
        within=AROUND,
        note=f"smallest theta with det J_x = 0 at one of the {len(angles):,} positions, strokes kept, to be within "
        f"{AROUND:g} deg of what the paper calls around 45 deg; {anywhere:.2f} deg between them, at "
        f"({millimetres(place)}) mm on the edge",
        anywhere=anywhere,
        position=place.tolist(),
    )
    note = (
        f"theta at which det J_x = 0 at x = y = 0, z = -200 mm; det J_x / (l^4 w) goes from {before:.4f} to "
        f"{after:.4f} within 0.01 rad of it"
    )
    yield Row.ours("leveziel/video/singular-centre", float(np.rad2deg(centre)), "deg", note=note)


def first_singular() -> tuple[Floats, float]:
    """The pose (4,) of the reduced workspace that is singular at the smallest theta, and this theta [rad]."""
    low, high, pose = HOME_THETA, float(np.deg2rad(60.0)), np.full(4, np.nan)
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        worst, value = lowest_pose(lambda poses: singularity(poses).value, middle)
        low, high = (low, middle) if value <= 0.0 else (middle, high)
        pose = worst if value <= 0.0 else pose
    return pose, high


def sections_figure(sections: Mapping[str, Section]) -> Figure:
    """Drawing of three sections at -45 deg (Fig. 5)."""
    figure, axes = tile_panels(3, 2, (WIDTH / 2, 3.1))
    image = None
    for panel, (name, cut) in zip(axes, sections.items(), strict=True):
        image = _draw_kappa_map(panel, cut)
        across, up = name.split("-")
        dress(panel, f"{across} [mm]", f"{up} [mm]", f"{name} section at {WHERE[name]}")
        panel.grid(visible=False)
    _draw_legends(figure, image, axes)
    figure.suptitle("inverse condition number κ at θ = -45°; pale where only the strokes forbid the pose", fontsize=11)
    return figure


def angles_figure(pixel: float) -> Figure:
    """Drawing of two sections at other angles (the paper's video)."""
    count = len(TURNED)
    figure, axes = subplots(count, 2, (WIDTH, 2.3 * count))
    image = None
    for k, degrees in enumerate(TURNED):
        for panel, name in ((axes[2 * k], "x-y"), (axes[2 * k + 1], "y-z")):
            image = _draw_kappa_map(panel, section(name, float(np.deg2rad(degrees)), pixel))
            panel.set_xlabel(f"{name[0]} [mm]", fontsize=9)
            panel.tick_params(labelsize=8)
            panel.set_title(f"θ = {degrees:.0f}°", fontsize=10)
        axes[2 * k].set_ylabel("y [mm], z = -200 mm", fontsize=9)
        axes[2 * k + 1].set_ylabel("z [mm], x = 0", fontsize=9)
    _draw_legends(figure, image, axes)
    figure.suptitle("κ over the angle of the platform's halves", fontsize=11)
    return figure


def _draw_kappa_map(axes: Axes, cut: Section) -> Any:
    """Draw kappa in colours, pale where the strokes forbid the pose, and the boundaries of both workspaces."""
    across, up, half = 1e3 * cut.across, 1e3 * cut.up, 0.5e3 * cut.pixel
    extent = (across[0] - half, across[-1] + half, up[0] - half, up[-1] + half)
    options: dict[str, Any] = {"extent": extent, "origin": "lower", "cmap": COLOUR_MAP, "vmin": 0.0, "vmax": LARGEST}
    axes.imshow(np.where(cut.full, cut.kappa, np.nan).T, alpha=PALE, **options)
    image = axes.imshow(np.where(cut.reduced, cut.kappa, np.nan).T, **options)
    for mask, colour in ((cut.full, FULL), (cut.reduced, REDUCED)):
        axes.contour(across, up, mask.T.astype(float), levels=[0.5], colors=[colour], linewidths=1.2)
    axes.contour(across, up, cut.kappa.T, levels=[0.5], colors=["white"], linewidths=0.9, linestyles="--")
    axes.set_aspect("equal")
    return image


def _draw_legends(figure: Figure, image: Any, axes: list[Axes]) -> None:
    """Draw the legends of the colours and of the boundaries."""
    from matplotlib.lines import Line2D  # noqa: PLC0415 - heavy, needed for drawings only

    figure.colorbar(image, ax=axes, fraction=0.02, pad=0.01).set_label("inverse condition number κ")
    lines = [Line2D([], [], color=FULL), Line2D([], [], color=REDUCED), Line2D([], [], color="gray", linestyle="--")]
    names = ["full workspace (Eq. 7)", "reduced workspace, strokes -85° to 45°", "κ = 0.5 (white)"]
    figure.legend(lines, names, fontsize=8, ncols=2, loc="outside lower center")
