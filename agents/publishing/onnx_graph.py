"""A policy as an ONNX graph, `policy.onnx`, which runtimes in many languages and on many machines take.

Input `observation` (N, D), output `action` (N, A), both float32, any number N of rows at once. Of a policy that chooses
at a line `action` is the choice (N,), int64: that of the greatest `scores` (N, C), float32, among those that the
observation says there are; others score minus infinity.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pnt_gym.cells.line.observation import CHOICE_TABLE, ENTRIES, LINE_TABLE
from pnt_gym.cells.line.state import CHOICES

from ..dispatchers.rules import HALF
from ..dispatchers.scored import REAL, Scored, there
from ..ground.cli import UsageError
from ..ground.versions import versions
from ..judging.decisions import observed_line
from ..policies.actor import Actor, Layers
from ..policies.scorer import Scorer, rule

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
"""Those of `agents.policies.actor` as operators with their inputs: x from the layer, y from the operator before, or a
number."""
NUMBERS: Final = {"root_half": np.sqrt(0.5), "half": 0.5, "one": 1.0}


def save_onnx(policy: Actor | Scorer, file: Path, about: Mapping[str, str]) -> None:
    """Write a policy's graph to a file, with words about it by name.

    Raises:
        UsageError: the runtime finds other actions in it.
    """
    import onnx  # noqa: PLC0415 - of an extra

    model = graph(policy, about)
    onnx.checker.check_model(model, full_check=True)
    if isinstance(policy, Actor) and policy.output != "scores":
        _check_parity(model, policy)
    else:
        _check_choices(model, policy)
    onnx.save_model(model, file)


def graph(policy: Actor | Scorer, about: Mapping[str, str]) -> Any:
    """The policy as a model of the library onnx."""
    from onnx import TensorProto, helper  # noqa: PLC0415 - of an extra

    seen, given = policy.sizes
    nodes, floats = _Nodes(), TensorProto.FLOAT
    if isinstance(policy, Actor) and policy.output != "scores":
        nodes.add("Identity", _output(nodes, policy, _layers(nodes, policy)), name="action")
        outputs = [helper.make_tensor_value_info("action", floats, ["N", given])]
    else:
        scores = _scores(nodes, policy) if isinstance(policy, Scorer) else _layers(nodes, policy)
        _choice(nodes, scores)
        outputs = [
            helper.make_tensor_value_info("action", TensorProto.INT64, ["N"]),
            helper.make_tensor_value_info("scores", floats, ["N", given]),
        ]
    observation = helper.make_tensor_value_info("observation", floats, ["N", seen])
    whole = helper.make_graph(nodes.nodes, "policy", [observation], outputs, nodes.constants)
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

    def constant(self, name: str, value: ArrayLike, kind: type[np.generic] = np.float32) -> str:
        """Append a constant; returns its name."""
        from onnx import numpy_helper  # noqa: PLC0415 - of an extra

        self.constants.append(numpy_helper.from_array(np.asarray(value, dtype=kind), name))
        return name

    def part(self, name: str, of: str, entries: slice) -> str:
        """Append a part of each row; returns its name."""
        ends = {"from": entries.start, "to": entries.stop, "axis": 1, "step": entries.step or 1}
        return self.add("Slice", of, *(self.constant(f"{name}_{end}", [at], np.int64) for end, at in ends.items()))


def _layers(nodes: _Nodes, actor: Actor) -> str:
    """What the last layer gives."""
    _numbers(nodes, actor.activation)
    value = "observation"
    for k, (weight, bias) in enumerate(actor.layers):
        value = _activated(nodes, actor.activation, value) if k > 0 else value
        inputs = (nodes.constant(f"weight_{k}", weight), nodes.constant(f"bias_{k}", bias))
        value = nodes.add("Gemm", value, *inputs, transB=1)
    return value


def _scores(nodes: _Nodes, scorer: Scorer) -> str:
    """Scores (N, CHOICES) by a scorer: what its layers and its rule say of each choice, seen with its line."""
    head, whole = len(LINE_TABLE), (-1, CHOICES, len(CHOICE_TABLE))
    line = nodes.part("line", "observation", slice(0, head))
    shape = nodes.constant("whole", whole, np.int64)
    each = nodes.add("Reshape", nodes.part("choices", "observation", slice(head, ENTRIES)), shape)
    _numbers(nodes, scorer.activation)
    weight, constant = rule(scorer.patience)
    said = _seen(nodes, "rule", each, line, ((weight[None].astype(np.float32), np.float32([constant])),))
    first, *later = scorer.layers
    value = _seen(nodes, "first", each, line, (first,))
    for k, (factors, bias) in enumerate(later, 1):
        value = _activated(nodes, scorer.activation, value)
        value = nodes.add("MatMul", value, nodes.constant(f"weight_{k}", factors.T))
        value = nodes.add("Add", value, nodes.constant(f"bias_{k}", bias))
    return nodes.add("Squeeze", nodes.add("Add", value, said), nodes.constant("last", [2], np.int64))


def _seen(nodes: _Nodes, name: str, each: str, line: str, layers: Layers) -> str:
    """What one layer gives of each choice (N, CHOICES, H), whose inputs are the choice's entries, then the line's."""
    ((weight, bias),) = layers
    own, common = weight[:, : len(CHOICE_TABLE)], weight[:, len(CHOICE_TABLE) :]
    inputs = (nodes.constant(f"{name}_common", common), nodes.constant(f"{name}_bias", bias))
    same = nodes.add("Gemm", line, *inputs, transB=1)
    same = nodes.add("Unsqueeze", same, nodes.constant(f"{name}_axis", [1], np.int64))
    return nodes.add("Add", nodes.add("MatMul", each, nodes.constant(f"{name}_own", own.T)), same)


def _choice(nodes: _Nodes, scores: str) -> None:
    """Outputs `scores` and `action`, of what scores all choices."""
    there = nodes.add("Greater", nodes.part("real", "observation", REAL), nodes.constant("half_way", HALF))
    scores = nodes.add("Where", there, scores, nodes.constant("never", -np.inf), name="scores")
    nodes.add("ArgMax", scores, name="action", axis=1, keepdims=0)


def _numbers(nodes: _Nodes, activation: str) -> None:
    """Constants that an activation needs."""
    for name, number in NUMBERS.items():
        if any(name in inputs for _, *inputs in ACTIVATIONS[activation]):
            nodes.constant(name, number)


def _activated(nodes: _Nodes, activation: str, value: str) -> str:
    """An activation of a value."""
    names = {"x": value}
    for operator, *inputs in ACTIVATIONS[activation]:
        names["y"] = nodes.add(operator, *(names.get(name, name) for name in inputs))
    return names["y"]


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


def _session(model: Any) -> Any:
    """The runtime with a graph."""
    import onnxruntime  # noqa: PLC0415 - of an extra

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3  # it warns of graphics cards that are not there
    return onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])


def _asked(size: int) -> NDArray[np.float32]:
    """Observations (ROWS, size) that both are asked for."""
    return (2.0 * np.random.default_rng(0).standard_normal((ROWS, size))).astype(np.float32)


def _check_choices(model: Any, policy: Actor | Scorer) -> None:
    """Let the runtime choose on some observations, all at once and one alone."""
    session, seen = _session(model), _asked(ENTRIES)
    real, scores = there(seen), policy(seen)
    expected = Scored("", policy).act(observed_line(seen))
    for rows in (slice(None), slice(1)):
        action, found = session.run(["action", "scores"], {"observation": seen[rows]})
        apart = np.abs(found - scores[rows])[real[rows]] / max(np.ptp(scores), 1e-9)
        # Only where two choices are as good as alike may rounding tell which comes first.
        lost = np.take_along_axis(scores[rows], np.stack([action, expected[rows]], axis=1), axis=1)
        if not (apart <= PARITY).all() or (np.abs(np.diff(lost)) > PARITY * np.ptp(scores)).any():
            raise UsageError("the ONNX graph chooses otherwise than the policy")


def _check_parity(model: Any, actor: Actor) -> None:
    """Let the runtime act on some observations, all at once and one alone."""
    session, seen = _session(model), _asked(actor.sizes[0])
    found = [session.run(["action"], {"observation": rows})[0] for rows in (seen, seen[:1])]
    apart = np.abs(np.concatenate(found) - actor(np.concatenate([seen, seen[:1]]))) / (actor.high - actor.low)
    if not (apart <= PARITY).all():
        raise UsageError(
            f"the ONNX graph acts otherwise than the policy, by {apart.max():.2g} of the range of an action; "
            f"at most {PARITY:g} is rounding"
        )
