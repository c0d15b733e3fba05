"""Cycle times of whole paths from pick to place with their vertical parts; Choe et al. 2023 print no times."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots, svg
from agents.ground.tables import Grid
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import NONE, by_quantity, plain, value
from pnt_gym.planning.motion.trajectory import JerkTrajectory

from ..common.fastest import fastest_motion
from .cases import BELT, LIFT, LIMITS, SPAN, Case, example_cases, long_cases, motion

BOUNDS: Final = {
    "bound-50mm": (0.05, None),
    "bound-50mm-top-100mm": (0.05, BELT + LIFT),
    "bound-20mm": (0.02, None),
}
"""Motions on a free path, by name: length of the vertical parts [m] and greatest height [m] (None: no bound)."""
CYCLES: Final = "cycles per minute there and back"
MOTION: Final = ("path", "time", "length", "height", "peak v, a, j")
"""Columns of a table of paths; the last column is in shares of the limits."""
PEAKS: Final = ("velocity", "acceleration", "jerk")
SHOWN: Final = ("ellipse-50mm-strict", "ellipse-50mm-relaxed", "lame-50mm-level")


def example_findings() -> Findings:
    """Times along the paper's ellipse: without vertical parts, with vertical parts, with other angles."""
    rows = [_case_row("example", case) for case in example_cases().values()]
    times = {name: float(motion(case).duration[0]) for name, case in example_cases().items()}
    quickest = min((name for name in times if name.endswith("deg-relaxed")), key=times.__getitem__)
    angle = quickest.removeprefix("ellipse-").removesuffix("deg-relaxed") + " deg"
    note = (
        "the paper gives no time, only that the shortest path may be the quickest; its sharp ends slow the hand "
        "down: of 9.5, 10, 12 and 15 deg, with 25 mm of vertical on either side, relaxed"
    )
    claim = Row.ours("choe/claim/shortest-is-quickest", angle, "-", beside="10 deg", note=note)
    table = Grid("Time of the example's path with short vertical parts, one way", MOTION, [_cells(row) for row in rows])
    further = plain("Shortest and quickest", by_quantity([claim]).values(), drop="choe/")
    return Findings((*rows, claim), {"choe_times_example": times}, grids=(table, further))


def long_findings() -> Findings:
    """Times over 0.82 m at 0.1 m height: the paper's kind of path, smooth corners, and the quickest free path."""
    paths = [_case_row("long", case) for case in long_cases().values()]
    bounds = [_bound_row(name) for name in BOUNDS]
    conclusions, joints = tuple(_conclusion_rows()), tuple(_joint_rows())
    conclusion_rows = by_quantity(conclusions)
    lines = [
        [
            *_cells(row),
            *(value(conclusion_rows, f"choe/{kind}/{_name(row)}", "{:.1f} %") for kind in ("saving", "above-bound")),
        ]
        for row in (*paths, *bounds)
    ]
    header = (*MOTION, "saved over rectangle", "above bound")
    tables = (
        Grid("Time of a pick-and-place within the limits, one way", header, lines),
        plain("Where line and ellipse meet", by_quantity(joints).values(), drop="choe/"),
    )
    times = {row.quantity: row.reproduced for row in (*paths, *bounds)}
    figures = {"choe_times.svg": svg(times_figure()), "choe_motions.svg": svg(motions_figure())}
    return Findings((*paths, *bounds, *conclusions, *joints), {"choe_times_long": times}, figures, tables)


def _name(row: Row) -> str:
    return row.quantity.rsplit("/", 1)[1]


def _cells(row: Row) -> list[str]:
    """Cells of a table's row: time, shape and peaks of a path."""
    shape = [f"{row.details[part]:.3f} m" if part in row.details else NONE for part in ("length_m", "top_m")]
    peaks = [f"{row.details[f'peak_{peak}']:.2f}" for peak in PEAKS if f"peak_{peak}" in row.details]
    return [_name(row).replace("-", " "), f"{row.reproduced:.3f} s", *shape, ", ".join(peaks) or NONE]


def _case_row(group: str, case: Case) -> Row:
    timed_path = motion(case)
    seconds = float(timed_path.duration[0])
    rule = {"strict": "continuous acceleration", "relaxed": "normal acceleration may step"}[case.joints]
    return Row.ours(
        f"choe/time/{group}/{case.name}",
        seconds,
        "s",
        note=f"one way, {case.label}, {rule}: {30.0 / seconds:.1f} {CYCLES}",
        length_m=case.path.length,
        top_m=case.path.top,
        **{f"peak_{peak}": float(ratio[0]) for peak, ratio in zip(PEAKS, timed_path.peak_ratios(LIMITS), strict=True)},
    )


@cache
def free_path_bound(name: str) -> JerkTrajectory:
    """The quickest motion over `SPAN` that is vertical near both ends and free between, by a name of `BOUNDS`."""
    vertical, roof = BOUNDS[name]
    start, end = (0.0, -0.5 * SPAN, BELT), (0.0, 0.5 * SPAN, BELT)
    return fastest_motion(start, end, LIMITS, lift=vertical, drop=vertical, roof=roof)


def _bound_row(name: str) -> Row:
    vertical, roof = BOUNDS[name]
    seconds = float(free_path_bound(name).duration[0])
    height = "" if roof is None else f", at most {LIFT} m high"
    note = f"one way, any path vertical over {vertical} m at both ends{height}: {30.0 / seconds:.1f} {CYCLES}"
    return Row.ours(f"choe/time/long/{name}", seconds, "s", note=note)


