"""Learning from pictures with the policies of stable-baselines3: what a file computes, and what goes on."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

pytest.importorskip("stable_baselines3")

from agents.controllers import between, make_controller
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from agents.judging.loop import observed, throw_held_out
from agents.learning.hyperparameters import hyperparameters
from agents.learning.runs import RunFolder
from agents.learning.sb3 import build
from agents.learning.vec_env import SameStepVecEnv
from agents.policies import weights
from agents.policies.actor import Actor
from agents.train import Arguments, main
from tests.tools.throws import same_bits

LEVEL: dict[str, Any] = {"base": "grasp", "fidelity": "flight"}
ROWS = 8


@pytest.fixture
def cells() -> Iterator[Any]:
    with closing(make_vector("PnTGrasp-v0", LEVEL, ROWS, 1)) as env:
        yield env


def adapted(env: Any, over: str = "analytic") -> SameStepVecEnv:
    return SameStepVecEnv(between.wrap(env, {"algo": "sac", "stack": 1, "over": over}))


def settings(algo: str, **changes: Any) -> dict[str, Any]:
    return {**hyperparameters(algo, "PnTGrasp-v0"), **changes}


@pytest.mark.parametrize(("algo", "over"), [("sac", "analytic"), ("sac", "flattest"), ("ppo", "centroid")])
def test_a_policys_file_computes_what_the_model_does(algo: str, over: str, cells: Any, tmp_path: Path) -> None:
    env = adapted(cells, over)
    model = build(algo, env, settings(algo, batch_size=16), 0)
    seen = env.reset()
    action = model.predict(seen, deterministic=True)[0]
    assert np.abs(action).max() < 0.02
    weights.actor(model).save(tmp_path / "policy.npz")
    actor = Actor.load(tmp_path / "policy.npz")
    assert actor.sizes == (seen["vector"].shape[1], 6)
    np.testing.assert_allclose(actor(seen["vector"], seen["image"]), action, atol=1e-5)
    assert actor.eye is not None
    other = np.zeros_like(seen["image"])
    assert np.abs(actor.eye(other) - actor.eye(seen["image"])).max() > 1e-3


def test_eyes_that_do_not_fit_are_refused(cells: Any, tmp_path: Path) -> None:
    weights.actor(build("sac", adapted(cells), settings("sac"), 0)).save(tmp_path / "policy.npz")
    arrays = dict(np.load(tmp_path / "policy.npz"))
    for name, change in {
        "wide": {"eye_weight_1": np.zeros((64, 30, 4, 4), np.float32)},
        "near": {"eye_weight_2": np.zeros((64, 64, 2, 2), np.float32)},
        "short": {"eye_bias_0": np.zeros(1, np.float32)},
        "nan": {"eye_bias_0": np.full(32, np.nan, np.float32)},
    }.items():
        np.savez(tmp_path / f"{name}.npz", **{**arrays, **change})
        with pytest.raises(UsageError, match="truncated or holds no policy"):
            Actor.load(tmp_path / f"{name}.npz")


def test_a_training_of_pictures_goes_on_as_if_uninterrupted(tmp_path: Path) -> None:
    config = tmp_path / "small.yml"
    small = settings("sac", n_envs=ROWS, learning_starts=24, batch_size=16, gradient_steps=1, buffer_size=400)
    config.write_text(yaml.safe_dump({"PnTGrasp-v0": small}))
    asked = Arguments(
        env="PnTGrasp-v0", steps=96, checkpoint_every=48, config=config, eval_picks=0, over="centroid",
        fidelity="flight", out=tmp_path / "whole", threads=1,
    )  # fmt: skip
    main(asked)
    main(replace(asked, steps=48, out=tmp_path / "halves"))
    main(Arguments(resume=tmp_path / "halves", steps=96, eval_picks=0, threads=1))
    whole, halves = (RunFolder(tmp_path / name).actor().numbers for name in ("whole", "halves"))
    assert all(same_bits(whole[name], halves[name]) for name in whole)
    assert "eye_weight_0" in whole
    with closing(make_vector("PnTGrasp-v0", LEVEL, ROWS, 1)) as env:
        controller = make_controller(str(tmp_path / "whole"), env)
        throws = throw_held_out(controller, env, 16, 0)
        assert throws.picked.any()
        seen = observed(*env.reset(seed=0)[:1], np.zeros(ROWS))
        controller.reset(0)
        base = make_controller("centroid", env).act(seen)
        assert np.abs(controller.act(seen) - base).max() < 0.2


@pytest.mark.parametrize("options", [{"algo": "recurrent_ppo"}, {"algo": "td3"}, {"stack": 4}])
def test_what_does_not_learn_from_pictures_says_so(options: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="hold pictures; algorithms there are sac, ppo, with a stack of 1"):
        main(Arguments(env="PnTGrasp-v0", eval_picks=0, out=tmp_path / "run", **options))
