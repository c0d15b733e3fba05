"""Lengths of the ellipse of Choe et al. 2023 against the curves of its Fig. 8, under stated definitions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.choe_cases import HALF_RISE, HALF_WIDTH, example
from agents.reproduce.findings import Findings, Part, Row
from pnt_gym.planning.paths import EllipsePath, PlanePath, lame_path, line_ellipse_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH: Final = 2.0 * HALF_WIDTH
RISE: Final = 2.0 * HALF_RISE
CREST: Final = 0.025
"""e of the paper's Lamé curves [m]."""
WIDTHS: Final = (0.05, 0.15)
"""d of the paper's Lamé curves [m]."""
EXPONENT: Final = 3.0
"""m is not given; 3 is the least with continuous curvature."""


def length_findings() -> Findings:
    """Fig. 8 under three readings."""
    rows: list[Row] = []
    for name, (text, paths) in readings().items():
        best = example().length
        for label, path in paths.items():
            ratio = path.length / best - 1.0
            note = f"{text}; {abs(100.0 * ratio):.1f} % {'longer' if ratio > 0 else 'shorter'} than the proposed curve"
            rows.append(Row(f"choe/fig-8/{name}/{label}", None, path.length, "m", "ours", note))
        shortest = min(path.length for path in paths.values())
        verdict = "reproduced" if shortest > best else "differs"
        answer = "shortest" if shortest > best else "not the shortest"
        note = f"{text}; {best:.4f} m against at least {shortest:.4f} m"
        rows.append(Row(f"choe/fig-8/{name}/proposed", "shortest", answer, "-", verdict, note, {"length_m": best}))
    rows += _exponents()
    return Findings(tuple(rows), figures={"choe_lengths.svg": svg(lengths_figure())})


def readings() -> dict[str, tuple[str, dict[str, PlanePath]]]:
    """What Fig. 8 may compare: a sentence and the paths by name."""
    own = example().top_height - HALF_RISE
    return {
        "same-ends": (
            f"from T1 to T2, {RISE} m straight up at the pick, crest {CREST} m above T2, m = {EXPONENT:g}",
            _family(RISE, CREST),
        ),
        "same-ends-and-top": (
            f"from T1 to T2, {RISE} m straight up at the pick, crest at the proposed curve's top, m = {EXPONENT:g}",
            _family(RISE, own),
        ),
        "curves-only": (
            f"curves alone, ends of equal height: ellipse {RISE} m high, Lame curves {CREST} m, m = {EXPONENT:g}",
            _family(0.0, CREST, RISE),
        ),
        "curves-only-25mm": (
            f"curves alone, ends of equal height, all {CREST} m high, m = {EXPONENT:g}",
            _family(0.0, CREST),
        ),
    }


def _family(lift: float, crest: float, ellipse_crest: float | None = None) -> dict[str, PlanePath]:
    level = EllipsePath.with_top(HALF_WIDTH, 0.0, ellipse_crest or crest)
    paths = {"symmetric-ellipse": line_ellipse_line(level, lift, 0.0)}
    for width in WIDTHS:
        paths[f"lame-d{round(1000 * width)}mm"] = lame_path(WIDTH, lift, 0.0, (width, crest), EXPONENT)
    return paths


def _exponents() -> list[Row]:
    """What the missing exponent does to the comparison."""
    rows: list[Row] = []
    for exponent in (2.0, 4.0):
        lengths = [lame_path(WIDTH, RISE, 0.0, (width, CREST), exponent).length for width in WIDTHS]
        note = f"Lame curves of d = 0.05 and 0.15 m as in same-ends with m = {exponent:g}"
        extra = {"lengths_m": lengths}
        rows.append(
            Row(f"choe/fig-8/exponent-{exponent:g}", None, min(lengths), "m", "ours", f"{note}: the shorter", extra)
        )
    return rows


def lengths_figure() -> Figure:
    """The curves of Fig. 8 under two readings."""
    figure, panels = subplots(1, 2, (11.0, 3.9))
    chosen = {"same-ends": "same ends T1 and T2", "curves-only": "curves only, ends of equal height"}
    names = ["symmetric ellipse", "Lamé d = 50 mm", "Lamé d = 150 mm"]
    own = line_ellipse_line(example(), 0.0, 0.0)
    for axes, (reading, title) in zip(panels, chosen.items(), strict=True):
        paths = readings()[reading][1]
        for k, (label, path) in enumerate([("proposed", own), *zip(names, paths.values(), strict=True)]):
            points = 1000.0 * path.points(1500)
            text = f"{label}, {1000.0 * path.length:.1f} mm"
            axes.plot(points[:, 0], points[:, 1], "--" if k == 3 else "-", color=COLOURS[k], label=text)
        axes.set_aspect("equal")
        axes.set_xlim(-8.0, 308.0)
        axes.set_ylim(-75.0, 85.0)
        axes.set_xlabel("x from T1 [mm]")
        axes.set_ylabel("y [mm]")
        axes.set_title(title, fontsize=10)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8, loc="lower center", ncols=2)
    return figure


PARTS = (Part("lengths", length_findings),)
