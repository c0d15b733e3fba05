"""Teaching a scorer what a planner decides: its choices are collected, and the scorer learns to make the same ones.

In the first round the planner works; in later ones what was learned so far does, and the planner says what it would
have done there (DAgger of Ross, Gordon and Bagnell 2011): the scorer is told of situations that it gets into itself.
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
from ..dispatchers.scored import Scored, there
from ..ground.environments import Env
from ..judging.decisions import Progress, observed_line, single_shifts
from ..learning.residual import Scoring, choices_of
from ..policies.scorer import Scorer

EPOCHS: Final = 60
BATCH: Final = 256
RATE: Final = 2e-3
"""Of learning in the first epoch; it falls to nothing along a cosine."""
HELD_OUT: Final = 8
"""Every so many-th label is not learned from, and tells how often the scorer chooses alike."""
NEVER: Final = -1e9


@final
@dataclass(frozen=True)
class Labels:
    """T decisions, and what the planner would do."""

    seen: NDArray[np.float32]
    """Observations (T, ENTRIES)."""
    choice: Ints
    """The planner's (T,)."""

    @classmethod
    def joined(cls, parts: list[Self]) -> Self:
        """All in one."""
        return cls(np.concatenate([p.seen for p in parts]), np.concatenate([p.choice for p in parts]))


def collected(
    expert: Controller, worker: Controller, env: Env, seeds: Ints, progress: Progress | None = None
) -> Labels:
    """What an expert would do in shifts that a worker works, one in each line.

    Args:
        expert: says what it would do.
        worker: whose decisions are carried out.
        env: lines.
        seeds: of their streams (N,).
        progress: told of shifts and parts of them.
    """
    parts, labels = list[Labels](), list[Ints]()

    def told(seen: Observation) -> NDArray[Any]:
        """The expert speaks before the worker acts: it may look at the lines themselves."""
        labels.append(np.asarray(expert.act(seen), dtype=np.int64))
        return labels[-1] if worker is expert else worker.act(seen)

    for one in single_shifts(told, env, seeds, progress):
        working = one.shift == 0
        parts.append(Labels(one.seen.features[working], labels[-1][working]))
    return Labels.joined(parts)


def fitted(labels: Labels, patience: float, widths: tuple[int, ...], seed: int) -> tuple[Scorer, float]:
    """A scorer that chooses as the labels say, and how often it does where it has not learned from them.

    Args:
        labels: of the planner.
        patience: of the rule that it begins as [s].
        widths: of its hidden layers.
        seed: of its weights and of the order of what it learns from.
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
