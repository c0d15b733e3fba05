"""Policies as numbers: they act as the models of stable-baselines3 that they are of, and carry nothing else."""

import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from stable_baselines3 import PPO, SAC, TD3
from torch import nn

from agents.ground.cli import UsageError
from agents.policies import weights
from agents.policies.actor import Actor
from agents.policies.networks import ACTIVATIONS, activate
from tests.tools.models import Space

LOW, HIGH = np.array([-2.0, -0.5], np.float32), np.array([1.0, 0.75], np.float32)
RESIDUAL = [SAC, TD3, PPO, "TQC"]
NETWORKS: list[dict[str, Any]] = [
    {},
    {"net_arch": [7], "activation_fn": nn.SiLU},
    {"net_arch": [9, 8, 7], "activation_fn": nn.Tanh},
    {"net_arch": {"pi": [5, 4], "qf": [3], "vf": [3]}, "activation_fn": nn.ELU},
    {"net_arch": []},
]


class Wide(Space):
    """Actions within bounds that are no mirror images."""

    observation_space = gym.spaces.Box(-5, 5, (6,), np.float32)
    action_space = gym.spaces.Box(LOW, HIGH, dtype=np.float32)


def model(algorithm: Any, settings: dict[str, Any], **more: Any) -> Any:
    """A model whose actions are spread over their range and, where they are clipped, beyond it."""
    if algorithm == "TQC":
        algorithm = pytest.importorskip("sb3_contrib").TQC
    return stirred(algorithm("MlpPolicy", Wide(), policy_kwargs=dict(settings), device="cpu", seed=1, **more))


def stirred(made: Any) -> Any:
    with torch.no_grad():
        for parameter in made.policy.parameters():
            parameter.add_(torch.randn_like(parameter), alpha=parameter.shape[-1] ** -0.5)
    return made


def seen(count: int = 2000) -> np.ndarray:
    scale = 10.0 ** np.linspace(-3.0, 0.5, count)
    return (np.random.default_rng(3).standard_normal((count, 6)) * scale[:, None]).astype(np.float32)


def assert_same(actor: Actor, made: Any) -> None:
    ours, theirs = actor(seen()), made.predict(seen(), deterministic=True)[0]
    assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype)
    assert (np.abs(ours - theirs) <= 1e-6 * (HIGH - LOW)).all()
    assert (np.ptp(ours, axis=0) > 0.04 * (HIGH - LOW)).all()


@pytest.mark.parametrize("settings", NETWORKS, ids=lambda s: str(s.get("net_arch", "default")))
@pytest.mark.parametrize("algorithm", RESIDUAL, ids=lambda a: getattr(a, "__name__", a))
def test_actions_are_the_models(algorithm: Any, settings: dict[str, Any], tmp_path: Path) -> None:
    made = model(algorithm, settings)
    weights.actor(made).save(tmp_path / "policy.npz")
    actor = Actor.load(tmp_path / "policy.npz")
    assert actor.sizes == (6, 2)
    assert_same(actor, made)


@pytest.mark.parametrize("name", ACTIVATIONS)
def test_every_activation_is_torchs(name: str) -> None:
    x = np.linspace(-40.0, 40.0, 4001)
    np.testing.assert_allclose(activate(name, x), getattr(nn, name)()(torch.tensor(x)).numpy(), rtol=0, atol=3e-9)
    assert_same(weights.actor(made := model(SAC, {"net_arch": [8, 8], "activation_fn": getattr(nn, name)})), made)


@pytest.mark.parametrize(
    ("algorithm", "settings"), [(SAC, {}), ("TQC", {"clip_mean": 0.1}), (PPO, {}), (PPO, {"squash_output": True})]
)
def test_state_dependent_exploration_bounds_and_squashes_as_there(algorithm: Any, settings: dict[str, Any]) -> None:
    made = model(algorithm, {"net_arch": [8], **settings}, use_sde=True)
    actor = weights.actor(made)
    assert actor.bound == (np.inf if algorithm is PPO else settings.get("clip_mean", 2.0))
    assert actor.output == ("clipped" if algorithm is PPO and not settings else "squashed")
    assert_same(actor, made)


