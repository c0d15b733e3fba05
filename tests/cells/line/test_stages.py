"""The compiled stages of a line's step give what movers, tables and searches that try everything give."""

from __future__ import annotations

import math
import multiprocessing
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base import parallel
from pnt_gym.cells.base.features import CLIP, EntryTable
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.observation import CHOICE_TABLE, LINE_TABLE
from pnt_gym.cells.line.rows import Choice
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.chase import Chase, earliest
from tests.tools.line import THREE_BINS, begun, decided, seen_values, with_table
from tests.tools.movers import choices_anew
from tests.tools.throws import same_bits

ROBOTS = [
    {"name": "first", "x": 0.0, "bins": THREE_BINS},
    {"name": "second", "x": 1.4, "percent": [30, 50], "skills": ["can", "paper_ball", "tray"]},
    {"name": "third", "x": 2.8},
]
LEVELS: dict[str, dict[str, Any]] = {
    "skills": {"base": "skills3_burst"},
    "mixed": {"base": "line3", "robots": ROBOTS},
    "settings": {"base": "speed", "arrivals": {"rate": 2.0}},
    "standing": {"base": "single", "cell": {"belt": {"tracking": False}, "motion": {"reserve": 0.0}}},
    "shares": {"base": "skills3", "cell": {"motion": {"follow_through": {"gravity_share": 0.9}}}},
    "quick": {"base": "speed", "cell": {"belt": {"speed": 0.5}, "limits": {"percent": [40, 100]}}, "horizon": 1.5},
}


@pytest.mark.parametrize("name", LEVELS)
def test_compiled_options_are_those_of_the_movers(name, tables):
    cell, random = begun(with_table({**LEVELS[name], "duration": 15.0}, tables), 6, 4), np.random.default_rng(4)
    decisions = 0
    while not cell.over.all():
        choices, anew, ongoing = cell.state.choices, choices_anew(cell, by_movers=True).choices, ~cell.over
        assert same_bits(choices["real"][ongoing], anew["real"][ongoing])
        real = choices["real"] & ongoing[:, None]
        for field in Choice.fields.keys() - {"line", "place"}:  # of the sight in which a choice was found
            np.testing.assert_allclose(choices[field][real], anew[field][real], rtol=1e-9, atol=1e-9, err_msg=field)
        cell.take(decided(cell, random, 0.1))
        decisions += 1
    assert decisions > 10


@pytest.mark.parametrize("name", ["skills", "mixed", "settings"])
def test_compiled_observations_are_what_robots_know(name, tables):
    core, random = LineCore(begun(with_table(LEVELS[name], tables)).config, 5), np.random.default_rng(0)
    core.reset(np.arange(5), [np.random.default_rng(row) for row in range(5)], seeded=True)
    for _ in range(30):
        line, choices = seen_values(core)
        choice_entries = np.where(choices["real"][..., None], encoded(CHOICE_TABLE, choices), np.float32(0.0))
        wanted = np.concatenate([encoded(LINE_TABLE, line), choice_entries.reshape(5, -1)], axis=1)
        assert same_bits(core.observe(), wanted)
        core.step(decided(core.cell, random))


def encoded(table: EntryTable, values: dict[str, Any]) -> Any:
    """Entries S + (D,) of physical values S."""
    centre, scale = table.scaling
    scaled = (np.stack([values[name] for name in table.names], axis=-1) - centre) / scale
    return np.clip(scaled, -CLIP, CLIP).astype(np.float32)


