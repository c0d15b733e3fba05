"""Better places: the search, how it ends, the verdict in the full physics, and the command."""

import json
import signal
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from agents.ground.cli import UsageError
from agents.ground.metrics import Interval
from agents.line import placing
from agents.line.layouts import Grounds
from agents.line.places import Improvement, Search, improve
from agents.line.plan import Arguments
from agents.line.plans import Conditions
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from tests.tools.commands import output_of, refused

SKILLS3 = LineConfig.load("skills3", duration=5.0)
GOAL = np.array([[-0.30, 0.30], [-0.05, 0.35], [0.20, 0.35], [0.43, 0.20]])
"""Places at which a made-up recovery is 1."""


def made_up(search, layout, flights):
    """A recovery that falls with the distance from the goal, and with a little bias of few flights."""
    return 1.0 - float(np.abs(layout.bins - GOAL).mean()) - 0.01 / flights


@pytest.fixture
def searched(monkeypatch):
    """What makes a search of a made-up recovery, and the progress that it tells."""
    monkeypatch.setattr(Search, "recovery", made_up)
    told = []

    def make(tries, should_stop=lambda: False):
        return Search(Grounds(SKILLS3), Conditions(shifts=2), tries, told.append, should_stop)

    return make, told


def test_a_search_comes_near_the_best_places(searched):
    make, told = searched
    search = make(120)
    found = search.run(0)
    today, best = (made_up(None, layout, 1000) for layout in (search.grounds.today, found[0]))
    assert best > 1.0 - 0.4 * (1.0 - today)
    assert 60 < search.tried <= 120
    assert [search.grounds.violation(layout) for layout in found] == [0.0] * 3
    assert [told[0].tried, told[-1].tried] == [1, search.tried]
    assert {one.stage for one in told} == {
        "bins nearer to the belt",
        "bins exchanged",
        "again with 256 flights",
        "search",
        "again with 512 flights",
        "settled estimates",
    }
    assert all(one.today <= one.best for one in told)
    again = make(120)
    assert np.array_equal(again.run(0)[0].bins, found[0].bins)


def test_a_search_that_is_stopped_ends_with_the_best_so_far(searched):
    make, told = searched
    search = make(300, lambda: len(told) >= 7)
    found = search.run(0)
    assert search.tried == 7
    assert made_up(None, found[0], 1000) == pytest.approx(max(made_up(None, one, 1000) for one in search.best(9)))


def test_layouts_that_are_no_line_cost_no_estimate_and_never_end_a_search(monkeypatch):
    search = Search(Grounds(SKILLS3), Conditions(shifts=2), 40, lambda progress: None, lambda: False)

    def estimate(line, conditions, flights):
        if line.cell.bins.fixed != SKILLS3.cell.bins.fixed:
            raise ConfigError("no robot can throw")
        return SimpleNamespace(planned=SimpleNamespace(row={"recovery": 0.5}))

    monkeypatch.setattr("agents.line.places.estimate", estimate)
    assert [layout is search.grounds.today for layout in search.run(0)] == [True]
    bins = search.grounds.today.bins + np.array([0.0, 1.0])
    before, layout = search.tried, replace(search.grounds.today, bins=bins)
    assert search.cost(layout) == search.grounds.violation(layout) > 0.0
    assert search.tried == before


@pytest.mark.nightly
def test_an_improvement_is_judged_in_the_full_physics(monkeypatch):
    monkeypatch.setattr("agents.line.places.SETTLED", 32)
    monkeypatch.setattr("agents.line.places.FLIGHTS", (32, 48, 64))
    told = []
    conditions = Conditions(shifts=2, check=2, threads=1)
    line = LineConfig.load("single", duration=5.0)
    found = improve(line, conditions, "bins", tries=6, tell=told.append)
    assert found.tried == 6
    assert found.shifts == 4
    assert found.gain.value == pytest.approx(found.found - found.today)
    assert found.gain.low <= found.gain.value <= found.gain.high
    assert found.config.cell.bins.fixed != line.cell.bins.fixed
    assert LineConfig.load(LineConfig.merge(line.model_dump(exclude_unset=True), found.differences)) == found.config
    assert told[-1].stage == "shifts in the full physics"


