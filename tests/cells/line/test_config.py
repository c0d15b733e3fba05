"""Levels of lines: those that ship load, and what no line can be is said in one sentence that names the value."""

import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from tests.tools.line import begun, with_table

LEVELS = ("line3", "nominal", "single", "skills3", "skills3_burst", "speed", "value")
ON_THE_BELT = {"name": "b", "x": 0.3, "y": -0.3}
ANY = {"name": "any", "x": -0.25, "y": 0.40}
FAR = {"name": "far", "x": 0.0, "y": 3.5}
RED = {"name": "left", "x": -0.25, "y": 0.40, "accepts": ["tray"]}


def test_the_shipped_levels_are_the_documented_ones():
    assert LineConfig.level_names() == LEVELS


def test_bins_may_fill_where_robots_have_equally_many():
    level = {"base": "skills3", "throws": "flight", "duration": 5.0, "cell": {"bins": {"emptied": 60}}}
    cell = begun(level, 2)
    depths = list[np.ndarray]()
    while not cell.over.all():
        depths.append(cell.take(np.zeros(2, dtype=np.int64)).context.depth)
    assert depths[0].shape == (2, 4)
    assert np.unique(depths).size > 8


@pytest.mark.parametrize("name", LEVELS)
def test_a_shipped_level_is_what_its_issue_says(name):
    config = LineConfig.load(name)
    assert config.name == name
    assert config.throws == "table"
    assert len(config.robots) == (3 if name in ("line3", "skills3", "skills3_burst") else 1)
    assert config.can_take().any(axis=0).all()
    counts = {"speed": 3}.get(name, 1)
    assert len(config.cell_of(0).limits.percent) == counts
    assert config.arrivals.regularity == (0.4 if name in ("speed", "skills3_burst") else 1.0)
    assert (config.value.spread > 0.0) == (name in ("value", "skills3_burst"))


def test_skills_are_those_of_the_level():
    assert LineConfig.load("line3").can_take().tolist() == [[True] * 4] * 3
    able = [[True] * 4, [True, True, False, False], [True, False, False, False]]
    assert LineConfig.load("skills3").can_take().tolist() == able
    assert LineConfig.load("skills3_burst").can_take().tolist() == able


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"robots": []}, "robots is []"),
    *(
        (
            {"base": "single", "name": "mine", "cell": {"bins": bins}},
            "level 'mine' of a line has cell.bins.random, which draws a bin for every throw; the robots of a line "
            "have fixed bins: leave random out and list the bins in cell.bins.fixed, or in the bins of each robot",
        )
        for bins in ({"random": {}}, {"random": {"side": [0.3, 0.4]}, "fixed": []})
    ),
    ({"robots": [{"name": str(i), "x": 2.0 * i} for i in range(5)]}, "at most 4"),
    ({"robots": [{"name": "", "x": 0.0}]}, "robots.0.name is ''"),
    ({"robots": [{"name": "a", "x": 0.0}, {"name": "a", "x": 2.0}]}, "['a', 'a']; the names must differ"),
    (
        {"robots": [{"name": "a", "x": 0.0}, {"name": "b", "x": 0.5}]},
        "robots 'a' at x 0 m and 'b' at 0.5 m have windows that overlap; each reaches from -0.3 to 0.3 m",
    ),
    ({"robots": [{"name": "a", "x": 2.0}, {"name": "b", "x": 0.0}]}, "upstream robots come first"),
    (
        {"robots": [{"name": "a", "x": 0.0, "skills": ["tray", "stone"]}]},
        "skills of robot 'a': unknown item 'stone'",
    ),
    (
        {"robots": [{"name": "a", "x": 0.0, "skills": ["tray"]}]},
        "no robot takes items 'can', 'paper_ball' and 'yoghurt_cup'; give a robot the skill",
    ),
    (
        {"robots": [{"name": "a", "x": 0.0, "bins": [ON_THE_BELT]}]},
        "lies on the belt, which spans y -0.65..-0.04 m",
    ),
    ({"robots": [{"name": "a", "x": 0.0, "bins": [FAR]}]}, "no robot can throw an object into its bins"),
    ({"robots": [{"name": "a", "x": 0.0, "bins": [RED]}]}, "no robot takes items 'can'"),
    ({"value": {"of": {"stone": 1.0}}}, "value.of: unknown item 'stone'"),
    ({"down": [{"robot": "nobody", "start": 0.0, "end": 1.0}]}, "down: unknown robot 'nobody'; known are first"),
    ({"down": [{"robot": 9, "start": 0.0, "end": 1.0}]}, "unknown robot '9'; known are first, or a number from 1 to 1"),
    (
        {"down": [{"robot": "first", "start": 3.0, "end": 3.0}]},
        "down.start is 3 s; it must be smaller than down.end, 3 s",
    ),
    ({"arrivals": {"rate": 6.0}}, "arrivals.rate is 6 objects a second; the belt's lanes have room for at most"),
    ({"cell": {"belt": {"neighbours": "solid"}}}, "cell.belt.neighbours is 'solid'; on a line carried objects pass"),
    ({"cell": {"planner": "auto"}}, "cell.planner 'auto' and cell.throwable select the thrown objects; on a line"),
    ({"cell": {"planner": "free_direction"}}, "cell.planner is 'free_direction'; on a line hands move on straight"),
    ({"cell": {"grip": {"safety": "surface"}}}, "cell.grip.safety is 'surface'; on a line throws are not slowed"),
    ({"cell": {"grip": {"safety": 1.5}}}, "cell.grip.safety is 1.5; on a line throws are not slowed for the grip"),
    ({"cell": {"drift": {"delay": {"even": 0.005}}}}, "cell.drift is not zero; a line has no drift: leave"),
    ({"cell": {"mix": {"stone": 1.0}}}, "cell: mix: unknown item 'stone'"),
    (
        {
            "cell": {"bins": {"emptied": 60}},
            "robots": [{"name": "a", "x": 0.0}, {"name": "b", "x": 2, "bins": [ANY]}],
        },
        "cell.bins.emptied is 60; robots with [4, 1] bins fill their bins unequally: set",
    ),
    ({"cell": {"belt": {"speed": 9.0}}}, "cell: belt.speed is 9 m/s"),
    ({"cell": {"typo": 1}}, "cell: unknown key 'typo'"),
    ({"cell": 5}, "cell is 5; it must be a level of the conveyor, a YAML file or a section"),
    ({"cell": "waste"}, "has cell.bins.random"),
    ({"cell": "none.yaml"}, "cell: level file 'none.yaml' does not exist"),
    ({"cell": {"robots": []}}, "cell: 'robots' must stand beside `cell`, and not in it"),
    ({"cell": {"base": "nowhere"}}, "nowhere"),
    ({"throws": "guess"}, "throws is 'guess': input should be 'table', 'flight' or 'full'"),
]


