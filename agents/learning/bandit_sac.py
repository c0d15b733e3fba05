"""SAC for contextual bandits: what a discount factor of 0 makes superfluous is left out of each gradient step."""

from __future__ import annotations

from typing import Any, Final, final

import numpy as np
import torch
from stable_baselines3 import SAC
from stable_baselines3.common.buffers import ReplayBuffer
from torch.nn import functional

LOSSES: Final = ("ent_coef_loss", "ent_coef", "critic_loss", "actor_loss")
"""Names of what a gradient step logs."""


@final
class BanditSAC(SAC):
    """SAC whose gradient steps compute no values of next observations while `gamma` is 0; nothing else changes.

    The target of the critics is then the reward alone. The target critics are neither asked nor moved, and the actor
    acts on no next observation. Random numbers are drawn as by `SAC`, so all other weights get the same bits.
    """

    def train(self, gradient_steps: int, batch_size: int = 64) -> None:
        """Take gradient steps on batches of the replay buffer."""
        if self.gamma != 0.0 or self.use_sde or self.ent_coef_optimizer is None:
            super().train(gradient_steps, batch_size)
            return
        # The means of the losses of all gradient steps are logged.
        self.policy.set_training_mode(True)
        self._update_learning_rate([self.actor.optimizer, self.critic.optimizer, self.ent_coef_optimizer])
        losses = [self._descend(batch_size) for _ in range(gradient_steps)]
        self._n_updates += gradient_steps
        self.logger.record("train/n_updates", self._n_updates, exclude="tensorboard")
        for name, values in zip(LOSSES, zip(*losses, strict=True), strict=True):
            self.logger.record(f"train/{name}", np.mean([value.item() for value in values]))

    def _descend(self, batch_size: int) -> tuple[Any, ...]:
        """Take one gradient step; returns the values of `LOSSES`."""
        observations, actions, rewards = self._sample(batch_size)
        chosen, log_prob = self.actor.action_log_prob(observations)
        log_prob = log_prob.reshape(-1, 1)
        torch.normal(torch.zeros_like(chosen), torch.ones_like(chosen))  # `SAC` draws actions of next observations here
        coefficient: Any = self.log_ent_coef
        entropy: Any = self.target_entropy
        ent_coef = torch.exp(coefficient.detach())
        ent_coef_loss = -(coefficient * (log_prob + entropy).detach()).mean()
        descend(self.ent_coef_optimizer, ent_coef_loss)
        values = self.critic(observations, actions)
        critic_loss: Any = 0.5 * sum(functional.mse_loss(value, rewards) for value in values)
        descend(self.critic.optimizer, critic_loss)
        least = torch.cat(self.critic(observations, chosen), dim=1).min(dim=1, keepdim=True).values
        actor_loss = (ent_coef * log_prob - least).mean()
        descend(self.actor.optimizer, actor_loss)
        return ent_coef_loss.detach(), ent_coef, critic_loss.detach(), actor_loss.detach()

    def _sample(self, count: int) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Observations (B, D), actions (B, A) and rewards (B, 1), of the throws that the buffer would sample."""
        memory: Any = self.replay_buffer
        plain = type(memory)._get_samples is ReplayBuffer._get_samples and not memory.optimize_memory_usage
        if not plain or self._vec_normalize_env is not None:
            batch = memory.sample(count, env=self._vec_normalize_env)
            return batch.observations, batch.actions, batch.rewards
        # The generator that stable-baselines3 draws from: rows of the buffer first, then environments.
        place = tuple(np.random.randint(0, most, size=count) for most in (memory.size(), memory.n_envs))  # noqa: NPY002
        columns = memory.observations, memory.actions, memory.rewards[..., None]
        observations, actions, rewards = (torch.from_numpy(column[place]) for column in columns)
        return observations, actions, rewards


def descend(optimizer: Any, loss: torch.Tensor) -> None:
    """Take a step of an optimizer down the gradient of a loss; no gradient of other weights is computed."""
    weights = optimizer.param_groups[0]["params"]
    for weight, gradient in zip(weights, torch.autograd.grad(loss, weights, allow_unused=True), strict=True):
        weight.grad = gradient
    optimizer.step()
