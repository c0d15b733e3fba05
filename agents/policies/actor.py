"""A trained policy as numbers: all it takes to act, without the libraries that trained it.

`policy.npz` is a NumPy archive of numbers and two names:

    lstm_in, lstm_kept, lstm_bias     of a recurrent policy: the layer before them, see `Lstm`
    weight_0, bias_0, weight_1, ...   full layers from the observation, or what the former gives, to the action, weights
                                      (outputs, inputs), float32
    activation                        after every layer but the last, a name of `ACTIVATIONS`
    output                            "squashed": tanh, then scaled from [-1, 1] to low and high (SAC, TD3, TQC);
                                      "clipped" to low and high (PPO, RecurrentPPO); "scores" of choices, as they are,
                                      of which the greatest is taken (MaskablePPO)
    bound                             the last layer's numbers are clipped to it on either side before; mostly inf
    low, high                         of the actions
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.reading import arrays_of

from ..ground.cli import UsageError

Array = NDArray[np.float32]
Layers = tuple[tuple[Array, Array], ...]
"""Weight and bias of each full layer."""
OUTPUTS: Final = ("squashed", "clipped", "scores")
LSTM: Final = ("lstm_in", "lstm_kept", "lstm_bias")
PARTS: Final = re.compile(rf"(?:weight|bias)_\d{{1,3}}|{'|'.join(LSTM)}|activation|output|bound|low|high")
"""Names of the arrays in a file."""


def _gelu(x: Floats) -> Floats:
    erf = importlib.import_module("scipy.special").erf  # at first use, because it takes a while
    return 0.5 * x * (1.0 + erf(x / np.sqrt(2.0)))


def _sigmoid(x: Floats) -> Floats:
    return 0.5 * (1.0 + np.tanh(0.5 * x))


ACTIVATIONS: Final[Mapping[str, Callable[[Floats], Floats]]] = {
    "ELU": lambda x: np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0))),
    "GELU": _gelu,
    "LeakyReLU": lambda x: np.where(x > 0.0, x, 0.01 * x),
    "Mish": lambda x: x * np.tanh(np.logaddexp(0.0, x)),
    "ReLU": lambda x: np.maximum(x, 0.0),
    "SiLU": lambda x: x * _sigmoid(x),
    "Sigmoid": _sigmoid,
    "Softplus": lambda x: np.logaddexp(0.0, x),
    "Tanh": np.tanh,
}
"""By their names in torch.nn, whose default settings they have."""


@final
@dataclass(frozen=True)
class Lstm:
    """A layer of H long short-term memories, as torch computes it.

    Its gates lie one after the other: input, forget, cell, output.
    """

    seen: Array
    """Weights of what is seen (4H, D)."""
    kept: Array
    """Weights of what it gave before (4H, H)."""
    bias: Array
    """(4H,)"""

    @property
    def size(self) -> int:
        """Memories H."""
        return self.kept.shape[1]

    def __call__(self, seen: Floats, memory: Floats) -> Floats:
        """The memory (N, 2, H) after what is seen (N, D): what it gives, and its cells."""
        before, cell = memory[:, 0], memory[:, 1]
        gates = seen @ self.seen.T + before @ self.kept.T + self.bias
        take, keep, new, give = np.split(gates, 4, axis=1)
        cell = _sigmoid(keep) * cell + _sigmoid(take) * np.tanh(new)
        return np.stack([_sigmoid(give) * np.tanh(cell), cell], axis=1)


@final
@dataclass(frozen=True)
class Actor:
    """The deterministic policy that a training left; `policy.npz` holds what its attributes say."""

    layers: Layers
    activation: str
    output: str
    """One of `OUTPUTS`."""
    bound: float
    low: Array
    high: Array
    lstm: Lstm | None = None
    """Of a recurrent policy."""

    def __call__(self, observations: NDArray[Any]) -> Array:
        """Actions (N, A) for observations (N, D), each row for itself; a recurrent policy's are those that begin.

        Computed with 64 bits, so that rounding the actions to 32 hides how many rows were computed at once.
        """
        return self.after(observations, self.blank(len(observations)))[0]

    def blank(self, rows: int) -> Floats:
        """What rows remember that begin, (N, 2, H); H is 0 without an LSTM."""
        return np.zeros((rows, 2, 0 if self.lstm is None else self.lstm.size))

    def after(self, observations: NDArray[Any], memory: Floats) -> tuple[Array, Floats]:
        """Actions (N, A) for observations (N, D) after what is remembered (N, 2, H), and what then is remembered."""
        value = np.asarray(observations, dtype=np.float64)
        if self.lstm is not None:
            memory = self.lstm(value, memory)
            value = memory[:, 0]
        return self._answer(value), memory

    def _answer(self, value: Floats) -> Array:
        """Actions (N, A) by the full layers."""
        value = np.clip(through(self.layers, self.activation, value), -self.bound, self.bound)
        if self.output == "scores":
            return value.astype(np.float32)
        if self.output == "squashed":
            value = self.low + 0.5 * (np.tanh(value) + 1.0) * (self.high - self.low)
        return np.clip(value, self.low, self.high).astype(np.float32)

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers in an observation and in an action."""
        first = self.layers[0][0] if self.lstm is None else self.lstm.seen
        return first.shape[1], len(self.low)

    @property
    def numbers(self) -> dict[str, Array]:
        """Weights and biases by their names in a file."""
        numbers: dict[str, Array] = {}
        if self.lstm is not None:
            numbers |= dict(zip(LSTM, (self.lstm.seen, self.lstm.kept, self.lstm.bias), strict=True))
        return numbers | named(self.layers)

    def save(self, file: Path) -> None:
        """Write it to a file."""
        more: dict[str, Any] = {"activation": self.activation, "output": self.output, "bound": np.float32(self.bound)}
        np.savez(file, **self.numbers, **more, low=self.low, high=self.high)

    @classmethod
    def load(cls, file: Path) -> Self:
        """Read it; nothing in the file is run.

        Raises:
            UsageError: it is damaged, or holds something else.
        """
        try:
            found = arrays_of(file, PARTS)
            actor = cls(
                layers_of(found),
                str(found["activation"]),
                str(found["output"]),
                float(found["bound"]),
                numbers_of(found["low"], 1),
                numbers_of(found["high"], 1),
                _lstm(found) if found.keys() & set(LSTM) else None,
            )
            _check(actor)
        except Exception as error:
            # There is no telling what a torn or foreign file upsets.
            raise UsageError(f"{str(file)!r} is damaged: {file.name} is truncated or holds no policy") from error
        return actor


