"""Imitation of a planner by a scorer: the planner's choices are collected, and the scorer is fitted to them.

In the first round the planner works; in later rounds the scorer works, and the planner labels the scorer's situations
(DAgger of Ross, Gordon and Bagnell 2011).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn.functional import cross_entropy

from pnt_gym.arrays import Ints

from ..controllers.protocol import Controller, Observation
from ..ground.environments import Env
from ..ground.fitting import fit_from
from ..learning.residual import Scoring, choices_of
from ..policies.scorer import Scorer
from .decisions import Progress, line_observation, work_single_shifts
from .scored import ScoreController, choice_mask

EPOCHS: Final = 60
BATCH: Final = 256
RATE: Final = 2e-3
"""Learning rate of the first epoch; it falls to zero along a cosine."""
HELD_OUT: Final = 8
"""One label in so many is held out, to measure how often the scorer agrees with the planner."""
NEVER: Final = -1e9


@final
@dataclass(frozen=True)
class Labels:
    """T observed decisions with the planner's choices."""

    observations: NDArray[np.float32]
    """Observations (T, ENTRIES)."""
    choice: Ints
    """Choices of the planner (T,)."""

    @classmethod
    def concatenate(cls, parts: list[Self]) -> Self:
        """All labels of several parts."""
        return cls(np.concatenate([p.observations for p in parts]), np.concatenate([p.choice for p in parts]))


def collect_labels(
    expert: Controller, worker: Controller, env: Env, seeds: Ints, progress: Progress | None = None
) -> Labels:
    """Choices of an expert in the shifts that a worker works, one shift in each line.

    Args:
        expert: planner that labels the decisions.
        worker: controller whose decisions are executed.
        env: environment of lines.
        seeds: seeds of the lines' streams (N,).
        progress: called with the numbers of shifts and parts of them.
    """
    parts, labels = list[Labels](), list[Ints]()

    def act(observation: Observation) -> NDArray[Any]:
        """Choices of the worker; the expert labels first, because an expert may read the lines themselves."""
        labels.append(np.asarray(expert.act(observation), dtype=np.int64))
        return labels[-1] if worker is expert else worker.act(observation)

    for step in work_single_shifts(act, env, seeds, progress):
        working = step.shift == 0
        parts.append(Labels(step.observation.features[working], labels[-1][working]))
    return Labels.concatenate(parts)


def fit_scorer(labels: Labels, patience: float, widths: tuple[int, ...], seed: int) -> tuple[Scorer, float]:
    """Scorer fitted to labels, and the share of held-out labels on which it agrees.

    Args:
        labels: choices of the planner.
        patience: patience of the rule as which the scorer begins [s].
        widths: widths of the hidden layers.
        seed: seed of the weights and of the order of the batches.
    """
    with fit_from(seed):
        scoring, is_held_out = Scoring(patience, widths), np.arange(len(labels.choice)) % HELD_OUT == HELD_OUT - 1
        training_observations, label = (
            torch.as_tensor(labels.observations[~is_held_out]),
            torch.as_tensor(labels.choice[~is_held_out]),
        )
        mask, choice_features = (
            torch.as_tensor(choice_mask(labels.observations[~is_held_out])),
            choices_of(training_observations),
        )
        optimizer = torch.optim.Adam(scoring.parameters(), lr=RATE)
        steps = EPOCHS * -(-len(label) // BATCH)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
        for _ in range(EPOCHS):
            for rows in torch.randperm(len(label)).split(BATCH):
                scores = torch.where(mask[rows], scoring(choice_features[rows]), NEVER)
                loss: Any = cross_entropy(scores, label[rows])
                optimizer.zero_grad()
                loss.backward()
                optimizer.step()
                schedule.step()
    scorer = scoring.numbers()
    agrees = (
        ScoreController("", scorer).act(line_observation(labels.observations[is_held_out]))
        == labels.choice[is_held_out]
    )
    return scorer, float(agrees.mean()) if is_held_out.any() else float("nan")
