"""The card of a published policy for people and for model hubs, and the curve of its training."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.reading import text_of, yaml_text

from ..ground.cli import UsageError
from ..ground.drawings import COLOURS, Figure, dress, subplots
from ..ground.files import MOST_RESULTS
from ..ground.tables import Grid, markdown_text
from ..judging.card import Card
from ..judging.trial import Trial
from .onnx_graph import OPSET

CURVE: Final = "curve.png"
"""File of the training curve; hubs show no SVG."""
REPLAY: Final = "replay.mp4"
"""File of the film, under the name that hubs expect."""
GRAPH: Final = "policy.onnx"
PARTS: Final = {
    "policy.npz": "weights and biases: all that the commands above read, with NumPy alone",
    GRAPH: "the same as an ONNX graph, opset {opset}: {graph}",
    "model.zip": "the same, with critics and optimisers, as stable-baselines3 saves it",
    "config.yml": "hyperparameters, as RL-Zoo reads them",
    "env.yaml": "the level in full",
    "versions.json": "of Python and packages it was trained with",
    "progress.csv": "the training in figures",
}
"""Files of the folder, and their content."""
ELSEWHERE: Final = """Observations and actions are those of the environment's manual. Without this package, wherever
there is an ONNX runtime:

```python
import onnxruntime

session = onnxruntime.InferenceSession("policy.onnx")
(actions,) = session.run(["action"], {{"observation": observations}})  # (N, D) float32 to {actions}
```"""


def card(
    asked: Mapping[str, Any],
    level: str,
    figures: Mapping[str, Mapping[str, Any]],
    name: str,
    files: set[str],
    trial: type[Trial],
) -> str:
    """The card: metadata in YAML, then what the policy is, what it is worth, and how it is used.

    Args:
        asked: arguments of the training.
        level: name of the training level.
        figures: reports of `agents.evaluate`, by evaluation level.
        name: name of the folder.
        files: names of the files in the folder.
        trial: kind of trial.
    """
    found, said = next(iter(figures.values())), trial.card()
    rows = [[label, *said.cells(one)] for label, one in figures.items()]
    shown = f"success and {trial.window.label} over the training"
    holds = {file: text.format(opset=OPSET, graph=said.graph) for file, text in PARTS.items()}
    lines = [f"| `{file}` | {text} |" for file, text in holds.items() if file in files]
    commands = "\n".join(said.use).format(name=name)
    parts = (
        f"---\n{yaml_text(metadata(asked, figures, said))}---",
        markdown_text(f"# {asked['algo'].upper()} on {asked['env']}, level {level}"),
        f"Trained for {asked['steps']} {trial.step}s with seed {asked['seed']}, action mode "
        f"{markdown_text(asked['action_mode'])}.{_between(asked)} Measured on {found[said.judged]} held-out "
        f"{said.judged.replace('picks', 'throws')} per level (seed {found['seed']}):",
        Grid("", ("level", *said.header), rows).markdown(),
        f"[{said.film}]({REPLAY})." if REPLAY in files else "",
        f"The {trial.step}s that it learned from, with its exploration:\n\n![{shown}]({CURVE})",
        f"```sh\n{commands}\n```",
        ELSEWHERE.format(actions=said.actions) if GRAPH in files else "",
        "\n".join(["| file | what it holds |", "| --- | --- |", *lines]),
    )
    return "\n\n".join(part for part in parts if part) + "\n"


def _between(asked: Mapping[str, Any]) -> str:
    """Sentences on stacked observations, base controller and training on flights, if not the defaults."""
    said = "" if asked["stack"] == 1 else f" It sees the last {asked['stack']} observations of a shift, oldest first."
    more = "" if asked["over"] == "analytic" else f" Its action is added to that of `{markdown_text(asked['over'])}`."
    flights = " It learned from flights alone." if asked["fidelity"] == "flight" and not asked["full_last"] else ""
    return said + more + flights


def metadata(asked: Mapping[str, Any], figures: Mapping[str, Mapping[str, Any]], said: Card) -> dict[str, Any]:
    """Metadata for hubs: tags that find the policy, and its figures in `model-index`."""
    env_id, algo = asked["env"].rpartition(":")[2], asked["algo"]
    tags = ("reinforcement-learning", "deep-reinforcement-learning", "stable-baselines3", "robotics", "pnt_gym")
    results = [
        {
            "task": {"type": "reinforcement-learning", "name": "reinforcement-learning"},
            "dataset": {"name": f"{env_id}, level {level}", "type": env_id, "config": level},
            "metrics": [{**metric, "verified": False} for metric in _metrics(found, said)],
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


def _metrics(found: Mapping[str, Any], said: Card) -> list[dict[str, Any]]:
    reward = np.array(said.reward(found), dtype=np.float64)
    mean = {"type": "mean_reward", "value": f"{reward.mean():.2f} +/- {reward.std():.2f}", "name": said.rewarded}
    return [mean, *({"type": key, "value": round(found[key], 4), "name": name} for key, name in said.metrics.items())]


def curve(progress: Path, trial: type[Trial]) -> Figure:
    """Curves of success, and of landing error or value per minute, over the steps of a training.

    Args:
        progress: progress.csv of the training.
        trial: kind of trial.

    Raises:
        UsageError: progress.csv is missing, or was not written by a training.
    """
    count, _, success, figure_, _ = _columns(progress)
    window, steps = trial.window, f"{trial.step}s"
    figure, (left, right) = subplots(1, 2, (9.0, 3.2))
    left.plot(count, 100.0 * success, color=COLOURS[0])
    dress(left, steps, "success [%]", ylim=(0.0, 102.0))
    right.plot(count, window.scale * figure_, color=COLOURS[1])
    dress(right, steps, window.label, ylim=(0.0, None))
    return figure


def _columns(progress: Path) -> Floats:
    """Columns of progress.csv, as `agents.learning.progress` writes it."""
    try:
        lines = text_of(progress, MOST_RESULTS).splitlines()[1:]
        rows = np.array([[float(number) for number in line.split(",")] for line in lines])
    except ValueError:
        rows = np.zeros(0)
    if rows.shape[1:] != (5,):
        raise UsageError(f"run folder {str(progress.parent)!r} is damaged: {progress.name} is missing or torn")
    return rows.T
