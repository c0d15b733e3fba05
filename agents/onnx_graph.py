"""A policy as an ONNX graph, `policy.onnx`, which runtimes in many languages and on many machines take.

Input `observation` (N, D), output `action` (N, A), both float32, any number N of rows at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from numpy.typing import ArrayLike

from .actor import Actor
from .cli import UsageError
from .versions import versions

OPSET: Final = 17
IR: Final = 8
"""The format's version that goes with this opset; runtimes since 2022 read both."""
PARITY: Final = 1e-4
"""By how much at most the graph's actions, computed with 32 bits, differ from the policy's, as a share of their
range."""
ROWS: Final = 256
"""Observations that both are asked for."""
ACTIVATIONS: Final[Mapping[str, tuple[tuple[str, ...], ...]]] = {
    "ELU": (("Elu", "x"),),
    "GELU": (("Mul", "x", "root_half"), ("Erf", "y"), ("Add", "y", "one"), ("Mul", "y", "half"), ("Mul", "y", "x")),
    "LeakyReLU": (("LeakyRelu", "x"),),
    "Mish": (("Softplus", "x"), ("Tanh", "y"), ("Mul", "y", "x")),
    "ReLU": (("Relu", "x"),),
    "SiLU": (("Sigmoid", "x"), ("Mul", "y", "x")),
    "Sigmoid": (("Sigmoid", "x"),),
    "Softplus": (("Softplus", "x"),),
    "Tanh": (("Tanh", "x"),),
}
"""Those of `agents.actor` as operators with their inputs: x from the layer, y from the operator before, or a number."""
NUMBERS: Final = {"root_half": np.sqrt(0.5), "half": 0.5, "one": 1.0}


def save_onnx(actor: Actor, file: Path, about: Mapping[str, str]) -> None:
    """Write a policy's graph to a file, with words about it by name.

    Raises:
        UsageError: the runtime finds other actions in it.
    """
    import onnx  # noqa: PLC0415 - of an extra

    model = graph(actor, about)
    onnx.checker.check_model(model, full_check=True)
    _check_parity(model, actor)
    onnx.save_model(model, file)


def graph(actor: Actor, about: Mapping[str, str]) -> Any:
    """The policy as a model of the library onnx."""
    from onnx import TensorProto, helper  # noqa: PLC0415 - of an extra

    seen, given = actor.sizes
    nodes = _Nodes()
    nodes.add("Identity", _output(nodes, actor, _layers(nodes, actor)), name="action")
    ends = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, ["N", size])
        for name, size in (("observation", seen), ("action", given))
    ]
    whole = helper.make_graph(nodes.nodes, "policy", ends[:1], ends[1:], nodes.constants)
    model = helper.make_model(
        whole,
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR,
        producer_name="pnt_gym",
        producer_version=versions()["pnt_gym"],
    )
    helper.set_model_props(model, dict(about))
    return model


@final
class _Nodes:
    """Operators and constants of a graph."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def add(self, operator: str, *inputs: str, name: str = "", **attributes: Any) -> str:
        """Append an operator; returns the name of what it gives."""
        from onnx import helper  # noqa: PLC0415 - of an extra

        given = name or f"{operator.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, inputs, [given], **attributes))
        return given

    def constant(self, name: str, value: ArrayLike) -> str:
        """Append a constant; returns its name."""
        from onnx import numpy_helper  # noqa: PLC0415 - of an extra

        self.constants.append(numpy_helper.from_array(np.asarray(value, dtype=np.float32), name))
        return name


def _layers(nodes: _Nodes, actor: Actor) -> str:
    """What the last layer gives."""
    steps = ACTIVATIONS[actor.activation]
    for name, number in NUMBERS.items():
        if any(name in inputs for _, *inputs in steps):
            nodes.constant(name, number)
    value = "observation"
    for k, (weight, bias) in enumerate(actor.layers):
        inputs = (nodes.constant(f"weight_{k}", weight), nodes.constant(f"bias_{k}", bias))
        value = nodes.add("Gemm", value, *inputs, transB=1)
        if k < len(actor.layers) - 1:
            names = {"x": value}
            for operator, *inputs in steps:
                names["y"] = nodes.add(operator, *(names.get(name, name) for name in inputs))
            value = names["y"]
    return value


def _output(nodes: _Nodes, actor: Actor, value: str) -> str:
    """The action, of what the last layer gives."""
    if np.isfinite(actor.bound):
        value = nodes.add("Clip", value, nodes.constant("least", -actor.bound), nodes.constant("most", actor.bound))
    if actor.output == "squashed":
        half = 0.5 * (actor.high - actor.low)
        value = nodes.add("Mul", nodes.add("Tanh", value), nodes.constant("half_range", half))
        value = nodes.add("Add", value, nodes.constant("middle", actor.low + half))
    value = nodes.add("Max", value, nodes.constant("low", actor.low))
    return nodes.add("Min", value, nodes.constant("high", actor.high))


def _check_parity(model: Any, actor: Actor) -> None:
    """Let the runtime act on some observations, all at once and one alone."""
    import onnxruntime  # noqa: PLC0415 - of an extra

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3  # it warns of graphics cards that are not there
    session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
    seen = (2.0 * np.random.default_rng(0).standard_normal((ROWS, actor.sizes[0]))).astype(np.float32)
    found = [session.run(["action"], {"observation": rows})[0] for rows in (seen, seen[:1])]
    apart = np.abs(np.concatenate(found) - actor(np.concatenate([seen, seen[:1]]))) / (actor.high - actor.low)
    if not (apart <= PARITY).all():
        raise UsageError(
            f"the ONNX graph acts otherwise than the policy, by {apart.max():.2g} of the range of an action; "
            f"at most {PARITY:g} is rounding"
        )
