"""The free direction in Table I's cells: the optimum, planning per pick, infeasible cells, the robot's answer."""

import json
from xml.etree import ElementTree

import pytest

from papers.common.fastest import NoMotionFound
from papers.hassan import free as hassan_free
from papers.hassan import per_pick as hassan_per_pick
from papers.hassan.cases import CELLS, PICKS, PROTOCOLS, PUBLISHED, TARGETS, limits_at, picks_per_min, scene
from papers.hassan.free import (
    HEADROOM,
    KEPT_MISS,
    PER_PICK,
    RULES,
    constant_jerk_findings,
    free_cycle,
    free_details,
    free_figure,
    headroom_findings,
)
from papers.hassan.per_pick import (
    BATCH,
    cell_config,
    cell_mover,
    loss_rows,
    per_pick_cycle,
    per_pick_grid,
    random_picks,
    timing_rows,
)
from papers.hassan.simulated import TrialSummary, simulate, simulation_rows
from pnt_gym.cells.conveyor.movers.free_mover import FreeMover
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.planning import InfeasibleThrow
from pnt_gym.planning.free.rules import HandRules

CELL = ("outside", 45)


@pytest.fixture(scope="module")
def optimum():
    return free_cycle(*CELL)


def measured(**changes):
    figures = {
        "trials": 9, "landing_error_mean": 0.005, "landing_error_max": 0.006, "landing_error_by_item": {},
        "sorted": 9, "recontacts": 0, "clearance": 0.01, "peak_torque": 100.0, "release_tracking": 0.0, "tracking": 0.0,
    }  # fmt: skip
    return TrialSummary(**(figures | changes))


@pytest.mark.nightly
def test_the_optimum_beats_the_published_cell_within_the_limits(optimum):
    assert picks_per_min(optimum) >= 110.0 > 1.3 * PUBLISHED["min-time-throw", *CELL]
    details = free_details(CELL, optimum, RULES)
    assert details["limits_kept"] is True
    assert details["over_published_best"] == pytest.approx(picks_per_min(optimum) / 81.0 - 1.0)
    for name in ("velocity", "acceleration", "jerk"):
        assert 0.99 <= details[f"peak_{name}_ratio"] <= 1.0 + 1e-6
    assert details["least_gap_m"] >= -1e-6
    assert 0.10 < details["hand_above_ceiling_m"] <= RULES.hand_cap + 1e-6
    assert details["planned_miss_m"] <= KEPT_MISS
    assert sum(details["cycle_times_s"]) == pytest.approx(180.0 / picks_per_min(optimum))
    json.dumps(details, allow_nan=False)


@pytest.mark.nightly
def test_broken_bounds_are_not_called_kept(optimum):
    low = HandRules(hand_cap=0.05, workspace=RULES.workspace)
    assert free_details(CELL, optimum, low)["limits_kept"] is False
    assert free_details(("outside", 40), optimum, RULES)["limits_kept"] is False


def test_the_rules_are_those_of_the_table_and_of_the_cell():
    rules = PROTOCOLS["limits-respected"].rules
    config = cell_config(40)
    standing = config.model_copy(update={"belt": config.belt.model_copy(update={"tracking": False})})
    for mover in (cell_mover(40), PickPlanner(standing).mover):  # the table's hand begins at rest
        assert isinstance(mover, FreeMover)
        assert mover.rules == RULES
    assert (RULES.approach, RULES.window, config.motion.ceiling) == (rules.approach, 0.0, rules.rise)
    assert config.limits.percent == (40,)


@pytest.mark.nightly
def test_planned_per_pick_it_loses_little(optimum):
    """The mover chooses its release before it knows the next pick; the optimum knows it."""
    quick = per_pick_cycle(*CELL).require()
    assert free_details(CELL, quick, RULES)["limits_kept"] is True
    assert 0.95 * picks_per_min(optimum) <= picks_per_min(quick) <= picks_per_min(optimum)
    (row,) = loss_rows(PER_PICK, {CELL: quick}, {CELL: optimum})
    assert row.reproduced == pytest.approx(100.0 * (1.0 - picks_per_min(quick) / picks_per_min(optimum)))
    assert loss_rows(PER_PICK, {CELL: quick}, {}) == []
    (line, *rest) = per_pick_grid([row]).rows
    assert line[-1] == f"{row.reproduced:.1f} %"
    assert all(set(other[1:]) == {"-"} for other in rest)


@pytest.mark.parametrize(("cell", "picks"), [*zip(CELLS, (30.0, 71.7, 127.4, 65.8, 84.3, 107.4), strict=True)])
def test_the_cells_planner_beats_the_straight_throw_within_the_same_limits(cell, picks):
    cycle = per_pick_cycle(*cell)
    assert picks_per_min(cycle) == pytest.approx(picks, abs=0.06)
    assert free_details(cell, cycle, RULES)["limits_kept"] is True


