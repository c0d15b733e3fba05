"""Lengths of the ellipse of Choe et al. 2023 against the curves of its Fig. 8, under stated definitions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots, svg
from agents.ground.tables import Grid
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import row_grids
from pnt_gym.planning.paths import EllipsePath

from .cases import HALF_RISE, HALF_WIDTH, example
from .planning.plane import PlanePath, lame_path, line_ellipse_line

SPAN: Final = 2.0 * HALF_WIDTH
RISE: Final = 2.0 * HALF_RISE
CREST: Final = 0.025
"""Corner height e of the paper's Lamé curves [m]."""
WIDTHS: Final = (0.05, 0.15)
"""Corner widths d of the paper's Lamé curves [m]."""
EXPONENT: Final = 3.0
"""Exponent m of the Lamé curves; the paper does not give m, and 3 is the least with continuous curvature."""
CURVES: Final = ("symmetric ellipse", "Lamé d = 50 mm", "Lamé d = 150 mm")
"""Curves that the paper compares the proposed curve with."""


def length_findings() -> Findings:
    """Lengths of the curves of Fig. 8 under four readings of the comparison."""
    rows: list[Row] = []
    lines: list[list[str]] = []
    best = example().length
    for name, (text, paths) in readings().items():
        for label, path in paths.items():
            ratio = path.length / best - 1.0
            note = f"{text}; {abs(100.0 * ratio):.1f} % {'longer' if ratio > 0 else 'shorter'} than the proposed curve"
            rows.append(Row.ours(f"choe/fig-8/{name}/{label}", path.length, "m", note=note))
        shortest = min(path.length for path in paths.values())
        answer = "shortest" if shortest > best else "not the shortest"
        note = f"{text}; {best:.4f} m against at least {shortest:.4f} m"
        rows.append(
            Row.compared(
                f"choe/fig-8/{name}/proposed",
                "shortest",
                answer,
                "-",
                note=note,
                statement="choe/fig-8/proposed",
                length_m=best,
            )
        )
        lengths = [f"{length:.4f} m" for length in (best, *(path.length for path in paths.values()))]
        lines.append([name.replace("-", " "), *lengths, answer, note])
    header = ["compared", "proposed", *CURVES, "proposed is", "note"]
    table = Grid("Lengths of the curves, by what the comparison is taken to mean", header, lines)
    exponents = list(_exponent_rows())
    further = row_grids("The Lamé curves with other exponents", exponents, drop="choe/fig-8/")
    figures = {"choe_lengths.svg": svg(lengths_figure())}
    return Findings((*rows, *exponents), figures=figures, grids=(table, *further))


def readings() -> dict[str, tuple[str, dict[str, PlanePath]]]:
    """Readings of Fig. 8 by name: a sentence for people, and the compared paths by name."""
    top_height = example().top_height - HALF_RISE
    ends, curves = f"from T1 to T2, {RISE} m straight up at the pick, crest", "curves alone, ends of equal height"
    comparisons = {
        "same-ends": (f"{ends} {CREST} m above T2", comparison_paths(RISE, CREST)),
        "same-ends-and-top": (f"{ends} at the proposed curve's top", comparison_paths(RISE, top_height)),
        "curves-only": (f"{curves}: ellipse {RISE} m high, Lame curves {CREST} m", comparison_paths(0.0, CREST, RISE)),
        "curves-only-25mm": (f"{curves}, all {CREST} m high", comparison_paths(0.0, CREST)),
    }
    return {name: (f"{text}, m = {EXPONENT:g}", paths) for name, (text, paths) in comparisons.items()}


def comparison_paths(
    lift: float, crest: float, ellipse_crest: float | None = None, drop: float = 0.0
) -> dict[str, PlanePath]:
    """The paper's other curves by name, between vertical parts ``lift`` and ``drop`` [m], ``crest`` [m] high."""
    level = EllipsePath.with_top(HALF_WIDTH, 0.0, ellipse_crest or crest)
    paths = {"symmetric-ellipse": line_ellipse_line(level, lift, drop)}
    for width in WIDTHS:
        paths[f"lame-d{round(1000 * width)}mm"] = lame_path(SPAN, lift, drop, (width, crest), EXPONENT)
    return paths


def _exponent_rows() -> Iterator[Row]:
    """Rows with the length of the Lamé curves for other exponents, as the paper gives none."""
    for exponent in (2.0, 4.0):
        lengths = [lame_path(SPAN, RISE, 0.0, (width, CREST), exponent).length for width in WIDTHS]
        note = f"Lame curves of d = 0.05 and 0.15 m as in same-ends with m = {exponent:g}: the shorter"
        yield Row.ours(f"choe/fig-8/exponent-{exponent:g}", min(lengths), "m", note=note, lengths_m=lengths)


def lengths_figure() -> Figure:
    """Drawing of the curves of Fig. 8 under two readings."""
    figure, panels = subplots(2, 1, (WIDTH, 7.6))
    chosen = {"same-ends": "same ends T1 and T2", "curves-only": "curves only, ends of equal height"}
    proposed = line_ellipse_line(example(), 0.0, 0.0)
    for axes, (reading, title) in zip(panels, chosen.items(), strict=True):
        paths = readings()[reading][1]
        for k, (label, path) in enumerate([("proposed", proposed), *zip(CURVES, paths.values(), strict=True)]):
            points = 1000.0 * path.points(1500)
            text = f"{label}, {1000.0 * path.length:.1f} mm"
            axes.plot(points[:, 0], points[:, 1], "--" if k == 3 else "-", color=COLOURS[k], label=text)
        dress(axes, "x from T1 [mm]", "y [mm]", title, aspect="equal", xlim=(-8.0, 308.0), ylim=(-75.0, 85.0))
        axes.legend(fontsize=8, loc="lower center", ncols=2)
    return figure
