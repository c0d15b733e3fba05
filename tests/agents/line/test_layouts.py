"""Layouts of lines: pushed apart until the validators of levels take them, and written as differences."""

import numpy as np
import pytest

from agents.line.layouts import Grounds, Layout
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from pnt_gym.reading import yaml_text
from tests.tools.plant import plant

SKILLS3 = LineConfig.load("skills3")
OWN = LineConfig.load(
    {
        "base": "skills3",
        "robots": [
            {"name": "first", "x": 0.0},
            {"name": "second", "x": 1.4, "bins": [{"name": "all", "x": 0.1, "y": 0.5, "size": [0.3, 0.3]}]},
        ],
    }
)
"""A line of two robots, of which the second has a bin of its own."""
KEPT = (-0.1, 0.1, 0.2, 0.9)


@pytest.mark.parametrize("config", [SKILLS3, OWN, LineConfig.load(plant())], ids=["skills3", "own", "plant"])
def test_any_vector_gives_a_layout_that_the_validators_take_where_there_is_room(config):
    """The validators of levels are the oracle, and a count of overlaps by hand for what they do not know."""
    grounds, random, possible = Grounds(config, "all", [KEPT]), np.random.default_rng(0), 0
    for _ in range(40):
        vector = grounds.vector(grounds.today) + random.normal(0.0, 0.1, len(grounds.free))
        layout = grounds.layout(vector)
        if grounds.violation(layout) > 0.0:
            continue
        possible += 1
        line = grounds.line(layout)
        for robot in line.robots:
            for one in robot.bins or line.cell.bins.fixed:
                reach = line.cell.robot.reach.semi_axes
                assert abs(one.x) <= reach[0] and abs(one.y) <= reach[1]
                half = np.array(one.size) / 2.0 + line.cell.bins.wall
                x, y = robot.x + one.x, one.y
                is_clear = [KEPT[0] >= x + half[0], x - half[0] >= KEPT[1], KEPT[2] >= y + half[1]]
                assert any([*is_clear, y - half[1] >= KEPT[3]])
    assert possible >= 15


def test_violation_says_how_far_a_layout_is_from_a_possible_one():
    grounds = Grounds(SKILLS3)
    assert grounds.violation(grounds.today) == 0.0
    # The first bin comes 35 mm nearer to its neighbour, 20 mm too near: 260 mm between them, 245 needed.
    bins = grounds.today.bins.copy()
    bins[0] = bins[1] - [0.225, 0.0]
    near = Layout(bins, grounds.today.robots)
    assert grounds.violation(near) == pytest.approx(3 * 0.020)
    with pytest.raises(ConfigError, match="overlaps"):
        grounds.line(near)
    bins = grounds.today.bins + np.array([0.0, 0.5])
    assert grounds.violation(Layout(bins, grounds.today.robots)) == pytest.approx(0.04 + 0.1 + 0.1 + 0.04)
    robots = np.array([0.0, 0.5, 2.8])
    assert Grounds(SKILLS3, "robots").violation(Layout(grounds.today.bins, robots)) >= 0.1


def test_what_is_not_placed_stays():
    random = np.random.default_rng(1)
    for what, free in (("bins", 8), ("robots", 2), ("all", 10)):
        grounds = Grounds(SKILLS3, what)
        assert len(grounds.free) == free
        layout = grounds.layout(grounds.vector(grounds.today) + random.normal(0.0, 0.2, free))
        assert np.array_equal(layout.bins, grounds.today.bins) == (what == "robots")
        assert np.array_equal(layout.robots, grounds.today.robots) == (what == "bins")
        assert layout.robots[0] == 0.0
        assert (np.diff(layout.robots) >= 0.6).all()
        same = grounds.layout(grounds.vector(grounds.today))
        assert not grounds.differences(same)


def test_bins_change_places_within_their_set():
    grounds = Grounds(OWN, "all")
    swaps = grounds.swaps(grounds.today)
    assert len(swaps) == 6
    assert swaps[0].bins[:2].tolist() == grounds.today.bins[[1, 0]].tolist()
    assert all(np.array_equal(one.bins[4], grounds.today.bins[4]) for one in swaps)
    assert not Grounds(OWN, "robots").swaps(grounds.today)


def test_bins_come_nearer_and_cross_the_belt():
    grounds = Grounds(SKILLS3)
    belt = SKILLS3.cell.belt.y
    ways = [(grounds.nearer(way).bins[:, 1] - belt[1]).mean() for way in (0.0, 0.1, 0.2)]
    assert ways == pytest.approx([0.41, 0.31, 0.21])
    assert (grounds.nearer(9.0).bins[:, 1] > belt[1]).all()
    over = grounds.crossings(grounds.today)
    assert [(one.bins[:, 1] < belt[0]).tolist() for one in over] == np.eye(4, dtype=bool).tolist()
    assert [grounds.violation(one) for one in over] == [0.0] * 4
    back = grounds.crossings(over[2])[2]
    assert (back.bins[:, 1] > belt[1]).all() and grounds.violation(back) == 0.0


@pytest.mark.parametrize("config", [SKILLS3, OWN], ids=["skills3", "own"])
def test_differences_are_a_level_that_is_the_line(config, tmp_path):
    grounds = Grounds(config, "all")
    layout = grounds.layout(grounds.vector(grounds.today) + 0.05)
    (tmp_path / "base.yaml").write_text(yaml_text(config.model_dump(mode="json", exclude_unset=True)))
    level = {"name": config.name, "base": "base.yaml", **grounds.differences(layout)}
    (tmp_path / "found.yaml").write_text(yaml_text(level))
    assert LineConfig.load(tmp_path / "found.yaml") == grounds.line(layout)
    assert grounds.line(layout) != config