@pytest.mark.parametrize(("level", "said"), WRONG, ids=lambda value: json.dumps(value)[:70])
def test_what_no_line_can_be_is_named(level, said):
    for make in (gym.make, gym.make_vec):
        with pytest.raises(ConfigError) as caught:
            make("PnTLine-v0", level={"base": "single", "throws": "flight", **level})
        assert said in str(caught.value)


def test_a_level_that_goes_by_a_table_needs_one():
    with pytest.raises(ConfigError) as caught:
        gym.make("PnTLine-v0", level={"base": "single", "name": "mine", "cell": {"belt": {"speed": 0.26}}})
    assert str(caught.value) == (
        "level 'mine' has no table of throws; make it with `pnt-gym line calibrate --level FILE.yaml`, or simulate the "
        "throws with `throws: flight` or `throws: full`"
    )


def test_a_table_is_that_of_its_cells(tmp_path: Path):
    other = with_table({"base": "single", "cell": {"limits": {"percent": [35]}}}, tmp_path)
    with pytest.raises(ConfigError) as caught:
        gym.make("PnTLine-v0", level={"base": "single", "name": "mine", "chances": other["chances"]})
    said = f"chances: {other['chances']!r} was made for other cells than those of level 'mine'"
    assert str(caught.value) == said
    LineCell(LineConfig.load(other), 1)


NO_TABLES = ("", "{", "[]", "{}", "null", "5", '{"digest": "x"}', '"text"')


@pytest.mark.parametrize("text", NO_TABLES)
def test_a_file_that_is_no_table_is_refused(text, tmp_path: Path):
    (tmp_path / "table.json").write_text(text)
    for name, said in (
        ("table.json", "is not a table from `pnt-gym line calibrate`"),
        ("none.json", "cannot read"),
    ):
        with pytest.raises(ConfigError) as caught:
            gym.make("PnTLine-v0", level={"base": "single", "chances": str(tmp_path / name)})
        assert f"chances: {str(tmp_path / name)!r}" in str(caught.value) or f"chances: {said}" in str(caught.value)
        assert said in str(caught.value)
        assert "\n" not in str(caught.value)


