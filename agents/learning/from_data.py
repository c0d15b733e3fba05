"""Policies learned from throws that somebody else made: behaviour cloning, TD3+BC and IQL.

An action decides its own throw alone: later objects do not depend on the action. Therefore the value of an action is
the mean reward of its throw (discount 0), and a critic is a regression of the reward.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn.functional import mse_loss

from ..ground.fitting import fit_from
from ..policies import networks
from ..policies.networks import layers_from_torch

WIDTH: Final = 128
"""Units of each of two hidden layers."""
BATCH: Final = 256
CRITIC_STEPS: Final = 4000
POLICY_STEPS: Final = 2000
LEARNING_RATE: Final = 1e-3
GREED: Final = 2.5
"""alpha of TD3+BC: weight of the critic's value against nearness to the data (Fujimoto and Gu 2021, section 5)."""
EXPECTILE: Final = 0.7
"""tau of IQL: the value that a state's better actions reach (Kostrikov et al. 2021, appendix B, locomotion)."""
TEMPERATURE: Final = 3.0
"""beta of IQL: how strongly better actions are preferred (Kostrikov et al. 2021, appendix B, locomotion)."""
MOST_WEIGHT: Final = 100.0
"""Largest weight of an action in IQL's policy (Kostrikov et al. 2021, appendix B)."""

Function: TypeAlias = Callable[[NDArray[np.float32]], NDArray[np.float32]]
"""Observations (N, D) to actions (N, A), each from -1 to 1."""


class Lesson(NamedTuple):
    """N throws to learn from."""

    observations: NDArray[np.float32]
    """Observations before the throws (N, D)."""
    actions: NDArray[np.float32]
    """Actions (N, A), each from -1 to 1."""
    rewards: NDArray[np.float32]
    """Rewards (N,)."""


def behaviour_cloning(lesson: Lesson, seed: int) -> Function:
    """Policy that imitates the actions of the throws."""
    with fit_from(seed):
        states, actions, _ = map(torch.as_tensor, lesson)
        policy = _policy(lesson)
        _fit(policy, lambda rows: mse_loss(policy(states[rows]), actions[rows]), len(states), POLICY_STEPS)
        return _function(policy)


def td3_bc(lesson: Lesson, seed: int) -> Function:
    """Policy that a critic prefers and that stays near the actions of the throws (Fujimoto and Gu 2021, Eq. 5).

    Two critics and delayed updates serve TD3's bootstrapping. With discount 0 nothing is bootstrapped: one critic is
    fitted first, and the policy then.
    """
    with fit_from(seed):
        states, actions, _ = map(torch.as_tensor, lesson)
        (critic, centre, scale), policy = _train(lesson), _policy(lesson)

        def loss(rows: Tensor) -> Tensor:
            chosen = policy(states[rows])
            # In the unit of the reward, as in the paper: its mean decides how much the critic counts.
            value = centre + scale * critic(torch.cat([states[rows], chosen], 1))
            greed = GREED / value.abs().mean().detach()
            return mse_loss(chosen, actions[rows]) - greed * value.mean()

        _fit(policy, loss, len(states), POLICY_STEPS)
        return _function(policy)


def iql(lesson: Lesson, seed: int) -> Function:
    """Policy that imitates the better actions of the throws (Kostrikov et al. 2021, Eq. 5 to 7, discount 0)."""
    with fit_from(seed):
        states, actions, _ = map(torch.as_tensor, lesson)
        (critic, _, _), policy = _train(lesson), _policy(lesson)
        value = _network(states.shape[1], 1)
        with torch.no_grad():
            worth = critic(torch.cat([states, actions], 1))[:, 0]

        def loss(rows: Tensor) -> Tensor:
            excess = worth[rows] - value(states[rows])[:, 0]
            return ((EXPECTILE - (excess < 0.0).float()).abs() * excess.square()).mean()

        _fit(value, loss, len(states), POLICY_STEPS)
        with torch.no_grad():
            advantage = worth - value(states)[:, 0]
            weight = (TEMPERATURE * advantage / advantage.std()).exp().clamp(max=MOST_WEIGHT)

        _fit(
            policy,
            lambda rows: (weight[rows] * (policy(states[rows]) - actions[rows]).square().sum(1)).mean(),
            len(states),
            POLICY_STEPS,
        )
        return _function(policy)


def _train(lesson: Lesson) -> tuple[nn.Sequential, Tensor, Tensor]:
    """Critic that returns the standardised reward (N, 1) to expect of observations and actions (N, D + A).

    Mean and standard deviation of the rewards stand beside the critic.
    """
    states, actions, rewards = map(torch.as_tensor, lesson)
    centre, scale = rewards.mean(), rewards.std()
    target = (rewards - centre) / (scale + 1e-6)
    critic = _network(states.shape[1] + actions.shape[1], 1)
    inputs = torch.cat([states, actions], 1)
    _fit(critic, lambda rows: mse_loss(critic(inputs[rows])[:, 0], target[rows]), len(states), CRITIC_STEPS)
    return critic.requires_grad_(requires_grad=False), centre, scale


def _fit(network: nn.Module, loss_of: Callable[[Tensor], Tensor], count: int, steps: int) -> None:
    """Minimise a loss, which is a function of the chosen rows of `count`, by Adam with a cosine schedule."""
    optimiser = torch.optim.Adam(network.parameters(), lr=LEARNING_RATE)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    for _ in range(steps):
        optimiser.zero_grad()
        loss_of(torch.randint(count, (BATCH,))).backward()
        optimiser.step()
        schedule.step()


def _policy(lesson: Lesson) -> nn.Sequential:
    return nn.Sequential(*_network(lesson.observations.shape[1], lesson.actions.shape[1]), nn.Tanh())


def _network(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inputs, WIDTH), nn.SiLU(), nn.Linear(WIDTH, WIDTH), nn.SiLU(), nn.Linear(WIDTH, outputs)
    )


def _function(policy: nn.Sequential) -> Function:
    """The policy as a function of arrays, without torch."""
    parameters: Iterable[Any] = policy.parameters()
    layers = layers_from_torch(parameters, np.float64)
    return lambda observations: np.tanh(networks.run(layers, "SiLU", observations.astype(np.float64))).astype(
        np.float32
    )
