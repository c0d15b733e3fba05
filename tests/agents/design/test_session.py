"""A session of designing without a browser: what a change does, what is refused, and what is answered."""

import threading
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from agents.design import answers, changes, figures, level_files, session
from agents.design.session import Session, opened
from agents.ground.metrics import Interval
from agents.line import plans, verdict
from agents.line.places import Improvement, Progress
from benchmarks.design_events import act
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError

LINE = LineConfig.load("skills3")


class Quick:
    """A judge whose recoveries of shifts follow from the rate alone, with a gate that holds its answers back."""

    def __init__(self) -> None:
        self.open, self.asked = threading.Event(), []
        self.open.set()
        self.example = answers.Judge().answer(opened(LineConfig.load("single", cell={"base": "nominal"})), False)

    def answer(self, line, is_settled):
        self.asked.append((line.arrivals.rate, is_settled))
        assert self.open.wait(30)
        recovery = np.full(16, 1.0 / (1.0 + line.arrivals.rate))
        row = {
            **self.example.row,
            "recovery": recovery.mean(),
            "recovery_counts": 0.0,
            "utilisation": [0.5] * len(line.robots),
        }
        return answers.Answer(line, replace(self.example.plan, recovery=recovery, row=row), is_settled)


@pytest.fixture(scope="module")
def judge():
    return Quick()


@pytest.fixture
def quick(judge, monkeypatch):
    """A session whose answers cost nothing; only the order of its work counts."""
    monkeypatch.setattr(session, "Judge", lambda: judge)
    monkeypatch.setattr(session, "possible_changes", lambda line, item: [])
    judge.asked.clear()
    made = Session(LINE)
    yield made
    judge.open.set()
    made.close()


def test_each_change_changes_what_it_names():
    assert changes.set_belt_speed(LINE, 0.5).cell.belt.speed == 0.5
    assert changes.set_limits(LINE, 55.0).cell.limits.percent == (55.0,)
    assert changes.set_rate(LINE, 120.0).arrivals.rate == 2.0
    assert changes.set_value(LINE, "can", 3.0).value.of["can"] == 3.0
    assert [robot.x for robot in changes.set_robots(LINE, 4).robots] == pytest.approx([0.0, 1.4, 2.8, 4.2])
    assert changes.move_robot(LINE, 1, 1.51).robots[1].x == 1.51
    moved = changes.move_bin(LINE, 0, 1, -0.13, 0.5)
    assert (moved.cell.bins.fixed[1].x, moved.cell.bins.fixed[1].y) == (-0.13, 0.5)
    assert changes.choose_sheet(LINE, 2, "scara_700").sheets()[2].name == "scara_700"


def test_the_other_items_keep_their_proportions():
    shares = changes.set_share(LINE, "tray", 10.0).cell.shares()
    assert shares == pytest.approx([0.1, 0.3, 0.45, 0.15])
    assert changes.set_share(LINE, "tray", 0.0).cell.shares() == pytest.approx([0.0, 1 / 3, 1 / 2, 1 / 6])


def test_a_standstill_goes_with_its_robot():
    line = changes.set_standstill(opened(LINE), "third", 20.0)
    assert [(down.start, down.end) for down in line.down] == [(60.0, 80.0)]
    assert changes.set_robots(line, 2).down == ()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (partial(changes.move_bin, robot=0, number=0, x=-0.13, y=0.4), "overlaps bin 'paper' by 245 mm along"),
        (partial(changes.move_bin, robot=0, number=0, x=-0.39, y=-0.1), "lies on the belt"),
        (partial(changes.move_robot, robot=1, x=0.2), "windows that overlap"),
        (partial(changes.move_robot, robot=1, x=1e9), "robots.1.x is 1000000000.0"),
        (partial(changes.set_robots, count=5), "1 to 4 robots"),
        (partial(changes.set_share, item="tray", percent=100.0), "below 100 %"),
        (partial(changes.set_rate, per_minute=5e4), "less than or equal to 20"),
        (partial(changes.choose_sheet, robot=0, name="nobody"), "nobody"),
    ],
)
def test_what_is_impossible_is_refused_in_a_sentence_and_the_design_stays(quick, change, words):
    before = quick.state
    assert not quick.change(change)
    assert words in quick.state.refusal
    assert quick.state.line == before.line
    assert quick.state.number == before.number
    assert quick.change(partial(changes.set_rate, per_minute=100.0))
    assert quick.state.refusal == ""


