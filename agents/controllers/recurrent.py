"""A recurrent network that learns in context: it reads the throws of a shift one by one and foresees the next.

A gated recurrent unit takes in a lesson, what was thrown and how far off it came down; a head says from its memory, and
from what is to be thrown, how far off that will come down. Trained by back-propagation through whole shifts (torch),
carried out in numpy.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats

from .protocol import State

UNIT: Final = 0.01
"""What landings are off by is counted in this [m]."""
LAYERS: Final = ("memory_in", "memory_kept", "head", "answer")
"""Weights and biases: of the unit's lesson and memory, three gates each, and of the head's two layers."""


@final
@dataclass(frozen=True)
class Lessons:
    """A batch of S shifts of P throws each."""

    features: Floats
    """What was seen of each (S, P, D)."""
    z: Floats
    """How far off each was seen to come down (S, P, 2) [m]; 0 where that is not known."""
    true: Floats
    """How far off each came down (S, P, 2) [m]: what is to be foreseen."""
    known: Bools
    """Where it is (S, P)."""


@final
class Recurrent:
    """The network.

    Args:
        layers: weights (out, in) and bias (out,) of each of `LAYERS`.
    """

    def __init__(self, layers: Mapping[str, tuple[Floats, Floats]]) -> None:
        self._layers = dict(layers)

    @property
    def size(self) -> int:
        """Numbers in its memory H."""
        return self._layers["memory_kept"][0].shape[1]

    def remembered(self, memory: Floats, features: Floats, z: Floats) -> Floats:
        """The memory (N, H) after lessons: what was thrown (N, D), and how far off it came down (N, 2) [m]."""
        lesson = np.concatenate([features, _bounded(z)], axis=1)
        new, old = self._through("memory_in", lesson), self._through("memory_kept", memory)
        size = memory.shape[1]
        reset, update = (_sigmoid((new + old)[:, part : part + size]) for part in (0, size))
        candidate = np.tanh(new[:, 2 * size :] + reset * old[:, 2 * size :])
        return (1.0 - update) * candidate + update * memory

    def foreseen(self, memory: Floats, features: Floats) -> Floats:
        """How far off throws (N, D) will come down (N, 2) [m], by memories (N, H)."""
        hidden = self._through("head", np.concatenate([memory, features], axis=1))
        return UNIT * self._through("answer", hidden * _sigmoid(hidden))

    def state(self) -> State:
        """All layers by name."""
        named = (("weight", 0), ("bias", 1))
        return {f"{layer}_{what}": pair[k] for layer, pair in self._layers.items() for what, k in named}

    @classmethod
    def of(cls, state: State) -> Self:
        """The network of a state."""

        def one(name: str) -> Floats:
            return np.asarray(state[name], dtype=np.float64)

        return cls({layer: (one(f"{layer}_weight"), one(f"{layer}_bias")) for layer in LAYERS})

    def _through(self, layer: str, values: Floats) -> Floats:
        weight, bias = self._layers[layer]
        return values @ weight.T + bias


def trained(
    batches: Iterable[Lessons], total: int, features: int, seed: int, size: int, rate: float = 3e-3
) -> Recurrent:
    """A network that has learned from shifts.

    Args:
        batches: of shifts, each to make one step of.
        total: how many there are.
        features: entries of an observation D.
        seed: of the weights.
        size: numbers in its memory, and in the head's hidden layer.
        rate: learning rate at the start of a cosine schedule.
    """
    import torch  # noqa: PLC0415 - a second to import, needed for training only

    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        parts = _parts(torch, features, size)
    parameters = [number for part in parts for number in part.parameters()]
    optimiser = torch.optim.AdamW(parameters, lr=rate, weight_decay=0.1)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, total)
    for lessons in batches:
        optimiser.zero_grad()
        _loss(torch, parts, lessons).backward()
        torch.nn.utils.clip_grad_norm_(parameters, 1.0)
        optimiser.step()
        schedule.step()
    return Recurrent(_layers(*parts))


def _parts(torch: Any, features: int, size: int) -> tuple[Any, Any, Any]:
    """The unit, the head and the answer, which begins at nothing."""
    unit, head = torch.nn.GRUCell(features + 2, size), torch.nn.Linear(size + features, size)
    answer = torch.nn.Linear(size, 2)
    with torch.no_grad():
        answer.weight.mul_(0.01)
        answer.bias.zero_()
    return unit, head, answer


def _loss(torch: Any, parts: tuple[Any, Any, Any], lessons: Lessons) -> Any:
    """Huber loss of what a network foresees in shifts."""
    parts_of = (lessons.features, _bounded(lessons.z), _bounded(lessons.true))
    features, z, true = (torch.as_tensor(part, dtype=torch.float32) for part in parts_of)
    known = torch.as_tensor(lessons.known)
    unit, head, answer = parts
    memory, foreseen = torch.zeros(len(features), unit.hidden_size), list[Any]()
    for at in range(features.shape[1]):
        seen = features[:, at]
        hidden = torch.nn.functional.silu(head(torch.cat([memory, seen], dim=1)))
        foreseen.append(answer(hidden))
        learned = unit(torch.cat([seen, z[:, at]], dim=1), memory)
        memory = torch.where(known[:, at, None], learned, memory)
    return torch.nn.functional.huber_loss(torch.stack(foreseen, dim=1), true, delta=1.0)


def _layers(unit: Any, head: Any, answer: Any) -> dict[str, tuple[Floats, Floats]]:
    pairs = {
        "memory_in": (unit.weight_ih, unit.bias_ih),
        "memory_kept": (unit.weight_hh, unit.bias_hh),
        "head": (head.weight, head.bias),
        "answer": (answer.weight, answer.bias),
    }
    return {name: tuple(part.detach().numpy().astype(np.float64) for part in pair) for name, pair in pairs.items()}  # pyright: ignore[reportReturnType] - two each


def _bounded(z: Floats) -> Floats:
    """In units, where a throw that was touched or hit a rim is just far off."""
    return np.clip(z / UNIT, -6.0, 6.0)


def _sigmoid(values: Floats) -> Floats:
    return 1.0 / (1.0 + np.exp(-values))