def _conclusion_rows() -> Iterator[Row]:
    times = {name: float(motion(case).duration[0]) for name, case in long_cases().items()}
    note = "of the time over the rectangle with stops at its corners"
    for name in SHOWN:
        yield Row.ours(f"choe/saving/{name}", 100.0 * (1.0 - times[name] / times["rectangle"]), "%", note=note)
    for name, over in (("lame-50mm-level", "bound-50mm-top-100mm"), ("lame-50mm-tall", "bound-50mm")):
        above = times[name] / float(free_path_bound(over).duration[0]) - 1.0
        note = f"one G2 path with two Lame corners over the quickest free motion ({over})"
        yield Row.ours(f"choe/above-bound/{name}", 100.0 * above, "%", note=note)


def _joint_rows() -> Iterator[Row]:
    """Rows with the speed and the step of the acceleration where line and ellipse meet."""
    case = long_cases()["ellipse-50mm-relaxed"]
    timed_path = motion(case)
    border = int(np.argmin(np.abs(timed_path.progress.s - case.path.borders[1])))
    moment = float(timed_path.knot_times[border])
    before, after = (timed_path.sample(np.array([moment + delta])) for delta in (-1e-9, 1e-9))
    speed = float(np.linalg.norm(before.velocity))
    step = float(np.linalg.norm(after.acceleration - before.acceleration))
    unfair = "the step has no finite jerk, so that this motion may be quicker than the quickest one within the limits"
    text = "where line and ellipse meet, vertical parts of 50 mm, relaxed"
    yield Row.ours("choe/joint/speed", speed, "m/s", note=text)
    yield Row.ours("choe/joint/acceleration-step", step, "m/s2", beside="continuous", note=f"{text}; {unfair}")


def times_figure() -> Figure:
    """Drawing of each path over the long way and of the time along the path."""
    figure, (bars, paths) = subplots(2, 1, (WIDTH, 8.6))
    shown = [case for name, case in long_cases().items() if "50mm" in name or name == "rectangle"]
    labels = [case.label for case in shown] + ["free path, 0.10 m high", "free path"]
    values = [float(motion(case).duration[0]) for case in shown]
    values += [float(free_path_bound(name).duration[0]) for name in ("bound-50mm-top-100mm", "bound-50mm")]
    colours = [_colour(case.name) for case in shown] + ["#8c8c8c"] * 2
    places = np.arange(len(values), dtype=np.float64)
    bars.hlines(places, 0.0, values, color=colours, linewidth=1)
    for place, seconds, colour in zip(places, values, colours, strict=True):
        bars.plot(seconds, place, "o", color=colour)
        bars.text(seconds + 0.008, float(place), f"{seconds:.3f}", va="center", fontsize=8)
    bars.set_yticks(places, labels, fontsize=8)
    bars.invert_yaxis()
    dress(bars, "time one way [s]", "", "0.82 m, vertical parts of 50 mm", xlim=(0.65, 0.90))
    bars.grid(visible=False, axis="y")
    bars.set_axisbelow(True)
    _draw_paths(paths)
    return figure


def _draw_paths(axes: Axes) -> None:
    for name in ("rectangle", "ellipse-50mm-strict", "lame-50mm-level", "lame-50mm-tall"):
        case = long_cases()[name]
        points = 1000.0 * case.path.points(3000)
        axes.plot(points[:, 0], points[:, 1], color=_colour(name), label=case.label.removesuffix(", strict"))
    for name, style in (("bound-50mm-top-100mm", "--"), ("bound-50mm", ":")):
        trajectory = free_path_bound(name)
        places = trajectory.sample(np.linspace(0.0, float(trajectory.duration[0]), 800)).position[0]
        label = "quickest free path" + (", 0.10 m high" if "top" in name else "")
        axes.plot(1000 * (places[:, 1] + 0.5 * SPAN), 1000 * (places[:, 2] - BELT), style, color="black", label=label)
    dress(axes, "x [mm]", "height [mm], stretched", "the paths", legend="lower center")


def _colour(name: str) -> str:
    kinds = {"rectangle": 3, "ellipse": 0, "lame-50mm-tall": 4, "lame": 2}
    return COLOURS[next(index for kind, index in kinds.items() if name.startswith(kind))]


def motions_figure() -> Figure:
    """Drawing of speed, acceleration and jerk over time for paths where the hand stops, steps or runs through."""
    figure, panels = subplots(3, 1, (WIDTH, 7.0), sharex=True)
    labels = ("ellipse, strict: stops at T1, T2", "ellipse, relaxed: acceleration steps", "Lamé m = 3.5: runs through")
    for colour, name, label in zip(COLOURS, SHOWN, labels, strict=False):
        timed_path = motion(long_cases()[name])
        times = np.linspace(0.0, float(timed_path.duration[0]), 3000)
        samples = timed_path.sample(times)
        for axes, vectors in zip(panels, (samples.velocity, samples.acceleration, timed_path.jerk(times)), strict=True):
            axes.plot(times, np.linalg.norm(vectors[0], axis=1), color=colour, linewidth=1.2, label=label)
    units = ("speed [m/s]", "acceleration [m/s²]", "jerk [m/s³]")
    for axes, unit, limit in zip(panels, units, LIMITS.numbers(), strict=True):
        axes.axhline(limit, color="gray", linestyle=":", linewidth=1)
        dress(axes, "time [s]" if axes is panels[-1] else "", unit, ylim=(0.0, 1.12 * limit))
    panels[0].set_title("0.82 m with vertical parts of 50 mm, lengths of the vectors and their limits", fontsize=10)
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2)
    return figure
