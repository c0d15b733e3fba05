"""Shifts of hours and robots far away: they begin, stay the same lines, cost what short ones do, or are refused."""

import subprocess
import sys
import tracemalloc
from fractions import Fraction
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.cells.line import acts
from pnt_gym.cells.line import cell as cells
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.lie import separate
from pnt_gym.cells.line.rows import UNAVAILABLE_X, Account, LineNumbers, Rider, Seen, Turn
from pnt_gym.cells.line.sight import show_objects
from pnt_gym.cells.line.view import LineView
from pnt_gym.errors import ConfigError
from tests.tools.line import BOXES, begun, decided
from tests.tools.throws import same_bits

BEGIN = """
import gymnasium, pnt_gym
for duration, x in ((3600.0, 0.0), (14400.0, -1e5), (14400.0, 2e5)):
    level = {"base": "skills3", "duration": duration, "robots": [{"name": "only", "x": x}]}
    env = gymnasium.make("PnTLine-v0", level=level)
    env.reset(seed=0)
    assert not env.step(0)[4]["invalid_action"]
"""
SINGLE = begun("single")
FOUR_HOURS = {"base": "skills3", "duration": 14400.0}


def robots(*places: float) -> list[dict[str, Any]]:
    return [{"name": f"robot {number}", "x": x} for number, x in enumerate(places)]


def test_long_shifts_begin_near_and_far_from_the_origin():
    """In a process of its own: a loop without end in machine code could not be stopped otherwise."""
    subprocess.run([sys.executable, "-c", BEGIN], check=True, timeout=120.0)


@given(given=BOXES, begin=st.floats(-1e6, 1e6), gap=st.sampled_from([0.0, 0.01, 1.0]))
def test_boxes_do_not_overlap_wherever_they_lie(given, begin, gap):
    """By fractions, which round nothing: to half a unit in the last place of a position, or 1e-12 of the distance."""
    steps, y, along, across = (np.array(column) for column in zip(*given, strict=True))
    x = begin - np.cumsum(steps)
    lies = separate(x, y, along, across, gap)
    assert (lies <= x).all()
    slack = Fraction(np.spacing(np.abs(lies).max() + 2.0)) / 2
    for i in range(len(x)):
        for j in np.flatnonzero(np.abs(y[:i] - y[i]) < across[:i] + across[i] + gap):
            free = Fraction(along[i] + along[j] + gap)
            away = abs(Fraction(lies[i]) - Fraction(lies[j]))
            assert away >= free - max(slack, free * Fraction(1.01e-12))


@given(
    x=st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=1, max_size=12),
    size=st.floats(0.0, 1e300),
    gap=st.floats(0.0) | st.just(np.nan),
)
def test_any_numbers_at_all_come_to_an_end(x, size, gap):
    sizes = np.full(len(x), size)
    assert len(separate(np.array(x), np.zeros(len(x)), sizes, sizes, gap)) == len(x)


@given(x=st.lists(st.floats(-10, 10), max_size=30), ride=st.floats(0, 10), low=st.floats(-5, 5), long=st.floats(0, 5))
def test_what_is_in_sight_is_what_a_look_at_everything_finds(x, ride, low, long):
    places = np.sort(np.array([x, x]), axis=1)[:, ::-1]
    seen = SINGLE.chooser.tables._replace(line=LineNumbers.zeros(1, speed=0.5, sight_low=low, sight_high=low + long))
    state = SINGLE.state._replace(turns=Turn.zeros(2, clock=[0.0, 2.0 * ride]), accounts=Account.zeros(*places.shape))
    then, riders = places[1] + ride, Rider.zeros(*places.shape, x=places)
    shown = show_objects(seen, state, riders, np.array([1]))[0] if len(x) else np.zeros(0, dtype=Seen.dtype)
    near = shown[shown["x"] != UNAVAILABLE_X]
    assert near["index"].tolist() == np.flatnonzero((then >= low) & (then <= low + long)).tolist()
    assert near["x"].tolist() == then[near["index"]].tolist()


