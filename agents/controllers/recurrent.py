"""A recurrent network that learns in context: it reads the throws of a shift one by one and predicts the next landing.

A gated recurrent unit takes in a throw and its landing error; a head predicts the landing error of the next throw from
the unit's memory and that throw's observation. Training: back-propagation through whole shifts (torch). Inference:
numpy.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats

from ..ground.fitting import fit_from
from ..policies import networks
from ..policies.networks import Dense, Gru, layers_from_torch
from .protocol import State

UNIT: Final = 0.01
"""Unit in which landing errors are counted [m]."""
LAYERS: Final = ("memory_in", "memory_kept", "head", "answer")
"""Names of the layers: input and memory of the unit, three gates each, and the two layers of the head."""


@final
@dataclass(frozen=True)
class TrainingShifts:
    """A batch of S shifts of P throws each."""

    features: Floats
    """Observation of each throw (S, P, D)."""
    z: Floats
    """Observed landing error of each throw (S, P, 2) [m]; 0 where it is unknown."""
    true: Floats
    """True landing error of each throw (S, P, 2) [m], which the network learns to predict."""
    has_landing: Bools
    """Whether the landing error was observed (S, P)."""


@final
class Recurrent:
    """Recurrent network in numpy.

    Args:
        unit: gated recurrent unit, updated by each throw.
        head: layer from the memory and the next throw's observation to the hidden layer.
        answer: layer from the hidden layer to the prediction.
    """

    def __init__(self, unit: Gru, head: Dense, answer: Dense) -> None:
        self._unit, self._head, self._answer = unit, head, answer

    @property
    def size(self) -> int:
        """Numbers in the network's memory H."""
        return self._unit.size

    def update(self, memory: Floats, features: Floats, z: Floats) -> Floats:
        """Memory (N, H) after throws (N, D) with landing errors (N, 2) [m]."""
        return self._unit(np.concatenate([features, np.clip(z / UNIT, -6.0, 6.0)], axis=1), memory)

    def predict(self, memory: Floats, features: Floats) -> Floats:
        """Predicted landing errors of throws (N, D) by memories (N, H): (N, 2) [m]."""
        return UNIT * networks.run((self._head, self._answer), "SiLU", np.concatenate([memory, features], axis=1))

    def state(self) -> State:
        """Arrays of all layers by name."""
        layers = zip(LAYERS, (*self._unit, self._head, self._answer), strict=True)
        return {f"{name}_{part}": array for name, layer in layers for part, array in layer._asdict().items()}

    @classmethod
    def of(cls, state: State) -> Self:
        """Network from a state."""
        input_layer, memory_layer, *layers = (
            networks.dense(state, f"{name}_weight", f"{name}_bias", np.float64) for name in LAYERS
        )
        return cls(Gru(input_layer, memory_layer), *layers)

    @classmethod
    def from_torch(cls, unit: Any, head: Any, answer: Any) -> Self:
        """Network from a GRUCell and two Linear layers of torch."""
        layers = layers_from_torch([*head.parameters(), *answer.parameters()], np.float64)
        return cls(Gru.from_torch(unit, np.float64), *layers)


def train(batches: Iterable[TrainingShifts], total: int, features: int, seed: int, size: int) -> Recurrent:
    """Network trained on batches of shifts.

    Args:
        batches: batches of shifts, one gradient step each.
        total: number of batches.
        features: number of entries of an observation D.
        seed: seed of the initial weights.
        size: numbers in the memory, and in the head's hidden layer.
    """
    import torch  # noqa: PLC0415 - a second to import, needed for training only

    with fit_from(seed):
        parts = _layers(torch, features, size)
        parameters = [number for part in parts for number in part.parameters()]
        optimiser = torch.optim.AdamW(parameters, lr=3e-3, weight_decay=0.1)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, total)
        for lessons in batches:
            optimiser.zero_grad()
            _loss(torch, parts, lessons).backward()
            torch.nn.utils.clip_grad_norm_(parameters, 1.0)
            optimiser.step()
            schedule.step()
    return Recurrent.from_torch(*parts)


def _layers(torch: Any, features: int, size: int) -> tuple[Any, Any, Any]:
    """Unit, head and answer in torch; the answer starts near zero."""
    unit, head = torch.nn.GRUCell(features + 2, size), torch.nn.Linear(size + features, size)
    answer = torch.nn.Linear(size, 2)
    with torch.no_grad():
        answer.weight.mul_(0.01)
        answer.bias.zero_()
    return unit, head, answer


def _loss(torch: Any, parts: tuple[Any, Any, Any], lessons: TrainingShifts) -> Any:
    """Huber loss of a network's predictions in shifts."""
    parts_of = (lessons.features, np.clip(lessons.z / UNIT, -6.0, 6.0), np.clip(lessons.true / UNIT, -6.0, 6.0))
    features, z, true = (torch.as_tensor(part, dtype=torch.float32) for part in parts_of)
    has_landing = torch.as_tensor(lessons.has_landing)
    unit, head, answer = parts
    memory, predictions = torch.zeros(len(features), unit.hidden_size), list[Any]()
    for at in range(features.shape[1]):
        throw = features[:, at]
        hidden = torch.nn.functional.silu(head(torch.cat([memory, throw], dim=1)))
        predictions.append(answer(hidden))
        updated = unit(torch.cat([throw, z[:, at]], dim=1), memory)
        memory = torch.where(has_landing[:, at, None], updated, memory)
    return torch.nn.functional.huber_loss(torch.stack(predictions, dim=1), true, delta=1.0)
