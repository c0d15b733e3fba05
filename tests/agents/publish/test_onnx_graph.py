"""`policy.onnx`: the runtime finds in it the actions that stable-baselines3 finds in the model."""

from dataclasses import replace
from itertools import cycle, product
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
from torch import nn

from agents.ground.cli import UsageError
from agents.policies import weights
from agents.policies.networks import ACTIVATIONS, Dense
from agents.publish import onnx_graph
from tests.agents.policies.test_actor import HIGH, LOW, NETWORKS, PPO, RESIDUAL, SAC, model, seen
from tests.tools.nightly import with_nightly


def assert_runs_as(made: Any, file: Path) -> None:
    session = onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])
    for rows in (seen(), seen(1), seen()[:7]):
        (found,) = session.run(["action"], {"observation": rows})
        theirs = made.predict(rows, deterministic=True)[0]
        assert (found.shape, found.dtype) == (theirs.shape, theirs.dtype)
        assert (np.abs(found - theirs) <= 2e-6 * (HIGH - LOW)).all()


@pytest.mark.parametrize(
    ("algorithm", "settings"),
    with_nightly(product(RESIDUAL, NETWORKS), [*zip(cycle(RESIDUAL), NETWORKS, strict=False)]),
    ids=lambda value: str(value.get("net_arch", "default")) if isinstance(value, dict) else None,
)
def test_the_runtime_acts_as_the_model(algorithm: Any, settings: dict[str, Any], tmp_path: Path) -> None:
    made = model(algorithm, settings)
    onnx_graph.save(weights.actor(made), tmp_path / "policy.onnx", {})
    assert_runs_as(made, tmp_path / "policy.onnx")


@pytest.mark.parametrize("name", ACTIVATIONS)
def test_every_activation_has_its_operators(name: str, tmp_path: Path) -> None:
    made = model(SAC, {"net_arch": [8, 8], "activation_fn": getattr(nn, name)})
    onnx_graph.save(weights.actor(made), tmp_path / "policy.onnx", {})
    assert_runs_as(made, tmp_path / "policy.onnx")


def test_bounds_of_state_dependent_exploration_are_kept(tmp_path: Path) -> None:
    made = model("TQC", {"net_arch": [8], "clip_mean": 0.1}, use_sde=True)
    onnx_graph.save(weights.actor(made), tmp_path / "policy.onnx", {})
    assert_runs_as(made, tmp_path / "policy.onnx")


def test_what_the_graph_says_of_itself(tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("one.onnx", "other.onnx")]
    for file in files:
        onnx_graph.save(
            weights.actor(model(PPO, {"activation_fn": nn.GELU})), file, {"env": "PnTRelease-v0", "level": "waste"}
        )
    assert files[0].read_bytes() == files[1].read_bytes()
    graph = onnx.load(files[0])
    assert [(found.domain, found.version) for found in graph.opset_import] == [("", 17)]
    assert (graph.ir_version, graph.producer_name) == (8, "pnt_gym")
    assert {prop.key: prop.value for prop in graph.metadata_props} == {"env": "PnTRelease-v0", "level": "waste"}
    ends = [*graph.graph.input, *graph.graph.output]
    shapes = {end.name: [d.dim_param or d.dim_value for d in end.type.tensor_type.shape.dim] for end in ends}
    assert shapes == {"observation": ["N", 6], "action": ["N", 2]}


def test_a_graph_that_acts_otherwise_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    right = weights.actor(model(SAC, {"net_arch": [8]}))
    (weight, bias), last = right.layers
    for wrong in (
        replace(right, layers=(Dense(weight, bias + np.float32(0.01)), last)),
        replace(right, activation="Softplus"),
        replace(right, high=right.high + np.float32(0.01)),
        replace(right, bound=0.5),
    ):
        with monkeypatch.context() as patch:
            made = onnx_graph.graph(wrong, {})
            patch.setattr(onnx_graph, "graph", lambda *_, made=made: made)
            with pytest.raises(UsageError, match=r"the ONNX graph differs from the policy by .* of the range"):
                onnx_graph.save(right, tmp_path / "policy.onnx", {})
        assert not (tmp_path / "policy.onnx").exists()
