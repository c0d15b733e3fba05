"""The drawings that pages of results begin with, where no chapter draws them already, and the figure of methods."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from operator import itemgetter
from typing import Any, Final

import numpy as np

from ..ground.drawings import COLOURS, WIDTH, Figure, dress, subplots, svg, tile_panels
from ..ground.looks import colours, said
from ..reproduce.record import AGREES
from ..results.study import shipped_study
from . import headline
from .answers import LOSSES, controller_paces, single_and_vector, verdict_counts
from .figures import over_the_shift
from .tables import first_level, name_of

Data = Mapping[str, Any]
Results = Mapping[str, Any]
VARIANTS: Final = ("_seed_", "_pace_", "_one_try", "_same_place")
"""Parts of the labels of grasping controllers that stand in the table alone: further seeds, paces and tries."""
ACROSS: Final = {
    "percent": "limits [%]",
    "opening": "opening of the bin [m]",
    "distance": "distance of the bin, y [m]",
    "mass": "mass of cans [kg]",
}
"""What panels are drawn over, and what the axis is called."""
METHOD: Final = "planner"
IN_A_ROW: Final = 2
"""Panels side by side."""


def losses(results: Results) -> Figure:
    """Where the picks of the short table's controllers end on the first level of the benchmark, as stacked bars."""
    level, shown = headline.rows_shown(results["benchmark"])
    rows = [row for _, row in shown]
    shares = {"sorted": "share_sorted", **{text: name for name, text in LOSSES.items()}}
    bars = {text: [100.0 * (row.get(name) or 0.0) for row in rows] for text, name in shares.items()}
    names = [said(name_of(row)) for row in rows]
    return _stacked(names, bars, "share of all picks [%]", f"level {level}")


def reality(results: Results) -> Figure:
    """How far simulated tosses are from the measured ones, by contact, and the rises above the bound of a fall."""
    rows = results["reality"]["rows"]
    cube = [row for row in rows if row["part"] == "cube"]
    figure, (paths, bounds) = subplots(2, 1, (WIDTH, 5.4))
    paths.barh([row["contact"] for row in cube], [100.0 * row["path"]["value"] for row in cube], color=COLOURS[0])
    paths.invert_yaxis()
    dress(paths, "distance of the simulated cube from the real one [% of its side]", "", "tosses of a cube")
    for colour, body in zip(COLOURS, ("cube", "square"), strict=False):
        own = [row for row in rows if row.get("body") == body]
        restitutions, above = [row["restitution"] for row in own], [100.0 * row["above"]["value"] for row in own]
        bounds.plot(restitutions, above, "o-", color=colour, label=body)
    dress(bounds, "restitution of the bound", "rises above it [%]", "first impacts", legend="best", ylim=(0.0, 100.0))
    return figure


def cells(results: Results) -> Figure:
    """Sorted objects per minute of each controller where one number of the cell is another."""
    paces = controller_paces(results["assumed"]["rows"])
    numbers = list(dict.fromkeys(number for pace in paces.values() for number in pace))
    pace = {name: [of[number] for number in numbers] for name, of in paces.items()}
    return _side_by_side(numbers, pace, "sorted per minute")


def drift(results: Results) -> Figure:
    """Landing error over the picks of a shift on the first level of the benchmark."""
    data = results["benchmark_adapt"]
    return over_the_shift({**data, "table": first_level(data)[1]})


def verdicts(results: Results) -> Figure:
    """How many published figures of each paper came out with which verdict, as stacked bars."""
    record = results["reproduction"]
    counts = verdict_counts(record)
    names = dict.fromkeys([AGREES, *(name for count in counts.values() for name in count)])
    bars = {name: [float(count.get(name, 0)) for count in counts.values()] for name in names}
    return _stacked([record["titles"][paper] for paper in counts], bars, "published statements", "")


def flight(results: Results) -> Figure:
    """How far the same throws land apart, and the success in both, level by level."""
    rows = results["fidelity"]["rows"]
    figure, (lengths, success) = subplots(1, 2, (WIDTH, 0.35 * len(rows) + 1.2), sharey=True)
    places = np.arange(len(rows))
    lengths.barh(places, [1000 * row["landing_p95_m"] for row in rows], color=COLOURS[0])
    dress(lengths, "95 % land within [mm]", "")
    for name, marker, colour in (("full", "o", COLOURS[0]), ("flight", "x", COLOURS[1])):
        success.plot([100 * row[f"success_{name}"] for row in rows], places, marker, color=colour, label=name)
    dress(success, "success [%]", "", legend="best", xlim=(0, 102))
    lengths.set_yticks(places, labels=[row["level"] for row in rows])
    lengths.invert_yaxis()
    return figure


def grasp(results: Results) -> Figure:
    """Sorted objects per minute by the place of the cup, on seen and on unseen kinds."""
    data = results["benchmark_grasp"]
    rows = [row for row in data["table"] if not any(word in row["label"] for word in VARIANTS)]
    names = list(dict.fromkeys(said(name_of(row)) for row in rows))
    levels = data["plan"]["levels"]
    pace = {level: [row["sorted_per_min"] for row in rows if row["level"] == level] for level in levels}
    return _side_by_side(names, pace, "sorted per minute")


