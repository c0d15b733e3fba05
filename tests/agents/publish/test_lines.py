"""Policies that choose at a line are published like others: card, film, and a graph that makes the same choices."""

from functools import partial
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import onnxruntime
import pytest
import yaml

from agents.controllers.protocol import Observation
from agents.dispatchers.rules import ScoreController, choice_mask, run_scores
from agents.ground.cli import UsageError
from agents.judging.evaluation import evaluate
from agents.learning.runs import RunFolder
from agents.policies.actor import Actor
from agents.policies.networks import Dense
from agents.policies.scorer import INPUTS, Scorer
from agents.publish import __main__ as publish
from agents.publish import onnx_graph
from agents.publish.__main__ import Arguments
from agents.publish.folder import film
from pnt_gym.cells.base.canvas import Picture
from pnt_gym.cells.base.view import record_video
from pnt_gym.cells.line.observation import ENTRIES
from pnt_gym.cells.line.rows import CHOICES
from tests.tools.commands import output_of
from tests.tools.line import observed, vector_lines
from tests.tools.nightly import with_nightly

LEVEL = {"base": "skills3_burst", "name": "brief", "duration": 5.0}
SMALL = {"n_steps": 4, "batch_size": 8, "policy_kwargs": {"net_arch": [8, 8]}}


@pytest.fixture(scope="module")
def seen() -> np.ndarray:
    """Observations (N, ENTRIES) along shifts of the ATC rule."""
    env, _ = vector_lines(LEVEL, 8)
    return np.concatenate([known.features for known, _ in observed(env, 12, seed=4)])


def layers(*sizes: int, seed: int = 0) -> Any:
    random = np.random.default_rng(seed)
    shapes = zip(sizes[1:], sizes[:-1], strict=True)
    return tuple(
        Dense(random.normal(size=s).astype(np.float32) / 4, random.normal(size=s[0]).astype(np.float32)) for s in shapes
    )


def chooser(activation: str = "Tanh") -> Actor:
    most = np.full(CHOICES, np.finfo(np.float32).max, dtype=np.float32)
    return Actor(layers(ENTRIES, 8, CHOICES), activation, "scores", np.inf, -most, most)


POLICIES: list[Actor | Scorer] = [
    Scorer.linear(1.4),
    Scorer.linear(8.0, {"pick_x": -0.3, "ln_rate": 0.5}),
    Scorer(layers(INPUTS, 8, 4, 1), 1.7),
    Scorer(layers(INPUTS, 8, 1), 1.7, "GELU"),
    chooser(),
    chooser("SiLU"),
]


@pytest.mark.parametrize("policy", POLICIES, ids=lambda p: f"{type(p).__name__}-{p.activation}-{len(p.layers)}")
def test_the_runtime_chooses_as_the_policy(policy: Actor | Scorer, seen: np.ndarray, tmp_path: Path) -> None:
    onnx_graph.save(policy, tmp_path / "policy.onnx", {"env": "PnTLine-v0"})
    session = onnxruntime.InferenceSession(tmp_path / "policy.onnx", providers=["CPUExecutionProvider"])
    expected = ScoreController("it", policy).act(Observation(seen, np.zeros(len(seen), dtype=np.int64)))
    assert len(set(expected.tolist())) > 1
    for rows in (slice(None), slice(1), slice(3, 10)):
        action, scores = session.run(["action", "scores"], {"observation": seen[rows]})
        assert (action.dtype, action.shape) == (np.int64, expected[rows].shape)
        np.testing.assert_array_equal(action, expected[rows])
        real = choice_mask(seen[rows])
        np.testing.assert_allclose(scores[real], policy(seen[rows])[real], rtol=1e-5, atol=1e-5)
        assert np.isneginf(scores[~real]).all()


def test_a_graph_that_chooses_otherwise_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    right = Scorer(layers(INPUTS, 8, 1), 1.7)
    for wrong in (Scorer(right.layers, 1.8), Scorer(layers(INPUTS, 8, 1, seed=1), 1.7), chooser()):
        with monkeypatch.context() as patch:
            made = onnx_graph.graph(wrong, {})
            patch.setattr(onnx_graph, "graph", lambda *_, made=made: made)
            with pytest.raises(UsageError, match="the ONNX graph does not choose as the policy does"):
                onnx_graph.save(right, tmp_path / "policy.onnx", {})
        assert not (tmp_path / "policy.onnx").exists()


@pytest.fixture(scope="module", params=with_nightly(("residual_ppo", "maskable_ppo"), ["residual_ppo"]))
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp(request.param)
    (place / "brief.yaml").write_text(yaml.safe_dump(LEVEL))
    (place / "own.yml").write_text(yaml.safe_dump({"PnTLine-v0": SMALL}))
    what = f"--env PnTLine-v0 --level brief.yaml --algo {request.param} --config own.yml"
    output_of(f"train {what} --steps 16 --num-envs 2 --eval-picks 0 --out run", place)
    return place / "run"


def test_a_published_policy_works_as_the_run_did(run: Path, seen: np.ndarray, tmp_path: Path) -> None:
    publish.main(Arguments(run, to=tmp_path, shifts=3, video=False))
    (copy,) = tmp_path.iterdir()
    algo = RunFolder(run).arguments["algo"]
    assert copy.name == f"PnTLine-v0-brief-{algo}-seed0"
    told = [evaluate(str(place), "PnTLine-v0", 3, level=str(run / "env.yaml")) for place in (run, copy)]
    for one in told:
        one.pop("ms_per_decision")
        one.pop("controller")
    assert told[0] == told[1]
    session = onnxruntime.InferenceSession(copy / "policy.onnx", providers=["CPUExecutionProvider"])
    expected = run_scores(copy).act(Observation(seen, np.zeros(len(seen), dtype=np.int64)))
    np.testing.assert_array_equal(session.run(["action"], {"observation": seen})[0], expected)
    card = (copy / "README.md").read_text()
    assert f"| brief | {told[0]['value_per_min']:.1f} (" in card
    assert "Trained for 16 decisions" in card
    assert "3 held-out shifts per level" in card
    assert f"--controller {copy.name} --shifts 100" in card
    assert "throw" not in card.replace("mean_reward", "")
    (result,) = yaml.safe_load(card.split("---\n")[1])["model-index"][0]["results"]
    metrics = {metric["type"]: metric["value"] for metric in result["metrics"]}
    value = np.array(told[0]["by_shift"]["value_per_min"])
    assert metrics["mean_reward"] == f"{value.mean():.2f} +/- {value.std():.2f}"
    assert metrics["recovery"] == round(told[0]["recovery"], 4)


@pytest.mark.usefixtures("opengl")
def test_the_film_shows_the_line(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.judging.shift_trial.SECONDS", 2.0)
    monkeypatch.setattr("agents.publish.folder.FRAME", Picture(width=160, height=96))
    monkeypatch.setattr("agents.pictures.stage.record_video", partial(record_video, fps=5))
    film(run, "PnTLine-v0", 0, tmp_path / "replay.mp4")
    frames = iio.imread(tmp_path / "replay.mp4")
    assert frames.shape[1:] == (96, 160, 3)
    assert 5 <= len(frames) <= 15
    assert np.abs(frames[0].astype(int) - frames[-1].astype(int)).max() > 40