RECURRENT: list[dict[str, Any]] = [
    {"lstm_hidden_size": 5, "net_arch": []},
    {"lstm_hidden_size": 16, "net_arch": [7], "activation_fn": nn.SiLU},
    {"lstm_hidden_size": 64, "net_arch": {"pi": [9, 8], "vf": [3]}, "shared_lstm": True, "enable_critic_lstm": False},
]


def recurrent(settings: dict[str, Any]) -> Any:
    """A recurrent model whose memory counts."""
    algorithm = pytest.importorskip("sb3_contrib").RecurrentPPO
    return stirred(algorithm("MlpLstmPolicy", Wide(), policy_kwargs=dict(settings), device="cpu", seed=1))


@pytest.mark.parametrize("settings", RECURRENT, ids=lambda s: str(s["lstm_hidden_size"]))
def test_a_recurrent_actor_remembers_as_the_model(settings: dict[str, Any], tmp_path: Path) -> None:
    """Through 60 steps of 7 rows, whose episodes begin anew at steps of their own."""
    made = recurrent(settings)
    weights.actor(made).save(tmp_path / "policy.npz")
    actor = Actor.load(tmp_path / "policy.npz")
    assert actor.sizes == (6, 2)
    random = np.random.default_rng(3)
    memory, state, forgotten = actor.initial_memory(7), None, actor.initial_memory(7)
    apart = []
    for step in range(60):
        rows, begin = random.standard_normal((7, 6)).astype(np.float32), (step + np.arange(7)) % 23 == 0
        theirs, state = made.predict(rows, state, begin, deterministic=True)
        memory[begin] = 0.0
        ours, memory = actor.act_with_memory(rows, memory)
        assert (ours.shape, ours.dtype) == (theirs.shape, theirs.dtype)
        assert (np.abs(ours - theirs) <= 1e-6 * (HIGH - LOW)).all()
        apart.append(np.abs(ours - actor.act_with_memory(rows, forgotten)[0]).max())
        np.testing.assert_array_equal(actor(rows), actor.act_with_memory(rows, forgotten)[0])
    assert np.median(apart) > 0.05, "what was before counts"


@pytest.mark.parametrize(
    "more", [{"n_lstm_layers": 2}, {"lstm_kwargs": {"proj_size": 3}}, {"lstm_kwargs": {"bias": False}}], ids=str
)
def test_other_recurrent_networks_are_refused(more: dict[str, Any]) -> None:
    made = pytest.importorskip("sb3_contrib").RecurrentPPO
    kwargs = {"lstm_hidden_size": 8, **more}
    with pytest.raises(UsageError, match="a recurrent policy needs one plain LSTM before these layers"):
        weights.actor(made("MlpLstmPolicy", Wide(), policy_kwargs=kwargs, device="cpu"))


LSTM_DAMAGES: list[dict[str, Any]] = [
    {"lstm_in": None}, {"lstm_kept": None}, {"lstm_bias": None}, {"lstm_in": np.zeros((20, 6))},
    {"lstm_in": np.zeros((19, 6), np.float32)}, {"lstm_kept": np.zeros((20, 4), np.float32)},
    {"lstm_bias": np.zeros(5, np.float32)}, {"lstm_bias": np.full(20, np.nan, np.float32)},
    {"lstm_in": np.zeros((0, 6), np.float32), "lstm_kept": np.zeros((0, 0), np.float32),
     "lstm_bias": np.zeros(0, np.float32)},
    {"weight_0": np.zeros((2, 6), np.float32)},
]  # fmt: skip


@pytest.mark.parametrize("changes", LSTM_DAMAGES, ids="-".join)
def test_what_is_no_lstm_is_refused(changes: dict[str, Any], tmp_path: Path) -> None:
    actor = weights.actor(recurrent(RECURRENT[0]))
    actor.save(tmp_path / "policy.npz")
    with np.load(tmp_path / "policy.npz") as file:
        whole = {**file, **changes}
    assert Actor.load(tmp_path / "policy.npz").lstm is not None
    np.savez(tmp_path / "policy.npz", **{name: value for name, value in whole.items() if value is not None})
    with pytest.raises(UsageError, match=r"policy\.npz is truncated or holds no policy"):
        Actor.load(tmp_path / "policy.npz")


