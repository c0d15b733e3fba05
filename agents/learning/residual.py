"""The policy of residual PPO: a trainable scorer as actor, and a network for the value of coming decisions."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Final, final

import torch
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from torch import Tensor, nn

from pnt_gym.cells.line.observation import CHOICE_TABLE, LINE_TABLE
from pnt_gym.cells.line.rows import CHOICES

from ..policies.networks import layers_from_torch
from ..policies.scorer import INPUTS, NAMES, Scorer, rule

WIDTHS: Final = (64, 64)
"""Default widths of a scorer's hidden layers."""


def choices_of(observations: Tensor) -> Tensor:
    """Inputs of a scorer for each choice (N, CHOICES, INPUTS), from observations (N, ENTRIES)."""
    head = len(LINE_TABLE)
    choices = observations[:, head:].reshape(-1, CHOICES, len(CHOICE_TABLE))
    return torch.cat([choices, observations[:, None, :head].expand(-1, CHOICES, -1)], dim=-1)


@final
class Scoring(nn.Module):
    """A trainable scorer: log of the ATC index plus a network; untrained the scorer is the ATC rule.

    Args:
        patience: patience of the ATC rule [s].
        widths: widths of the hidden layers.
    """

    def __init__(self, patience: float, widths: tuple[int, ...] = WIDTHS) -> None:
        super().__init__()
        self.patience = patience
        weight, constant = rule(patience)
        self.weight: Tensor
        self.register_buffer("weight", torch.as_tensor(weight, dtype=torch.float32), persistent=False)
        self.constant = constant
        layers = [nn.Linear(before, after) for before, after in pairwise((INPUTS, *widths, 1))]
        for layer in layers:
            nn.init.orthogonal_(layer.weight, 2.0**0.5)
            nn.init.zeros_(layer.bias)
        nn.init.zeros_(layers[-1].weight)
        between = [part for layer in layers[:-1] for part in (layer, nn.Tanh())]
        self.added = nn.Sequential(*between, layers[-1])

    def forward(self, inputs: Tensor) -> Tensor:
        """Scores (N, CHOICES) of choices with inputs (N, CHOICES, INPUTS)."""
        return inputs @ self.weight + self.constant + self.added(inputs)[..., 0]

    def numbers(self) -> Scorer:
        """The present scorer as NumPy arrays."""
        return Scorer(layers_from_torch(self.added.parameters()), self.patience)


@final
class LineEncoder(nn.Module):
    """Encoder of a line for the value function: mean and maximum of its encoded choices, and the line's entries.

    Args:
        width: number of features of each choice, and of the result.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.each = nn.Sequential(nn.Linear(INPUTS, width), nn.Tanh())
        self.whole = nn.Sequential(nn.Linear(2 * width + len(LINE_TABLE), width), nn.Tanh())

    def forward(self, inputs: Tensor) -> Tensor:
        """Features (N, width) of choices with inputs (N, CHOICES, INPUTS)."""
        real, features = inputs[..., NAMES.index("real"), None], self.each(inputs)
        mean = (features * real).sum(dim=1) / real.sum(dim=1).clamp(min=1.0)
        maximum = (features * real).amax(dim=1)
        return self.whole(torch.cat([mean, maximum, inputs[:, 0, len(CHOICE_TABLE) :]], dim=-1))


@final
class ActorCriticExtractor(nn.Module):
    """Actor and critic of the policy, by the names that stable-baselines3 calls.

    Args:
        scoring: returns the logits.
        outlook: returns the features for the value function.
        sharpness: factor on the scores; with 1 an untrained policy draws choices in proportion to their ATC indices.
    """

    def __init__(self, scoring: Scoring, outlook: LineEncoder, sharpness: float) -> None:
        super().__init__()
        self.scoring, self.outlook, self.sharpness = scoring, outlook, sharpness

    def forward(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Logits, and features for the value function."""
        return self.forward_actor(observations), self.forward_critic(observations)

    def forward_actor(self, observations: Tensor) -> Tensor:
        """Logits (N, CHOICES) for observations (N, ENTRIES)."""
        return self.sharpness * self.scoring(choices_of(observations))

    def forward_critic(self, observations: Tensor) -> Tensor:
        """Features (N, width) for the value function."""
        return self.outlook(choices_of(observations))


@final
class ResidualPolicy(MaskableActorCriticPolicy):
    """Policy that draws choices by a scorer's scores; untrained and deterministic it is the ATC rule.

    Args:
        arguments: positional arguments of `MaskableActorCriticPolicy`.
        patience: patience of the ATC rule [s].
        sharpness: see `ActorCriticExtractor`.
        options: further arguments of `MaskableActorCriticPolicy`; `net_arch` has the widths of the scorer's layers.
    """

    def __init__(self, *arguments: Any, patience: float = 1.0, sharpness: float = 4.0, **options: Any) -> None:
        self._patience, self._sharpness = patience, sharpness
        super().__init__(*arguments, **{"net_arch": list(WIDTHS), **options})

    def _build(self, lr_schedule: Any) -> None:
        widths = tuple(int(width) for width in self.net_arch)
        outlook = LineEncoder(widths[-1] if widths else WIDTHS[-1])
        self.mlp_extractor = ActorCriticExtractor(Scoring(self._patience, widths), outlook, self._sharpness)
        self.action_net = nn.Identity()
        self.value_net = nn.Linear(widths[-1] if widths else WIDTHS[-1], 1)
        optimizer_class: Any = self.optimizer_class
        self.optimizer = optimizer_class(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)

    def numbers(self) -> Scorer:
        """The policy's present scorer as NumPy arrays."""
        return self.mlp_extractor.scoring.numbers()
