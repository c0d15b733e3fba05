"""Networks as records of arrays: layers that NumPy computes, copied from torch, with the array names of files.

An activation is a list of operators by their names in ONNX. NumPy computes the operators here, and `agents.publish`
puts the same operators into a graph.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import Any, Final, NamedTuple, Self, final

import numpy as np
from numpy.typing import DTypeLike, NDArray

from pnt_gym.arrays import Floats

Array = NDArray[np.floating]
LAYER: Final = r"(?:weight|bias)_\d{1,3}"
"""Names of the arrays of full layers in a file."""
LSTM: Final = ("lstm_in", "lstm_kept", "lstm_bias")
"""Names of the arrays of an LSTM in a file."""


def sigmoid(x: Floats) -> Floats:
    """Compute 1 / (1 + exp(-x)) in a form that no x overflows."""
    return 0.5 * (1.0 + np.tanh(0.5 * x))


OPERATORS: Final[Mapping[str, Callable[..., Floats]]] = {
    "Add": np.add,
    "Div": np.divide,
    "Elu": lambda x: np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0))),
    "Erf": lambda x: importlib.import_module("scipy.special").erf(x),  # at first use, because the import takes a while
    "LeakyRelu": lambda x: np.where(x > 0.0, x, 0.01 * x),
    "Mul": np.multiply,
    "Relu": lambda x: np.maximum(x, 0.0),
    "Sigmoid": sigmoid,
    "Softplus": lambda x: np.logaddexp(0.0, x),
    "Tanh": np.tanh,
}
"""Operators of ONNX, with ONNX's default settings."""
NUMBERS: Final = {"root_two": np.sqrt(2.0), "half": 0.5, "one": 1.0}
ACTIVATIONS: Final[Mapping[str, tuple[tuple[str, ...], ...]]] = {
    "ELU": (("Elu", "x"),),
    "GELU": (("Div", "x", "root_two"), ("Erf", "y"), ("Add", "y", "one"), ("Mul", "y", "half"), ("Mul", "y", "x")),
    "LeakyReLU": (("LeakyRelu", "x"),),
    "Mish": (("Softplus", "x"), ("Tanh", "y"), ("Mul", "y", "x")),
    "ReLU": (("Relu", "x"),),
    "SiLU": (("Sigmoid", "x"), ("Mul", "y", "x")),
    "Sigmoid": (("Sigmoid", "x"),),
    "Softplus": (("Softplus", "x"),),
    "Tanh": (("Tanh", "x"),),
}
"""Operators with their inputs, by the activation's name in torch.nn, whose default settings it has.

An input is x from the layer, y from the operator before, or one of `NUMBERS`.
"""


def activate(name: str, value: Floats) -> Floats:
    """Apply one of `ACTIVATIONS` to a value."""
    inputs: dict[str, Any] = {"x": value, **NUMBERS}
    for operator, *names in ACTIVATIONS[name]:
        inputs["y"] = OPERATORS[operator](*(inputs[key] for key in names))
    return inputs["y"]


@final
class Dense(NamedTuple):
    """A full layer from I inputs to O outputs."""

    weight: Array
    """(O, I)"""
    bias: Array
    """(O,)"""

    def __call__(self, value: Floats) -> Floats:
        """Compute outputs S + (O,) of inputs S + (I,)."""
        return value @ self.weight.T + self.bias


Layers = tuple[Dense, ...]


@final
class Convolution(NamedTuple):
    """A convolution from I to O maps by windows of K by K points."""

    weight: Array
    """(O, I, K, K)"""
    bias: Array
    """(O,)"""

    def __call__(self, value: Floats, stride: int) -> Floats:
        """Compute maps (N, O, H', W') of maps (N, I, H, W) by windows that lie `stride` points apart."""
        side = self.weight.shape[-1]
        windows = np.lib.stride_tricks.sliding_window_view(value, (side, side), axis=(2, 3))[:, :, ::stride, ::stride]
        count, _, height, width = windows.shape[:4]
        # One product of matrices instead of sums over windows: it runs at the processor's full speed.
        columns = windows.transpose(0, 2, 3, 1, 4, 5).reshape(count * height * width, -1)
        maps = columns @ self.weight.reshape(len(self.bias), -1).T + self.bias
        return maps.reshape(count, height, width, -1).transpose(0, 3, 1, 2)


