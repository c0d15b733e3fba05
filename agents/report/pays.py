"""Where learning pays: curves over throws, performance profiles, and gains over the mismatch, from two studies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import itemgetter
from typing import Any, Final, NamedTuple

import numpy as np

from ..ground.drawings import COLOURS, WIDTH, Figure, dress, subplots, svg
from ..ground.looks import colours
from ..ground.tables import Grid
from . import profiles
from .templates import NoFigure

Data = Mapping[str, Any]
FIXED: Final = "fixed"
"""The part of the study `curves` with what does not learn, or has learned enough."""
REFERENCE: Final = "ridge"
"""The learner with which others are compared."""
BOUNDS: Final = np.linspace(0.0, 0.06, 121)
"""Landing errors at which a profile is drawn [m]."""
ERROR_TICKS: Final = (2, 5, 10, 20, 50, 100, 200, 500)
"""Ticks of landing errors [mm]."""
DISTINCT: Final = 10
"""Colours that differ enough at first sight; further lines are dashed."""
GAINS: Final = (
    ("landing_error_m", -1000.0, "smaller landing error [mm]"),
    ("sorted_per_min", 1.0, "more sorted objects a minute"),
)
"""Gains of the study `mismatch`, the factors that make them positive, and their names."""
STYLES: Final = ("-", "--", ":")
"""Lines of what does not learn."""
FEW: Final = 10
"""Throws after which a sentence tells who is nearest."""
NEAR: Final = 1.25
"""Times the floor within which a learner has learned nearly all."""
TOGETHER: Final = "all together"
"""The effect of the study `mismatch` that has every other one."""
FITTED: Final = "fitted planner"
"""The controller of the study `curves` that knows how a throw flies."""
WITHOUT: Final = "without a planner"
"""The part of the study `curves` whose learner gets no analytic throw to correct."""


def curves_figures(data: Data) -> dict[str, str]:
    """SVG texts by file name."""
    figure, (error, pace) = subplots(2, 1, (WIDTH, 8.6), sharex=True)
    first = list(_curves(data, "sorted_per_min"))[:DISTINCT]
    for axes, name, factor in ((error, "landing_error_mean_m", 1000.0), (pace, "sorted_per_min", 1.0)):
        curves = _curves(data, name)
        colour = colours(curves)
        for label, points in curves.items():
            throws = sorted(points)
            values = [factor * np.array(points[count]) for count in throws]
            means, style = [v.mean() for v in values], "-" if label in first else "--"
            axes.plot(throws, means, style, marker="o", markersize=3, color=colour[label], label=label)
            low, high = ([end(v) for v in values] for end in (np.min, np.max))
            axes.fill_between(throws, low, high, color=colour[label], alpha=0.1)
        fixed = [row for row in data["rows"] if row["part"] == FIXED]
        for dash, row in zip(STYLES, fixed, strict=False):
            axes.axhline(factor * row[name], color="black", linestyle=dash, linewidth=1.0, label=row["controller"])
        axes.set_xscale("log")
    dress(error, "", "landing error [mm], logarithmic")
    error.set_yscale("log")
    error.set_yticks(ERROR_TICKS, [str(tick) for tick in ERROR_TICKS])
    error.minorticks_off()
    dress(pace, "throws learned from", "sorted per minute", ylim=(0, None))
    figure.legend(*pace.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=4)
    return {"curves.svg": svg(figure), "curves_profiles.svg": svg(profiles_figure(data))}


def mismatch_figures(data: Data) -> dict[str, str]:
    """SVG texts by file name."""
    figure, panels = subplots(2, 1, (WIDTH, 7.4), sharex=True)
    learner = ""
    for axes, (name, factor, text) in zip(panels, GAINS, strict=True):
        for colour, effect in zip(COLOURS, list(dict.fromkeys(row["effect"] for row in data["rows"])), strict=False):
            learner, rows = list(_by_learner(data, effect).items())[-1]
            gains = [sorted(factor * row[name][end] for end in ("low", "value", "high")) for row in rows]
            dial = [row["mismatch"] for row in rows]
            axes.plot(dial, [gain for _, gain, _ in gains], marker="o", markersize=3, color=colour, label=effect)
            axes.fill_between(dial, [low for low, _, _ in gains], [high for *_, high in gains], color=colour, alpha=0.1)
        axes.axhline(0.0, color="black", linewidth=0.8)
        dress(axes, "", text)
    panels[0].set_title(f"gain of {learner} over the planner", fontsize=10)
    panels[1].set_xlabel("mismatch")
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=4)
    return {"mismatch.svg": svg(figure)}


class Point(NamedTuple):
    """A learner after a number of throws, with its mean landing error [m]."""

    throws: int
    error: float
    label: str


def curves_values(results: Data) -> dict[str, Any]:
    """The fitted planner and the nearest learner after few throws, the first near the floor, and one without a planner.

    The fitted planner knows how a throw flies, so it is not among the learners.
    """
    data = _read(results["curves"], "controller", "throws", "landing_error_mean_m")
    fixed = {row["controller"]: row["landing_error_mean_m"] for row in data["rows"] if row["part"] == FIXED}
    if not {"analytic", "floor"} <= set(fixed):
        raise NoFigure("no planner and no floor")
    points = sorted(
        Point(count, float(np.mean(errors)), label)
        for label, of_counts in _curves(data, "landing_error_mean_m").items()
        for count, errors in of_counts.items()
    )
    fitted = next((point for point in points if (point.label, point.throws) == (FITTED, FEW)), None)
    points = [point for point in points if point.label != FITTED]
    blind = {row["controller"] for row in data["rows"] if row["part"] == WITHOUT}
    return {
        "planner": fixed["analytic"],
        "floor": fixed["floor"],
        "few": FEW,
        "times": f"{NEAR:g}",
        "fitted": fitted,
        "nearest": min((point for point in points if point.throws <= FEW), key=lambda point: point.error),
        "near": next((point for point in points if point.error <= NEAR * fixed["floor"]), None),
        "blind": next((point for point in reversed(points) if point.label in blind), None),
    }


def mismatch_values(results: Data) -> dict[str, Any]:
    """From which mismatch learning sorts more, for each effect, and the best learner with all of them."""
    data = _read(results["mismatch"], "effect", "mismatch", "landing_error_m", "sorted_per_min")
    # The smallest mismatch from which a learner sorts more per minute than the planner, by effect.
    pays: dict[str, float | None] = {}
    for effect in dict.fromkeys(row["effect"] for row in data["rows"]):
        starts = [_limit(rows, "sorted_per_min", 1.0) for rows in _by_learner(data, effect).values()]
        pays[effect] = min((start for start in starts if start is not None), default=None)
    known = sorted((start, effect) for effect, start in pays.items() if start is not None)
    if TOGETHER not in pays or not known:
        raise NoFigure("no effect with a gain")
    ends = [rows[-1] for rows in _by_learner(data, TOGETHER).values()]
    return {"least": known[0], "most": known[-1], "row": min(ends, key=itemgetter("learned_m"))}


def _read(data: Data, *names: str) -> Data:
    """A study whose rows have figures of these names.

    Raises:
        NoFigure: the results are of another plan.
    """
    rows = data.get("rows", ())
    if not rows or not all({"part", *names} <= set(row) for row in rows):
        raise NoFigure(f"no rows with {', '.join(names)}")
    return data


def profiles_figure(data: Data) -> Figure:
    """Share of the runs below each landing error, after the most throws that all learners have."""
    last, scores = _scores(data)
    figure, (axes,) = subplots(1, 1, (WIDTH, 4.4))
    colour = colours(scores)
    for k, (label, errors) in enumerate(scores.items()):
        below, style = profiles.profile(errors, BOUNDS.tolist()), "-" if k < DISTINCT else "--"
        axes.step(1000.0 * BOUNDS, below, style, color=colour[label], label=label)
    dress(axes, "landing error [mm]", "share of runs below", f"after {last:,} throws")
    figure.legend(fontsize=8, loc="outside lower center", ncols=4)
    return figure


def improvement_grid(data: Data) -> Grid:
    """Probability that a run of each learner errs less than a run of the reference, after the most throws of all."""
    last, scores = _scores(data)
    rows: list[list[str]] = []
    for label, errors in scores.items():
        if label != REFERENCE and REFERENCE in scores:
            text = profiles.text(errors, scores[REFERENCE])
            rows.append([label, str(len(errors)), f"{1000 * np.mean(errors):.1f} mm", text])
    note = (
        f"After about {last:,} throws of learning. *Probability of improvement*: that a run errs less than a run of "
        f"{REFERENCE}; ties count half, with 95 % intervals over resampled runs."
    )
    header = ("learner", "runs", "landing error", "probability of improvement")
    return Grid(f"Runs compared with {REFERENCE}", header, rows, note)


def crossover_grid(data: Data) -> Grid:
    """The mismatch from which learning pays, by effect and learner: the smallest from which all gains are clear."""
    rows: list[list[str]] = []
    for effect in list(dict.fromkeys(row["effect"] for row in data["rows"])):
        for label, measured in _by_learner(data, effect).items():
            largest = measured[-1]["landing_error_m"]
            gain = f"{-1000 * largest['value']:.1f} mm ({-1000 * largest['high']:.1f}..{-1000 * largest['low']:.1f})"
            starts = _limit(measured, "landing_error_m", -1.0), _limit(measured, "sorted_per_min", 1.0)
            rows.append([effect, label, *("-" if start is None else f"{start:g}" for start in starts), gain])
    header = ("effect", "learner", "errs less from", "sorts more from", "gain at the largest mismatch")
    note = (
        "*Errs less from*, *sorts more from*: the smallest mismatch from which on the 95 % interval of the gain over "
        "the planner lies above 0, in landing error and in sorted objects per minute. Beside every effect stand the "
        "air and the place of the centre of mass under the cup."
    )
    return Grid("Where learning begins to pay", header, rows, note)


def _limit(rows: Sequence[Data], name: str, sign: float) -> float | None:
    """The smallest mismatch from which on a figure is clearly above the planner's, or below for a sign of -1."""
    start: float | None = None
    for row in reversed(rows):
        if min(sign * row[name]["low"], sign * row[name]["high"]) <= 0.0:
            break
        start = row["mismatch"]
    return start


def _by_learner(data: Data, effect: str) -> dict[str, list[Data]]:
    """Rows of an effect by learner, in the order of the mismatch."""
    rows = sorted((row for row in data["rows"] if row["effect"] == effect), key=itemgetter("mismatch"))
    learners = dict.fromkeys(row["controller"] for row in rows)
    return {label: [row for row in rows if row["controller"] == label] for label in learners}


def _curves(data: Data, name: str) -> dict[str, dict[int, list[float]]]:
    """A figure of all seeds, by learner and number of throws."""
    curves: dict[str, dict[int, list[float]]] = {}
    for row in (row for row in data["rows"] if row["part"] != FIXED):
        curves.setdefault(row["controller"], {}).setdefault(row["throws"], []).append(row[name])
    return curves


def _scores(data: Data) -> tuple[int, dict[str, list[float]]]:
    """The most throws that all learners have, about, and the landing errors of the runs of each learner."""
    curves = _curves(data, "landing_error_mean_m")
    last = {label: max(points) for label, points in curves.items()}
    return min(last.values()), {label: points[last[label]] for label, points in curves.items()}
