"""The reproduction of Hassan et al. 2022: Table I, the paper's methods, its inconsistencies, the figures."""

import json
from xml.etree import ElementTree

import numpy as np
import pytest

from agents.reproduce import hassan, hassan_figures, hassan_methods, hassan_table
from agents.reproduce.hassan_cases import FOLD, PROTOCOLS, PUBLISHED, cell_cycle, picks_per_min
from agents.reproduce.hassan_inconsistencies import inconsistency_findings
from pnt_gym.planning import InfeasibleThrow, MotionLimits


@pytest.fixture(scope="module")
def inconsistencies():
    return {row.quantity: row for row in inconsistency_findings().rows}


def table(protocol):
    return {cell: picks_per_min(cell_cycle(protocol, *cell)) for cell in PUBLISHED}


def test_the_published_table_is_complete():
    assert len(PUBLISHED) == 15
    assert sum(PUBLISHED.values()) == 24 + 42 + 51 + 29 + 56 + 75 + 30 + 68 + 120 + 54 + 60 + 65 + 62 + 71 + 81


def test_paper_clock_comes_close_in_every_cell():
    difference = {cell: abs(value / PUBLISHED[cell] - 1.0) for cell, value in table("paper-clock").items()}
    assert np.mean(list(difference.values())) <= 0.03
    assert max(difference.values()) <= 0.10
    assert max(value for cell, value in difference.items() if cell != FOLD) <= 0.06


@pytest.mark.parametrize("protocol", ["paper-clock", "jerk-overlap", "no-overlap"])
def test_orderings_and_trends_hold(protocol):
    values = table(protocol)
    for (method, zone, percent), value in values.items():
        higher = [p for m, z, p in PUBLISHED if (m, z) == (method, zone) and p > percent]
        assert all(values[method, zone, p] > value for p in higher)
    for zone, percent in {cell[1:] for cell in PUBLISHED}:
        assert values["min-time-throw", zone, percent] > values["horizontal-throw", zone, percent]
        if zone == "inside":
            assert values["horizontal-throw", zone, percent] > values["pick-and-place", zone, percent]


@pytest.mark.parametrize(
    ("zone", "percent", "least"),
    [("inside", 15, 29.7), ("inside", 40, 102.0), ("outside", 35, 55.0), ("outside", 45, 74.5)],
)
def test_the_straight_throw_within_the_limits(zone, percent, least):
    cycle = cell_cycle("limits-respected", "min-time-throw", zone, percent)
    assert picks_per_min(cycle) >= least
    for ratios in cycle.peak_ratios(MotionLimits.t3kr(percent)):
        assert ratios.max() <= 1.0 + 1e-6
    assert picks_per_min(cycle) > picks_per_min(cell_cycle("no-overlap", "min-time-throw", zone, percent))


def test_a_cell_becomes_a_row_with_its_details():
    row = hassan_table.cell_row("paper-clock", FOLD)
    assert row.quantity == "table1/paper-clock/min-time-throw/inside/40"
    assert (row.published, row.unit, row.verdict) == (120.0, "picks/min", "reproduced")
    assert row.reproduced == pytest.approx(113.5, abs=0.05)
    entry = json.loads(json.dumps(row.as_json(), allow_nan=False))
    assert entry["relative_difference"] == pytest.approx(row.reproduced / 120.0 - 1.0)
    assert entry["peak_acceleration_ratio"] == pytest.approx(2.0, abs=0.01)
    period = 180.0 / row.reproduced
    assert entry["picks_per_min_dwell_0.1"] == pytest.approx(180.0 / (period + 0.3))
    assert entry["picks_per_min_dwell_0.2"] == pytest.approx(180.0 / (period + 0.6))


def test_the_table_reports_every_cell_by_every_protocol(monkeypatch):
    # The optima take long and are tested above.
    quick = {name: protocol for name, protocol in PROTOCOLS.items() if protocol.rules.returning == "straight"}
    monkeypatch.setattr(hassan_table, "PROTOCOLS", quick)
    monkeypatch.setattr(hassan_table, "SIMULATED", ())
    monkeypatch.setattr(hassan_table, "table_figure", lambda reproduced: str(sorted(reproduced)))
    found = hassan_table.table_findings()
    rows = {row.quantity: row for row in found.rows}
    assert len(rows) == len(found.rows)
    for protocol in quick:
        assert {f"table1/{protocol}/" + "/".join(map(str, cell)) for cell in PUBLISHED} <= set(rows)
        for name, count in (("ordered-columns", 6.0), ("rising-rows", 5.0)):
            assert rows[f"table1/{protocol}/{name}"].reproduced == count
    assert rows["table1/paper-clock/mean-difference"].reproduced == pytest.approx(2.93, abs=0.01)
    assert rows["table1/paper-clock/mean-difference"].verdict == "reproduced"
    assert rows["table1/no-overlap/peak-jerk"].verdict == "reproduced"
    assert rows["table1/paper-clock/peak-acceleration"].reproduced == pytest.approx(2.0, abs=1e-3)
    assert rows["hassan/pick-and-place-outside"].verdict == "infeasible"
    assert rows["hassan/pick-and-place-outside"].details["refused"] == 3
    assert found.figures["hassan_table1.svg"] == str(sorted(quick))


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
    with pytest.raises(ValueError, match=r"must (be one of|lie in)"):
        cell_cycle(*cell)


def test_no_number_comes_of_a_cell_without_a_plan():
    with pytest.raises(InfeasibleThrow):
        picks_per_min(cell_cycle("paper-clock", "pick-and-place", "outside", 40))


