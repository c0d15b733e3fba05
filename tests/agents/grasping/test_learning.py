"""Rules and networks: what they score, what they learn from tries alone, and what they keep in files."""

import numpy as np
import pytest

from agents.grasping import rules
from agents.grasping.__main__ import Arguments, main
from agents.grasping.features import NAMES, place_features
from agents.grasping.network import PlaceNetwork
from agents.grasping.practice import network_places, practise, worth_maps
from agents.grasping.rules import COLOURED, TERMS, TUNED, Weights
from agents.grasping.scenes import Scenes
from agents.grasping.tuning import FREE, PlaceTable, tune
from agents.ground.cli import UsageError
from pnt_gym.cells.grasp.images import pixel_places
from tests.tools.throws import same_bits


@pytest.fixture(scope="module")
def scenes():
    return Scenes.draw("grasp", 500, seed=8)


@pytest.fixture(scope="module")
def features(scenes):
    return place_features(scenes.images, scenes.radius)


def test_a_rules_score_is_the_sum_of_its_terms(features):
    weights = Weights(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
    names = ("rough_in", "rough_out", "distance", "slope_in", "belt_out", "valid_in")
    expected = -sum(weight * features.column(name) for weight, name in zip(weights, names, strict=False))
    odd = sum(np.abs(features.column(f"{c}_in") - features.column(f"object_{c}")) for c in ("gray", "warm"))
    np.testing.assert_allclose(rules.scores(features, weights), expected - 0.7 * odd)


def test_a_rule_chooses_the_highest_mean_score_around(features):
    weights = Weights()
    maps = features.maps(rules.scores(features, weights))
    places, near = rules.places(features, weights), np.arange(-3, 4)
    kernel = np.exp(-0.5 * (np.hypot(*np.meshgrid(near, near)) * 0.005 / 0.0045) ** 2)
    padded = np.pad(maps, [(0, 0), (3, 3), (3, 3)], constant_values=np.nan)
    for n in range(0, 500, 50):
        means = np.full((48, 48), -np.inf)
        for row, column in zip(*np.nonzero(np.isfinite(maps[n])), strict=True):
            window = padded[n, row : row + 7, column : column + 7]
            weight = np.where(np.isfinite(window), kernel, 0.0)
            means[row, column] = np.nansum(weight * np.nan_to_num(window)) / weight.sum()
        expected = np.unravel_index(means.argmax(), (48, 48))
        np.testing.assert_allclose(places[n], pixel_places()[expected])


def test_the_flattest_place_alone_is_worse_than_the_middle(scenes, features):
    """The highest of hundreds of noisy scores is mostly noise, and edges of lips look flat."""
    worth = {
        name: scenes.try_places(places).worth.mean()
        for name, places in {
            "middle": np.zeros((500, 2)),
            "centroid": rules.centroid(features),
            "naive": rules.flattest(features),
            "tuned": rules.places(features, TUNED),
        }.items()
    }
    assert worth["naive"] < worth["middle"] - 0.1
    assert worth["tuned"] > worth["naive"] + 0.1
    assert abs(worth["centroid"] - worth["middle"]) < 0.08


def test_a_table_of_places_tries_where_the_rule_does(scenes, features):
    table = PlaceTable.draw("grasp", 500, seed=8)
    for weights in (TUNED, COLOURED, Weights(distance=1.0)):
        worths = scenes.try_places(rules.places(features, weights)).worth
        assert (table.worths(weights) == worths).mean() > 0.99  # sums in 32 and in 64 bits differ


@pytest.mark.parametrize("sees", FREE)
def test_tuning_searches_every_weight_and_beats_the_rule_of_defaults(sees, monkeypatch):
    monkeypatch.setattr("agents.grasping.tuning.GENERATIONS", 4)
    table = PlaceTable.draw("grasp", 400, seed=3)
    found = tune(table, FREE[sees], seed=0)
    searched = {name for name in TERMS if getattr(found, name) != 0.0}
    assert searched == {*TERMS} - ({"odd"} if sees == "depth" else set())
    assert found.rough_in + found.rough_out == pytest.approx(1.0)
    assert table.worths(found).mean() > table.worths(Weights()).mean() + 0.01
    assert tune(table, FREE[sees], seed=0) == found


def test_every_weight_of_the_shipped_rules_was_searched():
    assert all(getattr(TUNED, name) != 0.0 for name in TERMS if name != "odd")
    assert all(getattr(COLOURED, name) != 0.0 for name in TERMS)


def chances(count=2000):
    rng = np.random.default_rng(0)
    values = rng.normal(size=(count, len(NAMES)))
    chance = 1.0 / (1.0 + np.exp(-2.0 * values[:, 0] * values[:, 1]))
    return values, chance, (rng.random(count) < chance).astype(np.float64)


def test_a_network_learns_a_chance_and_keeps_it_in_a_file(tmp_path):
    pytest.importorskip("torch")
    values, chance, worth = chances()
    network = PlaceNetwork([0, 1, 5])
    assert not network.is_fitted
    network.fit(values, worth, seed=0, steps=250)
    assert np.corrcoef(network.predict(values), chance)[0, 1] > 0.8
    network.save(tmp_path / "places.npz")
    other = PlaceNetwork.load(tmp_path / "places.npz")
    assert same_bits(other.predict(values), network.predict(values))
    again = PlaceNetwork([0, 1, 5])
    again.fit(values, worth, seed=0, steps=250)
    assert same_bits(again.predict(values), network.predict(values))
    unseen = np.where(np.isin(np.arange(len(NAMES)), [0, 1, 5]), values, 100.0)
    assert same_bits(other.predict(unseen), network.predict(values))
    np.savez(tmp_path / "wide.npz", **{**network.state(), "columns": np.array([0, 1, 99])})
    np.savez(tmp_path / "less.npz", **{n: a for n, a in network.state().items() if n != "bias_1_of_2"})
    for name in ("less.npz", "wide.npz", "none.npz"):
        with pytest.raises(UsageError, match=r"holds no networks that choose places\Z"):
            PlaceNetwork.load(tmp_path / name)


@pytest.fixture
def few_steps(monkeypatch):
    """Networks of places learn in an eighth of the steps, after half as many tries."""
    for name, steps in (("STEPS", 400), ("QUICK_STEPS", 100), ("ROUND", 1000)):
        monkeypatch.setattr(f"agents.grasping.practice.{name}", steps)


@pytest.mark.usefixtures("few_steps")
def test_practice_finds_better_places_than_chance(scenes, features):
    pytest.importorskip("torch")
    practice = practise("grasp", 1200, seed=0)
    assert len(practice.held) == len(practice.values) == 1200
    first = 400
    assert practice.held[-300:].mean() > practice.held[:first].mean() + 0.15
    worth = scenes.try_places(network_places(features, practice.network)).worth.mean()
    assert worth > scenes.try_places(rules.flattest(features)).worth.mean() + 0.1
    maps = worth_maps(features, practice.network)
    assert maps.shape == (500, 48, 48)
    assert (maps >= 0.0).all()
    assert (maps <= 1.0).all()


@pytest.mark.usefixtures("few_steps")
def test_the_command_learns_saves_and_compares(tmp_path, capsys):
    pytest.importorskip("torch")
    main(Arguments(tries=300, judge=50, out=tmp_path / "places.npz"))
    text = capsys.readouterr().out
    assert PlaceNetwork.load(tmp_path / "places.npz").is_fitted
    assert all(name in text for name in ("centroid", "networks", "true surface", "grasp_unseen", "of the last"))
