"""A sample of the soak of lines, and that it finds what it looks for."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks import soak, soak_shifts
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore

BRIEF: dict[str, Any] = {"base": "skills3", "duration": 15.0}


def test_a_sample_of_the_soak_of_lines():
    finds, summary = soak.soak_shifts(120, longest=90.0, limit=80)
    assert finds == []
    assert summary.startswith("120 decisions in ")


def test_levels_of_the_soak_are_far_apart_and_take_hours():
    levels = [soak_shifts.random_level(np.random.default_rng(seed)) for seed in range(40)]
    assert {len(level.robots) for level in levels} == {1, 2, 3, 4}
    places, durations = [level.robots[0].x for level in levels], [level.duration for level in levels]
    assert min(places) < -5e4
    assert max(places) > 5e4
    assert min(durations) < 120.0
    assert max(durations) > 7200.0


def lost(name: str) -> Any:
    step = LineCore.step

    def told(core: LineCore, actions: object) -> Any:
        made = step(core, actions)
        changed = {name: made.info[name] + 1} if name in made.info else {}
        return replace(made, info={**made.info, **changed})

    return told


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("shift_passed", r"passed is \d+, and \d+ by a count"),
        ("shift_objects", r"of \d+ objects \d+ have come and \d+ are told of"),
        ("shift_attempts", r"\d+ attempts are told of, and \d+ were made"),
        ("shift_sorted", r"sorted is \d+, and \d+ by a count"),
        ("shift_utilisation", r"robots work .* of their time"),
    ],
)
def test_books_that_do_not_agree_are_found(monkeypatch: pytest.MonkeyPatch, name: str, said: str) -> None:
    config = LineConfig.load(BRIEF)
    assert soak_shifts.work(config, 0, 1000)[::2] == ([], True)
    monkeypatch.setattr(LineCore, "step", lost(name))
    (find,) = soak_shifts.work(config, 0, 1000)[0]
    assert re.search(said, find)


def test_objects_lifted_twice_time_that_stands_and_hangs_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    assert soak_shifts.no_numbers(np.zeros(3), np.inf) == ["a number is none"]
    books = soak_shifts.Books(LineConfig.load(BRIEF), np.zeros(9))
    lift = {"dt": 0.0, "cycle_time": 1.0, "start": 3.0, "invalid_action": False, "picked": True, "object": 7}
    lift |= {"sorted": True, "ended_in": 0}
    assert list(books.after(lift)) == []
    finds = list(books.after({**lift, "dt": -1.0, "cycle_time": 0.0, "start": 2.0}))
    assert finds[0] == "a cycle takes 0.0 s, and the next one begins -1.0 s later"
    assert finds[1:] == ["a decision at 3.0 s is followed by one at 2.0 s", "object 7 was lifted twice"]
    monkeypatch.setattr(soak_shifts, "RESET", -1.0)
    assert soak_shifts.work(LineConfig.load(BRIEF), 0, 1)[0] == ["reset took 0 s, more than -1 s"]
