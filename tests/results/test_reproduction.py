"""Guards of committed numbers: the form of results/reproduction.json, and that its verdicts follow from its figures.

What computes the figures is tested beside its code.
"""

from typing import Any, get_args

import pytest

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT
from agents.reproduce.finding import Verdict, agree, printed
from agents.reproduce.papers import PAPERS

DATA: dict[str, Any] = read_json(ROOT / "results" / "reproduction.json")
ROWS: dict[str, dict[str, Any]] = {row["quantity"]: row for row in DATA["rows"]}
COMPARED = [row for row in DATA["rows"] if row["verdict"] in ("reproduced", "differs", "misprint")]


def test_every_row_keeps_the_contract() -> None:
    assert len(ROWS) == len(DATA["rows"])
    for row in ROWS.values():
        assert row["verdict"] in get_args(Verdict)
        assert row["verdict"] == "not reproducible" or row["reproduced"] is not None
        assert isinstance(row["note"], str)
        assert isinstance(row["unit"], str)
        if row["verdict"] in ("differs", "misprint", "not reproducible"):
            assert row["note"]


def test_no_name_says_another_verdict_than_its_row() -> None:
    for name, row in ROWS.items():
        assert {*name.split("/")} & {"reproduced", "differs", "misprint", "inconsistency"} <= {row["verdict"]}, name


@pytest.mark.parametrize("row", COMPARED, ids=lambda row: row["quantity"])
def test_verdicts_follow_from_the_figures(row: dict[str, Any]) -> None:
    published, ours, tolerance = row["published"], row["reproduced"], row["tolerance"]
    if "holds" in row:  # a claim in words, whose truth was computed with the figure
        assert row["holds"] == (row["verdict"] == "reproduced")
        return
    assert agree(published, ours, tolerance) == (row["verdict"] == "reproduced")
    if row["verdict"] == "reproduced" and isinstance(ours, float) and published != 0.0:
        for wrong in (0.8 * published, 1.2 * published):
            assert not agree(published, wrong, tolerance), "a figure that is 20 % wrong would pass"


def test_every_paper_is_in_it_with_its_drawings() -> None:
    assert tuple(DATA["papers"]) == tuple(PAPERS)
    assert {row["paper"] for row in ROWS.values()} == set(PAPERS)
    for entry in ("titles", "overview", "grids"):
        assert set(DATA[entry]) == set(PAPERS)
    for names in DATA["figures"].values():
        assert names
        for name in names:
            assert (ROOT / "results" / "figures" / name).is_file()


AUDITED = (
    ("table1/constant-jerk-stops/mean-difference", "reproduced", 7.9, 1),
    ("table1/constant-jerk-stops/worst-difference", "reproduced", 13.0, 1),
    ("table1/constant-jerk-overlap/mean-difference", "reproduced", 4.76, 2),
    ("table1/constant-jerk-overlap/worst-difference", "reproduced", 8.86, 2),
    ("table1/constant-jerk-overlap/peak-acceleration", "reproduced", 1.00, 2),
    ("table1/constant-jerk-overlap/peak-jerk", "reproduced", 1.61, 2),
    ("hassan/statement/gain-proposed-over-pick-and-place", "reproduced", 57.5, 1),
    ("hassan/statement/gain-proposed-over-existing", "reproduced", 37.5, 1),
    ("hassan/statement/clock-figure-12", "reproduced", 2.95, 2),
    ("choe/time/fig-8/proposed-strict", "with_half_the_intervals", 0.482, 3),
    ("choe/time/fig-8/proposed-relaxed", "reproduced", 0.358, 3),
    ("choe/time/fig-8/equal-tops/symmetric-ellipse-strict", "reproduced", 0.511, 3),
    ("choe/time/fig-8/equal-tops/symmetric-ellipse-relaxed", "reproduced", 0.423, 3),
    ("choe/time/fig-8/equal-tops/lame-d50mm-strict", "reproduced", 0.462, 3),
    ("choe/time/fig-8/equal-tops/lame-d150mm-strict", "reproduced", 0.463, 3),
    ("choe/time/fig-8/equal-crests/lame-d50mm-strict", "reproduced", 0.460, 3),
    ("choe/time/fig-8/equal-crests/lame-d150mm-strict", "reproduced", 0.455, 3),
    ("miyashita/fig-7/without-margin", "reproduced", 0.00, 2),
    ("leveziel/closing/speed-limited", "smallest", 0.0111, 4),
    ("leveziel/closing/speed-limited", "largest", 0.0208, 4),
    ("leveziel/closing/speed-limited", "largest_beyond_the_strokes", 0.03848, 5),
    ("leveziel/cycle/angle-change-in-closed-form", "reproduced", 4.0, 1),
    ("leveziel/cycle/angle-change", "reproduced", 5.25, 2),
)
"""Figures that an audit with code of its own found: quantity, entry, value and printed decimals."""


@pytest.mark.parametrize(("quantity", "entry", "value", "digits"), AUDITED)
def test_figures_are_those_of_an_independent_audit(quantity: str, entry: str, value: float, digits: int) -> None:
    assert agree(value, ROWS[quantity][entry], printed(digits))


def test_an_audit_of_fig_7b_is_like_one_of_the_samples() -> None:
    """352 of the audit's 400 guesses led to a motion, and 97.7 % of these lay within 1 mN m of zero."""
    row = ROWS["miyashita/fig-7/without-margin"]
    assert row["starts"] == 400
    for entry, value in (("motions_by_sample", 352), ("shares_by_sample", 97.7)):
        assert min(row[entry]) < value < max(row[entry])