def test_results_are_those_of_the_table(tables):
    """First and later attempts, by hand."""
    level = with_table({"base": "line3", "duration": 40.0}, tables, picked=(0.4,) * 4)
    cell, random, again = begun(level, 16, 1), np.random.default_rng(1), 0
    table = cell.chances
    while not cell.over.all():
        state, choice, rows = cell.state, decided(cell, random), np.arange(16)
        chosen = state.choices[rows, choice]
        riders, attempts = cell.stream.riders[rows, chosen["index"]], state.accounts["attempts"][rows, chosen["index"]]
        decisions = cell.take(choice)
        for n in np.flatnonzero(decisions.valid):
            seal, luck = float(riders["seal"][n]), float(riders["luck"][n])
            for _ in range(attempts[n]):
                seal, luck = (draw * (1000.0 + (math.sqrt(5.0) - 1.0) / 2.0) % 1.0 for draw in (seal, luck))
            kind, part = riders["kind"][n], np.searchsorted(table.edges, math.hypot(*chosen["away"][n]))
            setting = np.abs(table.percent - chosen["percent"][n]).argmin()
            picked = seal >= 1.0 - table.picked[kind]
            hit = picked and luck < table.landed[kind, setting, part]
            result, accepts = decisions.results[n], cell.chooser.planner_of(state.robot[n]).config.acceptance()
            fits = hit and accepts[kind, chosen["bin"][n]]
            ended_in = chosen["bin"][n] if hit else -1
            assert (result["picked"], result["is_success"], result["sorted"]) == (picked, hit, fits)
            assert result["ended_in"] == ended_in
            again += int(attempts[n] > 0)
    assert again > 20


@pytest.mark.parametrize(("threads", "name"), [(2, "settings"), (3, "mixed"), (3, "shares"), (5, "mixed")])
def test_threads_change_nothing(threads, name, tables):
    level = with_table({**LEVELS[name], "duration": 12.0}, tables)
    lines = 5 * parallel.LEAST_LINES
    alone, together = begun(level, lines, 2), begun(level, lines, 2, threads)
    random = np.random.default_rng(2)
    while not alone.over.all():
        choice = decided(alone, random)
        one, other = alone.take(choice), together.take(choice)
        for field in ("end", "value", "elapsed", "observation"):
            assert same_bits(getattr(one, field), getattr(other, field)), field
        for rows, others in zip(alone.state, together.state, strict=True):
            assert all(same_bits(rows[field], others[field]) for field in rows.dtype.names)


def test_a_shift_by_table_is_that_of_whole_observations(tables):
    """A step writes the observations part by part, in the threads that advance the parts."""
    core = LineCore(LineConfig.load(with_table({**LEVELS["skills"], "duration": 12.0}, tables)), 16, 2)
    core.reset(np.arange(16), [np.random.default_rng(row) for row in range(16)], seeded=True)
    random, steps = np.random.default_rng(3), 0
    while not core.cell.over.all():
        step = core.step(decided(core.cell, random))
        assert same_bits(step.observation, core.observe())
        steps += 1
    assert steps > 5


def test_parts_together_are_all_lines_and_a_failure_is_raised():
    seen = np.zeros(50, dtype=np.int64)
    parallel.work_in_parts(lambda lines: np.add.at(seen, lines, 1), np.arange(50), 4)
    assert (seen == 1).all()

    counts = list[int]()
    calls = [lambda: counts.append(1)] * 3
    for threads in (1, 2, 5):
        seen[:] = 0
        counts.clear()
        parallel.work_in_parts(lambda lines: np.add.at(seen, lines, 1), np.arange(50), threads, calls)
        assert (seen == 1).all()
        assert len(counts) == 3

    def fail(lines):
        if 49 in lines:
            raise ValueError("the last line")

    for lines in (np.arange(50), np.arange(50)[::-1]):  # in a helping thread, and in the caller's
        with pytest.raises(ValueError, match="the last line"):
            parallel.work_in_parts(fail, lines, 4)


def _step_in_child(cell: LineCell, results: Any) -> None:
    results.put(cell.take(np.zeros(cell.count, dtype=np.int64)).end)


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_threads_work_after_a_fork(tables):
    """As in `AsyncVectorEnv`: the child has none of its parent's threads."""
    cell = begun(with_table(LEVELS["skills"], tables), 32, 0, 2)
    context = multiprocessing.get_context("fork")
    results = context.Queue()
    child = context.Process(target=_step_in_child, args=(cell, results))
    child.start()
    end = results.get(timeout=60.0)
    child.join()
    assert same_bits(end, cell.take(np.zeros(32, dtype=np.int64)).end)


