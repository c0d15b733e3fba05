"""Learning from pictures: what an extractor sees, what a buffer keeps, and what a policy's file computes."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

pytest.importorskip("stable_baselines3")
import torch
from torch import nn
from torch.nn import functional

from agents.controllers import make_controller
from agents.controllers.between import wrap_env
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from agents.judging.loop import observed, throw_held_out
from agents.learning.hyperparameters import hyperparameters
from agents.learning.picture_sac import Look, PictureSAC
from agents.learning.runs import RunFolder
from agents.learning.sb3 import build
from agents.learning.vec_env import SameStepVecEnv
from agents.policies.actor import Actor
from agents.policies.networks import Convolution, join_squares, split_squares
from agents.policies.weights import actor_of
from agents.train import Arguments, main
from tests.tools.throws import same_bits

LEVEL: dict[str, Any] = {"base": "grasp", "fidelity": "flight"}
ROWS = 8


@pytest.fixture
def cells() -> Iterator[Any]:
    with closing(make_vector("PnTGrasp-v0", LEVEL, ROWS, 1)) as env:
        yield env


def adapted(env: Any, over: str = "analytic") -> SameStepVecEnv:
    return SameStepVecEnv(wrap_env(env, {"algo": "sac", "stack": 1, "over": over}))


def settings(algo: str, **changes: Any) -> dict[str, Any]:
    return {**hyperparameters(algo, "PnTGrasp-v0"), **changes}


def test_convolutions_and_squares_are_those_of_torch() -> None:
    random = np.random.default_rng(0)
    maps = random.standard_normal((3, 4, 8, 12))
    weight, bias = random.standard_normal((5, 4, 3, 3)), random.standard_normal(5)
    theirs = functional.conv2d(*map(torch.as_tensor, (maps, weight, bias)), padding=1).numpy()
    np.testing.assert_allclose(Convolution(weight, bias)(maps), theirs, atol=1e-12)
    joined = join_squares(maps, 4)
    assert same_bits(joined, nn.PixelUnshuffle(4)(torch.as_tensor(maps)).numpy())
    assert same_bits(split_squares(joined, 4), maps)


@pytest.mark.parametrize(("algo", "over"), [("sac", "analytic"), ("sac", "flattest"), ("ppo", "centroid")])
def test_a_policys_file_computes_what_the_model_does(algo: str, over: str, cells: Any, tmp_path: Path) -> None:
    env = adapted(cells, over)
    model = build(algo, env, settings(algo, batch_size=16), 0)
    seen = env.reset()
    action = model.predict(seen, deterministic=True)[0]
    assert np.abs(action).max() < 0.02
    actor_of(model).save(tmp_path / "policy.npz")
    actor = Actor.load(tmp_path / "policy.npz")
    assert actor.sizes == (seen["vector"].shape[1], 6)
    np.testing.assert_allclose(actor(seen["vector"], seen["image"]), action, atol=1e-5)
    assert actor.eye is not None
    other = np.zeros_like(seen["image"])
    assert np.abs(actor.eye(other) - actor.eye(seen["image"])).max() > 1e-3


def test_eyes_that_do_not_fit_are_refused(cells: Any, tmp_path: Path) -> None:
    actor_of(build("sac", adapted(cells), settings("sac"), 0)).save(tmp_path / "policy.npz")
    arrays = dict(np.load(tmp_path / "policy.npz"))
    for name, change in {
        "wide": {"eye_weight_1": np.zeros((24, 30, 3, 3), np.float32)},
        "even": {"eye_weight_1": np.zeros((24, 32, 2, 2), np.float32)},
        "nan": {"eye_bias_0": np.full(32, np.nan, np.float32)},
    }.items():
        np.savez(tmp_path / f"{name}.npz", **{**arrays, **change})
        with pytest.raises(UsageError, match="truncated or holds no policy"):
            Actor.load(tmp_path / f"{name}.npz")


def test_the_buffer_keeps_steps_with_one_picture_each(cells: Any) -> None:
    """What it returns is what happened: the picture stays, the vector moves on, and rewards come at a pick's end."""
    env = adapted(cells)
    model: Any = build("sac", env, settings("sac", buffer_size=40 * ROWS), 0)
    buffer, before = model.replay_buffer, env.reset()
    assert buffer.images.dtype == np.uint8
    steps = []
    for k in range(6):
        action = np.full((ROWS, 6), 0.01 * k, dtype=np.float32)
        after, reward, done, infos = env.step(action)
        buffer.add(before, after, action, reward, done, infos)
        steps.append((before, after, action, reward, np.array(["cycle_time" in info for info in infos])))
        before = after
    ends = np.array([step[4] for step in steps])
    assert 0.0 < ends.mean() < 1.0
    assert (buffer.rewards[:6][~ends] == 0.0).all()
    batch = buffer.sample(300)
    assert same_bits(batch.observations["image"].numpy(), batch.next_observations["image"].numpy())
    for n in range(300):
        k = round(float(batch.actions[n, 0]) / 0.01)
        seen, later, _, reward, over = steps[k]
        (row,) = np.flatnonzero((seen["vector"] == batch.observations["vector"][n].numpy()).all(axis=1))
        assert same_bits(batch.observations["image"][n].numpy(), seen["image"][row])
        assert (float(batch.rewards[n, 0]), float(batch.dones[n, 0])) == (reward[row], over[row])
        if not over[row]:
            assert same_bits(seen["image"][row], later["image"][row])
            assert same_bits(batch.next_observations["vector"][n].numpy(), later["vector"][row])


