"""Cycle times of whole paths from pick to place, the vertical parts included, which Choe et al. 2023 leave open."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.choe_cases import BELT, LIFT, LIMITS, SPAN, Case, example_cases, long_cases, motion
from agents.reproduce.findings import Findings, Part, Row
from pnt_gym.planning.fastest import fastest_motion
from pnt_gym.planning.trajectory import HandPath, JerkTrajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BOUNDS: Final = {
    "bound-50mm": (0.05, None),
    "bound-50mm-top-100mm": (0.05, BELT + LIFT),
    "bound-20mm": (0.02, None),
}
"""Vertical parts [m] and greatest height [m] of the motions on a free path."""
CYCLES: Final = "cycles per minute there and back"
SHOWN: Final = ("ellipse-50mm-strict", "ellipse-50mm-relaxed", "lame-50mm-level")


def example_findings() -> Findings:
    """The paper's ellipse: alone, with vertical parts, with other angles."""
    rows = [_row("example", case) for case in example_cases()]
    by_name = {row.quantity.rsplit("/", 1)[1]: row.reproduced for row in rows}
    angles = {name: value for name, value in by_name.items() if name.endswith("deg-relaxed")}
    quickest = min(angles, key=lambda name: float(angles[name] or 0.0))
    rows.append(
        Row(
            "choe/claim/shortest-is-quickest",
            "10 deg",
            quickest.removeprefix("ellipse-").removesuffix("deg-relaxed") + " deg",
            "-",
            "differs",
            "the shortest ellipse is not the quickest, its sharp ends slow the hand down: of 9.5, 10, 12 and 15 deg, "
            "with 25 mm of vertical on either side, relaxed",
        )
    )
    return Findings(tuple(rows), {"choe_times_example": by_name})


def long_findings() -> Findings:
    """0.82 m at 0.1 m height: the paper's kind of path, smooth corners, and the quickest free path."""
    rows = [_row("long", case) for case in long_cases()]
    rows += [_bound_row(name) for name in BOUNDS]
    rows += _conclusions()
    by_name = {row.quantity: row.reproduced for row in rows if row.quantity.startswith("choe/time")}
    drawn = {"choe_times.svg": times_figure(), "choe_motions.svg": motions_figure()}
    return Findings(tuple(rows), {"choe_times_long": by_name}, {name: svg(figure) for name, figure in drawn.items()})


def _row(group: str, case: Case) -> Row:
    found = motion(case)
    seconds, ratios = float(found.duration[0]), [float(ratio[0]) for ratio in found.peak_ratios(LIMITS)]
    rule = {"strict": "continuous acceleration", "relaxed": "normal acceleration may step"}[case.joints]
    return Row(
        f"choe/time/{group}/{case.name}",
        None,
        seconds,
        "s",
        "ours",
        f"one way, {case.label}, {rule}: {30.0 / seconds:.1f} {CYCLES}",
        {
            "length_m": case.path.length,
            "top_m": case.path.top,
            "peak_velocity": ratios[0],
            "peak_acceleration": ratios[1],
            "peak_jerk": ratios[2],
        },
    )


@cache
def bound(name: str) -> JerkTrajectory:
    """The quickest motion that is vertical near both ends and free between."""
    vertical, roof = BOUNDS[name]
    start, end = (0.0, -0.5 * SPAN, BELT), (0.0, 0.5 * SPAN, BELT)
    return fastest_motion(start, end, LIMITS, lift=vertical, drop=vertical, roof=roof)


def _bound_row(name: str) -> Row:
    vertical, roof = BOUNDS[name]
    seconds = float(bound(name).duration[0])
    height = "" if roof is None else f", at most {LIFT} m high"
    note = f"one way, any path vertical over {vertical} m at both ends{height}: {30.0 / seconds:.1f} {CYCLES}"
    return Row(f"choe/time/long/{name}", None, seconds, "s", "ours", note)


def _conclusions() -> list[Row]:
    times = {case.name: float(motion(case).duration[0]) for case in long_cases()}
    rows = [
        Row(
            f"choe/saving/{name}",
            None,
            100.0 * (1.0 - times[name] / times["rectangle"]),
            "%",
            "ours",
            "of the time over the rectangle with stops at its corners",
        )
        for name in SHOWN
    ]
    for name, over in (("lame-50mm-level", "bound-50mm-top-100mm"), ("lame-50mm-tall", "bound-50mm")):
        above = times[name] / float(bound(over).duration[0]) - 1.0
        note = f"one G2 path with two Lame corners over the quickest free motion ({over})"
        rows.append(Row(f"choe/above-bound/{name}", None, 100.0 * above, "%", "ours", note))
    return [*rows, *_joint_rows()]