def test_published_throws_against_their_own_model(inconsistencies):
    expected = {
        1: (-0.0157, 0.0031, "reproduced"),
        2: (0.0358, -0.0041, "not reproducible"),
        3: (0.0150, -0.0046, "reproduced"),
    }
    for k, (along, across, verdict) in expected.items():
        row = inconsistencies[f"hassan/inconsistency/throw-{k}-landing"]
        assert row.details["along_m"] == pytest.approx(along, abs=1e-4)
        assert row.details["across_m"] == pytest.approx(across, abs=1e-4)
        assert row.verdict == verdict
    best = [
        inconsistencies[f"hassan/inconsistency/throw-{k}-landing"].details["best_under_rounding_m"] for k in (1, 2, 3)
    ]
    assert max(best[0], best[2]) < 0.005
    assert best[1] > 0.015
    points = [inconsistencies[f"hassan/inconsistency/throw-{k}-point"].reproduced for k in (1, 2, 3)]
    assert points == ["0.0981, 0.1375, -0.7500", "0.1222, 0.1334, -0.7500", "0.1031, 0.1538, -0.7500"]


def test_inconsistencies_are_computed(inconsistencies):
    value = {name.removeprefix("hassan/"): row.reproduced for name, row in inconsistencies.items()}
    assert value["inconsistency/greatest-height"] == -0.85
    assert inconsistencies["hassan/inconsistency/greatest-height"].details["throws"] == 0
    assert value["inconsistency/method-2-heights"] == "-0.64, -0.61, -0.59"
    assert value["inconsistency/gain-proposed-over-pick-and-place"] == pytest.approx(135.3, abs=0.05)
    assert value["inconsistency/peak-acceleration-paper-clock-turn"] == pytest.approx(2.0, abs=1e-2)
    assert value["inconsistency/peak-acceleration-jerk-overlap-turn"] == pytest.approx(1.0)
    assert value["inconsistency/stroke-twice-the-release"] > 1.4
    assert value["inconsistency/clock-figure-12"] == pytest.approx(3.64, abs=0.005)
    assert value["inconsistency/two-branches"] == pytest.approx(0.2051, abs=1e-4)
    assert inconsistencies["hassan/inconsistency/two-branches"].published == pytest.approx(0.0963, abs=1e-4)
    assert value["inconsistency/fold"] == pytest.approx(0.183, abs=1e-3)
    assert value["inconsistency/root-of-equation-18"] < 0.0
    assert value["inconsistency/order-of-bounds"] < 0.0
    assert value["inconsistency/outside-30-proposed"] == 3.0
    twelve = inconsistencies["hassan/inconsistency/greatest-acceleration"].details
    assert twelve["picks_per_min_12"] < 0.55 * 68 < twelve["picks_per_min_120"] == pytest.approx(68.0, abs=0.1)


def test_claims_that_hold(inconsistencies):
    claims = [row for name, row in inconsistencies.items() if name.startswith("hassan/claim/")]
    assert len(claims) == 6
    assert {row.verdict for row in claims} == {"reproduced"}


def test_methods_agree_with_the_exact_solver(monkeypatch):
    monkeypatch.setattr(hassan_methods, "PAIRS", 2)
    monkeypatch.setattr(hassan_methods, "TRUST_CASES", 4)
    rows = {row.quantity: row.reproduced for row in hassan_methods.methods_findings().rows}
    count = len(hassan_methods.PERCENTAGES) * 2 * 2
    for method in ("method-1-slsqp", "method-2"):
        assert rows[f"hassan/methods/no-ceiling/{method}/agreements"] >= count - 1
        assert rows[f"hassan/methods/no-ceiling/{method}/time-ratio"] > 1.0
    for bounds in ("no-ceiling", "ceiling"):
        assert rows[f"hassan/methods/{bounds}/method-1-slsqp/invented"] == 0.0
        assert rows[f"hassan/methods/{bounds}/exact-batch/difference"] <= 1e-12
        assert rows[f"hassan/methods/{bounds}/exact-batch/plans-per-second"] > 0.0
    # Method 2 knows no ceiling.
    assert rows["hassan/methods/ceiling/method-2/agreements"] < rows["hassan/methods/no-ceiling/method-2/agreements"]


@pytest.mark.parametrize("draw", ["scurve_figure", "positions_figure", "table_figure"])
def test_figures_are_drawings(draw):
    cells = {protocol: {cell: float(value) for cell, value in PUBLISHED.items()} for protocol in hassan_figures.STYLES}
    given = {"positions_figure": ("outside", ("horizontal-throw", "min-time-throw")), "table_figure": (cells,)}
    figure = getattr(hassan_figures, draw)(*given.get(draw, ()))
    text = figure if isinstance(figure, str) else hassan_figures.svg(figure)
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert len(text) > 10_000


def test_a_loop_is_drawn_in_one_piece():
    cycle = cell_cycle("paper-clock", "min-time-throw", "inside", 30)
    run = hassan_figures.loop_motion(cycle)
    assert (np.diff(run.time[0]) > 0.0).all()
    assert run.time[0, -1] == pytest.approx(cycle.duration.sum(), abs=1e-3)
    assert np.abs(np.diff(run.position[0], axis=0)).max() <= 1.8 / hassan_figures.RATE * (1.0 + 1e-9)
    np.testing.assert_allclose(run.position[0, -1], cycle.path.start[0], rtol=0, atol=1e-4)


def test_parts_are_named_apart():
    names = [part.name for part in hassan.PARTS]
    assert len(set(names)) == len(names) >= 4
