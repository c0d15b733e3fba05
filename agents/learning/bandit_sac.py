"""SAC for contextual bandits: what a discount factor of 0 makes superfluous is left out of each gradient step."""

from __future__ import annotations

from typing import Any, final

import numpy as np
import torch
from stable_baselines3 import SAC
from torch.nn import functional


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
        self.policy.set_training_mode(True)
        self._update_learning_rate([self.actor.optimizer, self.critic.optimizer, self.ent_coef_optimizer])
        losses = [self._step(batch_size) for _ in range(gradient_steps)]
        self._n_updates += gradient_steps
        self.logger.record("train/n_updates", self._n_updates, exclude="tensorboard")
        names = ("ent_coef_loss", "ent_coef", "critic_loss", "actor_loss")
        for name, values in zip(names, zip(*losses, strict=True), strict=True):
            self.logger.record(f"train/{name}", np.mean([value.item() for value in values]))

    def _step(self, batch_size: int) -> tuple[torch.Tensor, ...]:
        """Take one gradient step; losses of the entropy coefficient, critics and actor, and the coefficient."""
        batch: Any = self.replay_buffer.sample(batch_size, env=self._vec_normalize_env)  # type: ignore[union-attr]
        actions, log_prob = self.actor.action_log_prob(batch.observations)
        log_prob = log_prob.reshape(-1, 1)
        torch.normal(torch.zeros_like(actions), torch.ones_like(actions))  # as SAC draws actions of next observations
        ent_coef = torch.exp(self.log_ent_coef.detach())  # type: ignore[union-attr]
        ent_coef_loss = -(self.log_ent_coef * (log_prob + self.target_entropy).detach()).mean()
        _descend(self.ent_coef_optimizer, ent_coef_loss)
        values = self.critic(batch.observations, batch.actions)
        critic_loss = 0.5 * sum(functional.mse_loss(value, batch.rewards) for value in values)
        _descend(self.critic.optimizer, critic_loss)
        self.critic.requires_grad_(requires_grad=False)  # no gradients of weights that the actor's loss does not move
        least = torch.cat(self.critic(batch.observations, actions), dim=1).min(dim=1, keepdim=True).values
        actor_loss = (ent_coef * log_prob - least).mean()
        _descend(self.actor.optimizer, actor_loss)
        self.critic.requires_grad_(requires_grad=True)
        return ent_coef_loss.detach(), ent_coef, critic_loss.detach(), actor_loss.detach()


def _descend(optimizer: Any, loss: Any) -> None:
    """Take a step of an optimizer down the gradient of a loss."""
    optimizer.zero_grad()
    loss.backward()
    optimizer.step()