def _joint_rows() -> list[Row]:
    """Speed and step of the acceleration where line and ellipse meet."""
    case = next(case for case in long_cases() if case.name == "ellipse-50mm-relaxed")
    found = motion(case)
    border = int(np.argmin(np.abs(found.progress.s - case.path.borders[1])))
    moment = float(found.knot_times[border])
    before, after = (found.sample(np.array([moment + shift])) for shift in (-1e-9, 1e-9))
    speed = float(np.linalg.norm(before.velocity))
    step = float(np.linalg.norm(after.acceleration - before.acceleration))
    unfair = "the step has no finite jerk, so that this motion may be quicker than the quickest one within the limits"
    text = "where line and ellipse meet, vertical parts of 50 mm, relaxed"
    return [
        Row("choe/joint/speed", None, speed, "m/s", "ours", text),
        Row("choe/joint/acceleration-step", "continuous", step, "m/s2", "differs", f"{text}; {unfair}"),
    ]


def times_figure() -> Figure:
    """Time of each path over the long way, and the paths themselves."""
    figure, (bars, paths) = subplots(1, 2, (12.5, 4.4), width_ratios=(1.0, 1.25))
    shown = [case for case in long_cases() if "50mm" in case.name or case.name == "rectangle"]
    labels = [case.label for case in shown] + ["free path, 0.10 m high", "free path"]
    values = [float(motion(case).duration[0]) for case in shown]
    values += [float(bound(name).duration[0]) for name in ("bound-50mm-top-100mm", "bound-50mm")]
    colours = [_colour(case.name) for case in shown] + ["#8c8c8c"] * 2
    places = np.arange(len(values))
    bars.hlines(places, 0.0, values, color=colours, linewidth=1)
    for place, value, colour in zip(places, values, colours, strict=True):
        bars.plot(value, place, "o", color=colour)
        bars.text(value + 0.008, place, f"{value:.3f}", va="center", fontsize=8)
    bars.set_yticks(places, labels, fontsize=8)
    bars.invert_yaxis()
    bars.set_xlim(0.65, 0.90)
    bars.set_xlabel("time one way [s]")
    bars.set_title("0.82 m, vertical parts of 50 mm", fontsize=10)
    bars.grid(axis="x", alpha=0.3)
    bars.set_axisbelow(True)
    _draw_paths(paths)
    return figure


def _draw_paths(axes: Axes) -> None:
    wanted = ("rectangle", "ellipse-50mm-strict", "lame-50mm-level", "lame-50mm-tall")
    names = ("rectangle", "ellipse", "Lamé m = 3.5, d = 0.12 m", "Lamé m = 3, d = 0.16 m, 0.15 m high")
    for label, name in zip(names, wanted, strict=True):
        case = next(case for case in long_cases() if case.name == name)
        points = 1000.0 * case.path.points(3000)
        axes.plot(points[:, 0], points[:, 1], color=_colour(name), label=label)
    for name, style in (("bound-50mm-top-100mm", "--"), ("bound-50mm", ":")):
        found = bound(name)
        places = found.sample(np.linspace(0.0, float(found.duration[0]), 800)).position[0]
        label = "quickest free path" + (", 0.10 m high" if "top" in name else "")
        axes.plot(1000 * (places[:, 1] + 0.5 * SPAN), 1000 * (places[:, 2] - BELT), style, color="black", label=label)
    axes.set_xlabel("x [mm]")
    axes.set_ylabel("height [mm], stretched")
    axes.set_title("the paths", fontsize=10)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="lower center")


def _colour(name: str) -> str:
    if name == "rectangle":
        return COLOURS[3]
    if name.startswith("ellipse"):
        return COLOURS[0]
    return COLOURS[4] if name.endswith("tall") else COLOURS[2]


def motions_figure() -> Figure:
    """Speed, acceleration and jerk over time: stop, step, or run through."""
    figure, panels = subplots(3, 1, (8.5, 6.6), sharex=True)
    labels = ("ellipse, strict: stops at T1, T2", "ellipse, relaxed: acceleration steps", "Lamé m = 3.5: runs through")
    for k, (name, label) in enumerate(zip(SHOWN, labels, strict=True)):
        case = next(case for case in long_cases() if case.name == name)
        _draw_motion(panels, motion(case), COLOURS[k], label)
    units = ("speed [m/s]", "acceleration [m/s²]", "jerk [m/s³]")
    for axes, unit, limit in zip(panels, units, LIMITS.numbers(), strict=True):
        axes.axhline(limit, color="gray", linestyle=":", linewidth=1)
        axes.set_ylabel(unit)
        axes.set_ylim(0.0, 1.12 * limit)
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel("time [s]")
    panels[0].set_title("0.82 m with vertical parts of 50 mm, lengths of the vectors and their limits", fontsize=10)
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=3)
    return figure


def _draw_motion(panels: list[Axes], found: HandPath, colour: str, label: str) -> None:
    times = np.linspace(0.0, float(found.duration[0]), 3000)
    read = found.sample(times)
    for axes, vectors in zip(panels, (read.velocity, read.acceleration, found.jerk(times)), strict=True):
        axes.plot(times, np.linalg.norm(vectors[0], axis=1), color=colour, linewidth=1.2, label=label)


PARTS = (Part("example-times", example_findings), Part("long-times", long_findings))
