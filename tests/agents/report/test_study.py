"""The tables of studies: cells by expressions, columns across an axis, a dash for what is missing; and the figure."""

import math
from typing import Any

import pytest

from agents.ground.cli import UsageError
from agents.report import pictures, templates
from agents.results.study import StudyPlan, Table, pool, share, shipped_study

ROW = {
    "part": "a",
    "safety": None,
    "way": "x | y",
    "success": 0.5,
    "landing": {"mean": 0.0123},
    "rate": {"value": 0.1, "low": 0.05, "high": 0.2},
    "errors": [0.001, 0.002, 0.003],
    "margin_below_1.5": 0.25,
    "tilt": math.pi,
    "count": 12345,
}


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        ("success|percent(0)", "50 %"),
        ("landing.mean|mm", "12.3 mm"),
        ("rate|percent(sign=true)", "+10.0 % (+5.0..+20.0)"),
        ('rate.value|number(2) ~ " of " ~ rate|number(2)', "0.10 of 0.10 (0.05..0.20)"),
        ('errors[-1]|mm ~ ", " ~ errors[0]|mm(0)', "3.0 mm, 1 mm"),
        ('row["margin_below_1.5"]|percent', "25.0 %"),
        ("tilt|deg(0)", "180 deg"),
        ('"{:,} throws".format(count)', "12,345 throws"),
        ("way|code", "`x | y`"),
        ("safety", "-"),
        ("safety|percent", "-"),
        ('success|percent(0) ~ " " ~ nothing|number', "-"),
        ('success|percent(0) ~ " " ~ nothing', "-"),
        ("nothing", "-"),
        ("errors[9]", "-"),
        ("landing.none", "-"),
    ],
)
def test_a_cell_is_what_its_expression_makes_of_a_row(expression: str, text: str) -> None:
    assert templates.text(expression, {**ROW, "row": ROW}) == text


def plan() -> StudyPlan:
    axes = {"level": ["waste"], "planner": {"b": {}, "a": {}}}
    parts = {"one": {"measure": "throws.figures", "share": 0.5, "settings": {"shifts": 3}, "axes": axes}}
    return StudyPlan.model_validate(
        {"study": "s", "about": "x", "throws": 9, "parts": parts, "names": {"planner": {"a": "first way"}}}
    )


def data() -> dict[str, Any]:
    rows = [("waste", "b", 1.0), ("waste", "b", 2.0), ("waste", "a", 3.0), ("dense", "a", 4.0)]
    named = [{"part": "one", "level": level, "planner": name, "pace": pace} for level, name, pace in rows]
    return {"study": "s", "throws": 9, "seed": 2, "rows": [*named, {"part": "two", "level": "none", "planner": "c"}]}


def table(**changes: Any) -> Table:
    return Table.model_validate(
        {
            "title": "T",
            "parts": ["one"],
            "index": {"level": "level|code"},
            "columns": "planner",
            "figure": "pace|number",
        }
        | changes
    )


def test_an_axis_across_has_a_column_for_each_value_and_rows_that_meet_are_averaged() -> None:
    grid = templates.grid(plan(), table(), data())
    assert grid.header == ["level", "b", "first way"]
    assert grid.rows == [["`waste`", "1.5", "3.0"], ["`dense`", "-", "4.0"]]


def test_values_of_one_name_share_a_column_but_not_a_cell() -> None:
    named = plan().model_copy(update={"names": {"planner": {"b": "a way", "a": "a way"}}})
    apart = {**data(), "rows": [row for row in data()["rows"] if row.get("pace") in (1.0, 4.0)]}
    grid = templates.grid(named, table(), apart)
    assert grid.header == ["level", "a way"]
    assert grid.rows == [["`waste`", "1.0"], ["`dense`", "4.0"]]
    with pytest.raises(UsageError, match="table 'T': planner a, b meet in a cell; they need different names"):
        templates.grid(named, table(), data())


def test_a_table_shows_the_rows_that_it_asks_for_and_its_note_tells_counts_and_settings() -> None:
    note = "{{ throws }} of {{ settings.shifts }} shifts, seed {{ seed }}"
    figures = {"by": "planner", "pace": "pace|number"}
    wanted = table(columns="", figure="", figures=figures, where={"planner": ["b"]}, note=note)
    grid = templates.grid(plan(), wanted, data())
    assert grid.header == ["level", "by", "pace"]
    assert grid.rows == [["`waste`", "b", "1.0"], ["`waste`", "b", "2.0"]]
    assert grid.note == "4 of 3 shifts, seed 2"


def test_shares_that_meet_are_those_of_all_cases() -> None:
    rows = [{"part": "one", "share": share([True] * 3)}, {"part": "one", "share": share([True, False, False])}]
    whole = pool(rows)["share"]
    assert (whole["true"], whole["count"]) == (4, 6)
    assert whole == share([True] * 4 + [False] * 2)
    assert templates.text("share|percent(0)", {"share": whole}) == "67 % (30..90)"


def test_lists_that_meet_are_joined_and_tell_rates_landings_and_shares_won() -> None:
    rows: list[dict[str, Any]] = [
        {"cells": [[20.0, 30.0, 0.4, 20.0]], "least": [[10.0, 30.0]], "most": [[30.0, 30.0]]},
        {"cells": [[30.0, 30.0, 0.8, 40.0]], "least": [[10.0, 30.0]], "most": [[30.0, 30.0]]},
    ]
    whole = pool(rows)
    assert whole["cells"] == [[20.0, 30.0, 0.4, 20.0], [30.0, 30.0, 0.8, 40.0]]
    assert templates.text("cells|pace|number", whole) == "50.0 (40.0..60.0)"
    assert templates.text("cells|pace(most)|number(sign=true)", whole) == "-10.0 (-20.0..+0.0)"
    assert templates.text("cells|landing|mm", whole) == "20.0 mm (20.0..20.0)"
    assert templates.text("cells|won(least, most)|percent(0)", whole) == "75 % (50..100)"


@pytest.mark.parametrize("changes", [{"figure": ""}, {"columns": ""}, {"figures": {"pace": "pace"}}])
def test_a_table_has_figures_or_columns_of_one_figure(changes: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="figures are needed, or columns and a figure"):
        table(**changes)


def methods() -> dict[str, Any]:
    rows = [
        {**case.labels, "sorted_per_min": float(number)} if number else {**case.labels, "impossible": "no throw"}
        for part in shipped_study("methods").parts
        for number, case in enumerate(shipped_study("methods").cases(part))
    ]
    return {"study": "methods", "throws": 9, "seed": 0, "rows": rows}


def test_the_figure_has_a_line_for_each_method_in_each_panel_with_a_gap_where_it_cannot_throw() -> None:
    panels = [panel for panel in pictures.figure(methods()).axes if panel.get_visible()]
    assert [panel.get_title() for panel in panels] == ["level nominal", "level waste", "opening", "distance", "grip"]
    for panel in panels:
        assert [line.get_label() for line in panel.lines] == list(shipped_study("methods").names["planner"].values())
    assert math.isnan(panels[0].lines[0].get_ydata()[0])
    assert list(panels[0].lines[1].get_xdata()) == [15, 20, 30, 40, 60]
    assert list(panels[0].lines[1].get_ydata()) == [1.0, 6.0, 11.0, 16.0, 21.0]
    assert set(pictures.figures(methods())) == {"methods.svg"}
