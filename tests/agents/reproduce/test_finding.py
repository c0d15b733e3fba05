"""Verdicts: computed from the published figure, ours, and a tolerance."""

import json
import math
from typing import Any

import pytest

from agents.ground.tables import Grid
from agents.reproduce import finding
from agents.reproduce.finding import Row, agree, printed, share
from agents.reproduce.grids import JUDGED, by_quantity, number, plain, row_grids, short, value, with_unit


@pytest.mark.parametrize(
    ("published", "ours", "within", "verdict"),
    [
        (0.32, 0.3237, printed(2), "reproduced"),
        (0.32, 0.3251, printed(2), "differs"),
        (120, 118.0, share(120, 0.02), "reproduced"),
        (120.0, 1.2 * 120.0, share(120, 0.06), "differs"),
        (10.0, 10.0, None, "reproduced"),
        (10.0, 10.0 + 1e-9, None, "differs"),
        (1.0, math.inf, 10.0, "differs"),
        (1.0, math.nan, 10.0, "differs"),
        ("shortest", "shortest", None, "reproduced"),
        ("shortest", "longest", None, "differs"),
        ("shortest", 1.0, 2.0, "differs"),
        (1.0, None, 0.1, "not reproducible"),
        (None, 1.0, None, "ours"),
    ],
)
def test_a_verdict_follows_from_the_figures(published: Any, ours: Any, within: float | None, verdict: str) -> None:
    assert Row.compared("a", published, ours, "m", within=within).verdict == verdict


@pytest.mark.parametrize(("ours", "verdict"), [(135.0, "misprint"), (57.4, "reproduced")])
def test_a_misprint_needs_another_figure_and_a_slip_that_gives_the_published_one(ours: float, verdict: str) -> None:
    row = Row.compared("gain", 57.5, ours, "%", within=printed(1) + 0.1).explain(57.5)
    assert row.verdict == verdict
    assert Row.compared("gain", 57.5, 135.0, "%", within=0.1).explain(60.0).verdict == "differs"


@pytest.mark.parametrize(
    ("holds", "explained", "verdict"),
    [(True, None, "reproduced"), (False, None, "differs"), (False, "> 2", "misprint"), (False, "> 3", "differs")],
)
def test_a_claim_in_words_is_judged_by_whether_it_holds(holds: bool, explained: str | None, verdict: str) -> None:
    assert Row.compared("ratio", "> 2", 1.5, "-", holds=holds).explain(explained).verdict == verdict


def test_figures_of_ours_and_missing_ones_are_not_judged() -> None:
    assert Row.ours("a", 1.0, "m", beside=1.0).verdict == "ours"
    assert Row.missing("a", 1.0, "m", reproduced=1.0, note="why").verdict == "not reproducible"


def test_a_statement_counts_once_and_differs_only_if_it_differs_under_every_reading() -> None:
    rows = [
        Row.compared("a/first", 1.0, 2.0, "m", statement="a"),
        Row.compared("a/second", 1.0, 1.0, "m", statement="a"),
        Row.compared("b/first", 1.0, 2.0, "m", statement="b"),
        Row.missing("b/second", 1.0, "m", note="why", statement="b"),
        Row.compared("c", 1.0, 2.0, "m").explain(1.0),
        Row.ours("b/third", 1.0, "m", beside=1.0),
    ]
    verdicts = {"a": "reproduced", "b": "differs", "c": "misprint"}
    assert finding.judge(row.as_json() for row in rows) == verdicts
    assert finding.judge(row.as_json() for row in reversed(rows)) == verdicts


def test_no_detail_takes_the_place_of_a_verdict() -> None:
    row = Row("a", 1.0, 2.0, "m", details={"verdict": "reproduced", "seeds": [1]})
    assert row.as_json()["verdict"] == "differs"
    assert row.as_json()["seeds"] == [1]
    assert list(row.as_json())[:7] == ["quantity", "published", "reproduced", "unit", "verdict", "tolerance", "note"]
    json.dumps(row.as_json())


def test_tolerances_are_half_a_printed_digit_or_a_share() -> None:
    assert agree(0.125, 0.12, printed(2))
    assert not agree(0.1251, 0.12, printed(2))
    assert printed(0) == pytest.approx(0.5)
    assert share(-20.0, 0.06) == pytest.approx(1.2)


def test_judged_rows_stand_in_a_table_before_those_of_ours() -> None:
    ours, judged = Row.ours("a/one", 1.0, "m", beside=1.0), Row.compared("a/two", 1.0, 2.0, "m")
    first, second = row_grids("All", [ours, judged], drop="a/")
    assert (first.headline, [line[0] for line in first.rows]) == ("All", ["two"])
    assert (second.headline, [line[0] for line in second.rows]) == ("All: ours", ["one"])
    assert JUDGED in first.header
    assert JUDGED not in second.header
    assert [grid.headline for grid in row_grids("All", [ours], drop="a/")] == ["All: ours"]


def test_rows_as_tables() -> None:
    rows = by_quantity(
        [
            Row.compared("choe/statement/length", 0.5, 0.51234567, "m", within=0.1, note="n", top=1.0 / 3.0),
            Row.ours("choe/nodes/count", 80, "-"),
        ]
    )
    assert plain("All", rows.values(), drop="choe/") == Grid(
        "All",
        ["figure", "published", "reproduced", "verdict", "note"],
        [["length", "0.5 m", "0.51235 m", "reproduced", "n"], ["nodes count", "-", "80", "ours", ""]],
    )
    assert plain("All", rows.values(), verdict=False).header == ["figure", "published", "reproduced", "note"]
    assert number(rows["choe/statement/length"], "top", 2) == "0.33"
    assert number(rows.get("none"), "top", 2) == number(rows["choe/nodes/count"], "top", 2) == "-"
    assert (value(rows, "choe/nodes/count", "{:.1f}"), value(rows, "none", "{:.1f}")) == ("80.0", "-")
    assert (short("claim/a/b"), short("table1/a"), with_unit("word", "m"), with_unit(1.5, "-")) == (
        "a b", "table1 a", "word", "1.5",
    )  # fmt: skip
