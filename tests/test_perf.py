"""The speeds that `make perf` measures: what a figure is made of, and the form of the results that tables read."""

import json
import sys
import time
from functools import partial
from importlib import import_module
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pytest

import pnt_gym
from agents.ground.cli import UsageError
from agents.report import speeds
from benchmarks import perf, timing
from benchmarks.perf_cases import codes, planning, shares
from benchmarks.perf_cases.cells import FLIGHT, LEVELS, Cells, Steps
from benchmarks.timing import Count, Options, Seconds, Timing

RESULTS = Path(__file__).resolve().parents[1] / "results"


class Clock:
    """Time that passes only in calls: of the wall, and half as much of the processor."""

    now = 0.0

    def perf_counter(self) -> float:
        return self.now

    def process_time(self) -> float:
        return 0.5 * self.now

    def call(self, *seconds: float) -> Any:
        turns = iter(seconds)
        return lambda: setattr(self, "now", self.now + next(turns))


def test_figures_are_times_of_an_item_rates_and_ratios_of_items(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "time", clock := Clock())
    rows = [
        Timing(("slow", 0), clock.call(9.0, 8.0, 4.0, 6.0), "ms", count=2, repeats=3),
        Timing(("slow", 1), ("slow", 0), "s", statistic=median),
        Timing(("fast",), clock.call(2.0, 1.0), "1/s", count=lambda: 10, repeats=1, clock=timing.CPU),
        Timing(("ratio",), ("slow", 0), "x", count=2, over=("fast",)),
        Count(("seen",), lambda: {"now": clock.now, "level": "waste"}),
    ]
    values = timing.nest(timing.figures(rows, Options()))
    assert values == {"slow": [2000.0, 6.0], "fast": 20.0, "ratio": 20.0, "seen": {"now": 30.0, "level": "waste"}}


def test_a_call_may_say_which_seconds_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "time", clock := Clock())
    works, seconds = clock.call(1.0, 2.0, 3.0, 4.0), timing.Seconds()

    def turn() -> Seconds:
        works()
        return seconds.and_of(works)

    assert timing.figures([Timing(("x",), turn, "s", repeats=1)], Options()) == {("x",): 4.0}


def test_calls_that_repeat_as_often_take_turns_after_a_first_call_of_each() -> None:
    turns: list[str] = []
    repeats = {"a": 20, "b": 30, "c": 20}
    rows = [Timing((name,), partial(turns.append, name), repeats=count) for name, count in repeats.items()]
    timing.figures(rows, Options(quick=True))
    assert "".join(turns) == "acacacbbbb"
    turns.clear()
    timing.figures(rows, Options(quick=True, repeats=1))
    assert "".join(turns) == "acacbb"


def form(value: Any) -> Any:
    """Keys of results; rows of a list have the same."""
    if isinstance(value, dict):
        return {key: form(part) for key, part in value.items()}
    return [form(value[0])] if isinstance(value, list) else type(value)


@pytest.mark.parametrize(("case", "file"), [("planner", "perf_planner.json"), ("envs/PnTRelease-v0", "perf_envs.json")])
def test_results_have_the_form_that_tables_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, case: str, file: str
) -> None:
    monkeypatch.setattr(planning, "FIRST_PLAN", "print(0.5)")
    few = {"quick": True, "repeats": 1, "cells": 2}
    perf.main(perf.Arguments(cases=(case,), json=tmp_path / file, **few))
    expected = json.loads((RESULTS / file).read_text())
    if "envs" in expected:
        expected["envs"] = {"PnTRelease-v0": expected["envs"]["PnTRelease-v0"]}
    assert form(json.loads((tmp_path / file).read_text())) == form(expected)


@pytest.mark.nightly
@pytest.mark.parametrize("case", [name for name in perf.CASES if not name.startswith("before/")])
def test_every_case_is_measured(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, case: str) -> None:
    monkeypatch.setattr(planning, "FIRST_PLAN", "print(0.5)")
    monkeypatch.setattr(shares, "THROWS", 200)
    perf.main(perf.Arguments(cases=(case,), json=tmp_path / "speeds.json", quick=True, repeats=1, cells=2))
    assert len(json.loads((tmp_path / "speeds.json").read_text())) > 1


def test_a_name_stands_for_all_cases_that_begin_so() -> None:
    assert perf.select_cases([]) == [*perf.CASES]
    assert perf.select_cases(["envs", "planner"]) == ["planner", *(f"envs/{env_id}" for env_id in pnt_gym.ENV_IDS)]
    with pytest.raises(UsageError, match="unknown case 'one'; known are planner"):
        perf.select_cases(["one"])


def spin(seconds: float) -> None:
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


def spin_longer() -> None:
    spin(0.3)


def test_shares_are_of_the_processors_time_and_the_first_part_that_fits_has_a_sample() -> None:
    with shares.sample_shares((("long", {"spin", "spin_longer"}), ("short", {"spin"}), ("none", {"json"}))) as parts:
        spin(0.1)
        spin_longer()
    assert list(parts)[:2] == ["long", "short"]
    assert "none" not in parts
    assert sum(parts.values()) == pytest.approx(1.0)
    assert parts["long"] == pytest.approx(0.75, abs=0.1)


def test_parts_name_functions_that_exist() -> None:
    loaded = "agents.training.session", "agents.learning.sb3", "pnt_gym.cells.line.core", "pnt_gym.envs.conveyor"
    for module in loaded:
        import_module(module)
    roots, names = ("pnt_gym", "agents", "mujoco.batch", "stable_baselines3"), set[str]()
    for module in [part for name, part in sys.modules.items() if name.startswith(roots)]:
        for value in list(vars(module).values()):
            members = vars(value).values() if isinstance(value, type) else [value]
            functions = [getattr(member, "__func__", member) for member in members]
            names |= {function.__qualname__ for function in functions if hasattr(function, "__code__")}
    for parts in (shares.THROW, shares.DECISION, shares.TRAINING):
        assert {name for _, part in parts for name in part} <= names