def sorter(results: Results) -> Figure:
    """Sorted objects per minute under each effect, for each cell and controller of the study."""
    rows = results["judged"]["rows"]
    cases = list(dict.fromkeys(row["case"] for row in rows))
    pace: dict[str, list[float]] = {}
    for row in rows:
        pace.setdefault(f"{row['level']}, {row['controller']}", []).append(row["sorted_per_min"])
    return _side_by_side(cases, pace, "sorted per minute")


def cup(results: Results) -> Figure:
    """What the cup loses and what is sorted per minute over the safety of the grip, level by level."""
    rows = results["grip"]["rows"]
    figure, panels = subplots(2, 1, (WIDTH, 6.4), sharex=True)
    figures = {
        "lost of what was picked [%]": ("dropped_of_picked", 100.0),
        "sorted per minute": ("sorted_per_min", 1.0),
    }
    for axes, (text, (name, scale)) in zip(panels, figures.items(), strict=True):
        for level, colour in zip(dict.fromkeys(row["level"] for row in rows), COLOURS, strict=False):
            values = {str(row["safety"] or "none"): scale * row[name] for row in rows if row["level"] == level}
            axes.plot(list(values), list(values.values()), "o-", color=colour, label=level)
        dress(axes, "", text, ylim=(0, None))
    panels[0].legend(fontsize=8, loc="best")
    panels[1].set_xlabel("safety of the grip: times the measured load that the cup must hold")
    return figure


def speed(results: Results) -> Figure:
    """Throws per second of every environment: a single environment, a vector, and the bare physics of the vector."""
    rows = [
        (f"{env}, {level}", *single_and_vector(lines))
        for env, figures in results["perf_envs"]["envs"].items()
        for level, lines in groupby(figures["rows"], itemgetter("level"))
    ]
    figure, (axes,) = subplots(1, 1, (WIDTH, 0.32 * len(rows) + 1.6))
    places = np.arange(len(rows))
    kinds = {
        "a single environment": [single["env_throws_per_s"] for _, single, _ in rows],
        "a vector of environments": [vector["env_throws_per_s"] for _, _, vector in rows],
        "bare physics of the vector": [
            vector["bare_throws_per_s"] if vector["physics_steps_per_throw"] else np.nan for _, _, vector in rows
        ],
    }
    for (text, rates), marker, colour in zip(kinds.items(), "osd", COLOURS, strict=False):
        axes.plot(rates, places, marker, color=colour, label=text)
    threads = ", ".join(str(count) for count in dict.fromkeys(vector["threads"] for *_, vector in rows))
    dress(axes, f"throws or decisions per second, vectors on {threads} threads", "")
    figure.legend(*axes.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=3)
    axes.set_xscale("log")
    axes.set_xlabel(f"{axes.get_xlabel()}, logarithmic")
    axes.set_yticks(places, labels=[name for name, *_ in rows])
    axes.invert_yaxis()
    return figure


def _side_by_side(names: list[str], bars: Mapping[str, list[float]], across: str) -> Figure:
    """Horizontal bars, a group for each name, with one bar for each kind."""
    figure, (axes,) = subplots(1, 1, (WIDTH, 0.55 * len(names) + 1.2))
    height = 0.8 / len(bars)
    colour = colours(bars)
    for k, (kind, widths) in enumerate(bars.items()):
        axes.barh(np.arange(len(names)) + k * height, widths, height, color=colour[kind], label=kind)
    dress(axes, across, "")
    axes.set_yticks(np.arange(len(names)) + 0.4 - height / 2, labels=names)
    figure.legend(*axes.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2)
    axes.invert_yaxis()
    return figure


def _stacked(names: list[str], bars: Mapping[str, list[float]], across: str, title: str) -> Figure:
    """Horizontal bars, one for each name, each made of one piece for each kind."""
    figure, (axes,) = subplots(1, 1, (WIDTH, 0.45 * len(names) + 1.6))
    left = np.zeros(len(names))
    filled = {kind: widths for kind, widths in bars.items() if any(widths)}
    for (kind, widths), colour in zip(filled.items(), COLOURS, strict=False):
        axes.barh(names, widths, left=left, color=colour, label=kind)
        left += np.array(widths)
    dress(axes, across, "", title)
    figure.legend(*axes.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2)
    axes.invert_yaxis()
    return figure


def figures(data: Data) -> dict[str, str]:
    """SVG texts by file name."""
    return {"methods.svg": svg(figure(data))}


def figure(data: Data) -> Figure:
    """Sorted per minute by each method: over the limits in each level, and over each sweep."""
    panels: dict[str, list[Data]] = {}
    for row in (row for row in data["rows"] if METHOD in row):
        panels.setdefault(f"level {row['level']}" if "level" in row else row["part"], []).append(row)
    figure, axes = tile_panels(len(panels), IN_A_ROW, (3.2, 2.7), sharey=True)
    for panel, (title, rows) in zip(axes, panels.items(), strict=True):
        name = next(name for name in ACROSS if name in rows[0])
        # A line for each method, with gaps where it cannot be used.
        methods = shipped_study("methods").names[METHOD]
        colour = colours(methods)
        for method, label in methods.items():
            points = [(row[name], row.get("sorted_per_min", float("nan"))) for row in rows if row[METHOD] == method]
            panel.plot(*zip(*points, strict=True), marker="o", markersize=4, color=colour[method], label=label)
        dress(panel, ACROSS[name], "sorted per minute" if panel in axes[::IN_A_ROW] else "", title)
    axes[0].set_ylim(bottom=0.0)
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=3)
    return figure
