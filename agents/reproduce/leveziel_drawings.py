"""Drawings of the gripper robot's workspace: sections with kappa as a colour map, and the circle in its sections."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from agents.report.figures import COLOURS, subplots
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.robots.gripper4 import CIRCLE_RADIUS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOUR_MAP: Final = "viridis"
FULL, REDUCED = COLOURS[0], "black"
"""Boundaries without and with the motors' strokes, in the paper's colours."""
PALE: Final = 0.45
LARGEST: Final = 0.65
"""kappa at the upper end of the colours."""


class Section(NamedTuple):
    """A plane cut through the workspace; arrays (M, K) over `across` (M,) and `up` (K,) [m]."""

    name: str
    across: Floats
    up: Floats
    kappa: Floats
    full: Bools
    reduced: Bools

    @property
    def pixel(self) -> float:
        """Spacing [m]."""
        return float(self.across[1] - self.across[0])


def sections_figure(sections: Mapping[str, Section]) -> Figure:
    """Three sections at -45 deg (Fig. 5)."""
    figure, axes = subplots(1, 3, (13.0, 4.6))
    image = None
    for panel, (name, cut) in zip(axes, sections.items(), strict=True):
        image = _kappa_map(panel, cut)
        where = {"x-y": "z = -200 mm", "x-z": "y = 0", "y-z": "x = 0"}[name]
        panel.set_title(f"{name} section at {where}", fontsize=10)
        across, up = name.split("-")
        panel.set_xlabel(f"{across} [mm]")
        panel.set_ylabel(f"{up} [mm]")
    _colour_bar(figure, image, axes)
    _boundary_legend(figure)
    figure.suptitle("inverse condition number κ at θ = -45°; pale where only the strokes forbid the pose", fontsize=11)
    return figure


def turned_figure(sections: Mapping[float, tuple[Section, Section]]) -> Figure:
    """Two sections at other angles (the paper's video)."""
    figure, axes = subplots(2, len(sections), (2.6 * len(sections), 5.2), sharey="row")
    image = None
    for k, (degrees, cuts) in enumerate(sections.items()):
        for row, cut in enumerate(cuts):
            panel = axes[row * len(sections) + k]
            image = _kappa_map(panel, cut)
            panel.set_xlabel(f"{cut.name[0]} [mm]", fontsize=9)
            panel.tick_params(labelsize=8)
        axes[k].set_title(f"θ = {degrees:.0f}°", fontsize=10)
    axes[0].set_ylabel("y [mm], z = -200 mm", fontsize=9)
    axes[len(sections)].set_ylabel("z [mm], x = 0", fontsize=9)
    _colour_bar(figure, image, axes)
    _boundary_legend(figure)
    figure.suptitle("κ over the angle of the platform's halves", fontsize=11)
    return figure


def circle_figure(
    heights: Floats, curves: Mapping[float, Floats], cuts: Mapping[float, tuple[Floats, Bools]]
) -> Figure:
    """The circle in sections at some heights, and its share of the section's area and radius over the height.

    Args:
        heights: (H,) [m].
        curves: by angle [deg], (H, 2): area over the section's, radius that fits [m].
        cuts: by height [m], coordinates (M,) and where the workspace is (M, M).
    """
    figure, (plane, shares) = subplots(1, 2, (11.0, 4.6))
    for colour, (height, (axis, inside)) in zip(COLOURS, cuts.items(), strict=False):
        millimetres = 1e3 * axis
        plane.contour(millimetres, millimetres, inside.T.astype(float), levels=[0.5], colors=[colour])
        plane.plot([], [], color=colour, label=f"z = {1e3 * height:.0f} mm")
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    rim = 1e3 * CIRCLE_RADIUS * np.array([np.cos(turn), np.sin(turn)])
    plane.plot(*rim, "--", color="black", linewidth=1.2, label="circle of 80 mm")
    plane.set_aspect("equal")
    plane.set_xlim(-160, 160)
    plane.set_ylim(-135, 135)
    plane.set_xlabel("x [mm]")
    plane.set_ylabel("y [mm]")
    plane.set_title("reduced workspace at θ = -45°", fontsize=10)
    plane.legend(fontsize=8, loc="lower left")
    plane.grid(alpha=0.3)
    for colour, (degrees, values) in zip(COLOURS[4:], curves.items(), strict=False):
        fits = values[:, 1] >= CIRCLE_RADIUS
        area = 100.0 * np.where(fits, values[:, 0], np.nan)
        radius = 100.0 * np.where(fits, CIRCLE_RADIUS / values[:, 1], np.nan)
        shares.plot(1e3 * heights, area, color=colour, label=f"of the area, θ = {degrees:.0f}°")
        shares.plot(1e3 * heights, radius, "--", color=colour, label=f"of the radius that fits, θ = {degrees:.0f}°")
    shares.axhline(80.0, color="black", linewidth=0.8, linestyle=":", label="published: almost 80 %")
    shares.set_xlim(-255, -160)
    shares.set_ylim(20.0, 105.0)
    shares.set_xlabel("height z [mm]")
    shares.set_ylabel("share of the circle [%]")
    shares.set_title("where the circle fits", fontsize=10)
    shares.legend(fontsize=8)
    shares.grid(alpha=0.3)
    return figure


def _kappa_map(axes: Axes, cut: Section) -> Any:
    """Colours where the robot reaches, pale where the strokes forbid it, and both boundaries."""
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


def _colour_bar(figure: Figure, image: Any, axes: list[Axes]) -> None:
    bar = figure.colorbar(image, ax=axes, fraction=0.02, pad=0.01)
    bar.set_label("inverse condition number κ")


def _boundary_legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D  # noqa: PLC0415 - heavy, needed for drawings only

    lines = [Line2D([], [], color=FULL), Line2D([], [], color=REDUCED), Line2D([], [], color="gray", linestyle="--")]
    names = ["full workspace (Eq. 7)", "reduced workspace, strokes -85° to 45°", "κ = 0.5 (white)"]
    figure.legend(lines, names, fontsize=9, ncols=3, loc="outside lower center")
