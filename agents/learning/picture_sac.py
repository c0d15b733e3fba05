"""SAC that sees pictures: one extractor, which learns from the critics, and critics that look where the cup goes.

Actor and critics of `SAC` have an extractor each, and a gradient step runs these six times forward and four times
back. Here actor and critics share one, so a step takes a third of the time. The critics learn what a place is worth
from few tries, because they get the maps of the picture at that place.
"""

from __future__ import annotations

from typing import Any, NamedTuple, final

import torch
from stable_baselines3 import SAC
from stable_baselines3.common.policies import ContinuousCritic
from stable_baselines3.common.utils import polyak_update
from stable_baselines3.sac.policies import MultiInputPolicy
from torch import Tensor, nn
from torch.nn import functional

from pnt_gym.cells.grasp.config import PIXEL, PIXELS
from pnt_gym.cells.grasp.observation import TABLE

from .bandit_sac import descend, take_steps
from .pictures import WIDTHS, PictureExtractor


class Look(NamedTuple):
    """What an extractor sees in N pictures."""

    maps: Tensor
    """Maps before the last convolution (N, C, 12, 12)."""
    features: Tensor
    """(N, F)."""

    def detach(self) -> Look:
        """The same without gradients of the extractor."""
        return Look(self.maps.detach(), self.features.detach())


@final
class Ceiling(nn.Module):
    """A smooth upper bound of values.

    Args:
        highest: the bound.
    """

    def __init__(self, highest: float) -> None:
        super().__init__()
        self.highest = highest

    def forward(self, value: Tensor) -> Tensor:
        """Values that stay below the bound."""
        return self.highest - functional.softplus(self.highest - value)


