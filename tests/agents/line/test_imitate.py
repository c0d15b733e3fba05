"""Imitation: a scorer that is shown what a planner decides comes to decide like it."""

from pathlib import Path

import numpy as np

from agents.controllers.protocol import Observation
from agents.dispatchers.imitation import Labels, collect_labels, fit_scorer
from agents.dispatchers.rules import IndexRule
from agents.dispatchers.scored import ScoreController, choice_mask
from agents.ground.environments import make_vector
from agents.policies.scorer import Scorer
from tests.tools.commands import output_of


def lessons(expert: IndexRule, worker: IndexRule, level: str, shifts: int = 4) -> Labels:
    env = make_vector("PnTLine-v0", level, shifts, 1)
    found = collect_labels(expert, worker, env, np.arange(shifts))
    env.close()
    return found


def test_labels_are_what_the_expert_would_do_where_the_worker_is(short: str) -> None:
    expert, worker = IndexRule("a", "soonest"), IndexRule("b", "atc", patience=2.0)
    own, others = lessons(expert, expert, short), lessons(expert, worker, short)
    for labels in (own, others):
        seen = Observation(labels.observations, np.zeros(len(labels.observations), dtype=np.int64))
        np.testing.assert_array_equal(labels.choice, expert.act(seen))
        assert choice_mask(labels.observations)[np.arange(len(labels.choice)), labels.choice].all()
    assert own.observations.shape != others.observations.shape or not np.array_equal(
        own.observations, others.observations
    )


def test_labels_are_of_one_shift_in_each_line(short: str) -> None:
    seen = lessons(IndexRule("a", "soonest"), IndexRule("a", "soonest"), short).observations
    gone = seen[:, 0].reshape(-1)
    assert (gone == gone.min()).sum() == 4


def test_a_scorer_learns_a_rule_that_is_not_its_own(short: str) -> None:
    expert, level = IndexRule("a", "soonest"), short
    labels = lessons(expert, expert, level, 24)
    scorer, alike = fit_scorer(labels, 1.4, (32,), 0)
    fresh = lessons(expert, expert, "single", 1)
    seen = Observation(fresh.observations, np.zeros(len(fresh.observations), dtype=np.int64))
    share = (ScoreController("it", scorer).act(seen) == fresh.choice).mean()
    before = (ScoreController("it", Scorer.linear(1.4)).act(seen) == fresh.choice).mean()
    assert alike > 0.6
    assert share > max(0.6, before + 0.1)


def test_the_same_seed_learns_the_same(short: str) -> None:
    labels = lessons(IndexRule("a", "soonest"), IndexRule("a", "soonest"), short)
    one, two, other = (fit_scorer(labels, 1.4, (8,), seed)[0](labels.observations) for seed in (0, 0, 1))
    np.testing.assert_array_equal(one, two)
    assert not np.array_equal(one, other)


def test_the_command_leaves_a_scorer_that_evaluate_works_with(short: str, tmp_path: Path) -> None:
    said = output_of(f"line imitate --level {short} --of pair --shifts 3 --hidden 8 --eval-shifts 2", tmp_path)
    assert "round 2:" in said
    assert "imitation of pair" in said
    assert Scorer.load(tmp_path / "runs" / "pair-short.npz").activation == "Tanh"
    line = f"evaluate --env PnTLine-v0 --level {short} --shifts 2 --controller runs/pair-short.npz"
    assert "value per minute" in output_of(line, tmp_path)