@final
class Lstm(NamedTuple):
    """A layer of H long short-term memory cells, with torch's equations (`torch.nn.LSTM`).

    The gates lie one after the other: input, forget, cell, output.
    """

    input_weights: Array
    """Weights of the inputs (4H, D)."""
    recurrent_weights: Array
    """Weights of the previous outputs (4H, H)."""
    bias: Array
    """(4H,)"""

    @property
    def size(self) -> int:
        """Number of cells H."""
        return self.recurrent_weights.shape[1]

    def __call__(self, inputs: Floats, memory: Floats) -> Floats:
        """Compute the memory (N, 2, H), outputs and cells, after inputs (N, D)."""
        before, cell = memory[:, 0], memory[:, 1]
        gates = inputs @ self.input_weights.T + before @ self.recurrent_weights.T + self.bias
        take, keep, new, give = np.split(gates, 4, axis=1)
        cell = sigmoid(keep) * cell + sigmoid(take) * np.tanh(new)
        return np.stack([sigmoid(give) * np.tanh(cell), cell], axis=1)

    @classmethod
    def from_torch(cls, lstm: Any) -> Self:
        """Copy a plain `torch.nn.LSTM`, with the sum of its two biases."""
        input_weights, recurrent_weights, *biases = (tensor.detach().numpy().copy() for tensor in lstm.parameters())
        return cls(input_weights, recurrent_weights, biases[0] + biases[1])


@final
class Gru(NamedTuple):
    """A layer of H gated recurrent units, with torch's equations (`torch.nn.GRUCell`).

    The gates lie one after the other: reset, update, candidate.
    """

    input_layer: Dense
    """Layer of the inputs (3H, D)."""
    recurrent_layer: Dense
    """Layer of the previous memory (3H, H)."""

    @property
    def size(self) -> int:
        """Number of units H."""
        return self.recurrent_layer.weight.shape[1]

    def __call__(self, inputs: Floats, memory: Floats) -> Floats:
        """Compute the memory (N, H) after inputs (N, D)."""
        new, old = self.input_layer(inputs), self.recurrent_layer(memory)
        reset, update = (sigmoid((new + old)[:, part : part + self.size]) for part in (0, self.size))
        candidate = np.tanh(new[:, 2 * self.size :] + reset * old[:, 2 * self.size :])
        return (1.0 - update) * candidate + update * memory

    @classmethod
    def from_torch(cls, unit: Any, kind: DTypeLike = np.float32) -> Self:
        """Copy a `torch.nn.GRUCell` as arrays of a dtype."""
        return cls(*layers_from_torch((unit.weight_ih, unit.bias_ih, unit.weight_hh, unit.bias_hh), kind))


def layers_from_torch(tensors: Iterable[Any], kind: DTypeLike = np.float32) -> Layers:
    """Copy full layers from tensors of torch, weight and bias in turn, as arrays of a dtype."""
    arrays = [tensor.detach().numpy().astype(kind) for tensor in tensors]
    return tuple(map(Dense, arrays[0::2], arrays[1::2]))


def run(layers: Layers, activation: str, value: Floats) -> Floats:
    """Compute outputs of full layers for values S + (D,), with an activation after every layer but the last."""
    *hidden, last = layers
    for layer in hidden:
        value = activate(activation, layer(value))
    return last(value)


def arrays(layers: Layers) -> dict[str, Array]:
    """Name the arrays of full layers as in a file."""
    return {f"{part}_{k}": array for k, layer in enumerate(layers) for part, array in layer._asdict().items()}


def layers(arrays: Mapping[str, NDArray[Any]], kind: DTypeLike = np.float32) -> Layers:
    """Find the full layers among the arrays of a file.

    Raises:
        ValueError: the layers do not fit together, or are no finite numbers of the dtype.
        KeyError: there is no layer, or a layer lacks its bias.
    """
    count = max(sum(name.startswith("weight_") for name in arrays), 1)
    layers = tuple(dense(arrays, f"weight_{k}", f"bias_{k}", kind) for k in range(count))
    fits = [after.weight.shape[1] == len(before.weight) for before, after in pairwise(layers)]
    if not all([*fits, *(layer.bias.shape == layer.weight.shape[:1] for layer in layers)]):
        raise ValueError("layers that do not fit together")
    return layers


def dense(arrays: Mapping[str, NDArray[Any]], weight: str, bias: str, kind: DTypeLike = np.float32) -> Dense:
    """Find a full layer by the names of its arrays.

    Raises:
        ValueError: the arrays are no finite numbers of the dtype, or have other axes.
        KeyError: an array is missing.
    """
    return Dense(numbers(arrays[weight], 2, kind), numbers(arrays[bias], 1, kind))


def lstm_of(arrays: Mapping[str, NDArray[Any]]) -> Lstm | None:
    """Find the LSTM among the arrays of a file, if there is one.

    Raises:
        ValueError: the LSTM's arrays do not fit together, or are no finite numbers.
        KeyError: an array of the LSTM is missing.
    """
    if not arrays.keys() & set(LSTM):
        return None
    lstm = Lstm(*(numbers(arrays[name], axes) for name, axes in zip(LSTM, (2, 2, 1), strict=True)))
    if any(len(part) != 4 * lstm.size for part in lstm):
        raise ValueError("an LSTM whose parts do not fit together")
    return lstm


def numbers(array: NDArray[Any], axes: int, kind: DTypeLike = np.float32) -> Array:
    """Return an array after checking that it holds finite numbers of a dtype in `axes` axes.

    Raises:
        ValueError: the array holds other data.
    """
    if array.dtype != kind or array.ndim != axes or not np.isfinite(array).all():
        raise ValueError(f"{array.dtype} {array.shape}")
    return array
