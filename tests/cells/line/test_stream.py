"""What comes along a line's belt: nothing on anything else, as many, as regular, as mixed, as dear as asked for."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.lie import Jam, separate
from pnt_gym.cells.line.simulate import redraw
from pnt_gym.errors import ConfigError
from tests.cells.base.test_records import arrays
from tests.tools.line import BOXES, begun, decided, with_table
from tests.tools.outlines import outlines, overlap
from tests.tools.throws import same_bits

FLIGHT = {"throws": "flight"}
"""Streams do not depend on the throws, and these need no table."""


def drawn(level, count=1, seed=0):
    cell = begun({**level, **FLIGHT}, count, seed)
    return cell.config, cell.stream


def lying(level, count, seed=0):
    """Outlines (N, M, K, 2) and centres (N, M, 2) of what lies on N belts, [m]."""
    _, stream = drawn(level, count, seed)
    rows, many = stream.x.shape
    flat = take(stream.objects, (np.repeat(np.arange(rows), many), np.tile(np.arange(many), rows)))
    centre = np.stack([stream.x.ravel(), flat.draws.lane_y], axis=-1)
    return outlines(flat, centre).reshape(rows, many, -1, 2), centre.reshape(rows, many, 2)


DENSE = (
    {"base": "single", "arrivals": {"rate": 5.0}, "duration": 1200.0},
    {"base": "skills3_burst", "arrivals": {"rate": 6.0, "regularity": 0.2}, "duration": 1000.0},
    {"base": "value", "arrivals": {"rate": 4.0, "gap": 0.0, "regularity": 20.0}, "duration": 1500.0},
)
BELTS = 6


@pytest.mark.parametrize("level", DENSE, ids=lambda level: level["base"])
def test_no_two_objects_overlap_on_any_belt(level):
    """By their true outlines, of 100,000 objects over all levels: everyone against all that lie near."""
    polygons, centre = lying(level, BELTS)
    assert centre[..., 0].size > 100_000 / len(DENSE)
    radius = np.linalg.norm(polygons - centre[:, :, None], axis=-1).max(axis=-1)
    for row in range(BELTS):
        ahead, close = 1, 0
        # As long as anybody is so near along the belt that circles around the two could meet.
        while (centre[row, :-ahead, 0] - centre[row, ahead:, 0] < 2.0 * radius.max()).any():
            away = np.linalg.norm(centre[row, :-ahead] - centre[row, ahead:], axis=-1)
            near = np.flatnonzero(away < radius[row, :-ahead] + radius[row, ahead:])
            assert not overlap(polygons[row, near], polygons[row, near + ahead]).any()
            ahead, close = ahead + 1, close + near.size
        assert ahead > 4  # several lie abreast
        assert close > 100
        assert (np.diff(centre[row, :, 0]) <= 0.0).all()


def test_objects_that_do_not_give_way_do_overlap(monkeypatch):
    """So that the test above can fail."""
    monkeypatch.setattr("pnt_gym.cells.line.stream.lie.separate", lambda x, *_: x)
    polygons, _ = lying({"base": "single", "arrivals": {"rate": 5.0}}, 2)
    assert overlap(polygons[0, :-1], polygons[0, 1:]).any()


@given(given=BOXES, gap=st.sampled_from([0.0, 0.01, 0.1]))
def test_boxes_give_way_no_farther_than_they_must(given, gap):
    """Against all pairs: nobody lies on anybody, and who was moved touches the gap around somebody before it."""
    steps, y, along, across = (np.array(column) for column in zip(*given, strict=True))
    x = -np.cumsum(steps)
    lies = separate(x, y, along, across, gap)
    assert (lies <= x).all()
    beside = np.abs(y[:, None] - y) < across[:, None] + across + gap
    free = along[:, None] + along + gap
    away = np.abs(lies[:, None] - lies)
    before = np.tri(len(x), k=-1, dtype=bool)
    assert not (before & beside & (away < free * (1 - 1e-9))).any()
    touches = before & beside & (np.abs(away - free) < 1e-9)
    assert touches.any(axis=1)[lies < x].all()


@pytest.mark.parametrize("regularity", [0.4, 1.0, 10.0])
def test_as_many_come_as_regularly_as_asked_for(regularity):
    """Counts over windows of ten seconds: mean and variance of a gamma renewal stream, on a belt with room for it."""
    rate, duration = 0.5, 2000.0
    level = {"base": "single", "arrivals": {"rate": rate, "regularity": regularity}, "duration": duration}
    config, stream = drawn(level, 10, 3)
    come = np.sort((config.reach[1] - stream.x) / config.cell.belt.speed, axis=1)
    gaps = np.diff(come[:, : int(0.9 * rate * duration)], axis=1).ravel()
    assert gaps.size > 8000
    share = np.sqrt(1.0 / (regularity * gaps.size))
    assert gaps.mean() == pytest.approx(1.0 / rate, rel=5.0 * share)
    # Those that come at once give way to each other, which makes a burst a little longer.
    assert gaps.std() * rate == pytest.approx(regularity**-0.5, rel=0.06)


def test_the_belt_is_full_when_a_shift_begins_and_stays_so():
    config, stream = drawn({"base": "line3"}, 8, 2)
    low, high = config.reach
    assert (stream.x <= high).all()
    there = ((stream.x >= low) & (stream.x <= high)).sum(axis=1)
    mean = config.arrivals.rate * (high - low) / config.cell.belt.speed
    assert np.abs(there.mean() - mean) < 4.0 * math.sqrt(mean / 8)
    last = low - config.cell.belt.speed * (config.duration + config.horizon)
    assert (stream.x.min(axis=1) < last).all()


def test_enough_is_drawn_for_every_shift():
    for level in ({"base": "skills3_burst"}, {"base": "single", "arrivals": {"regularity": 0.1}}):
        config, stream = drawn(level, 40, 9)
        assert stream.x.shape[1] == int(config.objects)
        end = config.reach[0] - config.cell.belt.speed * (config.duration + config.horizon)
        assert (stream.x[:, -1] < end).all()


def test_an_item_that_the_mix_does_not_list_does_not_come():
    items = ["tray", "cork", "can"]
    config = ConveyorConfig.load({"items": items, "mix": {"tray": 1.0, "can": 3.0}})
    kinds = PickPlanner(config).draw([np.random.default_rng(0)], np.zeros(1, dtype=np.int64), 4000).kind
    assert config.shares().tolist() == [0.25, 0.0, 0.75]
    assert np.abs(np.bincount(kinds[0]) / 4000 - config.shares()).max() < 4.0 * np.sqrt(0.25 / 4000)
    assert (np.bincount(kinds[0]) > 0).tolist() == [True, False, True]
    assert ConveyorConfig.load({"items": items}).shares().tolist() == [1.0 / 3.0] * 3


@pytest.mark.parametrize("spread", [0.0, 0.5, 1.0])
def test_values_scatter_about_their_items_mean(spread):
    of = {"tray": 1.0, "can": 1.5, "paper_ball": 0.3, "yoghurt_cup": 2.0}
    _, stream = drawn({"base": "single", "value": {"of": of, "spread": spread}, "duration": 1000.0}, 8)
    for item, mean in enumerate(of.values()):
        worth = stream.riders["worth"][stream.objects.kind == item]
        assert worth.size > 1000
        off = np.sqrt((np.exp(spread**2) - 1.0) / worth.size)
        assert worth.mean() == pytest.approx(mean, rel=5.0 * off + 1e-12)
        assert np.log(worth).std() == pytest.approx(spread, abs=0.05)


def test_an_item_without_a_value_is_worth_one():
    _, stream = drawn({"base": "single", "value": {"of": {"can": 7.0}}})
    assert set(np.unique(stream.riders["worth"])) == {1.0, 7.0}


def test_the_same_seed_gives_the_same_stream_however_throws_are_made_and_whatever_is_decided(tmp_path):
    level = {"base": "skills3_burst", "duration": 5.0}
    forms = [with_table(level, tmp_path), {**level, "throws": "flight"}, {**level, "throws": "full"}]
    cells = [begun(form, 2, 6) for form in forms]
    for shift in range(2):
        first, *others = (arrays(cell.stream) for cell in cells)
        assert len(first) > 25
        for other in others:
            for name, values in first.items():
                assert same_bits(values, other[name]), (shift, name)
        for k, cell in enumerate(cells):
            random = np.random.default_rng(k)
            for _ in range(6 + k):
                cell.take(decided(cell, random))
            cell.reset(np.arange(2), cell.generators)
    assert not same_bits(cells[0].stream.x, begun(forms[1], 2, 7).stream.x)


def short(tmp_path, threads):
    """Lines whose shifts begin, and are soon over."""
    return begun(with_table({"base": "single", "duration": 5.0}, tmp_path), 20, 0, threads)


def ended(cell):
    """The same lines when their shifts are over."""
    random = np.random.default_rng(1)
    while not cell.over.all():
        cell.take(decided(cell, random))
    return cell


def test_a_shift_that_was_drawn_ahead_is_the_shift_that_begins(tmp_path):
    """By threads, at the end of the shift before, and without them, when the shift begins."""
    alone, beside = (ended(short(tmp_path, threads)) for threads in (1, 3))
    drawn_ahead = list(beside.arriving._coming)
    assert len(drawn_ahead) > 10
    assert not alone.arriving._coming
    for cell in (alone, beside):
        cell.reset(np.arange(20), cell.generators)
    for (name, values), others in zip(arrays(alone.stream).items(), arrays(beside.stream).values(), strict=True):
        assert same_bits(values, others), name
    assert [g.bit_generator.state for g in alone.generators] == [g.bit_generator.state for g in beside.generators]
    assert not beside.arriving._coming


def test_a_shift_that_was_drawn_ahead_does_not_begin_for_another_generator(tmp_path):
    cells = [ended(short(tmp_path, threads)) for threads in (1, 2)]
    row = next(iter(cells[1].arriving._coming))
    for cell in cells:
        cell.reset(np.array([row]), [np.random.default_rng(77)])
    first, other = (cell.stream.x[row] for cell in cells)
    assert same_bits(first, other)
    assert row not in cells[1].arriving._coming


def test_a_shift_that_finds_no_room_is_told_when_it_begins_and_not_while_it_is_drawn_ahead(tmp_path, monkeypatch):
    alone, beside = (short(tmp_path, threads) for threads in (1, 3))
    jammed = []

    def separate(x, *_):
        jammed.append(len(x))
        raise Jam(4.0)

    ended(alone)
    monkeypatch.setattr("pnt_gym.cells.line.stream.lie.separate", separate)
    ended(beside)
    assert len(jammed) > 10
    assert not beside.arriving._coming
    assert [g.bit_generator.state for g in alone.generators] == [g.bit_generator.state for g in beside.generators]
    with pytest.raises(ConfigError, match=r"arrivals.rate is .* the belt has room for about 1 a second"):
        beside.reset(np.arange(20), beside.generators)


def test_a_new_shift_is_another_and_the_other_lines_go_on():
    cell = begun({"base": "skills3_burst", "duration": 5.0, **FLIGHT}, 3)
    before, mass = cell.stream.riders.copy(), cell.stream.objects.mass.copy()
    cell.take(decided(cell, np.random.default_rng(0)))
    going = cell.state
    cell.reset(np.array([1]), [cell.generators[1]])
    after = cell.stream.riders
    for old, new in [
        (mass, cell.stream.objects.mass),
        *((before[name], after[name]) for name in ("x", "worth", "luck")),
    ]:
        assert same_bits(old[[0, 2]], new[[0, 2]])
        assert not same_bits(old[1], new[1])
    assert (cell.state.clock[[0, 2]] == going.clock[[0, 2]]).all()
    assert cell.state.accounts["attempts"][1].sum() == 0
    assert cell.state.accounts["attempts"][[0, 2]].sum() == 2


def test_draws_of_later_attempts_tell_nothing_of_earlier_ones():
    draws = np.random.default_rng(0).random(200_000)
    tries = [redraw(draws, np.full(draws.size, attempt)) for attempt in range(4)]
    assert same_bits(tries[0], draws)
    for one in tries:
        assert ((one >= 0.0) & (one < 1.0)).all()
    for k in range(1, 4):
        for earlier in tries[:k]:
            failed = earlier < 0.2
            share = np.histogram(tries[k][failed], bins=10, range=(0.0, 1.0))[0] / failed.sum()
            assert np.abs(share - 0.1).max() < 5.0 * np.sqrt(0.09 / failed.sum())
    assert redraw(np.array([1.0]), np.array([3])).tolist() == [1.0]
    mixed = redraw(draws[:3], np.array([0, 2, 1]))
    assert mixed.tolist() == [tries[0][0], tries[2][1], tries[1][2]]
