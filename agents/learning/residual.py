"""The policy of residual PPO: a scorer that learns, and by its side what the coming decisions are worth."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Final, final

import numpy as np
import torch
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from torch import Tensor, nn

from pnt_gym.cells.line.observation import CHOICE_TABLE, LINE_TABLE
from pnt_gym.cells.line.state import CHOICES

from ..policies.scorer import INPUTS, NAMES, Scorer, rule

WIDTHS: Final = (64, 64)
"""Of a scorer's hidden layers."""


def choices_of(observations: Tensor) -> Tensor:
    """What a scorer sees of each choice (N, CHOICES, INPUTS), in observations (N, ENTRIES)."""
    head = len(LINE_TABLE)
    each = observations[:, head:].reshape(-1, CHOICES, len(CHOICE_TABLE))
    return torch.cat([each, observations[:, None, :head].expand(-1, CHOICES, -1)], dim=-1)


@final
class Scoring(nn.Module):
    """A scorer that can learn; it begins as the ATC rule.

    Args:
        patience: of the rule [s].
        widths: of the hidden layers.
    """

    def __init__(self, patience: float, widths: tuple[int, ...] = WIDTHS) -> None:
        super().__init__()
        self.patience = patience
        weight, constant = rule(patience)
        self.register_buffer("weight", torch.as_tensor(weight, dtype=torch.float32), persistent=False)
        self.constant = constant
        layers = [nn.Linear(before, after) for before, after in pairwise((INPUTS, *widths, 1))]
        for layer in layers:
            nn.init.orthogonal_(layer.weight, 2.0**0.5)
            nn.init.zeros_(layer.bias)
        nn.init.zeros_(layers[-1].weight)
        between = [part for layer in layers[:-1] for part in (layer, nn.Tanh())]
        self.added = nn.Sequential(*between, layers[-1])

    def forward(self, seen: Tensor) -> Tensor:
        """Scores (N, CHOICES) of what is seen of choices (N, CHOICES, INPUTS)."""
        return seen @ self.weight + self.constant + self.added(seen)[..., 0]

    def numbers(self) -> Scorer:
        """As it is now, for good."""
        full = [part for part in self.added if isinstance(part, nn.Linear)]
        layers = tuple(
            (layer.weight.detach().numpy().copy(), layer.bias.detach().numpy().copy().astype(np.float32))
            for layer in full
        )
        return Scorer(layers, self.patience)


@final
class Outlook(nn.Module):
    """What a line looks like to who judges how it will go on: its choices, each seen alike, taken together.

    Args:
        width: numbers for each choice, and in the end.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.each = nn.Sequential(nn.Linear(INPUTS, width), nn.Tanh())
        self.whole = nn.Sequential(nn.Linear(2 * width + len(LINE_TABLE), width), nn.Tanh())

    def forward(self, seen: Tensor) -> Tensor:
        """Numbers (N, width) for what is seen of choices (N, CHOICES, INPUTS)."""
        real, each = seen[..., NAMES.index("real"), None], self.each(seen)
        mean = (each * real).sum(dim=1) / real.sum(dim=1).clamp(min=1.0)
        most = (each * real).amax(dim=1)
        return self.whole(torch.cat([mean, most, seen[:, 0, len(CHOICE_TABLE) :]], dim=-1))


@final
class Sides(nn.Module):
    """Both sides of the policy, by the names that stable-baselines3 asks for.

    Args:
        scoring: gives the logits.
        outlook: is what values are read from.
        sharpness: factor on the scores; 1 explores as ATC's indices stand to one another.
    """

    def __init__(self, scoring: Scoring, outlook: Outlook, sharpness: float) -> None:
        super().__init__()
        self.scoring, self.outlook, self.sharpness = scoring, outlook, sharpness

    def forward(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Logits, and what values are read from."""
        return self.forward_actor(observations), self.forward_critic(observations)

    def forward_actor(self, observations: Tensor) -> Tensor:
        """Logits (N, CHOICES) for observations (N, ENTRIES)."""
        return self.sharpness * self.scoring(choices_of(observations))

    def forward_critic(self, observations: Tensor) -> Tensor:
        """What values are read from."""
        return self.outlook(choices_of(observations))


@final
class ResidualPolicy(MaskableActorCriticPolicy):
    """A scorer's choices, drawn by their scores; untrained and without chance it is the ATC rule.

    Args:
        given: as other policies take them.
        patience: of the rule [s].
        sharpness: see `Sides`.
        options: as other policies take them; `net_arch` has the widths of the scorer's layers.
    """

    def __init__(self, *given: Any, patience: float = 1.0, sharpness: float = 4.0, **options: Any) -> None:
        self._patience, self._sharpness = patience, sharpness
        super().__init__(*given, **{"net_arch": list(WIDTHS), **options})

    def _build(self, lr_schedule: Any) -> None:
        widths = tuple(self.net_arch)
        outlook = Outlook(widths[-1] if widths else WIDTHS[-1])
        self.mlp_extractor = Sides(Scoring(self._patience, widths), outlook, self._sharpness)
        self.action_net = nn.Identity()
        self.value_net = nn.Linear(widths[-1] if widths else WIDTHS[-1], 1)
        self.optimizer = self.optimizer_class(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)

    def numbers(self) -> Scorer:
        """Its scorer as it is now, for good."""
        return self.mlp_extractor.scoring.numbers()
