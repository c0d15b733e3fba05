"""Fig. 8 of Choe et al. 2023 timed: the proposed curve and the curves that the paper compares it with.

The paper prints lengths only, and concludes that the cycle time may be smaller than along the other paths. Here the
curves run from T1 to T2 with vertical parts of 25 mm on either side, within limits that the paper does not state.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, get_args

from agents.ground.tables import Grid
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import row_grids

from .cases import HALF_RISE, LIMITS, SHORT_LIFT, Case, example, example_cases, motion
from .lengths import CREST, CURVES, RISE, comparison_paths
from .planning.timing import INTERVALS, JointRule

HEIGHTS: Final = {"equal-tops": example().top_height - HALF_RISE, "equal-crests": CREST}
"""Height of the compared curves above T2 [m], by reading: that of the proposed curve, or the paper's e."""
RULES: Final[tuple[JointRule, ...]] = get_args(JointRule)
PROPOSED: Final = "proposed"
WORDS: Final = {"strict": "continuous acceleration", "relaxed": "the normal acceleration may step at T1 and T2"}


def rival_findings() -> Findings:
    """Times of the curves of Fig. 8 at equal tops and at equal crests, with and without a continuous acceleration."""
    rows: list[Row] = []
    claims: list[Row] = []
    lines: list[list[str]] = []
    for rule in RULES:
        case = example_cases()[f"ellipse-10deg-{rule}"]
        ours, coarse = _time(case), float(motion(case, INTERVALS // 2).duration[0])
        note = f"proposed curve, {WORDS[rule]}; {coarse:.4f} s with half of the {INTERVALS} intervals"
        rows.append(_row(f"{PROPOSED}-{rule}", ours, note, with_half_the_intervals=coarse))
        for reading, height in HEIGHTS.items():
            paths = comparison_paths(RISE + SHORT_LIFT, height, drop=SHORT_LIFT)
            times = {name: _time(Case(path, rule)) for name, path in paths.items()}
            where = f"{reading.replace('-', ' ')}, {1000 * height:.1f} mm above T2, {WORDS[rule]}"
            rows += [_row(f"{reading}/{name}-{rule}", seconds, where) for name, seconds in times.items()]
            claims += _claim_rows(f"{reading}-{rule}", ours, times, where, rule == "strict")
            lines.append([reading.replace("-", " "), rule, *(f"{t:.3f} s" for t in (ours, *times.values()))])
    grid = Grid("Fig. 8 timed, with 25 mm of vertical on either side", ("curves", "rule", PROPOSED, *CURVES), lines)
    further = row_grids("Is the cycle time smaller?", claims, drop="choe/claim/")
    return Findings((*rows, *claims), grids=(*further, grid))


def _time(case: Case) -> float:
    """Time [s] of the quickest motion of a case."""
    return float(motion(case).duration[0])


def _row(name: str, seconds: float, note: str, **details: float) -> Row:
    limits = "{:g} m/s, {:g} m/s2, {:g} m/s3".format(*LIMITS.numbers())
    return Row.ours(f"choe/time/fig-8/{name}", seconds, "s", note=f"one way within {limits}: {note}", **details)


def _claim_rows(name: str, ours: float, times: dict[str, float], where: str, is_continuous: bool) -> Iterator[Row]:
    """Rows on the conclusion that the cycle time may be smaller, against the symmetric ellipse and the Lame curves.

    The paper also concludes that the acceleration is continuous, so motions without that judge nothing.
    """
    groups = {
        "symmetric-ellipse": [seconds for curve, seconds in times.items() if curve.startswith("symmetric")],
        "lame": [seconds for curve, seconds in times.items() if curve.startswith("lame")],
    }
    for rival, seconds in groups.items():
        quantity, claim = f"choe/claim/shorter-cycle-than-{rival}/{name}", "may be smaller"
        gain = 100.0 * (ours / min(seconds) - 1.0)
        note = f"time of the proposed curve, {ours:.3f} s, over the quickest such curve, {min(seconds):.3f} s; {where}"
        if not is_continuous:
            yield Row.ours(quantity, gain, "%", beside=claim, note=note)
            continue
        statement = f"choe/claim/shorter-cycle-than-{rival}"
        yield Row.compared(quantity, claim, gain, "%", holds=gain < 0.0, statement=statement, note=note)
