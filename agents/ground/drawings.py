"""Drawing tools: figures as SVG, with the same bytes for the same data."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .small_svg import small_svg

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.figure
    from matplotlib.typing import LegendLocType

Axes: TypeAlias = "matplotlib.axes.Axes"
Figure: TypeAlias = "matplotlib.figure.Figure"
"""Matplotlib's figure; the heavy library is imported only where something is drawn."""
WIDTH: Final = 6.6
"""Width of a figure whose text a phone still shows at a legible size [inch]."""
RASTER: Final = 200
"""Pixels per inch of what a drawing holds as pixels: clouds of thousands of points."""
COLOURS: Final = (
    "#4c72b0", "#dd8452", "#55a868", "#c44e52", "#8172b3", "#937860", "#da8bc3", "#8c8c8c", "#ccb974", "#64b5cd",
    "#2f4b26", "#000000",
)  # fmt: skip


def svg(figure: Figure) -> str:
    """A figure as SVG text, the same bytes for the same data."""
    import matplotlib as mpl  # noqa: PLC0415 - heavy, needed for reports only

    buffer = io.StringIO()
    # Without salt and with a date, two runs over the same data would differ.
    with mpl.rc_context({"svg.hashsalt": "pnt_gym", "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", bbox_inches="tight", metadata={"Date": None}, dpi=RASTER)
    return small_svg(buffer.getvalue())


def subplots(rows: int, columns: int, size: tuple[float, float], **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure of a size in inches and its axes, row by row."""
    from matplotlib.figure import Figure as MatplotlibFigure  # noqa: PLC0415 - heavy, needed for reports only

    figure = MatplotlibFigure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    return figure, list(axes.ravel())


def tile_panels(count: int, columns: int, size: tuple[float, float], **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure with `count` panels, each of a size in inches, in rows of `columns`; and its panels."""
    columns = min(count, columns)
    rows = -(-count // columns)
    figure, panels = subplots(rows, columns, (size[0] * columns, size[1] * rows), **options)
    for unused in panels[count:]:
        unused.set_visible(False)
    return figure, panels[:count]


def stacked_panels(width: float, heights: Sequence[float]) -> tuple[Figure, list[Any]]:
    """A figure of a width in inches, and its parts below one another, each of a height in inches."""
    from matplotlib.figure import Figure as MatplotlibFigure  # noqa: PLC0415 - heavy, needed for reports only

    figure = MatplotlibFigure(figsize=(width, sum(heights)), layout="constrained")
    parts = figure.subfigures(len(heights), 1, squeeze=False, height_ratios=list(heights))
    return figure, list(parts.ravel())


def dress(
    axes: Axes, across: str, up: str, title: str = "", *, legend: LegendLocType | None = None, **options: Any
) -> None:
    """Set the names of both axes, a title, a pale grid, a legend at a place, and other properties of `Axes.set`."""
    axes.set(xlabel=across, ylabel=up, **options)
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.3)
    if legend is not None:
        axes.legend(fontsize=8, loc=legend)


def say_start(axes: Axes) -> None:
    """Say at a linear vertical axis where it begins, if that is above zero."""
    if axes.get_yscale() == "linear" and (start := axes.get_ylim()[0]) > 0.0:
        axes.set_ylabel(f"{axes.get_ylabel()} (axis from {start:.3g})")


def frames_figure(frames: Sequence[tuple[str, NDArray[np.uint8]]]) -> Figure:
    """A figure of equal pictures (height, width, 3) in rows of two, each with its title."""
    high, wide = frames[0][1].shape[:2]
    panel_width = WIDTH / 2
    figure, axes = tile_panels(len(frames), 2, (panel_width, panel_width * high / wide + 0.3))
    for panel, (title, frame) in zip(axes, frames, strict=True):
        panel.imshow(frame, interpolation="none")
        panel.set_title(title, fontsize=10)
        panel.set_axis_off()
    return figure


ZOOM: Final = 4.0
"""Height of the picture, as a multiple of the widest interval at the end or of the differences."""


def intervals(report: Mapping[str, Any]) -> str:
    """Mean difference and interval of every pair over the units, with zero and the margin, as SVG.

    Args:
        report: report of a comparison.
    """
    figure = next(iter(report["figures"].values()))
    picture, (axes,) = subplots(1, 1, (7.5, 4.2))
    reach = 0.0
    for number, pair in enumerate(report["pairs"]):
        trace = np.array(pair["trace"], dtype=np.float64).reshape(-1, 4)
        count, (value, low, high) = trace[:, 0], figure["scale"] * trace[:, 1:].T
        colour = COLOURS[number % len(COLOURS)]
        axes.fill_between(count, low, high, step="post", color=colour, alpha=0.25, linewidth=0.0)
        axes.step(count, value, where="post", color=colour, label=f"{pair['a']} minus {pair['b']}")
        if pair["settled"] is not None:
            axes.axvline(pair["settled"], color=colour, linestyle=":", linewidth=1.0)
        if len(trace):
            reach = max(reach, float(high[-1] - low[-1]), float(np.abs(value).max()))
    axes.axhline(0.0, color="black", linewidth=1.0)
    for margin in () if report["margin"] is None else (-report["margin"], report["margin"]):
        axes.axhline(figure["scale"] * margin, color="black", linestyle="--", linewidth=0.8)
    limits = {"ylim": (-ZOOM * reach / 2.0, ZOOM * reach / 2.0)} if reach else {}
    up = f"difference in {figure['label']} [{figure['unit']}]" if figure["unit"] else f"difference in {figure['label']}"
    title = f"{report['env']}, level {report['level']}: 95 % intervals, valid at all times"
    dress(axes, f"{report['unit']} of each controller", up, title, legend="best", **limits)
    return svg(picture)