def _lateness(chase: Any, time: float) -> float:
    """How much too late a hand arrives at a time, as the documentation of `chase` says."""
    x, y, z = chase["way"] + time * chase["belt"]
    descent, velocity, acceleration, jerk = (chase[name] for name in ("descent", "velocity", "acceleration", "jerk"))
    way, square = math.sqrt(x * x + y * y + z * z), acceleration * acceleration
    if jerk * jerk * way <= 2.0 * square * acceleration and jerk * way * way <= 4.0 * velocity**3:
        speed, peak = math.cbrt(0.25 * jerk * way * way), math.cbrt(0.5 * jerk * jerk * way)
    elif jerk * velocity <= square:
        speed, peak = velocity, math.sqrt(jerk * velocity)
    else:
        root = math.sqrt(square * square + 4.0 * jerk * jerk * way * acceleration)
        speed, peak = min(2.0 * jerk * way * acceleration / (square + root), velocity), acceleration
    return (way / speed + (speed / peak + peak / jerk) if speed > 0.0 else 0.0) + descent - time


def _plain_search(chase: Any) -> float:
    """The first meeting, where every sample and every halving is tried; NaN where there is none."""
    first, last, end = (float(chase[name]) for name in ("first", "last", "end"))
    if not _lateness(chase, first) > 0.0:
        return first
    way, belt = chase["way"], chase["belt"]
    square = sum(v * v for v in belt)
    along = way[0] * belt[0] + way[1] * belt[1] + way[2] * belt[2]
    nearest = float(min(max(-along / (square if square > 0.0 else 1.0), first), last))
    late, met = first, nearest
    if _lateness(chase, nearest) > 0.0:
        end = max(nearest, min(last, end))
        samples = [nearest + (end - nearest) * ((k / 96) * (k / 96)) for k in range(97)]
        good = [k for k in range(1, 97) if not _lateness(chase, samples[k]) > 0.0]
        if not good:
            return math.nan
        late, met = samples[good[0] - 1], samples[good[0]]
    for _ in range(64):
        middle = 0.5 * (late + met)
        if middle in (late, met):
            break
        late, met = (middle, met) if _lateness(chase, middle) > 0.0 else (late, middle)
    return met


@pytest.mark.parametrize(("speed", "far"), [(0.25, 1.0), (0.5, 0.1), (3.0, 1.0), (0.0, 1.0), (0.3, 1e-4), (0.25, 1e4)])
def test_meetings_are_those_of_a_search_that_tries_every_time(speed, far):
    random, count = np.random.default_rng(0), 300
    percent, late = random.uniform(0.2, 1.0, count), random.uniform(0.0, 1.0, count)
    velocity = random.normal(size=(count, 3)) * [1.0, 0.2, 0.0]
    velocity *= speed / np.linalg.norm(velocity, axis=1, keepdims=True)
    chases = Chase.zeros(
        count,
        way=random.normal(size=(count, 3)) * far,
        belt=velocity,
        descent=random.uniform(0.0, 0.2, count),
        velocity=6.0 * percent,
        acceleration=120.0 * percent,
        jerk=3000.0 * percent,
        first=np.where(late < 0.5, 0.0, late),
        last=late + random.uniform(0.0, 3.0, count),
        end=random.uniform(0.0, 4.0, count),
    )
    assert same_bits(earliest(chases), np.array([_plain_search(chase) for chase in chases]))


def test_robots_that_find_nothing_to_take_end_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pnt_gym.cells.line.choosing.MOST_LOOKS", 0)
    with pytest.raises(ConfigError, match="level 'single': the robots find no object that they can take"):
        gym.make("PnTLine-v0", level="single")
