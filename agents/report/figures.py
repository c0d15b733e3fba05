"""Figures of the benchmark as SVG, and what the report shows of a benchmark by the kind of task."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from ..ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, say_start, subplots, svg, tile_panels
from ..ground.looks import colours, said
from ..ground.metrics import Interval
from ..ground.tables import Grid
from ..judging import figures as judged
from . import headline, line, profiles, tables
from .line import gains_figure
from .profiles import profiles_figure
from .tables import conditions, is_of_shifts, labels, name_of, other_level_tables, rows_of, side_by_side


class Measure(NamedTuple):
    """What curves show.

    Attributes:
        names: keys of the mean and of the ends of its interval.
        scale: factor on them.
        said: what it is called.
        learned_from: what is counted of the learning.
        hidden: a controller so far off that the others would lie on each other.
        ticks: of the figure, on an axis that is logarithmic; none for one that is not.
        counts: ticks of what is learned from; none for those that were measured.
    """

    names: tuple[str, str, str]
    scale: float
    said: str
    learned_from: str
    hidden: str = ""
    ticks: tuple[int, ...] = ()
    counts: tuple[int, ...] = ()


VALUE: Final = Measure(
    ("value_per_min", "value_per_min_low", "value_per_min_high"),
    1.0,
    "value a minute",
    "decisions learned from",
    hidden="random",
)
THROW_TICKS = (100, 1000, 10_000)
ERROR_TICKS = (2, 5, 10, 20, 50, 100)
ERROR: Final = Measure(
    ("landing_error_mean_m", "landing_error_low_m", "landing_error_high_m"),
    1000.0,
    "landing error [mm], logarithmic",
    "throws learned from",
    ticks=ERROR_TICKS,
    counts=THROW_TICKS,
)
ADAPTING = ("static", "ema", "kalman", "recursive_ridge", "in_context", "recurrent_ppo", "oracle_drift")
NAMED_BESIDE = 4
"""Names in a row of the legend."""
SMOOTHED = 5
"""Picks over which a curve is averaged."""


def throw_figures(data: Mapping[str, Any]) -> dict[str, str]:
    """SVG texts of a benchmark of throws, by file name; no clouds of a cell that tells its errors only.

    A plan in which every controller learns from one number of throws, or from none, has no figures over throws.
    """
    if is_of_shifts(data):
        return {"over_the_shift.svg": svg(over_the_shift(data))}
    # Some controller has learned from several numbers of throws.
    counts = {(row["label"], row["throws"]) for row in data["table"] if row["throws"] > 0}
    has_curves = len(counts) > len({label for label, _ in counts})
    drawn = {"sorted_per_min.svg": headline.figure(data)} if has_curves else {}
    drawn["landing_error.svg"] = bars(data)
    if has_curves:
        drawn["learning_curves.svg"] = learning_curves(data, ERROR)
    if len(profiles.errors(data)) > 1:
        drawn["profiles.svg"] = profiles_figure(data)
    # The planner, the references after most throws, the first learner on the first level: one seed each.
    plan = data["plan"]
    choices = [("analytic", 0)]
    throws = [c["throws"] for c in plan["references"] if c["label"] == "virtual_goal"]
    choices += [("virtual_goal", max(throws))] if throws else []
    choices += [(c["label"], c["throws"]) for c in plan["learned"][:1]]
    on_first = [r for r in reversed(data["results"]) if r["level"] == plan["levels"][0] and "along_m" in r["columns"]]
    first = {(r["label"], r["throws"]): r for r in on_first}
    clouds = [first[key] for key in choices if key in first]
    if clouds:
        drawn["landing_clouds.svg"] = landing_clouds(clouds)
    return {name: svg(figure) for name, figure in drawn.items()}


def bars(data: Mapping[str, Any]) -> Figure:
    """Landing error of every controller, a panel for each level, one below another, with 95 % intervals."""
    levels, colour = data["plan"]["levels"], colours(labels(data))
    row_count = max(len(rows_of(data, [level])) for level in levels)
    figure, panels = subplots(len(levels), 1, (WIDTH, (0.24 * row_count + 0.9) * len(levels)))
    for axes, level in zip(panels, levels, strict=True):
        rows = rows_of(data, [level])
        places = np.arange(len(rows))
        value, low, high = (ERROR.scale * np.array([row[name] for row in rows]) for name in ERROR.names)
        axes.barh(places, value, color=[colour[row["label"]] for row in rows], height=0.7)
        axes.errorbar(value, places, xerr=[value - low, high - value], fmt="none", ecolor="black", capsize=2)
        axes.set_yticks(places, [name_of(row) for row in rows])
        axes.invert_yaxis()
        axes.set(xlabel=ERROR.said, title=f"level {level}", axisbelow=True)
        axes.grid(axis="x", alpha=0.3)
    return figure


def learning_curves(data: Mapping[str, Any], measure: Measure) -> Figure:
    """A figure over the throws or decisions learned from; controllers that do not learn are lines."""
    levels = data["plan"]["levels"]
    figure, panels = tile_panels(len(levels), 2, (WIDTH / 2 if len(levels) > 1 else WIDTH, 3.2))
    greatest_count = max([row["throws"] for row in data["table"] if not row["label"].startswith("floor")] or [0])
    for axes, level in zip(panels, levels, strict=True):
        for label, colour in colours(labels(data)).items():
            rows = [row for row in rows_of(data, [level]) if row["label"] == label]
            if rows and rows[0]["controller"] != measure.hidden:
                _draw(axes, rows, label, colour, measure)
        axes.set(xscale="log", xlabel=measure.learned_from, ylabel=measure.said, title=f"level {level}")
        if measure.ticks:
            axes.set_yscale("log")
            axes.set_yticks(measure.ticks, [str(tick) for tick in measure.ticks])
            axes.set_xticks(measure.counts, [f"{count:,}" for count in measure.counts])
            axes.set_xlim(20, max(2000, 2 * greatest_count))
        else:
            counts = sorted({row["throws"] for row in rows_of(data, [level]) if row["throws"] > 0})
            axes.set_xticks(counts, [f"{count / 1e6:g} M" if count >= 10**6 else f"{count:,}" for count in counts])
        axes.minorticks_off()
        axes.grid(alpha=0.3)
        say_start(axes)
    _name_once(figure, panels)
    return figure


def over_the_shift(data: Mapping[str, Any]) -> Figure:
    """Mean landing error pick by pick, one panel per level, of those that are `ADAPTING`."""
    levels = list(dict.fromkeys(row["level"] for row in data["table"]))
    figure, panels = tile_panels(len(levels), 2, (WIDTH / 2, 2.8) if len(levels) > 1 else (WIDTH, 3.8))
    colour = colours(ADAPTING)
    for axes, level in zip(panels, levels, strict=True):
        for row in rows_of(data, [level]):
            if row["controller"] in colour:
                error = 1000 * np.array(row["landing_error_by_pick_m"])
                width = min(SMOOTHED, len(error))
                smooth = np.convolve(error, np.full(width, 1.0 / width), mode="valid")
                picks = np.arange(len(smooth)) + (width + 1) / 2
                axes.plot(picks, smooth, color=colour[row["controller"]], label=said(row["controller"]))
        dress(axes, "pick of the shift", "landing error, mean [mm]", f"level {level}")
        axes.set_ylim(bottom=0.0)
    _name_once(figure, panels, 2)
    return figure


def landing_clouds(chosen: Sequence[Mapping[str, Any]]) -> Figure:
    """Where objects landed against the target, along and across the throw, one panel per result."""
    figure, panels = tile_panels(len(chosen), 2, (WIDTH / 2, WIDTH / 2), sharex=True, sharey=True)
    for axes, result in zip(panels, chosen, strict=True):
        along, across = (1000 * np.array(result["columns"][c], dtype=float) for c in ("along_m", "across_m"))
        axes.scatter(along, across, s=4, alpha=0.4, color=COLOURS[0], linewidths=0, rasterized=True)
        axes.axhline(0, color="black", linewidth=0.6)
        axes.axvline(0, color="black", linewidth=0.6)
        axes.plot(np.nanmean(along), np.nanmean(across), "+", color=COLOURS[3], markersize=12, markeredgewidth=2)
        axes.set_title(name_of(result), fontsize=10)
        axes.set(xlim=(-150, 150), ylim=(-150, 150), aspect="equal", xlabel="along the throw [mm]")
    for axes in panels[::2]:
        axes.set_ylabel("across [mm]")
    return figure


def _name_once(figure: Figure, panels: Sequence[Axes], beside: int = NAMED_BESIDE) -> None:
    """One legend for all panels: not every controller is in every one."""
    shown = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(shown.values(), shown.keys(), fontsize=8, loc="outside lower center", ncols=beside)


def _draw(axes: Axes, rows: list[Mapping[str, Any]], label: str, colour: str, measure: Measure) -> None:
    value, low, high = (measure.scale * np.array([row[name] for row in rows]) for name in measure.names)
    if rows[0]["throws"] == 0 or label.startswith("floor"):
        axes.axhline(value[-1], color=colour, linestyle="--", linewidth=1, label=label)
        return
    spread = [value - low, high - value]
    throws = [row["throws"] for row in rows]
    axes.errorbar(throws, value, yerr=spread, marker="o", color=colour, label=label, capsize=2)


Data = Mapping[str, Any]


class Kind(NamedTuple):
    """What is shown of one kind of task.

    Attributes:
        grids: every table of a benchmark.
        figures: SVG texts by file name.
    """

    grids: Callable[[Data], list[Grid]]
    figures: Callable[[Data], dict[str, str]]


def grids(data: Data) -> list[Grid]:
    """Tables of a kind of task that has none of its own: its figures side by side, and paired differences."""
    levels, who = data["plan"]["levels"], ("controller", f"{data['step']}s to learn")
    columns = {figure.label: _cell(name, figure) for name, figure in _figures(data).items()}
    note = conditions(data, f"{data['table'][0]['count']} held-out {data['unit']}", "95 % intervals")
    grids = [
        side_by_side("Every controller on the same held-out tasks", data, levels, columns, note, who),
        *other_level_tables(data, columns, who),
        *(tables.comparison(data, level, _figures(data)) for level in levels),
    ]
    return [grid for grid in grids if grid.rows]


def figures(data: Data) -> dict[str, str]:
    """Learning curves of a kind of task that has no drawings of its own; nothing where nobody has learned."""
    if not any(row["throws"] for row in data["table"]):
        return {}
    name, figure = next(iter(_figures(data).items()))
    label = f"{figure.label} [{figure.unit}]" if figure.unit else figure.label
    measure = Measure((name, f"{name}_low", f"{name}_high"), figure.scale, label, f"{data['step']}s learned from")
    return {"learning_curves.svg": svg(learning_curves(data, measure))}


KINDS: Final = {
    "throws": Kind(lambda data: [*tables.grids(data), *profiles.grids(data)], throw_figures),
    "work_shifts": Kind(
        line.grids,
        lambda data: {"value.svg": svg(gains_figure(data)), "learning_curves.svg": svg(learning_curves(data, VALUE))},
    ),
}
"""Kinds of tasks that have tables and figures of their own."""
USUAL: Final = Kind(grids, figures)
"""Tables and figures of any other kind of task."""


def _figures(data: Data) -> dict[str, judged.Figure]:
    """How the figures of a benchmark are called and written."""
    return {name: judged.Figure(**fields) for name, fields in data["figures"].items()}


def _cell(name: str, figure: judged.Figure) -> Callable[[Data], str]:
    """What a table shows of a row."""

    def text(row: Data) -> str:
        low, high = row[f"{name}_low"], row[f"{name}_high"]
        return "-" if row[name] is None else figure.interval(Interval(row[name], low, high))

    return text
