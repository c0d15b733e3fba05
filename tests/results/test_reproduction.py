"""Guards of committed numbers: the form of results/reproduction.json, and that its verdicts follow from its figures.

What computes the figures is tested beside its code.
"""

from typing import Any, get_args

import pytest

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT
from agents.reproduce.finding import Verdict, agree
from agents.reproduce.papers import PAPERS

DATA: dict[str, Any] = read_json(ROOT / "results" / "reproduction.json")
ROWS: dict[str, dict[str, Any]] = {row["quantity"]: row for row in DATA["rows"]}
COMPARED = [row for row in DATA["rows"] if row["verdict"] in ("reproduced", "differs", "misprint")]


def test_every_row_keeps_the_contract() -> None:
    assert len(ROWS) == len(DATA["rows"])
    for row in ROWS.values():
        assert row["verdict"] in get_args(Verdict)
        assert row["verdict"] in ("infeasible", "not reproducible") or row["reproduced"] is not None
        assert row["verdict"] != "infeasible" or row["reproduced"] is None
        assert isinstance(row["note"], str)
        assert isinstance(row["unit"], str)
        if row["verdict"] in ("infeasible", "differs", "misprint", "not reproducible"):
            assert row["note"]


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


def test_dwells_are_counted() -> None:
    rows = [row for row in ROWS.values() if "picks_per_min_dwell_0.1" in row]
    assert rows
    for row in rows:
        for dwell in (0.1, 0.2):
            expected = 180.0 / (180.0 / row["reproduced"] + 3 * dwell)
            assert row[f"picks_per_min_dwell_{dwell}"] == pytest.approx(expected)