def test_a_loop_without_a_throw_is_infeasible(monkeypatch):
    monkeypatch.setattr(hassan_per_pick, "CEILING", -0.9)
    with pytest.raises(InfeasibleThrow):
        per_pick_cycle(*CELL)


@pytest.mark.nightly
def test_every_answer_of_the_timed_batches_is_checked(monkeypatch):
    monkeypatch.setattr(hassan_per_pick, "ROUNDS", 1)
    picks, following = random_picks()
    assert picks.shape == following.shape == (BATCH, 3)
    assert (picks[:, 2] == PICKS[0][2]).all()
    for row in timing_rows("x", KEPT_MISS):
        assert row.reproduced > 0.0
        assert 0 <= row.details["straight"] <= row.details["planned"] == row.details["limits_kept"] <= BATCH


@pytest.mark.nightly
def test_with_constant_jerk_the_optimum_is_judged_by_its_own_limits(monkeypatch, optimum):
    asked = []
    monkeypatch.setattr(
        hassan_free, "free_cycle", lambda *cell, constant_jerk: asked.append((cell, constant_jerk)) or optimum
    )
    both = {0.0: measured(), 1.0: measured()}
    monkeypatch.setattr(hassan_free, "simulate", lambda plans: dict.fromkeys(plans, both))
    rows = {row.quantity: row for row in constant_jerk_findings().rows}
    assert asked == [(cell, True) for cell in CELLS]
    row = rows["table1/constant-jerk/free-direction-throw/outside/45"]
    assert row.verdict == "ours"
    scaled = free_details(CELL, optimum, RULES)["peak_jerk_ratio"]
    assert row.details["peak_jerk_ratio"] == pytest.approx(scaled * limits_at(45).numbers()[2] / 3000.0)


@pytest.mark.nightly
def test_a_cell_without_a_motion_is_infeasible(monkeypatch, optimum):
    def found(zone, percent, rules=RULES):
        if (zone, percent) == ("inside", 40):
            raise NoMotionFound("no throw was found")
        return optimum

    seen = {}
    monkeypatch.setattr(hassan_free, "free_cycle", found)
    both = {0.0: measured(), 1.0: measured()}
    monkeypatch.setattr(hassan_free, "simulate", lambda plans: seen.update(plans) or dict.fromkeys(plans, both))
    rows = {row.quantity: row for row in headroom_findings("hand-cap-0").rows}
    cells = [f"headroom/hand-cap-0/{zone}/{percent}" for zone, percent in CELLS]
    assert set(cells) <= set(rows)
    assert list(seen) == [name for name in cells if name != "headroom/hand-cap-0/inside/40"]
    row = rows["headroom/hand-cap-0/inside/40"]
    assert (row.verdict, row.reproduced, row.published) == ("infeasible", None, None)
    assert "the hand at most 0.00 m above the release ceiling" in row.note
    other = rows["headroom/hand-cap-0/outside/45"]
    assert other.reproduced == picks_per_min(optimum)
    assert other.details["simulated"]["1"]["trials"] == 9
    assert other.details["limits_kept"] is False


def test_without_any_motion_there_are_only_infeasible_rows(monkeypatch):
    def none(*_, **__):
        raise NoMotionFound("no throw was found")

    monkeypatch.setattr(hassan_free, "free_cycle", none)
    rows = headroom_findings("window-30ms").rows
    assert [row.verdict for row in rows] == ["infeasible"] * len(CELLS)


def test_variants_change_one_bound_each():
    for name, rules in HEADROOM.items():
        fields = ("approach", "window", "hand_cap", "clear_distance", "margin", "workspace")
        changed = [field for field in fields if getattr(rules, field) != getattr(RULES, field)]
        assert changed == ["hand_cap" if "cap" in name else "window"]


def test_sums_of_the_simulation():
    plans = [
        {0.0: measured(landing_error_max=0.009), 1.0: measured(sorted=3, peak_torque=150.0)},
        {0.0: measured(recontacts=2), 1.0: measured(sorted=6, recontacts=5)},
    ]
    rows = {row.quantity: row.reproduced for row in simulation_rows("x", plans)}
    assert rows == {
        "x/landing-max": 0.009, "x/recontacts": 2.0, "x/peak-torque": 150.0, "x/sorted-with-mismatch": 50.0,
    }  # fmt: skip


@pytest.mark.nightly
def test_the_robot_lands_every_object_of_the_optimum(optimum):
    found = simulate({"outside": (optimum, TARGETS["outside"])})["outside"]
    assert found[0.0].trials == found[0.0].sorted == 3 * len(scene("outside")[0])
    assert found[0.0].landing_error_max <= 0.010
    assert found[0.0].recontacts == 0
    assert max(one.peak_torque for one in found.values()) < 530.0
    assert found[1.0].landing_error_mean > found[0.0].landing_error_mean


@pytest.mark.nightly
def test_the_figure_is_a_drawing(optimum):
    text = free_figure(lambda *_: optimum)
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert len(text) > 10_000