def improvement(*gain: float):
    """Bins 10 cm nearer, with a gain and its interval."""
    grounds = Grounds(SKILLS3)
    layout = grounds.nearer(0.1)
    figures = {"today": 0.70, "found": 0.70 + gain[0], "gain": Interval(*gain), "shifts": 8, "tried": 50}
    return Improvement(grounds.line(layout), grounds.differences(layout), **figures)


def test_the_verdict_says_where_there_is_no_difference():
    assert improvement(0.05, 0.04, 0.06).sentence == (
        "in 8 shifts in the full physics the places found sort 75.0 % and today's 70.0 %, +5.0 points (+4.0..+6.0)"
    )
    assert improvement(0.01, -0.01, 0.03).sentence.startswith("no difference: in 8 shifts")


def test_the_level_that_is_written_is_the_line_that_was_found(tmp_path, monkeypatch):
    asked, found = [], improvement(0.05, 0.04, 0.06)

    def improve(*arguments, **further):
        asked.append(arguments)
        return found

    monkeypatch.setattr(placing, "improve", improve)
    options = "--keep-out 0 0.1 0.2 0.3 1 2 0.5 0.6 --minutes 0.2 --tries 50"
    said = output_of(f"line plan --place bins {options} --write found.yaml --json found.json", tmp_path)
    line, _, what, keep_out, tries = asked[0]
    assert (line.duration, what, tries) == (12.0, "bins", 50)
    assert keep_out == ((0.0, 0.1, 0.2, 0.3), (1.0, 2.0, 0.5, 0.6))
    words = " ".join(said.split())
    assert "bin trays" in words
    assert "+5.0 points (+4.0..+6.0)" in words
    written = LineConfig.load(tmp_path / "found.yaml")
    assert written.name == "found"
    assert written.cell == found.config.cell
    assert written.robots == SKILLS3.robots
    told = json.loads((tmp_path / "found.json").read_text())
    assert (told["gain"], told["place"], told["tried"]) == (0.05, "bins", 50)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--tries", "5"), "--tries goes with --place bins, robots or all, which is not given"),
        (("--place", "bins", "--robots", "2"), "leave --robots out"),
        (("--place", "bins", "--picture", "x.svg"), "leave --picture out"),
        (("--place", "bins", "--keep-out", "1", "0", "0", "1"), "--keep-out is 1 0 0 1; it must be X0 X1 Y0 Y1"),
        (("--place", "bins", "--write", "found.json"), "must end in .yaml or .yml"),
        (("--place", "robots", "--level", "single"), "there is nothing to place"),
        (("--place", "bins", "--tries", "0"), "tries is 0"),
    ],
)
def test_options_that_do_not_fit_are_refused(options, said):
    assert said in refused("agents.line plan", *options)


def test_the_first_interrupt_ends_the_search_and_the_second_the_command():
    stop = placing.Stop()
    stop(signal.SIGINT, None)
    assert stop.is_set()
    for number in (signal.SIGINT, signal.SIGTERM):
        with pytest.raises(KeyboardInterrupt):
            stop(number, None)


def test_with_a_goal_robots_are_added_until_the_best_places_reach_it(monkeypatch, tmp_path):
    lines, interval = [], Interval(0.02, 0.01, 0.03)

    def found_places(line, *_, **__):
        lines.append(line)
        return Improvement(line, {}, 0.5, 0.52, interval, 4, 1)

    monkeypatch.setattr(placing, "improve", found_places)
    file = tmp_path / "more.yaml"
    options = vars(Arguments(place="bins", want="55%", shifts=2, minutes=0.5, throws=100, write=file, mend=False))
    placing.place("bins", options)
    assert [len(line.robots) for line in lines] == [1, 2, 3]
    assert len(LineConfig.load(file).robots) == 3
    with pytest.raises(UsageError, match="keeps robots, speeds, limits, skills and throws: leave --robots out"):
        placing.place("bins", vars(Arguments(place="bins", robots=(2,))))