def test_undo_and_redo_go_through_the_designs(quick):
    for rate in (60.0, 120.0):
        quick.change(partial(changes.set_rate, per_minute=rate))
    quick.undo()
    assert quick.state.line.arrivals.rate == 1.0
    quick.redo()
    assert quick.state.line.arrivals.rate == 2.0
    for _ in range(5):
        quick.undo()
    assert quick.state.line == opened(LINE)
    quick.change(partial(changes.set_rate, per_minute=90.0))
    quick.redo()
    assert quick.state.line.arrivals.rate == 1.5


def test_the_newest_design_is_answered_and_those_before_it_are_left_out(quick, judge):
    assert quick.worker.wait()
    judge.open.clear()
    for rate in range(1, 9):
        quick.change(partial(changes.set_rate, per_minute=60.0 * rate))
    judge.open.set()
    assert quick.worker.wait()
    assert quick.state.is_current and quick.state.answer.is_settled
    assert quick.state.answer.line.arrivals.rate == 8.0
    # One of them may have been begun before the next ones came; the others were never judged.
    assert len({rate for rate, _ in judge.asked} - {4.0, 8.0}) <= 1


def test_a_design_is_compared_with_the_kept_one(quick):
    assert quick.worker.wait()
    assert quick.state.over_saved is None
    quick.change(partial(changes.set_rate, per_minute=60.0))
    assert quick.worker.wait()
    assert quick.state.over_saved.value == pytest.approx(1 / 2 - 1 / 5)
    assert answers.in_points(quick.state.over_saved) == "+30.0 points of recovery (+30.0..+30.0)"
    quick.keep()
    assert quick.worker.wait()
    assert quick.state.over_saved is None


def improvement(line, low):
    """What a search found."""
    found = changes.move_bin(line, 0, 0, -0.39, 0.30)
    return Improvement(found, {}, 0.7, 0.75, Interval(0.05, low, 0.08), 4, 10)


@pytest.mark.parametrize(("low", "is_taken"), [(0.02, True), (-0.01, False)])
def test_places_that_are_better_beyond_doubt_become_the_design(quick, monkeypatch, low, is_taken):
    before = quick.state.line
    monkeypatch.setattr(session, "improve", lambda line, *_, **__: improvement(line, low))
    assert quick.worker.wait()
    quick.improve("bins")
    assert quick.worker.wait()
    assert (quick.state.line != before) == is_taken
    assert "5.0 points" in quick.state.note
    assert ("no difference" in quick.state.note) != is_taken
    quick.undo()
    assert quick.state.line == before


def test_a_change_ends_a_search_whose_find_is_forgotten(quick, monkeypatch):
    begun, ended = threading.Event(), []

    def search(line, *_, tell, **__):
        begun.set()
        try:
            while True:
                tell(Progress("search", 1, 60, 0.5, float("-inf")))
        except BaseException as error:
            ended.append(type(error).__name__)
            raise

    monkeypatch.setattr(session, "improve", search)
    assert quick.worker.wait()
    quick.improve("all")
    assert begun.wait(30)
    quick.change(partial(changes.set_rate, per_minute=90.0))
    assert quick.worker.wait()
    assert ended == ["_StaleError"]
    assert quick.state.is_current
    assert quick.worker.faults == 0


def test_a_search_can_be_ended(quick, monkeypatch):
    def search(line, *_, should_stop, **__):
        while not should_stop():
            quick.end_search()
        return improvement(line, 0.01)

    monkeypatch.setattr(session, "improve", search)
    assert quick.worker.wait()
    quick.improve("bins")
    assert quick.worker.wait()
    assert quick.state.note


