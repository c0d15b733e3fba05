"""Scorers: the rule that they begin as, files of them, and what acts by them."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import torch

from agents.controllers.protocol import Observation
from agents.dispatchers import registry
from agents.dispatchers.rules import IndexRule, ScoreController, choice_mask
from agents.ground.cli import UsageError
from agents.learning.residual import Scoring, choices_of
from agents.policies.networks import Dense
from agents.policies.scorer import INPUTS, NAMES, Scorer, inputs, rule
from pnt_gym.cells.line.observation import LINE_TABLE, decoded
from tests.tools.line import observed, vector_lines

ROWS = 16


@pytest.fixture(scope="module")
def some() -> Iterator[list[Observation]]:
    env, _ = vector_lines("skills3_burst", ROWS)
    yield [seen for seen, _ in observed(env, 40)]
    env.close()


def random_scorer(seed: int = 0, patience: float = 1.7) -> Scorer:
    random = np.random.default_rng(seed)
    shapes = ((8, INPUTS), (4, 8), (1, 4))
    layers = tuple(
        Dense(random.normal(size=s).astype(np.float32), random.normal(size=s[0]).astype(np.float32)) for s in shapes
    )
    return Scorer(layers, patience)


@pytest.mark.parametrize("patience", [0.3, 1.4, 11.0])
def test_a_scorer_that_says_nothing_acts_as_the_rule(some: list[Observation], patience: float) -> None:
    by_score, by_rule = ScoreController("it", Scorer.linear(patience)), IndexRule("atc", "atc", patience=patience)
    for seen in some:
        np.testing.assert_array_equal(by_score.act(seen), by_rule.act(seen))


def test_scores_are_the_log_of_the_index_and_what_is_added(some: list[Observation]) -> None:
    seen = some[7].features
    choices = decoded(seen).choices
    expected = choices["ln_rate"] - choices["slack"] / 2.0 + 0.5 * inputs(seen)[..., NAMES.index("crowd")]
    np.testing.assert_allclose(Scorer.linear(2.0, {"crowd": 0.5})(seen), expected, rtol=0, atol=1e-9)


def test_what_a_choice_is_scored_does_not_depend_on_its_place(some: list[Observation]) -> None:
    seen, head = some[5].features.copy(), len(LINE_TABLE)
    turned = seen.copy()
    each = turned[:, head:].reshape(ROWS, 16, -1)
    turned[:, head:] = each[:, ::-1].reshape(ROWS, -1)
    scorer = random_scorer()
    np.testing.assert_allclose(scorer(turned), scorer(seen)[:, ::-1], rtol=0, atol=1e-12)


def test_who_goes_by_scores_takes_only_what_there_is(some: list[Observation]) -> None:
    worst = ScoreController("it", lambda seen: np.where(choice_mask(seen), -1e30, 0.0))
    for seen in some:
        chosen = worst.act(seen)
        assert choice_mask(seen.features)[np.arange(ROWS), chosen].all()


def test_what_there_is_is_what_the_mask_says() -> None:
    env, core = vector_lines("single", ROWS)
    for seen, info in observed(env, 20):
        np.testing.assert_array_equal(choice_mask(seen.features), core.masks())
        np.testing.assert_array_equal(choice_mask(seen.features), info["action_mask"])
    env.close()


def test_a_scorer_comes_back_from_its_file(some: list[Observation], tmp_path: Path) -> None:
    scorer = random_scorer()
    scorer.save(tmp_path / "it.npz")
    loaded = Scorer.load(tmp_path / "it.npz")
    assert loaded.patience == scorer.patience
    np.testing.assert_array_equal(loaded(some[0].features), scorer(some[0].features))


@pytest.mark.parametrize(
    "damage", ["nothing", "torn", "text", "inputs", "outputs", "patience", "nan", "activation", "gap", "object"]
)
def test_a_damaged_file_is_told_in_one_sentence(tmp_path: Path, damage: str) -> None:
    file, whole = tmp_path / "it.npz", random_scorer()
    whole.save(file)
    with np.load(file) as parts:
        found = dict(parts)
    if damage == "nothing":
        file.unlink()
    elif damage == "torn":
        file.write_bytes(file.read_bytes()[:300])
    elif damage == "text":
        file.write_text("weights")
    else:
        found |= {
            "inputs": {"weight_0": found["weight_0"][:, 1:]},
            "outputs": {"weight_2": np.ones((2, 4), np.float32), "bias_2": np.ones(2, np.float32)},
            "patience": {"patience": np.float64(0.0)},
            "nan": {"bias_1": np.full(4, np.nan, dtype=np.float32)},
            "activation": {"activation": np.array("Wobble")},
            "gap": {"weight_1": np.ones((4, 7), np.float32)},
            "object": {"weight_0": np.array([{}], dtype=object)},
        }[damage]
        np.savez(file, **found)
    with pytest.raises(UsageError, match=r"damaged|does not exist") as said:
        Scorer.load(file)
    assert "\n" not in str(said.value)


def test_an_index_weighs_only_entries_that_there_are() -> None:
    with pytest.raises(UsageError, match="'weight'"):
        Scorer.linear(1.0, {"weight": 1.0})


def test_the_network_that_learns_is_the_scorer_that_it_leaves(some: list[Observation]) -> None:
    torch.manual_seed(0)
    scoring, seen = Scoring(1.4, (16, 16)), some[3].features
    weight, constant = rule(1.4)
    np.testing.assert_allclose(
        scoring(choices_of(torch.as_tensor(seen))).detach(), inputs(seen) @ weight + constant, atol=1e-4
    )
    torch.nn.init.normal_(scoring.added[-1].weight)
    np.testing.assert_allclose(scoring(choices_of(torch.as_tensor(seen))).detach(), scoring.numbers()(seen), atol=1e-4)


def test_a_tuned_index_and_a_file_are_controllers_of_a_line(tmp_path: Path) -> None:
    env, core = vector_lines("single", 2)
    random_scorer().save(tmp_path / "mine.npz")
    assert registry.make(str(tmp_path / "mine.npz"), core).name == "mine"
    assert registry.make("index", core, weights={"wait": -0.1}).name == "index"
    with pytest.raises(UsageError, match="unknown controller of a line 'nobody'"):
        registry.make("nobody", core)
    env.close()
