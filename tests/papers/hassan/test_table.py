"""Table I of Hassan et al. 2022: every cell by every protocol, and what holds across it."""

import json

import numpy as np
import pytest

from papers.hassan import table as hassan_table
from papers.hassan.cases import FOLD, PROTOCOLS, PUBLISHED, SHOWN, cell_cycle, differences, picks_per_min
from pnt_gym.planning import InfeasibleThrow


def table(protocol):
    return {cell: picks_per_min(cell_cycle(protocol, *cell)) for cell in PUBLISHED}


def test_the_published_table_is_complete():
    assert len(PUBLISHED) == 15
    assert sum(PUBLISHED.values()) == 24 + 42 + 51 + 29 + 56 + 75 + 30 + 68 + 120 + 54 + 60 + 65 + 62 + 71 + 81


def test_paper_clock_comes_close_in_every_cell():
    difference = differences(table("paper-clock"))
    assert np.mean(list(difference.values())) <= 0.03
    assert max(difference.values()) <= 0.10
    assert max(value for cell, value in difference.items() if cell != FOLD) <= 0.06


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_orderings_and_trends_hold(protocol):
    values = table(protocol)
    for (method, zone, percent), value in values.items():
        higher = [p for m, z, p in PUBLISHED if (m, z) == (method, zone) and p > percent]
        assert all(values[method, zone, p] > value for p in higher)
    for zone, percent in {cell[1:] for cell in PUBLISHED}:
        assert values["min-time-throw", zone, percent] > values["horizontal-throw", zone, percent]
        if zone == "inside":
            assert values["horizontal-throw", zone, percent] > values["pick-and-place", zone, percent]


def test_a_cell_becomes_a_row_with_its_details():
    judged = hassan_table.cell_row("constant-jerk-overlap", FOLD)
    assert (judged.published, judged.unit, judged.verdict) == (120.0, "picks/min", "reproduced")
    assert judged.tolerance == pytest.approx(12.0)
    assert "within 10 %" in judged.note
    row = hassan_table.cell_row("paper-clock", FOLD)
    assert row.quantity == "table1/paper-clock/min-time-throw/inside/40"
    assert row.reproduced == pytest.approx(113.5, abs=0.05)
    entry = json.loads(json.dumps(row.as_json(), allow_nan=False))
    assert entry["relative_difference"] == pytest.approx(row.reproduced / 120.0 - 1.0)
    assert entry["peak_acceleration_ratio"] == pytest.approx(2.0, abs=0.01)


def test_protocols_that_are_no_reading_of_the_paper_are_not_judged():
    for protocol in ("constant-jerk-stops", "paper-clock"):
        row = hassan_table.cell_row(protocol, FOLD)
        assert (row.published, row.verdict) == (120.0, "ours")
    assert [name for name, protocol in PROTOCOLS.items() if protocol.reading] == [
        "paper-clock",
        "constant-jerk-overlap",
    ]


def test_the_table_reports_every_cell_by_every_protocol_that_is_shown(found_table):
    rows = {row.quantity: row for row in found_table.rows}
    assert len(rows) == len(found_table.rows)
    for protocol in SHOWN:
        assert {f"table1/{protocol}/" + "/".join(map(str, cell)) for cell in PUBLISHED} <= set(rows)
        for name, count in (("ordered-columns", 6.0), ("rising-rows", 5.0)):
            assert rows[f"table1/{protocol}/{name}"].reproduced == count
    assert rows["table1/paper-clock/mean-difference"].reproduced == pytest.approx(2.93, abs=0.01)
    assert rows["table1/paper-clock/rising-rows"].verdict == "ours"
    assert rows["table1/constant-jerk-overlap/rising-rows"].verdict == "reproduced"
    assert rows["table1/constant-jerk-overlap/peak-velocity"].verdict == "reproduced"
    assert rows["table1/paper-clock/peak-acceleration"].verdict == "ours"
    assert rows["table1/constant-jerk-overlap/peak-acceleration"].verdict == "reproduced"
    assert rows["table1/constant-jerk-overlap/peak-jerk"].verdict == "ours"
    assert rows["table1/constant-jerk-overlap/peak-jerk"].reproduced == pytest.approx(1.61, abs=0.005)
    for name, mean, worst in (("overlap", 4.76, 8.86), ("stops", 7.91, 12.98)):
        assert rows[f"table1/constant-jerk-{name}/mean-difference"].reproduced == pytest.approx(mean, abs=0.006)
        assert rows[f"table1/constant-jerk-{name}/worst-difference"].reproduced == pytest.approx(worst, abs=0.006)
    assert rows["table1/constant-jerk-stops/peak-jerk"].reproduced == pytest.approx(1.0)
    assert rows["table1/paper-clock/peak-acceleration"].reproduced == pytest.approx(2.0, abs=1e-3)
    assert rows["hassan/pick-and-place-outside"].verdict == "reproduced"
    assert rows["hassan/pick-and-place-outside"].details["refused"] == 3
    assert found_table.figures["hassan_table1.svg"] == str(sorted(SHOWN))
    (grid,) = found_table.grids
    assert [line[0] for line in grid.rows] == [PROTOCOLS[name].label for name in SHOWN]
    assert grid.rows[1][1:6] == ["2.9 %", "5.5 %", "5.5 %", "6 of 6", "5 of 5"]


@pytest.mark.parametrize(
    "cell",
    [
        ("fast-clock", "min-time-throw", "inside", 30),
        ("paper-clock", "throw", "inside", 30),
        ("paper-clock", "min-time-throw", "above", 30),
        ("paper-clock", "min-time-throw", "inside", 0),
        ("paper-clock", "min-time-throw", "inside", 101),
    ],
)
def test_unknown_cells_are_refused(cell):
    with pytest.raises(ValueError, match=r"unknown (protocol|method|zone) |must lie in"):
        cell_cycle(*cell)


def test_no_number_comes_of_a_cell_without_a_plan():
    with pytest.raises(InfeasibleThrow):
        picks_per_min(cell_cycle("paper-clock", "pick-and-place", "outside", 40))
