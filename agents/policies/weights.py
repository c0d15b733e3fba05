"""Policies of stable-baselines3's models as arrays: see `agents.policies.actor` and `agents.policies.scorer`."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import torch
from gymnasium.spaces import Box, Dict, Discrete
from stable_baselines3 import TD3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.torch_layers import CombinedExtractor, NatureCNN

from ..ground.cli import UsageError
from .actor import Actor, Eye
from .networks import ACTIVATIONS, Convolution, Dense, Lstm, layers_from_torch
from .scorer import Scorer


def actor(model: BaseAlgorithm) -> Actor | Scorer:
    """The deterministic policy of a model, as arrays.

    Raises:
        UsageError: the policy is no network of full layers with one known activation, for observations in one vector or
            a picture with one.
    """
    policy, space = cast("Any", model.policy), model.observation_space
    if hasattr(policy, "numbers"):
        return policy.numbers()
    steps, bound = _layers(model)
    full, between = {type(step) for step in steps[::2]}, {type(step) for step in steps[1::2]}
    activations = [name for name in ACTIVATIONS if between <= {getattr(torch.nn, name)}]
    recurrent = getattr(policy, "lstm_actor", None)
    # A plain LSTM has one layer in one direction, with biases.
    form = ("num_layers", "proj_size", "bidirectional", "bias", "batch_first")
    plain = recurrent is None or [getattr(recurrent, name) for name in form] == [1, 0, False, True, False]
    eye = _eye_of(model) if isinstance(space, Dict) else None
    readable = eye is not None or (isinstance(space, Box) and len(space.shape) == 1)
    if full != {torch.nn.Linear} or not activations or not plain or not readable:
        raise UsageError(
            "the policy cannot be saved as arrays: its observation must be one vector, and its layers fully connected "
            f"(net_arch) with activation_fn one of {', '.join(ACTIVATIONS)} of torch.nn; a recurrent policy "
            "needs one plain LSTM before these layers"
        )
    lstm = None if recurrent is None else Lstm.from_torch(recurrent)
    layers = layers_from_torch(tensor for step in steps[::2] for tensor in (step.weight, step.bias))
    if isinstance(model.action_space, Discrete):
        low = np.full(int(model.action_space.n), np.finfo(np.float32).min, dtype=np.float32)
        return Actor(layers, activations[0], "scores", bound, low, -low)
    action_space = cast("Box", model.action_space)
    low, high = (np.asarray(end, dtype=np.float32) for end in (action_space.low, action_space.high))
    output = "squashed" if policy.squash_output else "clipped"
    return Actor(layers, activations[0], output, bound, low, high, lstm, eye)


def _eye_of(model: BaseAlgorithm) -> Eye | None:
    """What a policy sees in pictures by the extractor that is stable-baselines3's default; None for another one."""
    policy: Any = model.policy
    extractor = policy.features_extractor if isinstance(model, OnPolicyAlgorithm) else policy.actor.features_extractor
    seeing = extractor.extractors["image"] if isinstance(extractor, CombinedExtractor) else None
    if not isinstance(seeing, NatureCNN):
        return None
    arrays = [tensor.detach().numpy().copy() for tensor in seeing.parameters()]
    *convolutions, dense = zip(arrays[0::2], arrays[1::2], strict=True)
    return Eye(tuple(Convolution(*pair) for pair in convolutions), Dense(*dense))


def _layers(model: BaseAlgorithm) -> tuple[list[Any], float]:
    """Full layers of a policy with the activations between them, and the bound of the last layer's outputs."""
    policy: Any = model.policy
    if isinstance(model, OnPolicyAlgorithm):
        parts = [policy.mlp_extractor.policy_net, policy.action_net]
    else:
        parts = [policy.actor.mu] if isinstance(model, TD3) else [policy.actor.latent_pi, policy.actor.mu]
    steps = [step for part in parts for step in part.modules() if not isinstance(step, torch.nn.Sequential)]
    if isinstance(model, TD3):
        steps.pop()  # tanh, which other algorithms apply in their distribution
    return (steps[:-1], steps[-1].max_val) if isinstance(steps[-1], torch.nn.Hardtanh) else (steps, np.inf)  # gSDE