def test_a_table_of_other_shape_or_of_no_shares_is_refused(tmp_path: Path):
    good = json.loads(Path(with_table({"base": "single"}, tmp_path)["chances"]).read_text())
    wrong = {
        "picked": good["picked"][:2],
        "landed": [row[0] for row in good["landed"]],
        "edges": good["edges"][:1],
        "percent": [40.0, 50.0],
    }
    shares = {"picked": [None, 0.5, 0.5, 0.5], "landed": (2.0 * np.ones((4, 1, 4))).tolist()}
    for name, value in [*wrong.items(), *shares.items()]:
        (tmp_path / "table.json").write_text(json.dumps({**good, name: value}))
        with pytest.raises(ConfigError, match="is not a table from `pnt-gym line calibrate`") as caught:
            gym.make("PnTLine-v0", level={"base": "single", "chances": str(tmp_path / "table.json")})
        assert "\n" not in str(caught.value)


def test_a_name_of_a_table_depends_on_what_is_thrown_and_how_fast_and_on_nothing_else():
    base = LineConfig.load("single").digest()
    same: list[dict[str, Any]] = [
        {"arrivals": {"rate": 0.7, "regularity": 0.4}},
        {"value": {"of": {"can": 3.0}, "spread": 1.0}},
        {"robots": [{"name": "x", "x": 1.0}, {"name": "y", "x": 2.0, "skills": ["tray"]}]},
        {"cell": {"mix": {"can": 9.0}}},
        {"duration": 50.0, "horizon": 2.0, "camera": 2.0, "price_of_time": 0.1},
        {"down": [{"robot": "first", "start": 1.0, "end": 2.0}]},
        {"throws": "flight"},
        {"throws": "full"},
        {"name": "mine"},
    ]
    for changes in same:
        assert LineConfig.load({"base": "single", **changes}).digest() == base, changes
    bins = [b.model_dump() for b in LineConfig.load("single").cell.bins.fixed]
    moved = [{**bins[0], "x": -0.40}, *bins[1:]]
    other: list[dict[str, Any]] = [
        {"robots": [{"name": "x", "x": 1.0, "bins": moved}]},
        {"robots": [{"name": "x", "x": 0.0}, {"name": "y", "x": 1.0, "percent": [30]}]},
        {"cell": {"limits": {"percent": [30]}}},
        {"cell": {"bins": {"rim": -0.86}}},
        {"cell": {"mismatch": 0.5}},
        {"cell": {"belt": {"speed": 0.3}}},
    ]
    names = [LineConfig.load({"base": "single", **changes}).digest() for changes in other]
    assert len({base, *names}) == len(names) + 1
    assert LineConfig.load("value").digest() == base == LineConfig.load("nominal").digest()
    assert LineConfig.load("line3").digest() == LineConfig.load("skills3_burst").digest() != base


@pytest.mark.parametrize("name", ["single", "value", "speed", "nominal"])
def test_the_tables_that_ship_are_of_the_levels_that_ship(name):
    cell = LineCell(LineConfig.load(name), 1)
    chances = cell.chances
    assert chances.percent.tolist() == [float(p) for p in cell.config.cell.limits.percent]
    assert chances.picked.shape == (4,)
    assert chances.landed.shape == (4, len(chances.percent), len(chances.edges) + 1)
    assert ((chances.landed > 0.0) & (chances.landed <= 1.0)).all()
    assert (np.diff(chances.edges) > 0.0).all()


def test_robots_may_have_bins_and_speeds_of_their_own(tmp_path: Path):
    left = {"name": "left", "x": -0.35, "y": 0.38, "size": [0.235, 0.235]}
    robots = [
        {"name": "one", "x": 0.0, "bins": [left]},
        {"name": "two", "x": 1.4, "percent": [30, 50]},
        {"name": "three", "x": 2.8, "bins": [left, {**left, "name": "right", "x": 0.35}]},
    ]
    level = {"base": "skills3", "robots": robots, "duration": 8.0}
    for given in (with_table(level, tmp_path), {**level, "throws": "flight"}):
        cell = begun(given, 2)
        bins, speeds = [set(), set(), set()], [set(), set(), set()]
        while not cell.over.all():
            state = cell.state
            for row in range(2):
                real = state.choices["real"][row]
                bins[state.robot[row]] |= set(state.choices["bin"][row][real].tolist())
                speeds[state.robot[row]] |= set(state.choices["percent"][row][real].tolist())
            cell.take(np.zeros(2, dtype=np.int64))
        assert bins == [{0}, {0, 1, 2, 3}, {0, 1}]
        assert speeds == [{40.0}, {30.0, 50.0}, {40.0}]


@pytest.mark.parametrize("robot", ["second", 2, "2"])
def test_a_robot_that_stands_still_is_given_by_its_name_or_its_number(robot):
    level = LineConfig.load("skills3", down=[{"robot": robot, "start": 1.0, "end": 2.0}])
    assert level.standstills()[0].tolist() == [[one.name for one in level.robots].index("second")]
