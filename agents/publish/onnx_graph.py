"""A policy as an ONNX graph, `policy.onnx`, for runtimes in many languages and on many machines.

Input `observation` (N, D), output `action` (N, A), both float32, for any number N of rows. For a policy that chooses
objects on a line, `action` is the choice (N,), int64, with the greatest of the `scores` (N, C), float32. Choices that
the observation marks as empty have the score minus infinity.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pnt_gym.cells.line.observation import ENTRIES, LINE_TABLE
from pnt_gym.cells.line.rows import CHOICES

from ..dispatchers import decisions
from ..dispatchers.rules import HALF, REAL, ScoreController, choice_mask
from ..ground.cli import UsageError
from ..ground.versions import versions
from ..policies.actor import Actor
from ..policies.networks import ACTIVATIONS, NUMBERS, Dense
from ..policies.scorer import INPUTS, Scorer, rule

OPSET: Final = 17
IR: Final = 8
"""Version of the format that belongs to this opset; runtimes since 2022 read both."""
PARITY: Final = 1e-4
"""Largest difference of the graph's actions, computed with 32 bits, from the policy's, as a share of their range."""
ROWS: Final = 256
"""Number of observations on which graph and policy are compared."""


def save(policy: Actor | Scorer, file: Path, about: Mapping[str, str]) -> None:
    """Write a policy's ONNX graph to a file, with metadata by name.

    Raises:
        UsageError: the runtime computes other actions than the policy.
    """
    import onnx  # noqa: PLC0415 - of an extra

    model = graph(policy, about)
    onnx.checker.check_model(model, full_check=True)
    if isinstance(policy, Actor) and policy.output != "scores":
        # The runtime must act like the policy, on all sample observations at once and on the first alone.
        session, observations = _session(model), _sample(policy.sizes[0])
        actions = [session.run(["action"], {"observation": rows})[0] for rows in (observations, observations[:1])]
        differences = np.abs(np.concatenate(actions) - policy(np.concatenate([observations, observations[:1]]))) / (
            policy.high - policy.low
        )
        if not (differences <= PARITY).all():
            raise UsageError(
                f"the ONNX graph differs from the policy by {differences.max():.2g} of the range of an action; at most "
                f"{PARITY:g} is rounding"
            )
    else:
        _check(model, policy)
    onnx.save_model(model, file)


def graph(policy: Actor | Scorer, about: Mapping[str, str]) -> Any:
    """The policy's graph as a model of the library onnx."""
    from onnx import TensorProto, helper  # noqa: PLC0415 - of an extra

    observation_size, output_size = policy.sizes
    nodes, floats = _Nodes(), TensorProto.FLOAT
    if isinstance(policy, Actor) and policy.output != "scores":
        # The action, from the output of the last layer.
        value = _layers(nodes, policy, "observation")
        if np.isfinite(policy.bound):
            value = nodes.add(
                "Clip", value, nodes.constant("least", -policy.bound), nodes.constant("most", policy.bound)
            )
        if policy.output == "squashed":
            half = 0.5 * (policy.high - policy.low)
            value = nodes.add("Mul", nodes.add("Tanh", value), nodes.constant("half_range", half))
            value = nodes.add("Add", value, nodes.constant("middle", policy.low + half))
        value = nodes.add("Max", value, nodes.constant("low", policy.low))
        nodes.add("Identity", nodes.add("Min", value, nodes.constant("high", policy.high)), name="action")
        outputs = [helper.make_tensor_value_info("action", floats, ["N", output_size])]
    else:
        scores = _scores(nodes, policy) if isinstance(policy, Scorer) else _layers(nodes, policy, "observation")
        _choose(nodes, scores)
        outputs = [
            helper.make_tensor_value_info("action", TensorProto.INT64, ["N"]),
            helper.make_tensor_value_info("scores", floats, ["N", output_size]),
        ]
    observation = helper.make_tensor_value_info("observation", floats, ["N", observation_size])
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
        """Append an operator; returns the name of its output."""
        from onnx import helper  # noqa: PLC0415 - of an extra

        output = name or f"{operator.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, inputs, [output], **attributes))
        return output

    def constant(self, name: str, value: ArrayLike, kind: type[np.generic] = np.float32) -> str:
        """Append a constant; returns the constant's name."""
        from onnx import numpy_helper  # noqa: PLC0415 - of an extra

        self.constants.append(numpy_helper.from_array(np.asarray(value, dtype=kind), name))
        return name

    def dense(self, name: str, value: str, layer: Dense) -> str:
        """Append a full layer; returns the name of its output."""
        weight, bias = self.constant(f"weight_{name}", layer.weight), self.constant(f"bias_{name}", layer.bias)
        return self.add("Gemm", value, weight, bias, transB=1)

    def reshape(self, name: str, value: str, *shape: int) -> str:
        """Append a reshape of a value; returns the name of its output."""
        return self.add("Reshape", value, self.constant(f"{name}_shape", shape, np.int64))

    def part(self, name: str, of: str, entries: slice) -> str:
        """Append a slice of each row; returns the name of its output."""
        ends = {"from": entries.start, "to": entries.stop, "axis": 1, "step": entries.step or 1}
        return self.add("Slice", of, *(self.constant(f"{name}_{end}", [at], np.int64) for end, at in ends.items()))