def _lstm(found: Mapping[str, NDArray[Any]]) -> Lstm:
    """The layer that a file holds."""
    parts = zip(LSTM, (2, 2, 1), strict=True)
    return Lstm(*(numbers_of(found[name], axes) for name, axes in parts))


def through(layers: Layers, activation: str, value: Floats) -> Floats:
    """What full layers make of values S + (D,), with an activation after every layer but the last."""
    *hidden, (weight, bias) = layers
    for inner, shift in hidden:
        value = ACTIVATIONS[activation](value @ inner.T + shift)
    return value @ weight.T + bias


def named(layers: Layers) -> dict[str, Array]:
    """Weights and biases by their names in a file."""
    numbers: dict[str, Array] = {}
    for k, (weight, bias) in enumerate(layers):
        numbers |= {f"weight_{k}": weight, f"bias_{k}": bias}
    return numbers


def layers_of(found: Mapping[str, NDArray[Any]]) -> Layers:
    """The layers that a file holds.

    Raises:
        ValueError: they do not fit together.
        KeyError: there is none, or one lacks its bias.
    """
    count = max(sum(name.startswith("weight_") for name in found), 1)
    layers = tuple((numbers_of(found[f"weight_{k}"], 2), numbers_of(found[f"bias_{k}"], 1)) for k in range(count))
    fits = [after.shape[1] == len(before) for (before, _), (after, _) in pairwise(layers)]
    if not all([*fits, *(bias.shape == weight.shape[:1] for weight, bias in layers)]):
        raise ValueError("layers that do not fit together")
    return layers


def numbers_of(array: NDArray[Any], axes: int) -> Array:
    """Finite numbers in so many axes."""
    if array.dtype != np.float32 or array.ndim != axes or not np.isfinite(array).all():
        raise ValueError(f"{array.dtype} {array.shape}")
    return array


def _check(actor: Actor) -> None:
    """Make sure that the parts fit together."""
    weights = [weight for weight, _ in actor.layers]
    fits = [actor.low.shape == actor.high.shape == weights[-1].shape[:1], bool((actor.low < actor.high).all())]
    fits += [actor.activation in ACTIVATIONS, actor.output in OUTPUTS, actor.bound > 0.0]
    if actor.lstm is not None:
        size, lstm = actor.lstm.size, actor.lstm
        fits += [len(part) == 4 * size for part in (lstm.seen, lstm.kept, lstm.bias)]
        fits += [weights[0].shape[1] == size > 0]
    if not all(fits):
        raise ValueError("parts that do not fit together")
