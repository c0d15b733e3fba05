"""Where learning pays: curves over throws, performance profiles, and gains over the mismatch, from two studies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from ..ground.drawings import COLOURS, Axes, Figure, dress, subplots, svg, tile_panels
from ..ground.tables import Grid
from .runs_compared import improvement_text, performance_profile

Data = Mapping[str, Any]
FIXED: Final = "fixed"
"""The part of the study `curves` with what does not learn, or has learned enough."""
REFERENCE: Final = "ridge"
"""The learner with which others are compared."""
BOUNDS: Final = np.linspace(0.0, 0.06, 121)
"""Landing errors at which a profile is drawn [m]."""
STYLES: Final = ("-", "--", ":")
"""Lines of what does not learn."""


def curves_figures(data: Data) -> dict[str, str]:
    """SVG texts by file name."""
    return {"curves.svg": svg(curves_figure(data)), "curves_profiles.svg": svg(profiles_figure(data))}


def mismatch_figures(data: Data) -> dict[str, str]:
    """SVG texts by file name."""
    return {"mismatch.svg": svg(mismatch_figure(data))}


def curves_figure(data: Data) -> Figure:
    """Landing error and sorted per minute over throws: mean, smallest and largest of the seeds."""
    figure, (error, pace) = subplots(1, 2, (11.0, 4.2))
    for axes, name, factor in ((error, "landing_error_mean_m", 1000.0), (pace, "sorted_per_min", 1.0)):
        for colour, (label, points) in zip(COLOURS, _curves(data, name).items(), strict=False):
            throws = sorted(points)
            values = [factor * np.array(points[count]) for count in throws]
            axes.plot(throws, [v.mean() for v in values], marker="o", markersize=3, color=colour, label=label)
            axes.fill_between(throws, [v.min() for v in values], [v.max() for v in values], color=colour, alpha=0.15)
        _fixed_lines(data, axes, name, factor)
        axes.set_xscale("log")
    dress(error, "throws learned from", "landing error [mm]")
    dress(pace, "throws learned from", "sorted per minute", legend="lower right")
    return figure


def profiles_figure(data: Data) -> Figure:
    """Share of the runs below each landing error, after the most throws that all learners have."""
    last, scores = _last_scores(data)
    figure, (axes,) = subplots(1, 1, (6.0, 3.8))
    for colour, (label, errors) in zip(COLOURS, scores.items(), strict=False):
        axes.step(1000.0 * BOUNDS, performance_profile(errors, BOUNDS.tolist()), color=colour, label=label)
    dress(axes, "landing error [mm]", "share of runs below", f"after {last:,} throws", legend="lower right")
    return figure


def improvement_grid(data: Data) -> Grid:
    """Probability that a run of each learner errs less than a run of the reference, after the most throws of all."""
    last, scores = _last_scores(data)
    rows: list[list[str]] = []
    for label, errors in scores.items():
        if label != REFERENCE and REFERENCE in scores:
            text = improvement_text(errors, scores[REFERENCE])
            rows.append([label, str(len(errors)), f"{1000 * np.mean(errors):.1f} mm", text])
    note = (
        f"After about {last:,} throws of learning. *Probability of improvement*: that a run errs less than a run of "
        f"{REFERENCE}; ties count half, with 95 % intervals over resampled runs."
    )
    header = ("learner", "runs", "landing error", "probability of improvement")
    return Grid(f"Runs compared with {REFERENCE}", header, rows, note)


def mismatch_figure(data: Data) -> Figure:
    """Gain in landing error over the mismatch, a panel for each effect."""
    effects = list(dict.fromkeys(row["effect"] for row in data["rows"]))
    figure, panels = tile_panels(len(effects), 4, (3.4, 2.8), sharey=True)
    for axes, effect in zip(panels, effects, strict=True):
        for colour, (label, rows) in zip(COLOURS, _by_learner(data, effect).items(), strict=False):
            gains = [{end: -1000.0 * row["landing_error_m"][end] for end in ("value", "low", "high")} for row in rows]
            dial = [row["mismatch"] for row in rows]
            axes.plot(dial, [gain["value"] for gain in gains], marker="o", markersize=3, color=colour, label=label)
            axes.fill_between(dial, [g["low"] for g in gains], [g["high"] for g in gains], color=colour, alpha=0.2)
        axes.axhline(0.0, color="black", linewidth=0.8)
        dress(axes, "mismatch", "gain [mm]" if axes in panels[::4] else "", effect)
    panels[0].legend(fontsize=8)
    return figure


def crossover_grid(data: Data) -> Grid:
    """The mismatch from which learning gains, by effect and learner: the smallest from which all gains are clear."""
    rows: list[list[str]] = []
    for effect in dict.fromkeys(row["effect"] for row in data["rows"]):
        for label, measured in _by_learner(data, effect).items():
            largest = measured[-1]["landing_error_m"]
            gain = f"{-1000 * largest['value']:.1f} mm ({-1000 * largest['high']:.1f}..{-1000 * largest['low']:.1f})"
            rows.append([effect, label, _crossover(measured), gain])
    header = ("effect", "learner", "learning pays from", "gain at the largest mismatch")
    note = (
        "*Pays from*: the smallest mismatch from which on the 95 % interval of the gain in landing error over the "
        "planner lies above 0. Beside every effect stand the air and the place of the centre of mass under the cup."
    )
    return Grid("Where learning begins to pay", header, rows, note)


def _crossover(rows: Sequence[Data]) -> str:
    start: float | None = None
    for row in reversed(rows):
        if row["landing_error_m"]["high"] >= 0.0:  # learned less planned: a gain is negative
            break
        start = row["mismatch"]
    return "-" if start is None else f"{start:g}"


def _by_learner(data: Data, effect: str) -> dict[str, list[Data]]:
    """Rows of an effect by learner, in the order of the mismatch."""
    rows = sorted((row for row in data["rows"] if row["effect"] == effect), key=_dial)
    return {label: [row for row in rows if row["controller"] == label] for label in _learners(rows)}


def _dial(row: Data) -> float:
    return float(row["mismatch"])


def _learners(rows: Sequence[Data]) -> list[str]:
    return list(dict.fromkeys(row["controller"] for row in rows))


def _curves(data: Data, name: str) -> dict[str, dict[int, list[float]]]:
    """A figure of all seeds, by learner and number of throws."""
    curves: dict[str, dict[int, list[float]]] = {}
    for row in (row for row in data["rows"] if row["part"] != FIXED):
        curves.setdefault(row["controller"], {}).setdefault(row["throws"], []).append(row[name])
    return curves


def _last_scores(data: Data) -> tuple[int, dict[str, list[float]]]:
    """The most throws that all learners have, about, and the landing errors of the runs of each learner."""
    curves = _curves(data, "landing_error_mean_m")
    last = {label: max(points) for label, points in curves.items()}
    return min(last.values()), {label: points[last[label]] for label, points in curves.items()}


def _fixed_lines(data: Data, axes: Axes, name: str, factor: float) -> None:
    fixed = [row for row in data["rows"] if row["part"] == FIXED]
    for style, row in zip(STYLES, fixed, strict=False):
        axes.axhline(factor * row[name], color="black", linestyle=style, linewidth=1.0, label=row["controller"])
