"""Training on a line: it begins as the rule, resumes exactly, and leaves numbers that act as its model does."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm

from agents.controllers import make_controller
from agents.controllers.protocol import Observation
from agents.dispatchers import registry
from agents.dispatchers.registry import line_core
from agents.dispatchers.rules import choice_mask, run_scores
from agents.dispatchers.settings import rate, settings
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from agents.judging.shifts import run_shifts
from agents.learning.hyperparameters import MASKED
from agents.learning.runs import RunFolder
from agents.learning.vec_env import SameStepVecEnv
from agents.train import Arguments, main
from agents.training import session
from tests.tools.commands import figures_of, output_of
from tests.tools.models import weights

SMALL: dict[str, Any] = {
    "learning_rate": 0.003,
    "n_steps": 8,
    "batch_size": 32,
    "n_epochs": 2,
    "gamma": 0.9,
    "policy_kwargs": {"net_arch": [16]},
}
BOTH = pytest.mark.parametrize("algo", MASKED)


@pytest.fixture
def asked(tmp_path: Path, short: str) -> Arguments:
    config = tmp_path / "small.yml"
    config.write_text(yaml.safe_dump({"default": SMALL}))
    return Arguments(
        env="PnTLine-v0",
        level=short,
        algo="residual_ppo",
        steps=64,
        num_envs=4,
        checkpoint_every=32,
        out=tmp_path / "run",
        config=config,
        eval_picks=0,
    )


def of_rule(level: str) -> tuple[Any, Any]:
    env = make_vector("PnTLine-v0", level, 4, 1)
    core = line_core(env)
    return env, registry.make("atc", core)


@pytest.mark.parametrize("level", ["value", "skills3_burst"])
def test_before_it_learns_a_residual_is_the_tuned_rule(asked: Arguments, tmp_path: Path, level: str) -> None:
    main(replace(asked, level=level, steps=1))
    untrained = run_scores(tmp_path / "run", RunFolder(tmp_path / "run").checkpoints[0])
    env, rule = of_rule(level)
    assert rule.patience == settings(level, "atc")["patience"]
    features, _ = env.reset(seed=7)
    for _ in range(120):
        seen = Observation(np.array(features, dtype=np.float32), np.zeros(4, dtype=np.int64))
        action = rule.act(seen)
        np.testing.assert_array_equal(untrained.act(seen), action)
        features, *_ = env.step(action)


@BOTH
def test_what_is_kept_acts_as_its_model(asked: Arguments, tmp_path: Path, algo: Any) -> None:
    main(replace(asked, algo=algo))
    env, rule = of_rule("value")
    features, _ = env.reset(seed=1)
    for checkpoint in (None, *RunFolder(tmp_path / "run").checkpoints):
        model, kept = RunFolder(tmp_path / "run").load(None, checkpoint), run_scores(tmp_path / "run", checkpoint)
        for _ in range(10):
            seen = Observation(np.array(features, dtype=np.float32), np.zeros(4, dtype=np.int64))
            theirs, _ = model.predict(seen.features, deterministic=True, action_masks=choice_mask(seen.features))
            np.testing.assert_array_equal(kept.act(seen), theirs)
            features, *_ = env.step(rule.act(seen))


@BOTH
def test_a_resumed_run_is_bit_for_bit_the_uninterrupted_one(asked: Arguments, tmp_path: Path, algo: Any) -> None:
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    main(replace(asked, algo=algo, out=whole))
    main(replace(asked, algo=algo, out=halves, steps=32))
    main(Arguments(resume=halves, steps=64, eval_picks=0))
    assert RunFolder(halves).load().num_timesteps == 64
    pairs = list(zip(weights(whole), weights(halves), strict=True))
    assert all(np.array_equal(a, b) for a, b in pairs)
    before = weights(whole, RunFolder(whole).checkpoints[0])
    assert not all(np.array_equal(a, b) for a, (b, _) in zip(before, pairs, strict=True)), "nothing was learned"


def test_a_learning_rate_falls_over_all_legs(asked: Arguments, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert asked.config is not None
    asked.config.write_text(yaml.safe_dump({"default": SMALL | {"learning_rate": "lin_0.008"}}))
    rates: list[tuple[int, float]] = []
    update = OnPolicyAlgorithm._update_learning_rate

    def noted(self: Any, optimizer: Any) -> None:
        update(self, optimizer)
        rates.append((self.num_timesteps, optimizer.param_groups[0]["lr"]))

    monkeypatch.setattr(OnPolicyAlgorithm, "_update_learning_rate", noted)
    main(replace(asked, steps=128))
    # Legs of 32 decisions, in rollouts of 8 x 4.
    assert [count for count, _ in rates] == [32, 64, 96, 128]
    np.testing.assert_allclose([rate for _, rate in rates], [0.006, 0.004, 0.002, 0.0], atol=1e-12)


def test_the_table_at_the_end_compares_with_rules_on_the_shifts_of_evaluate(asked: Arguments, tmp_path: Path) -> None:
    what = f"--env PnTLine-v0 --level {asked.level} --algo maskable_ppo --config {asked.config}"
    said = output_of(f"train {what} --steps 32 --num-envs 4 --out run --eval-picks 3", tmp_path)
    assert "value/min" in said
    assert (tmp_path / "run" / "progress.csv").read_text().startswith("throws,seconds,success_rate,value_per_min,")
    table = json.loads((tmp_path / "run" / "evaluation.json").read_text())
    assert [row["controller"] for row in table] == ["fifo", "atc", "maskable_ppo"]
    for name, row in (("atc", table[1]), (str(tmp_path / "run"), table[2])):
        found = figures_of(f"evaluate --env PnTLine-v0 --level {asked.level} --controller {name} --shifts 3", tmp_path)
        assert found["by_shift"]["value_per_min"] == row["by_shift"]["value_per_min"]


def test_a_run_is_judged_on_its_own_level_unless_another_is_asked_for(asked: Arguments, tmp_path: Path) -> None:
    main(asked)
    found = figures_of("evaluate --controller run --shifts 2", tmp_path)
    assert (found["level"], found["env"]) == ("short", "PnTLine-v0")


def test_settings_of_the_line_are_noted_in_the_run(asked: Arguments, tmp_path: Path) -> None:
    main(replace(asked, level="value", steps=1))
    noted = yaml.safe_load((tmp_path / "run" / "config.yml").read_text())["PnTLine-v0"]
    assert noted["patience"] == settings("value", "atc")["patience"]
    assert noted["price_of_time"] == rate("value")
    assert noted["gamma"] == 0.9
    main(replace(asked, level="line3", steps=1, out=tmp_path / "three"))
    main(Arguments(resume=tmp_path / "three", steps=33, eval_picks=0))
    noted = yaml.safe_load((tmp_path / "three" / "config.yml").read_text())["PnTLine-v0"]
    assert noted["gamma"] == pytest.approx(0.9 ** (1 / 3), abs=1e-5)
    assert RunFolder(tmp_path / "three").load().gamma == noted["gamma"]


def test_a_second_costs_what_training_says() -> None:
    plain, dear = (SameStepVecEnv(make_vector("PnTLine-v0", "single", 4, 1), price=price) for price in (0.0, 0.5))
    for env in (plain, dear):
        env.seed(3)
        env.reset()
    for _ in range(5):
        _, reward, _, infos = plain.step(np.zeros(4, dtype=np.int64))
        _, less, _, _ = dear.step(np.zeros(4, dtype=np.int64))
        np.testing.assert_allclose(reward - less, [0.5 * info["dt"] for info in infos], atol=1e-6)
    plain.close()
    dear.close()


def test_masks_are_those_of_each_row() -> None:
    env = SameStepVecEnv(make_vector("PnTLine-v0", "value", 4, 1))
    env.seed(3)
    env.reset()
    core = line_core(env.env)
    assert env.has_attr("action_masks")
    np.testing.assert_array_equal(np.stack(env.env_method("action_masks")), core.masks())
    np.testing.assert_array_equal(env.env_method("action_masks", indices=[2])[0], core.masks()[2])
    env.close()
    other = SameStepVecEnv(make_vector("ToyThrow-v0", "waste", 2))
    assert not other.has_attr("action_masks")


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"patience": -1.0}, "hyperparameter patience is -1.0"),
        ({"price_of_time": -1.0}, "hyperparameter price_of_time is -1.0"),
        ({"policy_kwargs": {"sharpness": -1.0}}, "hyperparameter sharpness is -1.0"),
        ({"policy": "MlpPolicy"}, "residual_ppo has a policy of its own"),
    ],
)
def test_a_wrong_setting_of_the_line_is_told(
    asked: Arguments, tmp_path: Path, wrong: dict[str, Any], said: str
) -> None:
    (tmp_path / "small.yml").write_text(yaml.safe_dump({"default": {**SMALL, **wrong}}))
    with pytest.raises(UsageError, match=said):
        main(asked)
    assert not (tmp_path / "run").exists()


def test_a_run_whose_price_is_damaged_is_told(asked: Arguments, tmp_path: Path) -> None:
    main(replace(asked, steps=1))
    file = tmp_path / "run" / "config.yml"
    file.write_text(file.read_text().replace("price_of_time: 1.0", "price_of_time: dear"))
    with pytest.raises(UsageError, match="hyperparameter price_of_time is 'dear'"):
        main(Arguments(resume=tmp_path / "run", steps=64, eval_picks=0))


def test_a_policy_that_chooses_is_refused_where_throws_are_corrected(asked: Arguments, tmp_path: Path) -> None:
    main(replace(asked, steps=1))
    with pytest.raises(UsageError, match="is of a policy that chooses"):
        make_controller(str(tmp_path / "run"), make_vector("ToyThrow-v0", "waste", 2))


def test_a_policy_that_corrects_throws_is_refused_on_a_line(tmp_path: Path) -> None:
    config = tmp_path / "small.yml"
    small = {"policy": "MlpPolicy", "n_steps": 8, "batch_size": 16, "n_epochs": 1, "policy_kwargs": {"net_arch": [8]}}
    config.write_text(yaml.safe_dump({"default": small}))
    begun = Arguments(env="ToyThrow-v0", level="waste", algo="ppo", steps=16, num_envs=2, config=config, eval_picks=0)
    main(replace(begun, out=tmp_path / "run"))
    with pytest.raises(UsageError, match="has 26 inputs and 2 outputs"):
        run_scores(tmp_path / "run")


@pytest.mark.nightly
def test_it_learns_what_a_rule_does_not_know(asked: Arguments, tmp_path: Path) -> None:
    """From a rule with the wrong patience, which leaves much to be learned at once."""
    wrong = {**SMALL, "n_steps": 32, "batch_size": 256, "n_epochs": 5, "patience": 200.0, "price_of_time": 1.8}
    (tmp_path / "small.yml").write_text(yaml.safe_dump({"default": wrong}))
    main(replace(asked, level="value", steps=10000, num_envs=16, checkpoint_every=10000))
    env = make_vector("PnTLine-v0", "value", 16, 1)
    first, *_, last = RunFolder(tmp_path / "run").checkpoints
    before, after = (run_shifts(run_scores(tmp_path / "run", place), env, 16, 5).value for place in (first, last))
    env.close()
    assert (after - before).mean() > 2.0


def test_defaults_of_a_line_are_its_own() -> None:
    asked, _ = session.resolve(vars(Arguments(env="PnTLine-v0")))
    assert (asked["algo"], asked["steps"], asked["num_envs"]) == ("residual_ppo", 500_000, 256)
    asked, _ = session.resolve(vars(Arguments()))
    assert (asked["algo"], asked["steps"], asked["num_envs"]) == ("sac", 10_000, 16)


def test_hyperparameters_say_how_long_and_in_how_many_cells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    given = Arguments(env="PnTLine-v0", config=Path("configs/rl/residual_ppo_long.yml"))
    asked, settings = session.resolve(vars(given))
    assert (asked["steps"], asked["num_envs"], settings["n_steps"]) == (2_000_000, 128, 128)
    asked, _ = session.resolve(vars(replace(given, steps=5, num_envs=3)))
    assert (asked["steps"], asked["num_envs"]) == (5, 3)
    Path("own.yml").write_text("default: {n_timesteps: !!float 1e5, gamma: 0.5}\n")
    asked, settings = session.resolve(vars(replace(given, config=Path("own.yml"))))
    assert (asked["steps"], asked["num_envs"], settings["gamma"]) == (100_000, 256, 0.5)
    for value in ("0", "1.5", "many", "true"):
        Path("own.yml").write_text(f"default: {{n_timesteps: {value}}}\n")
        with pytest.raises(UsageError, match=r"hyperparameter n_timesteps is .*; it must be"):
            session.resolve(vars(replace(given, config=Path("own.yml"))))
