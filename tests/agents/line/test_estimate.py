"""Estimates of lines: tables of flights in memory, valid for the cells alone, with the figures of `line plan`."""

from dataclasses import replace

import numpy as np
import pytest

import pnt_gym
from agents.ground.cli import UsageError
from agents.line.counting import counting_line
from agents.line.estimate import estimate
from agents.line.flown import FlightTable, fly
from agents.line.plans import Conditions
from agents.line.thrown import random_throws
from pnt_gym.cells.line.config import LineConfig
from tests.tools.line import chances

LEVEL = LineConfig.load("skills3", duration=15.0)
CONDITIONS = Conditions(shifts=2, threads=1)
FLIGHTS = 64


def with_bins(config: LineConfig, **by: float) -> LineConfig:
    """The line with its bins moved by lengths in x and y [m]."""
    bins = [{**one.model_dump(), **{k: getattr(one, k) + v for k, v in by.items()}} for one in config.cell.bins.fixed]
    cell = config.cell.model_dump(exclude_unset=True)
    return LineConfig.load(config, cell={**cell, "bins": {**cell["bins"], "fixed": bins}})


@pytest.fixture(scope="module")
def first():
    return estimate(LEVEL, CONDITIONS, FLIGHTS)


def test_an_estimate_is_the_plan_judged_by_flights_and_writes_no_file(first, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = {
        "robots": (3,),
        "minutes": 0.25,
        "shifts": 2,
        "throws": FLIGHTS + 36,
        "check": 0,
        "mend": False,
        "threads": 1,
    }
    with pytest.raises(UsageError, match="fidelity"):
        pnt_gym.plan_line("skills3", fidelity="plan", **options)
    monkeypatch.setattr("agents.line.verdict.LEARNED", "random")  # a release that costs no network
    told = pnt_gym.plan_line("skills3", fidelity="flight", **options)
    assert told["plans"] == [estimate(LEVEL, CONDITIONS, FLIGHTS + 36).planned.row]
    assert told["plans"] != [first.planned.row]
    assert not list(tmp_path.iterdir())


def test_nothing_flies_where_the_cells_are_the_same(first, monkeypatch):
    monkeypatch.setattr("agents.line.flown.random_throws", None)
    robots = [robot.model_copy(update={"skills": (), "x": 1.5 * robot.x}) for robot in LEVEL.robots[:2]]
    for changes in ({"arrivals": {"rate": 3.0}}, {"robots": robots}, {"value": {"of": {"can": 9.0}}}):
        other = estimate(LineConfig.load(LEVEL, **changes), CONDITIONS, FLIGHTS, first.table)
        assert other.table is first.table
        assert other.planned.row != first.planned.row
    again = estimate(LEVEL, CONDITIONS, FLIGHTS, first.table)
    assert again.planned.row == first.planned.row


def test_a_table_grows_by_flights_and_equals_one_that_was_counted_at_once(first, monkeypatch):
    counted = []

    def count(*args, **options):
        for batch in random_throws(*args, **options):
            counted.append(len(batch["kind"]))
            yield batch

    monkeypatch.setattr("agents.line.flown.random_throws", count)
    few = fly(LEVEL, FLIGHTS, 0, 1)
    begun = sum(counted)
    grown = fly(LEVEL, 2 * FLIGHTS, 0, 1, near=few)
    assert begun < sum(counted) < begun + 2 * FLIGHTS
    at_once = fly(LEVEL, 2 * FLIGHTS, 0, 1)
    assert grown.chances.entries == at_once.chances.entries != few.chances.entries
    assert grown.counted.as_json() == at_once.counted.as_json()
    again = fly(LEVEL, FLIGHTS + 1, 0, 1, near=few)
    assert again.chances.entries == fly(LEVEL, FLIGHTS + 1, 0, 1).chances.entries


def test_a_table_belongs_to_the_cells_and_not_to_the_stream(first):
    """So a table that was kept is, to the bit, the one that the changed line would count."""
    mix = {"cell": {**LEVEL.cell.model_dump(exclude_unset=True), "mix": {"can": 1.0, "tray": 5.0}}}
    robots = [LEVEL.robots[0].model_copy(update={"x": 7.0})]
    other = fly(LineConfig.load(LEVEL, robots=robots, arrivals={"rate": 0.5}, **mix), FLIGHTS, 0, 1)
    assert other.digest == first.table.digest
    assert other.chances.entries == first.table.chances.entries
    assert counting_line(LEVEL, "flight").cell.shares().tolist() == [0.25] * 4


def test_few_flights_are_shrunk_towards_the_table_of_the_design_before(first):
    moved = with_bins(LEVEL, y=0.05)
    usual = replace(chances(LEVEL), landed=np.full_like(first.table.chances.landed, 0.01))
    near = replace(first.table, chances=usual)
    alone, shrunk = fly(moved, FLIGHTS, 0, 1), fly(moved, FLIGHTS, 0, 1, near=near)
    assert alone.digest != first.table.digest
    assert (shrunk.chances.landed < alone.chances.landed).all()
    assert shrunk.chances.picked.tolist() == alone.chances.picked.tolist()
    other = fly(moved, FLIGHTS, 0, 1, near=replace(near, chances=replace(usual, landed=usual.landed[:3])))
    assert other.chances.entries == alone.chances.entries


def test_settled_tables_stand_alone(first, monkeypatch):
    monkeypatch.setattr("agents.line.flown.SETTLED", FLIGHTS)
    near = replace(first.table, digest="another")
    assert fly(LEVEL, FLIGHTS, 0, 1, near=near).chances.entries == first.table.chances.entries


def test_chances_to_seal_are_those_of_the_level():
    def sealed(**cell):
        config = LineConfig.load({"base": "skills3", "cell": {**cell}})
        return fly(config, 32, 0, 1).chances.picked.tolist()

    spread = {"grasp": 0.0, "belt_speed": 0.0}
    assert sealed(spread=spread) == pytest.approx([0.9, 0.93, 0.7, 0.92])
    assert sealed(spread=spread, mismatch=0.5) == pytest.approx([0.95, 0.965, 0.85, 0.96])
    assert sealed(pick={"fails": False}) == [1.0] * 4
    assert 0.0 < sealed(spread={"grasp": 0.03})[3] < 0.9  # a lip that overhangs a small item leaks


def test_a_line_on_which_no_object_comes_says_so():
    rare = LineConfig.load(LEVEL, arrivals={"rate": 1e-6})
    with pytest.raises(UsageError, match=r"^no objects: .* arrivals.rate is 1e-06 objects a second"):
        estimate(rare, CONDITIONS, FLIGHTS)


def test_shifts_without_an_object_do_not_count():
    rare = LineConfig.load(LEVEL, arrivals={"rate": 0.05})
    found = estimate(rare, replace(CONDITIONS, shifts=8), FLIGHTS).planned
    assert np.isnan(found.recovery).any()
    assert found.row["recovery"] == np.nanmean(found.recovery)
    assert found.row["recovery_low"] <= found.row["recovery"] <= found.row["recovery_high"]


def test_a_table_is_a_value(first):
    assert isinstance(first.table, FlightTable)
    assert LineConfig.load(first.planned.config.model_dump(mode="json")) == first.planned.config
