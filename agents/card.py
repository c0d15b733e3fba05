"""The card of a published policy, as people and as model hubs read it, and its training as a picture."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml

from pnt_gym.arrays import Floats

from .cli import UsageError
from .drawings import COLOURS, Figure, dress, subplots
from .onnx_graph import OPSET
from .tables import Grid, landing_cells, markdown_text

CURVE: Final = "curve.png"
"""Hubs show no SVG."""
REPLAY: Final = "replay.mp4"
"""The name under which hubs look for a film."""
GRAPH: Final = "policy.onnx"
PARTS: Final = {
    "policy.npz": "weights and biases: all that the commands above read, with NumPy alone",
    GRAPH: f"the same as an ONNX graph, opset {OPSET}: `observation` (N, D) to `action` (N, A)",
    "model.zip": "the same, with critics and optimisers, as stable-baselines3 saves it",
    "config.yml": "hyperparameters, as RL-Zoo reads them",
    "env.yaml": "the level in full",
    "versions.json": "of Python and packages it was trained with",
    "progress.csv": "the training in figures",
}
"""Files of the folder, and what they hold."""
FILM: Final = f"[A film of some throws]({REPLAY})."
TRAINING: Final = f"""The throws that it learned from, with its exploration:

![success and landing error over the throws of the training]({CURVE})"""
USE: Final = """```sh
pnt-gym evaluate --controller {name} --picks 200
pnt-gym play --controller {name} --video throws.mp4
```"""
ELSEWHERE: Final = """Observations and actions are those of the environment's manual. Without this package, wherever
there is an ONNX runtime:

```python
import onnxruntime

session = onnxruntime.InferenceSession("policy.onnx")
(actions,) = session.run(["action"], {"observation": observations})  # (N, D) float32 to (N, A) float32
```"""
METRICS: Final = {
    "success_rate": "share of throws that succeed",
    "landing_error_mean_m": "landing error, mean [m]",
    "sorted_per_min": "sorted picks per minute",
}
"""Figures beside the reward that hubs are told, and what they are called there."""


def card(
    asked: Mapping[str, Any], level: str, figures: Mapping[str, Mapping[str, Any]], name: str, files: set[str]
) -> str:
    """The card: metadata in YAML, then what the policy is, what it is worth, and how it is used.

    Args:
        asked: what its training was asked for.
        level: it was trained on.
        figures: what `agents.evaluate` found, by the levels it is judged on.
        name: of the folder.
        files: names of what lies in the folder.
    """
    found = next(iter(figures.values()))
    header = ["level", "landing error", "95th percentile", "under 30 mm", "success (95 % interval)", "sorted/min"]
    rows = [[label, *landing_cells(one), f"{one['sorted_per_min']:.1f}"] for label, one in figures.items()]
    lines = [f"| `{file}` | {holds} |" for file, holds in PARTS.items() if file in files]
    parts = (
        f"---\n{yaml.safe_dump(metadata(asked, figures), sort_keys=False)}---",
        markdown_text(f"# {asked['algo'].upper()} on {asked['env']}, level {level}"),
        f"Trained for {asked['steps']} throws with seed {asked['seed']}, action mode "
        f"{markdown_text(asked['action_mode'])}.{_between(asked)} Measured on {found['picks']} held-out throws per "
        f"level (seed {found['seed']}):",
        Grid("", header, rows).markdown(),
        FILM if REPLAY in files else "",
        TRAINING,
        USE.format(name=name),
        ELSEWHERE if GRAPH in files else "",
        "\n".join(["| file | what it holds |", "| --- | --- |", *lines]),
    )
    return "\n\n".join(part for part in parts if part) + "\n"


def _between(asked: Mapping[str, Any]) -> str:
    """What stands between the policy and its environment, and what it learned from if not from the whole of it."""
    said = "" if asked["stack"] == 1 else f" It sees the last {asked['stack']} observations of a shift, oldest first."
    more = "" if asked["over"] == "analytic" else f" Its action is added to that of `{markdown_text(asked['over'])}`."
    flights = " It learned from flights alone." if asked["fidelity"] == "flight" and not asked["full_last"] else ""
    return said + more + flights


def metadata(asked: Mapping[str, Any], figures: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """What hubs read: by what the policy is found, and in `model-index` what it is worth."""
    env_id, algo = asked["env"].rpartition(":")[2], asked["algo"]
    tags = ("reinforcement-learning", "deep-reinforcement-learning", "stable-baselines3", "robotics", "pnt_gym")
    results = [
        {
            "task": {"type": "reinforcement-learning", "name": "reinforcement-learning"},
            "dataset": {"name": f"{env_id}, level {level}", "type": env_id, "config": level},
            "metrics": [{**metric, "verified": False} for metric in _metrics(found)],
        }
        for level, found in figures.items()
    ]
    return {
        "library_name": "stable-baselines3",
        "pipeline_tag": "reinforcement-learning",
        "license": "mit",
        "tags": [*tags, env_id, algo],
        "model-index": [{"name": algo.upper(), "results": results}],
    }


def _metrics(found: Mapping[str, Any]) -> list[dict[str, Any]]:
    reward = np.array([throw["reward"] for throw in found["throws"]], dtype=np.float64)
    mean = {"type": "mean_reward", "value": f"{reward.mean():.2f} +/- {reward.std():.2f}", "name": "reward of a throw"}
    return [mean, *({"type": key, "value": round(found[key], 4), "name": name} for key, name in METRICS.items())]


def curve(progress: Path) -> Figure:
    """Success and landing error over the throws of a training.

    Raises:
        UsageError: progress.csv is missing, or was not written by a training.
    """
    throws, _, success, error, _ = _columns(progress)
    figure, (left, right) = subplots(1, 2, (9.0, 3.2))
    left.plot(throws, 100.0 * success, color=COLOURS[0])
    right.plot(throws, 1000.0 * error, color=COLOURS[1])
    dress(left, "throws", "success [%]", ylim=(0.0, 102.0))
    dress(right, "throws", "landing error, mean [mm]", ylim=(0.0, None))
    return figure


def _columns(progress: Path) -> Floats:
    """Columns of progress.csv, as `agents.progress` writes it."""
    try:
        lines = progress.read_text(encoding="utf-8").splitlines()[1:]
        rows = np.array([[float(number) for number in line.split(",")] for line in lines])
    except (OSError, ValueError):
        rows = np.zeros(0)
    if rows.shape[1:] != (5,):
        raise UsageError(f"run folder {str(progress.parent)!r} is damaged: {progress.name} is missing or torn")
    return rows.T
