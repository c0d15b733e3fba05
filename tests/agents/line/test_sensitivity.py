"""Assumed numbers at both ends of their ranges: which lines they make, and how what they bring is shown."""

import numpy as np
import pytest

from agents.ground.drawings import stacked_panels, svg
from agents.ground.metrics import Interval
from agents.line import sensitivity
from agents.line.changes import Gain
from agents.line.plans import Planned
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.config import LineConfig

LINE = LineConfig.load("skills3")


def brings(what: str, to: str, points: float, money: float | None = None) -> Gain:
    """What an end of a number brings, in points, with a point to both sides."""
    interval = Interval(points / 100.0, (points - 1.0) / 100.0, (points + 1.0) / 100.0)
    return Gain(what, to, 0.7 + points / 100.0, interval, money)


def test_each_number_is_changed_alone_to_both_ends_of_its_range() -> None:
    ends = sensitivity.assumptions(LINE)
    found = {(end.what, end.to): end.config for end in ends}
    assert len(found) == len(ends) == 18
    ranges = ConveyorConfig.load("cells").cells.ranges
    taus = [config.cell.suction.tau for (what, _), config in found.items() if what == "suction.tau"]
    assert tuple(taus) == ranges["tau"]
    for (what, _), config in found.items():
        now, before = config.cell.model_dump(mode="json"), LINE.cell.model_dump(mode="json")
        differing = {key for key in now if now[key] != before[key]}
        assert differing <= ({what.split(".")[0]} if "." in what else {"extra_items"})
    heavy, light = (found["mass of all items", f"x {factor}"].cell.item_list() for factor in (1.2, 0.8))
    masses = [item.mass for item in LINE.cell.item_list()]
    assert [item.mass for item in heavy] == pytest.approx([1.2 * mass for mass in masses])
    assert [item.mass for item in light] == pytest.approx([0.8 * mass for mass in masses])


def test_the_number_that_moves_the_recovery_most_comes_first() -> None:
    gains = [brings("a", "low", 1.0), brings("b", "low", -3.0), brings("a", "high", -1.0), brings("b", "high", 0.5)]
    assert [(gain.what, gain.to) for gain in sensitivity.widest_first(gains)] == [
        ("b", "low"), ("b", "high"), ("a", "high"), ("a", "low")
    ]  # fmt: skip


@pytest.mark.parametrize("money", [None, 100.0])
def test_a_table_and_a_chart_say_what_decides(money: float | None) -> None:
    gains = [brings("tau", "20 ms", -21.0, money and 80.0), brings("tau", "5 ms", 0.5, money and 101.0)]
    plan = Planned(LINE, None, {"recovery": 0.7, "money_per_hour": money}, np.full(2, 0.7))
    table = sensitivity.table("x", plan, gains)
    assert [row[4] for row in table.rows] == ["yes", "no difference"]
    assert table.rows[0][3] == "-21.0 (-22.0..-20.0)"
    assert ("money/h" in table.header) == (money is not None)
    figure, (part,) = stacked_panels(6.4, [2.0])
    sensitivity.draw(part, gains, money)
    assert len(figure.subfigs[0].axes) == (1 if money is None else 2)
    assert svg(figure).startswith("<?xml")
    assert [entry["points_low"] for entry in sensitivity.entries(gains)] == pytest.approx([-0.22, -0.005])