def test_steps_stand_beside_each_other_with_everything_else_at_the_end() -> None:
    steps = [
        {"env": "A", "level": "waste", "cells": 1, "parts": {"engine": 0.5, "everything else": 0.5}},
        {"env": "B", "level": "single", "cells": 64, "parts": {"choice": 0.25, "everything else": 0.75}},
    ]
    grid = speeds.grid("shares", {"steps": steps})
    assert grid.header == ["part of a step", "`A`, waste, single", "`B`, single, 64 cells"]
    assert grid.rows == [["engine", "50.0 %", "-"], ["choice", "-", "25.0 %"], ["everything else", "50.0 %", "75.0 %"]]


def test_goals_say_by_how_much_a_speed_falls_short() -> None:
    throws = [
        {"level": "waste", "cells": cells, "threads": threads, "env_over_bare": share}
        for cells, threads, share in ((1, 1, 0.50), (64, 1, 0.92), (64, 2, 0.66))
    ]
    flights = {"level": "waste, fidelity: flight", "cells": 64, "threads": 1, "env_over_bare": 0.1}
    line = [{"level": "single", "cells": 64, "threads": n, "env_throws_per_s": 50_000.0 * n} for n in (1, 2)]
    envs = {"PnTConveyor-v0": {"rows": [*throws, flights]}, "PnTLine-v0": {"rows": line}}
    assert [row[1:] for row in speeds.grid("speed-goals", {"envs": envs}).rows] == [
        ["0.60", "0.50", "17 %"],
        ["0.92", "0.92", "-"],
        ["0.88", "0.66", "25 %"],
        ["1.70", "2.00", "-"],
    ]


def test_a_training_stands_beside_that_of_older_code() -> None:
    turns = {
        "before": {"seconds": 40.0, "landing_error_m": 0.04},
        "now": {"seconds": 20.0, "landing_error_m": 0.05},
    }
    grid = speeds.grid("training-before", {"older": "1a2b3c4d", "training": {"throws": 2000, "seeds": [turns]}})
    assert grid.rows == [["0", "40.0 s", "20.0 s", "40.00 mm", "50.00 mm"]]
    grid = speeds.grid("training-shares", {"throws": 2000, "parts": {"throws": 0.5, "everything else": 0.5}})
    assert grid.rows == [["throws", "50.0 %"], ["everything else", "50.0 %"]]


def test_steps_stand_beside_those_of_older_code() -> None:
    row = {"env": "A", "level": "single", "cells": 64, "threads": 1, "before": 10_600.0, "now": 60_000.0, "ratio": 5.66}
    grid = speeds.grid("steps-before", {"older": "1a2b3c4d", "steps": {"turns": 10, "rows": [row]}})
    assert grid.rows == [["`A`", "single", "64", "1", "10,600", "60,000", "5.66"]]
    assert "commit `1a2b3c4d`" in grid.note


def test_cases_with_older_code_are_measured_where_it_is_given() -> None:
    without = perf.select_cases([], has_older_code=False)
    assert [name for name in perf.select_cases([]) if name not in without] == ["before/training", "before/steps"]
    with pytest.raises(UsageError, match="needs the older code's checkout: give --before DIR"):
        list(codes.steps(Options()))


STEPPED = [(*world, cells) for cells in (1, 2) for world in (("PnTLine-v0", "single"), ("PnTConveyor-v0", FLIGHT))]


@pytest.mark.nightly
@pytest.mark.parametrize(("env_id", "level", "cells"), STEPPED)
def test_both_codes_step_in_turn(env_id: str, level: Any, cells: int) -> None:
    stepped = codes.Stepped(env_id, level, cells, 1, 3)
    rates = codes.pair_steps({"before": codes.ROOT, "now": codes.ROOT}, stepped, 1)
    assert rates["before"] > 0.0
    assert rates["now"] / rates["before"] == pytest.approx(rates["ratio"])


@pytest.mark.parametrize("cells", [1, 2])
@pytest.mark.parametrize(
    ("env_id", "level"), [*(("PnTLine-v0", level) for level in LEVELS["PnTLine-v0"]), ("PnTConveyor-v0", "waste")]
)
def test_the_physics_of_the_steps_is_repeated_alone(env_id: str, level: Any, cells: int) -> None:
    steps = Steps(env_id, level, cells, 1, 2 * cells)
    steps.simulate()
    assert (steps.simulated() > 0) == (level != "single")
    taps = [tap for tap in steps._taps if tap.calls]
    ends = [tap.state.copy() for tap in taps]
    for tap in taps:
        tap.state[:] = 0.0
    steps._repeat()
    for tap, end in zip(taps, ends, strict=True):
        np.testing.assert_array_equal(tap.state, end)


def test_every_turn_has_the_same_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = list[Any]()
    monkeypatch.setattr(Cells, "step", lambda self: seen.append(self.env.step(np.zeros((2, 2), np.float32))[0]))
    steps = Steps("PnTConveyor-v0", FLIGHT, 2, 1, 4)
    for turn in (steps.step, steps.simulate, steps.step):
        turn()
    first, *others = np.reshape(seen, (3, steps.count, -1))
    for turn in others:
        np.testing.assert_array_equal(turn, first)
    assert (first[1:] != first[:-1]).any(axis=1).all()