def test_a_line_far_away_works_the_same_shift():
    near, far = (begun({"base": "skills3", "robots": robots(x, x + 1.4)}, 2, 5) for x in (0.0, 1e5))
    random = np.random.default_rng(0)
    for _ in range(60):
        choice = decided(near, random)
        one, other = near.take(choice), far.take(choice)
        assert (one.index == other.index).all()
        np.testing.assert_allclose(one.end, other.end, atol=1e-8)
    assert near.state.clock.min() > 10.0


def test_a_line_far_away_looks_the_same():
    scenes = []
    for x in (0.0, -1e5):
        core = LineCore(begun({"base": "skills3", "robots": robots(x, x + 1.4)}).config, 1)
        view = LineView(core.cell)
        core.reset(np.arange(1), [np.random.default_rng(0)], seeded=True)
        core.step(np.zeros(1, dtype=np.int64))
        _, data, markers = view.scene(float(core.cell.state.clock[0]))
        scenes.append(np.concatenate([data.geom_xpos, [one.position for one in markers]]))
        view.close()
    np.testing.assert_allclose(*scenes, atol=1e-6)
    assert np.abs(scenes[0]).max() < 10.0


def test_a_decision_in_a_long_shift_copies_nothing_of_its_length():
    """One column of a stream of 59,000 objects is half a megabyte."""
    cell, random = begun(FOUR_HOURS), np.random.default_rng(0)
    for _ in range(5):
        cell.take(decided(cell, random))
    tracemalloc.start()
    for _ in range(5):
        cell.take(decided(cell, random))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < cell.stream.x.nbytes


def test_pictures_keep_the_latest_acts_and_every_hand(monkeypatch):
    cell = begun({"base": "skills3", "duration": 60.0})
    cell.watch()
    every = cell.acts
    monkeypatch.setattr(acts, "MAX_CYCLES", 4)
    for _ in range(30):
        before, choice = cell.state, np.zeros(1, dtype=np.int64)
        cell.take(choice)
        with monkeypatch.context() as patch:
            patch.setattr(acts, "MAX_CYCLES", 1000)
            every = every.advance(float(before.clock[0]), cell.acts.cycles[-1])
        now = float(cell.state.clock[0])
        assert same_bits(cell.acts.tips(now), every.tips(now))
        assert len(cell.acts.cycles) <= 4 + 3 + 1
    assert len(every.cycles) == 30


REFUSED = (
    ({"robots": robots(-1e5, 1e5)}, "200002 m of a belt that runs 0.4 m/s takes 2.01e.06 objects; at most 400000"),
    ({"robots": robots(1e6)}, "robots.0.x is 1000000.0: input should be less than or equal to 200000"),
    ({"robots": robots(-1e300)}, "robots.0.x is -1e.300: input should be greater than or equal to -200000"),
    ({"duration": 14401.0}, "duration is 14401.0: input should be less than or equal to 14400"),
    (
        {"duration": 3600.0, "arrivals": {"gap": 1.0}},
        "with arrivals.gap 1 m the belt has room for about 0.3[0-9]* a second",
    ),
)


@pytest.mark.parametrize(("level", "said"), REFUSED)
def test_what_takes_too_many_objects_or_too_much_room_is_one_sentence(level, said):
    with pytest.raises(ConfigError, match=said):
        gym.make("PnTLine-v0", level={"base": "line3", "throws": "flight", **level})


def test_so_many_lines_that_memory_would_not_hold_their_objects_are_one_sentence(monkeypatch):
    config = begun("skills3").config
    with pytest.raises(ConfigError, match=r"num_envs is 100000; .* draws 676 objects, .* num_envs to at most 7396"):
        LineCore(config, 100_000)
    monkeypatch.setattr(cells, "MOST_OBJECTS", 2 * 676)
    assert LineCore(config, 2).cell.stream.x.shape == (2, 676)
