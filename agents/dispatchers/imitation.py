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
from ..learning.residual import Scoring, choices_of
from ..policies.scorer import Scorer
from .decisions import Progress, observed_line, single_shifts
from .scored import Scored, there

EPOCHS: Final = 60
BATCH: Final = 256
RATE: Final = 2e-3
"""Learning rate of the first epoch; it falls to zero along a cosine."""
HELD_OUT: Final = 8
"""Every label of this rank is held out, to measure how often the scorer agrees with the planner."""
NEVER: Final = -1e9


@final
@dataclass(frozen=True)
class Labels:
    """T observed decisions with the planner's choices."""

    seen: NDArray[np.float32]
    """Observations (T, ENTRIES)."""
    choice: Ints
    """Choices of the planner (T,)."""

    @classmethod
    def joined(cls, parts: list[Self]) -> Self:
        """Labels of several parts in one."""
        return cls(np.concatenate([p.seen for p in parts]), np.concatenate([p.choice for p in parts]))


def collected(
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

    def told(seen: Observation) -> NDArray[Any]:
        """Choices of the worker; the expert labels first, because it may read the lines themselves."""
        labels.append(np.asarray(expert.act(seen), dtype=np.int64))
        return labels[-1] if worker is expert else worker.act(seen)

    for one in single_shifts(told, env, seeds, progress):
        working = one.shift == 0
        parts.append(Labels(one.seen.features[working], labels[-1][working]))
    return Labels.joined(parts)


def fitted(labels: Labels, patience: float, widths: tuple[int, ...], seed: int) -> tuple[Scorer, float]:
    """Scorer fitted to labels, and the share of held-out labels on which it agrees.

    Args:
        labels: choices of the planner.
        patience: patience of the rule as which the scorer begins [s].
        widths: widths of the hidden layers.
        seed: seed of the weights and of the order of the batches.
    """
    torch.set_num_threads(1)  # small networks are slower on many threads
    torch.manual_seed(seed)
    scoring, held = Scoring(patience, widths), np.arange(len(labels.choice)) % HELD_OUT == HELD_OUT - 1
    learned, label = torch.as_tensor(labels.seen[~held]), torch.as_tensor(labels.choice[~held])
    mask, seen = torch.as_tensor(there(labels.seen[~held])), choices_of(learned)
    optimizer = torch.optim.Adam(scoring.parameters(), lr=RATE)
    steps = EPOCHS * -(-len(label) // BATCH)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(label)).split(BATCH):
            scores = torch.where(mask[rows], scoring(seen[rows]), NEVER)
            loss: Any = cross_entropy(scores, label[rows])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
    scorer = scoring.numbers()
    alike = Scored("", scorer).act(observed_line(labels.seen[held])) == labels.choice[held]
    return scorer, float(alike.mean()) if held.any() else float("nan")