@final
class PicturePolicy(MultiInputPolicy):
    """Policy of `PictureSAC`, which never explores more widely than `log_std_init` says.

    Critics that know little yet would widen it until nothing is held.

    Args:
        arguments: arguments of stable-baselines3's `MultiInputPolicy`.
        options: further arguments of `MultiInputPolicy`.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        chosen = {"features_extractor_class": PictureExtractor, **options, "share_features_extractor": True}
        super().__init__(*arguments, **chosen)

    def make_actor(self, features_extractor: Any = None) -> Any:
        """The actor, with bounded logarithms of standard deviations."""
        actor: Any = super().make_actor(features_extractor)
        actor.log_std = nn.Sequential(actor.log_std, Ceiling(actor.log_std_init)).to(self.device)
        return actor

    def make_critic(self, features_extractor: Any = None) -> ContinuousCritic:
        """Critics with further inputs: the maps at the place of an action."""
        kwargs = self._update_features_extractor(self.critic_kwargs, features_extractor)
        kwargs["features_dim"] += WIDTHS[-2]
        return ContinuousCritic(**kwargs).to(self.device)

    def _build(self, lr_schedule: Any) -> None:
        super()._build(lr_schedule)
        seeing = {id(weight) for weight in self.actor.features_extractor.parameters()}
        own = [weight for weight in self.actor.parameters() if id(weight) not in seeing]
        settings: dict[str, Any] = {"lr": lr_schedule(1), **self.optimizer_kwargs}
        optimizer_class: Any = self.optimizer_class
        self.actor.optimizer = optimizer_class(own, **settings)
        self.critic.optimizer = optimizer_class(list(self.critic.parameters()), **settings)


@final
class PictureSAC(SAC):
    """SAC whose extractor learns from the critics alone, and whose actor begins to learn after its critics.

    Before `learning_starts` steps nothing learns, and before twice as many the critics alone; it acts as its untrained
    policy until then.

    Args:
        arguments: arguments of `SAC`.
        pull: price of an action's mean per entry and of its square; critics know little of actions that are far from
            all tries, and without a price the first gradients lead there.
        options: further arguments of `SAC`.
    """

    reach: float = 0.1
    """Distance of the cup from the picture's middle for an action of 1 [m]."""

    def __init__(self, *arguments: Any, pull: float = 0.3, **options: Any) -> None:
        self.pull = pull
        super().__init__(*arguments, **options)

    def _sample_action(self, learning_starts: int, action_noise: Any = None, n_envs: int = 1) -> Any:
        del learning_starts  # actions from the whole space would grasp beside the object
        return super()._sample_action(0, action_noise, n_envs)

    def train(self, gradient_steps: int, batch_size: int = 64) -> None:
        """Take gradient steps on batches of the replay buffer."""
        take_steps(self, gradient_steps, batch_size)

    def _descend(self, batch_size: int) -> tuple[Any, ...]:
        """Take one gradient step; returns the values of `LOSSES`."""
        memory, coefficient, entropy = self.replay_buffer, self.log_ent_coef, self.target_entropy
        assert memory is not None and isinstance(coefficient, Tensor) and isinstance(entropy, float)
        batch: Any = memory.sample(batch_size)
        images, vectors = batch.observations["image"].float() / 255.0, batch.observations["vector"]
        look = _look(self.critic, images)
        seen = look.detach()
        chosen, log_prob, mean = self._act(seen, vectors)
        ent_coef = torch.exp(coefficient.detach())
        ent_coef_loss = -(coefficient * (log_prob + entropy).detach()).mean()
        target = self._target(batch, images, seen, ent_coef)
        critic_loss: Any = sum(
            functional.mse_loss(value, target) for value in self._values(self.critic, look, vectors, batch.actions)
        )
        descend(self.critic.optimizer, 0.5 * critic_loss)
        least = torch.cat(self._values(self.critic, seen, vectors, chosen), dim=1).min(dim=1, keepdim=True).values
        actor_loss = (ent_coef * log_prob - least).mean() + self.pull * mean.square().sum(dim=1).mean()
        if self.num_timesteps >= 2 * self.learning_starts:  # before, critics mislead the actor
            descend(self.ent_coef_optimizer, ent_coef_loss)
            descend(self.actor.optimizer, actor_loss)
        polyak_update(self.critic.parameters(), self.critic_target.parameters(), self.tau)
        return ent_coef_loss.detach(), ent_coef, critic_loss.detach(), actor_loss.detach()

    @torch.no_grad()
    def _target(self, batch: Any, images: Tensor, seen: Look, ent_coef: Tensor) -> Tensor:
        """Values (N, 1) that the critics should have; the picture after a step is the same."""
        vectors = batch.next_observations["vector"]
        action, log_prob, _ = self._act(seen, vectors)
        values = self._values(self.critic_target, _look(self.critic_target, images), vectors, action)
        least = torch.cat(values, dim=1).min(dim=1, keepdim=True).values - ent_coef * log_prob
        return batch.rewards + (1.0 - batch.dones) * self.gamma * least

    def _act(self, seen: Look, vectors: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Actions (N, A) of the policy, the logarithms of their densities (N, 1), and mean actions (N, A)."""
        actor: Any = self.actor
        latent = actor.latent_pi(torch.cat([seen.features, vectors], dim=1))
        spread = actor.log_std(latent).clamp(-20.0, 2.0)  # the bounds of stable-baselines3
        mean = actor.mu(latent)
        action, log_prob = actor.action_dist.log_prob_from_params(mean, spread)
        return action, log_prob.reshape(-1, 1), torch.tanh(mean)

    def _values(self, critic: Any, look: Look, vectors: Tensor, actions: Tensor) -> list[Tensor]:
        """Values (N, 1) of actions by each critic."""
        base = vectors[:, len(TABLE) :]  # action of the base controller, to which the policy's is added
        asked = (actions[:, :2] + base[:, :2]).clamp(-1.0, 1.0) if base.shape[1] > 0 else actions[:, :2]
        place = 2.0 * self.reach / (PIXEL * PIXELS) * asked * torch.tensor([1.0, -1.0])  # rows fall with y
        there = functional.grid_sample(look.maps, place[:, None, None], align_corners=False)[:, :, 0, 0]
        inputs = torch.cat([look.features, vectors, there, actions], dim=1)
        return [network(inputs) for network in critic.q_networks]


def _look(critic: Any, images: Tensor) -> Look:
    """What a critic's extractor sees in pictures (N, 5, 48, 48) as shares of 255."""
    return Look(*critic.features_extractor.look(images))
