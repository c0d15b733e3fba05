"""Chances of throws by a table: counted as by hand, and met by the throws that go by them."""

import json

import numpy as np
import pytest

from pnt_gym.cells.line.chances import PRIOR, Chances, format_table, read_table
from pnt_gym.cells.line.choose import landing_chance
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.rows import Choice
from pnt_gym.errors import ConfigError
from tests.tools.line import begun, chances, decided, with_table

CONFIG = LineConfig.load({"base": "speed", "throws": "flight"})


def test_a_table_is_what_was_counted():
    """21 throws of two items at two speeds, by hand."""
    kind, percent = np.repeat([0, 1], [10, 11]), np.tile([30.0, 50.0], 11)[:21]
    distance, hits = np.linspace(0.5, 1.1, 21), np.arange(21) % 3 != 0
    made = Chances.of(np.array([0.9, 0.8, 0.7, 0.6]), kind, percent, distance, hits)
    assert made.percent.tolist() == [30.0, 50.0]
    assert made.picked.tolist() == [0.9, 0.8, 0.7, 0.6]
    assert [int((distance <= edge).sum()) for edge in made.edges] == [6, 11, 16]  # 4 classes of equally many
    for item in range(4):
        throws = [i for i in range(21) if kind[i] == item]
        mean = (sum(hits[i] for i in throws) + hits.mean()) / (len(throws) + 1.0)
        for setting, speed in enumerate((30.0, 50.0)):
            for near in range(4):
                low = made.edges[near - 1] if near else -np.inf
                high = made.edges[near] if near < 3 else np.inf
                own = [i for i in throws if percent[i] == speed and low < distance[i] <= high]
                wanted = (sum(hits[i] for i in own) + PRIOR * mean) / (len(own) + PRIOR)
                assert made.landed[item, setting, near] == pytest.approx(wanted)


def test_shares_of_few_held_objects_have_no_bias():
    """12 throws of the first item at two speeds, by hand; nobody threw the other items."""
    percent, distance, kind = np.tile([30.0, 50.0], 6), np.linspace(0.5, 1.1, 12), np.zeros(12, dtype=np.int64)
    hits, sealing = np.arange(12) % 4 != 0, np.array([0.9, 0.8, 0.7, 0.6])
    made = Chances.of(sealing, kind, percent, distance, hits)
    assert made.picked is sealing
    assert made.landed[1:] == pytest.approx(0.75)
    for near in range(4):  # three throws in each class of distance
        own = slice(3 * near, 3 * near + 3)
        for setting, speed in enumerate((30.0, 50.0)):
            rows = percent[own] == speed
            wanted = (hits[own][rows].sum() + PRIOR * 0.75) / (rows.sum() + PRIOR)
            assert made.landed[0, setting, near] == pytest.approx(wanted)
    usual = Chances(np.array([50.0]), np.array([0.8]), sealing, np.array([[[0.2, 0.4]]] * 4))
    shrunk = Chances.of(sealing, kind, percent, distance, hits, usual)
    assert shrunk.landed[1:, 0].tolist() == [pytest.approx([0.2, 0.2, 0.4, 0.4])] * 3
    assert shrunk.landed[0, 0, 0] == pytest.approx((hits[:3][percent[:3] == 30.0].sum() + PRIOR * 0.2) / (2 + PRIOR))


def test_a_level_may_hold_its_table(tmp_path):
    level = with_table({"base": "speed"}, tmp_path)
    entries = json.loads((tmp_path / level["chances"]).read_text())
    held = LineConfig.load({"base": "speed", "chances": entries})
    found, made = read_table(held), read_table(LineConfig.load(level))
    assert found is not None and made is not None
    assert found.entries == made.entries
    assert held.files() == ()
    for key, value, said in (
        ("digest", "other", "the level's table was made for other cells than those of level"),
        ("picked", [0.5], "the level's table is not a table"),
    ):
        with pytest.raises(ConfigError, match=said):
            read_table(LineConfig.load({"base": "speed", "chances": {**entries, key: value}}))
    with pytest.raises(ConfigError, match=r"chances.*edge"):
        LineConfig.load({"base": "speed", "chances": {**entries, "edge": 1}})


def chances_of(table, kind, percent, distance):
    """Chances of choices of one line, as planners see them."""
    look_up = getattr(landing_chance, "py_func", landing_chance)
    choices = Choice.zeros(len(kind), percent=percent, away=np.stack([distance, 0 * distance], -1)).view(np.recarray)
    return [table.picked[k] * look_up(table.table, k, choice) for k, choice in zip(kind, choices, strict=True)]


def test_a_chance_is_looked_up_by_item_speed_and_distance():
    table = chances(CONFIG)
    kind, percent = np.array([0, 1, 2, 3, 3]), np.array([30.0, 40.0, 50.0, 33.0, 90.0])
    distance = np.array([0.1, 0.75, 0.85, 5.0, 0.7])
    at = [(0, 0, 0), (1, 1, 1), (2, 2, 2), (3, 0, 3), (3, 2, 0)]
    assert chances_of(table, kind, percent, distance) == [table.landed[i] * table.picked[i[0]] for i in at]


def test_nothing_fails_by_the_table_of_lines_that_throw():
    sure = Chances.certain(CONFIG.cell)
    assert chances_of(sure, np.arange(4), np.full(4, 35.0), np.linspace(0.1, 3.0, 4)) == [1.0] * 4


def test_a_table_that_is_written_is_read_again(tmp_path):
    config = LineConfig.load(with_table({"base": "speed"}, tmp_path))
    found, made = read_table(config), chances(config)
    assert found is not None
    for name in ("percent", "edges", "picked", "landed"):
        np.testing.assert_allclose(getattr(found, name), getattr(made, name), atol=5e-6)
    assert json.loads(format_table(made, throws=7))["throws"] == 7


def test_throws_come_out_as_often_as_the_table_has_it(tmp_path):
    """By item, speed and distance: the shares of what was thrown, within four standard deviations of each."""
    level = with_table({"base": "speed", "duration": 120.0, "arrivals": {"rate": 2.0}}, tmp_path)
    cell, random = begun(level, 16), np.random.default_rng(0)
    table = chances(cell.config)
    wanted, found = np.zeros((2, 4, 4)), np.zeros((2, 4, 4))
    count = 0
    while not cell.over.all():
        taken = cell.take(decided(cell, random))
        rows = np.flatnonzero(taken.valid)
        kind, made = taken.context.objects.kind[rows], taken.results
        setting = np.searchsorted(table.percent, taken.context.objects.percent[rows])
        of = np.searchsorted(table.edges, taken.context.distance[rows])
        held = made["picked"][rows]
        np.add.at(wanted[0], (kind, 0), table.picked[kind])
        np.add.at(wanted[1], (kind, of), np.where(held, table.landed[kind, setting, of], 0.0))
        np.add.at(found[0], (kind, 0), held)
        np.add.at(found[1], (kind, of), made["is_success"][rows])
        assert (made["ended_in"][rows][made["is_success"][rows]] >= 0).all()
        assert (made["ended_in"][rows][~made["is_success"][rows]] == -1).all()
        assert not (made["sorted"] & ~made["is_success"]).any()
        count += rows.size
    assert count > 700
    assert (np.abs(found - wanted) <= 4.0 * np.sqrt(np.maximum(wanted, 1.0))).all()
    assert found[1].sum() == pytest.approx(wanted[1].sum(), abs=4.0 * np.sqrt(0.25 * count))
