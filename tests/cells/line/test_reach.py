"""What robots of a line can reach: against the planner of the conveyor, in shifts, and in words."""

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.outcome import shift_figures
from pnt_gym.cells.line.reach import PLACES, find_reach

BINS = [
    {"name": "pet", "x": -0.48, "y": 0.4, "size": [0.3, 0.3], "accepts": ["bottle"]},
    {"name": "cans", "x": -0.16, "y": 0.4, "size": [0.3, 0.3], "accepts": ["can"]},
    {"name": "films", "x": 0.16, "y": 0.4, "size": [0.3, 0.3], "accepts": ["film"]},
    {"name": "woods", "x": 0.48, "y": 0.4, "size": [0.3, 0.3], "accepts": ["wood"]},
]
ITEMS = [
    {"name": "bottle", "shape": "cylinder", "size": [0.21, 0.065, 0.065], "mass": 0.025},
    {"name": "film", "shape": "box", "size": [0.12, 0.10, 0.03], "mass": 0.006},
    {"name": "wood", "shape": "box", "size": [0.15, 0.06, 0.04], "mass": 0.15},
]
FAR = {
    "name": "far",
    "cell": {
        "items": ["bottle", "can", "film", "wood"],
        "extra_items": ITEMS,
        "mix": {"bottle": 4, "can": 3, "film": 2, "wood": 1},
        "limits": {"percent": [40]},
        "belt": {"speed": 0.5, "lane_y": [-0.56, -0.14]},
        "bins": {"fixed": BINS},
    },
    "robots": [{"name": "first", "x": 0.0}, {"name": "second", "x": 1.4, "skills": ["bottle", "can"]}],
    "arrivals": {"rate": 1.5},
    "duration": 40.0,
    "throws": "flight",
}
"""A line whose outer bins are too far for objects on the far side of the belt."""


@pytest.fixture(scope="module")
def far() -> LineCell:
    """Four lines whose outer bins are too far for objects on the far side of the belt."""
    with pytest.warns(UserWarning, match="out of reach"):
        return LineCell(LineConfig.load(FAR), 4)


def test_reach_is_what_the_planner_of_the_conveyor_can_throw(far: LineCell) -> None:
    riders, objects = far.stream.riders[0], take(far.stream.objects, np.zeros(1, dtype=np.int64))
    reached, config = find_reach(far.chooser.tables, riders), far.config
    for robot in range(2):
        planner, (low, high) = far.chooser.planner_of(robot), config.cell_of(robot).lift_x
        accepts = planner.config.acceptance()
        expected = np.zeros(len(riders), dtype=bool)
        for x in np.linspace(low, high, PLACES):
            for number in range(len(BINS)):
                throws = take(objects, (np.zeros(len(riders), dtype=np.int64), np.arange(len(riders))))
                throws = throws.replace(percent=np.full(len(riders), 40.0))
                height = planner.height(throws.size, throws.known_depth)
                places = np.stack([np.full(len(riders), x), riders["lane_y"], height], axis=-1)
                _, feasible = planner.plan_into(throws, places, np.full(len(riders), number))
                expected |= feasible & accepts[riders["seen"], number] & config.can_take()[robot, riders["seen"]]
        assert 0.2 < expected.mean() < 0.95
        np.testing.assert_array_equal(reached[:, robot], expected)


def test_nobody_tries_what_is_out_of_reach_and_it_is_counted(far: LineCell) -> None:
    far.reset(np.arange(4), [np.random.default_rng(row) for row in range(4)])
    while not far.over.all():
        far.take(np.zeros(4, dtype=np.int64))
    figures = shift_figures(far.config, far.chooser.tables, far.state, far.stream, np.arange(4))
    border = far.config.reach[1] - far.config.cell.belt.speed * far.config.duration
    for row in range(4):
        riders, tried = far.stream.riders[row], far.state.accounts["attempts"][row] > 0
        unreached = ~find_reach(far.chooser.tables, riders).any(axis=1)
        assert not (unreached & tried).any()
        gone = unreached & (riders["x"] > border)
        assert figures["shift_out_of_reach"][row] == gone.sum() > 0
        counts = np.bincount(riders["kind"][gone], minlength=4)
        assert figures["shift_out_of_reach_by_item"][row].tolist() == counts.tolist()
        assert counts[0] > 0 == counts[1] == counts[2]


def test_a_line_says_which_share_of_which_items_is_out_of_reach() -> None:
    said = r"level 'far': \d+\.\d% of the objects are out of reach, \d+\.\d% of wood, \d+\.\d% of bottle: no robot"
    with pytest.warns(UserWarning, match=said):
        LineCell(LineConfig.load(FAR), 1)


def test_a_robot_that_reaches_no_bin_leaves_all_objects_to_the_next_one() -> None:
    idle = {"name": "first", "x": 0.0, "bins": [{"name": "distant", "x": 0.0, "y": 3.5}]}
    level = {"base": "single", "throws": "flight", "duration": 20.0, "robots": [idle, {"name": "second", "x": 1.4}]}
    cell = LineCell(LineConfig.load(level), 2)
    cell.reset(np.arange(2), [np.random.default_rng(seed) for seed in range(2)])
    while not cell.over.all():
        assert (cell.take(np.zeros(2, dtype=np.int64)).robot[~cell.over] == 1).all()
    assert set(np.unique(cell.state.accounts["taker"])) == {-1, 1}
