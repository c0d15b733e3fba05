"""Finding settings: on shifts that no evaluation sees, each setting on the same ones, kept beside those of others."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
import yaml

from agents.dispatchers import registry
from agents.dispatchers import search as tuning
from agents.dispatchers.registry import line_core
from agents.dispatchers.rules import IndexRule, ScoreController
from agents.dispatchers.search import Bench
from agents.dispatchers.settings import FILE, rate, settings
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector, stream_seed
from agents.line import tune
from agents.line.tune import Arguments, main
from agents.policies.scorer import Scorer
from pnt_gym.cells.line.config import LineConfig
from tests.tools.commands import output_of

SHIPPED = ("single", "value", "speed", "line3", "skills3", "skills3_burst")


@pytest.fixture
def bench(short: str) -> Bench:
    return Bench(LineConfig.load(short), np.arange(5, 9))


@pytest.fixture
def pair(tmp_path: Path) -> Bench:
    """Two short shifts of robots that differ."""
    file = tmp_path / "pair.yaml"
    file.write_text("base: skills3\nname: pair\nduration: 5\n")
    return Bench(LineConfig.load(str(file)), np.arange(2))


def test_controllers_side_by_side_work_the_same_shifts_as_alone(bench: Bench) -> None:
    patiences = (0.3, 1.0, 8.0)
    together = bench.compare([IndexRule("atc", "atc", patience=k) for k in patiences])
    for k, values in zip(patiences, together, strict=True):
        for seed, value in zip(bench.seeds, values, strict=True):
            env = make_vector("PnTLine-v0", bench.level, 1, 1)
            alone = tuning.shift_values(IndexRule("atc", "atc", patience=k), env, np.array([seed]))
            assert alone[0] == value
    assert not np.array_equal(together[0], together[2])


def test_parts_of_what_does_not_fit_side_by_side_come_to_the_same(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = [{"patience": k} for k in (0.3, 1.0, 8.0)]
    whole = bench.try_rule("atc", tried)
    monkeypatch.setattr(tuning, "ROWS", 8)
    for one, other in zip(whole, bench.try_rule("atc", tried), strict=True):
        np.testing.assert_array_equal(one.value, other.value)


def test_progress_counts_every_shift_once(short: str) -> None:
    counted = list[float]()
    Bench(LineConfig.load(short), np.arange(3), counted.append).try_rule("atc", [{"patience": 1.0}, {"patience": 2.0}])
    assert sum(counted) == pytest.approx(6.0)
    assert len(counted) > 5


def test_no_shift_of_tuning_is_one_of_an_evaluation() -> None:
    first = stream_seed("practice", 0)
    tuned = set(range(first, first + 100_000))
    assert all(stream_seed("evaluate", seed) not in tuned for seed in range(100))


def test_shifts_of_a_search_are_others_every_time(bench: Bench) -> None:
    seeds = [bench.seeds, *(bench.other_shifts(4, number).seeds for number in range(3))]
    assert len(np.unique(np.concatenate(seeds))) == 16


def test_price_is_tuned_in_share_and_patience_where_somebody_comes_after(pair: Bench) -> None:
    tried = tuning.price(pair, 1.4)
    assert {one.settings["share"] for one in tried} == set(tuning.SHARE)
    assert {one.settings["patience"] for one in tried} == set(tuning.PATIENCE)
    told = [tuple(one.settings.values()) for one in tried]
    assert len(set(told)) == len(told)


def test_a_search_ends_with_weights_that_make_a_controller(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tuning, "EACH", 2)
    found, rule = tuning.weights(bench, 1.4, 2, 0)
    assert rule.settings == {"patience": 1.4, "weights": {}}
    assert set(found.settings["weights"]) == set(tuning.WEIGHED)
    again = bench.compare(
        [ScoreController("index", Scorer.linear(**found.settings)), IndexRule("atc", "atc", patience=1.4)]
    )
    np.testing.assert_array_equal(again, [found.value, rule.value])
    assert tuning.weights(bench, 1.4, 2, 0)[0].settings == found.settings
    weights = found.settings["weights"]
    on, begun = tuning.weights(bench, 1.4, 1, 1, weights)
    assert begun.settings == found.settings
    np.testing.assert_array_equal(begun.value, found.value)
    assert on.settings["weights"] != weights
    distance = [abs(on.settings["weights"][name] - weights[name]) for name in weights]
    assert max(distance) < 10 * tuning.SPREAD


def run(short: str, place: Path, **changes: Any) -> dict[str, Any]:
    arguments = Arguments(level=short, what=("atc",), shifts=32, out=place)
    main(replace(arguments, **changes))
    return yaml.safe_load(place.read_text())


def test_settings_are_kept_beside_those_of_others(short: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tuning, "PATIENCE", (0.5, 1.0))
    place = tmp_path / "rules.yaml"
    place.write_text("other: {atc: {patience: 3.0}}\nshort: {beam: {price: 1.1}, atc: {patience: 9.0}}\n")
    kept = run(short, place)
    assert kept["other"] == {"atc": {"patience": 3.0}}
    assert kept["short"]["beam"] == {"price": 1.1}
    assert kept["short"]["atc"]["patience"] in (0.5, 1.0)
    assert place.read_text().startswith("# Settings")


def test_what_is_kept_is_the_best_of_what_was_tried(
    short: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tuning, "PATIENCE", (0.5, 16.0))
    kept = run(short, tmp_path / "rules.yaml", json=tmp_path / "all.json")["short"]
    tried = json.loads((tmp_path / "all.json").read_text())["atc"]
    means = {one["patience"]: np.mean(one["value_per_min"]) for one in tried}
    assert kept["atc"]["patience"] == max(means, key=means.__getitem__)
    assert kept["rate"] == pytest.approx(max(means.values()) / 60.0, abs=1e-3)


def test_a_price_of_time_is_sought_about_what_the_rule_brings(
    short: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tuning, "PATIENCE", (1.0,))
    monkeypatch.setattr(tuning, "PRICE", (0.9,))
    monkeypatch.setattr(tune, "ENOUGH", 2)
    kept = run(short, tmp_path / "rules.yaml", what=("beam", "atc"), shifts=2)["short"]
    assert kept["beam"]["price"] == pytest.approx(0.9 * kept["rate"], abs=2e-3)


@pytest.mark.nightly
def test_the_beam_that_leaves_to_others_has_its_share_and_then_its_price_sought(pair: Bench) -> None:
    tried = tuning.planner(pair, "price_beam", 1.0)
    first, last = tried[: len(tuning.SHARES)], tried[len(tuning.SHARES) :]
    assert [one.settings for one in first] == [{"price": 1.0, "share": share} for share in tuning.SHARES]
    share = tuning.best(first).settings["share"]
    assert [one.settings for one in last] == [{"price": factor, "share": share} for factor in tuning.AROUND]


@pytest.mark.nightly
def test_what_a_guided_beam_makes_of_its_plans_is_sought_with_the_guide_that_the_level_has(pair: Bench) -> None:
    guide = "results/policies/PnTLine-v0/skills3/residual_ppo"
    for told, given in (({}, {}), ({"guide": guide, "trust": 3.0}, {"guide": guide})):
        with mock.patch("agents.dispatchers.settings.read_settings", return_value={"pair": {"guided_beam": told}}):
            tried = tuning.planner(pair, "guided_beam", 1.0)
        assert [one.settings for one in tried] == [{**given, "trust": trust} for trust in tuning.TRUST]


def test_settings_go_into_the_working_folder_where_rules_find_them(
    short: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tuning, "PATIENCE", (0.5,))
    shipped = FILE.read_bytes()
    level = str(tmp_path / "mine.yaml")
    Path(level).write_text(f"base: {short}\nname: mine\n")
    main(Arguments(level=level, what=("atc",), shifts=32))
    assert FILE.read_bytes() == shipped
    assert yaml.safe_load(Path("runs/line_rules.yaml").read_text())["mine"]["atc"] == {"patience": 0.5}
    assert (settings("mine", "atc"), settings("elsewhere", "atc")) == ({"patience": 0.5}, {"patience": 1.0})
    Path("runs/line_rules.yaml").write_text("single: {atc: {patience: 77.0}}")
    assert settings("single", "atc")["patience"] != 77.0


def test_few_shifts_are_shown_and_not_kept(short: str, tmp_path: Path) -> None:
    said = output_of(f"line tune --level {short} --what atc --shifts 2", tmp_path)
    assert "patience" in said
    assert "2 shifts are too few, so no settings were saved" in said
    assert not list(tmp_path.glob("*rules.yaml"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("short: [", "not valid YAML"),
        ("[short]", "not a file of settings"),
        ("short: 3", "not a file of settings"),
    ],
)
def test_a_damaged_file_of_settings_is_told_before_any_work(tmp_path: Path, short: str, text: str, said: str) -> None:
    (tmp_path / "rules.yaml").write_text(text)
    with mock.patch.object(tune, "try_settings", side_effect=AssertionError), pytest.raises(UsageError, match=said):
        run(short, tmp_path / "rules.yaml")


def test_a_planner_that_nobody_tuned_has_the_price_that_the_rule_brings() -> None:
    told = yaml.safe_load(FILE.read_text())
    told["line3"].pop("beam", None)
    with mock.patch("agents.dispatchers.settings.read_settings", return_value=told):
        assert settings("line3", "beam", 3) == {"price": round(told["line3"]["rate"] / 3, 3)}
        assert settings("nowhere", "beam", 3) == {}
    told["skills3"].pop("price_beam", None)
    with mock.patch("agents.dispatchers.settings.read_settings", return_value=told):
        assert settings("skills3", "price_beam", 3)["share"] == told["skills3"]["price"]["share"]


@pytest.mark.parametrize("level", SHIPPED)
def test_every_shipped_level_has_rules_that_were_tuned_for_it(level: str) -> None:
    assert FILE.is_file()
    assert 0.3 < (rate(level) or 0.0) < 10.0
    assert settings(level, "atc")["patience"] in tuning.PATIENCE
    assert settings(level, "price")["share"] in tuning.SHARE
    env = make_vector("PnTLine-v0", level, 1, 1)
    core = line_core(env)
    for name in ("atc", "price", "beam", "price_beam", "guided_beam", "index"):
        assert registry.make(name, core).name == name
    env.close()