def test_a_difference_with_zero_in_its_interval_is_none():
    assert answers.in_points(Interval(0.01, -0.01, 0.03)) == "no difference in recovery (-1.0..+3.0 points)"
    assert answers.in_points(Interval(0.02, 0.01, 0.03)) == "+2.0 points of recovery (+1.0..+3.0)"


@pytest.mark.parametrize("name", LineConfig.level_names())
def test_a_line_is_the_same_after_saving_and_opening(name):
    line = opened(LineConfig.load(name))
    again = level_files.line_of_text(level_files.text_of_line(line), "other")
    assert again == line
    assert again.digest() == line.digest()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: [", "no YAML"),
        ("- 1", "no line"),
        ("", "no line"),
        ("env_id: PnT\nsteps: 3", "unknown key"),
        ("base: waste", "waste"),
        ("base: skills3\nrobbots: []", "perhaps robots"),
        ("base: ../secret.yaml", "stands alone"),
        ("base: skills3\nchances: /etc/passwd", "stands alone"),
        ("base: skills3\ncell: {base: x/y.yaml}", "stands alone"),
    ],
)
def test_a_file_that_is_no_line_is_refused_and_the_design_stays(quick, text, words):
    before = quick.state.line
    assert not quick.begin(partial(level_files.line_of_file, text.encode(), "file.yaml"))
    assert words in quick.state.refusal
    assert quick.state.line == before


def test_bytes_that_are_no_text_are_refused():
    with pytest.raises(ConfigError, match="no text"):
        level_files.line_of_file(b"\xff\xfe\x00", "picture.png")


def test_a_settled_answer_is_that_of_line_plan_to_the_bit():
    first = opened(LineConfig.load("single"))
    line, judge = changes.move_bin(first, 0, 1, -0.13, 0.33), answers.Judge()
    for each in (first, line):
        judge.answer(each, False)  # what was judged before leaves no trace
    found = judge.answer(line, True)
    again = level_files.line_of_text(level_files.text_of_line(line), "saved")
    # The way of `pnt-gym line plan --level saved.yaml --fidelity flight --robots 1`.
    sweep, conditions = verdict.read({"check": 0, "fidelity": "flight", "robots": (1,)})
    ((numbers, config),) = plans.make_plans(again, sweep)
    row = plans.judge(numbers, config, conditions).row
    assert {name: row[name] for name in found.row} == found.row


@pytest.mark.nightly
def test_random_events_leave_a_valid_design_and_no_fault(quick):
    rng, refused = np.random.default_rng(0), 0
    for _ in range(300):
        refused += not act(quick, rng)
        assert figures.panel(quick.state)
    assert 30 < refused < 250
    assert quick.worker.wait()
    assert quick.worker.faults == 0
    assert level_files.line_of_text(level_files.text_of_line(quick.state.line), "x") == quick.state.line


def test_names_of_a_level_are_no_html(quick, judge):
    robots = [{"name": "<img src=x onerror=alert(1)>", "x": 0.0}]
    assert quick.begin(lambda: LineConfig.load(LINE, name="<b>", robots=robots))
    assert quick.worker.wait()
    assert "<img" not in figures.panel(quick.state)


def test_a_line_that_sorts_nothing_has_no_purity(judge):
    row = {**judge.example.row, **plans.with_interval("purity", np.full(4, np.nan))}
    answer = replace(judge.example, plan=replace(judge.example.plan, row=row))
    assert [figure.value for figure in figures.figures(answer) if figure.name == "purity"] == ["none"]


def test_a_fault_is_told_and_the_page_goes_on(quick, judge, monkeypatch, capsys):
    def broken(line, is_settled):
        raise ZeroDivisionError

    assert quick.worker.wait()
    with monkeypatch.context() as patch:
        patch.setattr(judge, "answer", broken)
        quick.change(partial(changes.set_rate, per_minute=30.0))
        assert quick.worker.wait()
        assert quick.worker.faults == 1
        assert "ZeroDivisionError" in capsys.readouterr().err
    quick.change(partial(changes.set_rate, per_minute=60.0))
    assert quick.worker.wait()
    assert quick.state.is_current