def _layers(nodes: _Nodes, policy: Actor | Scorer, value: str) -> str:
    """Append the layers of a policy; returns the name of the last layer's output."""
    _numbers(nodes, policy.activation)
    for k, layer in enumerate(policy.layers):
        if k > 0:
            names = {"x": value}
            for operator, *inputs in ACTIVATIONS[policy.activation]:
                names["y"] = nodes.add(operator, *(names.get(name, name) for name in inputs))
            value = names["y"]
        value = nodes.dense(str(k), value, layer)
    return value


def _scores(nodes: _Nodes, scorer: Scorer) -> str:
    """Append a scorer's scores (N, CHOICES): the rule's plus the layers' output for each choice's inputs."""
    head = len(LINE_TABLE)
    choices = nodes.part("choices", "observation", slice(head, ENTRIES))
    choices = nodes.reshape("each", choices, -1, CHOICES, INPUTS - head)
    line = nodes.reshape("line", nodes.part("line", "observation", slice(0, head)), -1, 1, head)
    line = nodes.add("Expand", line, nodes.constant("choices_each", [1, CHOICES, 1], np.int64))
    inputs = nodes.reshape("seen", nodes.add("Concat", choices, line, axis=2), -1, INPUTS)
    weight, constant = rule(scorer.patience)
    index = nodes.dense("rule", inputs, Dense(weight[None], np.array([constant])))
    scores = nodes.add("Add", _layers(nodes, scorer, inputs), index)
    return nodes.reshape("scores_each", scores, -1, CHOICES)


def _choose(nodes: _Nodes, scores: str) -> None:
    """Append the outputs `scores` and `action`, from the scores of all choices."""
    real = nodes.add("Greater", nodes.part("real", "observation", REAL), nodes.constant("half_way", HALF))
    scores = nodes.add("Where", real, scores, nodes.constant("never", -np.inf), name="scores")
    nodes.add("ArgMax", scores, name="action", axis=1, keepdims=0)


def _numbers(nodes: _Nodes, activation: str) -> None:
    """Append the constants of an activation."""
    for name, number in NUMBERS.items():
        if any(name in inputs for _, *inputs in ACTIVATIONS[activation]):
            nodes.constant(name, number)


def _session(model: Any) -> Any:
    """Session of the ONNX runtime with a graph."""
    import onnxruntime  # noqa: PLC0415 - of an extra

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3  # the runtime warns of missing graphics cards
    return onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])


def _sample(size: int) -> NDArray[np.float32]:
    """Random observations (ROWS, size) on which graph and policy are compared."""
    return (2.0 * np.random.default_rng(0).standard_normal((ROWS, size))).astype(np.float32)


def _check(model: Any, policy: Actor | Scorer) -> None:
    """Make sure that the runtime chooses like the policy, on all sample observations at once and on the first alone."""
    session, observations = _session(model), _sample(ENTRIES)
    real, scores = choice_mask(observations), policy(observations)
    expected = ScoreController("", policy).act(decisions.observe(observations))
    for rows in (slice(None), slice(1)):
        action, graph_scores = session.run(["action", "scores"], {"observation": observations[rows]})
        differences = np.abs(graph_scores - scores[rows])[real[rows]] / max(np.ptp(scores), 1e-9)
        # Only between nearly equal scores may rounding change the choice.
        lost = np.take_along_axis(scores[rows], np.stack([action, expected[rows]], axis=1), axis=1)
        if not (differences <= PARITY).all() or (np.abs(np.diff(lost)) > PARITY * np.ptp(scores)).any():
            raise UsageError("the ONNX graph does not choose as the policy does")
