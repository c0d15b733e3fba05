"""Figures of the benchmark as SVG."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = (
    "#4c72b0", "#dd8452", "#55a868", "#c44e52", "#8172b3", "#937860", "#da8bc3", "#8c8c8c", "#ccb974", "#64b5cd",
    "#2f4b26", "#000000",
)  # fmt: skip
THROW_TICKS = (30, 100, 300, 1000, 3000, 10_000, 30_000)


def benchmark_figures(data: Mapping[str, Any]) -> dict[str, str]:
    """SVG texts by file name."""
    drawn = {
        "landing_error.svg": error_bars(data),
        "learning_curves.svg": learning_curves(data),
        "landing_clouds.svg": landing_clouds(data),
    }
    return {name: svg(figure) for name, figure in drawn.items()}


def svg(figure: Figure) -> str:
    """A figure as SVG text, the same bytes for the same data."""
    import matplotlib as mpl  # noqa: PLC0415 - heavy, needed for reports only

    buffer = io.StringIO()
    # Without salt and with a date, two runs over the same data would differ.
    with mpl.rc_context({"svg.hashsalt": "pnt_gym", "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", bbox_inches="tight", metadata={"Date": None})
    return buffer.getvalue()


def error_bars(data: Mapping[str, Any]) -> Figure:
    """Mean landing error of every controller, one panel per level, with 95 % intervals."""
    levels = data["plan"]["levels"]
    order = [entry["label"] for entry in data["plan"]["entries"]]
    figure, panels = subplots(1, len(levels), (5.2 * len(levels), 0.3 * _most_rows(data) + 1.0))
    for axes, level in zip(panels, levels, strict=True):
        rows = [row for row in data["table"] if row["level"] == level]
        rows.sort(key=lambda row: (order.index(row["label"]), row["throws"]))
        places = np.arange(len(rows))
        value, low, high = (
            1000 * np.array([row[f"landing_error_{part}_m"] for row in rows]) for part in ("mean", "low", "high")
        )
        colours = [COLOURS[order.index(row["label"]) % len(COLOURS)] for row in rows]
        axes.barh(places, value, color=colours, height=0.7)
        axes.errorbar(value, places, xerr=[value - low, high - value], fmt="none", ecolor="black", capsize=2)
        axes.set_yticks(places, [_name(row) for row in rows])
        axes.invert_yaxis()
        axes.set_xlabel("landing error, mean [mm]")
        axes.set_title(f"level {level}")
        axes.grid(axis="x", alpha=0.3)
        axes.set_axisbelow(True)
    return figure


def learning_curves(data: Mapping[str, Any]) -> Figure:
    """Landing error over the throws learned from; controllers that do not learn are lines."""
    levels = data["plan"]["levels"]
    order = [entry["label"] for entry in data["plan"]["entries"]]
    figure, panels = subplots(1, len(levels), (5.2 * len(levels), 4.0))
    for axes, level in zip(panels, levels, strict=True):
        for label in order:
            rows = [row for row in data["table"] if (row["level"], row["label"]) == (level, label)]
            rows.sort(key=lambda row: row["throws"])
            if rows:
                _curve(axes, rows, label, COLOURS[order.index(label) % len(COLOURS)])
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xticks(THROW_TICKS, [f"{ticks:,}" for ticks in THROW_TICKS])
        most = max([row["throws"] for row in data["table"] if not row["label"].startswith("floor")] or [0])
        axes.set_xlim(20, max(2000, 2 * most))
        axes.set_yticks([2, 5, 10, 20, 50, 100], ["2", "5", "10", "20", "50", "100"])
        axes.minorticks_off()
        axes.set_xlabel("throws learned from")
        axes.set_ylabel("landing error, mean [mm]")
        axes.set_title(f"level {level}")
        axes.grid(alpha=0.3)
    # Not every controller is in every panel.
    shown = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(shown.values(), shown.keys(), fontsize=8, loc="outside right center")
    return figure


def landing_clouds(data: Mapping[str, Any], most: int = 4) -> Figure:
    """Where objects landed against the target, along and across the throw."""
    level = data["plan"]["levels"][0]
    chosen = _cloud_choices(data, level)[:most]
    figure, panels = subplots(1, len(chosen), (3.4 * len(chosen), 3.4), sharex=True, sharey=True)
    for axes, result in zip(panels, chosen, strict=True):
        along, across = (1000 * np.array(result["columns"][c], dtype=float) for c in ("along_m", "across_m"))
        axes.scatter(along, across, s=4, alpha=0.4, color=COLOURS[0], linewidths=0)
        axes.axhline(0, color="black", linewidth=0.6)
        axes.axvline(0, color="black", linewidth=0.6)
        axes.plot(np.nanmean(along), np.nanmean(across), "+", color=COLOURS[3], markersize=12, markeredgewidth=2)
        axes.set_title(_name(result), fontsize=10)
        axes.set_xlim(-150, 150)
        axes.set_ylim(-150, 150)
        axes.set_aspect("equal")
        axes.set_xlabel("along the throw [mm]")
    panels[0].set_ylabel("across [mm]")
    return figure


def _curve(axes: Axes, rows: list[Mapping[str, Any]], label: str, colour: str) -> None:
    error = [1000 * row["landing_error_mean_m"] for row in rows]
    if rows[0]["throws"] == 0 or label.startswith("floor"):
        axes.axhline(error[-1], color=colour, linestyle="--", linewidth=1, label=label)
        return
    low, high = ([1000 * row[f"landing_error_{side}_m"] for row in rows] for side in ("low", "high"))
    spread = [np.subtract(error, low), np.subtract(high, error)]
    axes.errorbar([row["throws"] for row in rows], error, yerr=spread, marker="o", color=colour, label=label, capsize=2)


def _cloud_choices(data: Mapping[str, Any], level: str) -> list[Mapping[str, Any]]:
    """The planner, the references after most throws, the first learner: one seed each."""
    plan = data["plan"]
    learned = plan["learned"][:1]
    wanted = [("analytic", 0)]
    for label in ("virtual_goal", "mean_shift"):
        throws = [c["throws"] for c in plan["references"] if c["label"] == label]
        wanted += [(label, max(throws))] if throws else []
    wanted += [(c["label"], c["throws"]) for c in learned]
    first = {(r["label"], r["throws"]): r for r in reversed(data["results"]) if r["level"] == level}
    return [first[key] for key in wanted if key in first]


def _most_rows(data: Mapping[str, Any]) -> int:
    levels = [row["level"] for row in data["table"]]
    return max(levels.count(level) for level in set(levels))


def _name(row: Mapping[str, Any]) -> str:
    return f"{row['label']} ({row['throws']})" if row["throws"] else str(row["label"])


def subplots(rows: int, columns: int, size: tuple[float, float], **options: Any) -> tuple[Figure, list[Axes]]:
    """A figure of a size in inches and its axes, row by row."""
    from matplotlib.figure import Figure as MatplotlibFigure  # noqa: PLC0415 - heavy, needed for reports only

    figure = MatplotlibFigure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    return figure, list(axes.ravel())


def frames_figure(frames: Sequence[tuple[str, NDArray[np.uint8]]], columns: int = 2, width: float = 10.0) -> Figure:
    """Pictures of one size (height, width, 3) with a title each, in rows; the width of the whole is in inches."""
    rows = -(-len(frames) // columns)
    high, wide = frames[0][1].shape[:2]
    figure, axes = subplots(rows, columns, (width, width * rows * high / (columns * wide) + 0.3 * rows))
    for panel, (title, frame) in zip(axes, frames, strict=False):
        panel.imshow(frame, interpolation="none")
        panel.set_title(title, fontsize=10)
        panel.set_axis_off()
    return figure