def test_an_actor_is_of_its_moment_and_a_rows_action_is_its_own() -> None:
    made = model(SAC, {})
    actor = weights.actor(made)
    before = actor(seen())
    with torch.no_grad():
        made.policy.actor.mu.bias += 1.0
    np.testing.assert_array_equal(actor(seen()), before)
    np.testing.assert_array_equal(np.concatenate([actor(row[None]) for row in seen(200)]), actor(seen(200)))


class Halved(nn.Module):
    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return 0.5 * x


class ReLU(nn.Module):
    """Not that of torch.nn."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return torch.relu(x) + 0.001


@pytest.mark.parametrize("activation", [nn.PReLU, nn.Dropout, nn.Hardtanh, Halved, ReLU])
@pytest.mark.parametrize("algorithm", [SAC, TD3, PPO])
def test_other_networks_are_refused(algorithm: Any, activation: Any) -> None:
    with pytest.raises(UsageError, match="the policy cannot be saved as arrays: "):
        weights.actor(model(algorithm, {"net_arch": [8], "activation_fn": activation}))


@pytest.fixture
def actor() -> Actor:
    return weights.actor(model(TD3, {"net_arch": [8]}))


def parts(actor: Actor) -> dict[str, Any]:
    ((weight_0, bias_0), (weight_1, bias_1)) = actor.layers
    layers = {"weight_0": weight_0, "bias_0": bias_0, "weight_1": weight_1, "bias_1": bias_1}
    return {**layers, "activation": "ReLU", "output": "squashed", "bound": 1.0, "low": actor.low, "high": actor.high}


def other(**changes: Any) -> Callable[[Path, Actor], None]:
    """The parts of a policy but for some; None leaves one out."""

    def damage(file: Path, actor: Actor) -> None:
        changed = {
            **parts(actor),
            **{name: value(actor) if callable(value) else value for name, value in changes.items()},
        }
        np.savez(file, **{name: value for name, value in changed.items() if value is not None})

    damage.__name__ = "-".join(changes)
    return damage


def one_array(file: Path, actor: Actor) -> None:
    with file.open("wb") as out:
        np.save(out, actor.low)


FILES = {
    "torn": lambda file, _: file.write_bytes(file.read_bytes()[:-300]),
    "empty": lambda file, _: file.write_bytes(b""),
    "text": lambda file, _: file.write_text("weights"),
    "one array": one_array,
    "a pickle": lambda file, actor: file.write_bytes(pickle.dumps(actor)),
    "objects": lambda file, actor: np.savez(file, **{**parts(actor), "low": np.array([actor], dtype=object)}),
}
"""What makes no policy of a file."""
DAMAGES = [
    other(weight_0=None), other(weight_1=None), other(bias_1=None), other(low=None), other(activation=None),
    other(weight_0=lambda a: a.layers[0][0].T), other(weight_0=lambda a: a.layers[0][0].astype(np.float64)),
    other(weight_0=lambda a: a.layers[0][0] * np.float32(np.nan)), other(bias_0=lambda a: a.layers[0][1][:1]),
    other(bias_1=lambda a: a.layers[0][1]), other(weight_0=lambda a: a.layers[0][0][0]),
    other(weight_0=None, weight_1=None, bias_0=None, bias_1=None),
    other(activation="PReLU"), other(activation="__class__"), other(output="raw"), other(bound=0.0),
    other(bound=np.nan), other(low=lambda a: a.high), other(high=lambda a: a.high[:1]),
]  # fmt: skip


def test_the_parts_as_they_are_make_a_policy(actor: Actor, tmp_path: Path) -> None:
    other()(tmp_path / "policy.npz", actor)
    found = Actor.load(tmp_path / "policy.npz")
    np.testing.assert_array_equal(found(seen()), replace(actor, bound=1.0)(seen()))


@pytest.mark.parametrize("damage", [*FILES.values(), *DAMAGES], ids=[*FILES, *(d.__name__ for d in DAMAGES)])
def test_what_is_no_policy_is_refused(damage: Any, actor: Actor, tmp_path: Path) -> None:
    file = tmp_path / "policy.npz"
    actor.save(file)
    damage(file, actor)
    with pytest.raises(UsageError, match=r"policy\.npz' is damaged: policy\.npz is truncated or holds no policy"):
        Actor.load(file)