def test_the_actor_waits_for_its_critics_and_the_eye_learns_from_them(cells: Any) -> None:
    model: Any = build(
        "sac", adapted(cells), settings("sac", learning_starts=4 * ROWS, batch_size=16, gradient_steps=1), 0
    )
    assert isinstance(model, PictureSAC)
    assert model.actor.features_extractor is model.critic.features_extractor

    def copy(module: Any) -> list[Any]:
        return [weight.detach().clone() for weight in module.parameters()]

    head, eye = copy(model.actor.mu), copy(model.actor.features_extractor)
    model.learn(7 * ROWS)
    assert all(map(torch.equal, head, copy(model.actor.mu)))
    assert not any(map(torch.equal, eye, copy(model.actor.features_extractor)))
    model.learn(4 * ROWS, reset_num_timesteps=False)
    assert not any(map(torch.equal, head, copy(model.actor.mu)))


def test_critics_look_where_the_cup_goes(cells: Any) -> None:
    """The maps are read at the place of base action and action together, with rows that fall from large y to small."""
    model: Any = build("sac", adapted(cells, "flattest"), settings("sac"), 0)
    maps = torch.zeros((1, 24, 12, 12))
    maps[0, :, 3, 8] = 1.0  # middle at x = 2.5 squares of 20 mm, y = 2.5 squares
    seen = torch.zeros((1, 48))

    def inputs(base: list[float], action: list[float]) -> float:
        vectors, actions = torch.zeros((1, 38)), torch.zeros((1, 6))
        vectors[0, 32:34], actions[0, :2] = torch.tensor(base), torch.tensor(action)
        kept: list[Any] = []

        class Critic:
            q_networks = (kept.append,)

        model._values(Critic, Look(maps, seen), vectors, actions)
        return float(kept[0][0, 48 + 38 : 48 + 38 + 24].mean())

    assert inputs([0.0, 0.0], [0.5, 0.5]) == pytest.approx(1.0, abs=1e-5)
    assert inputs([0.2, 0.3], [0.3, 0.2]) == pytest.approx(1.0, abs=1e-5)
    assert inputs([0.0, 0.0], [0.5, -0.5]) == 0.0
    assert inputs([0.0, 0.0], [0.4, 0.5]) == pytest.approx(0.5, abs=1e-5)


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
    whole, halves = (RunFolder(tmp_path / name).load_actor().numbers for name in ("whole", "halves"))
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
