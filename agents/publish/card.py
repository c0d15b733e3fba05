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
from ..judging.record import Card
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
    run_args: Mapping[str, Any],
    level: str,
    figures: Mapping[str, Mapping[str, Any]],
    name: str,
    files: set[str],
    trial: type[Trial],
) -> str:
    """The card: metadata in YAML, then what the policy is, what it is worth, and how it is used.

    Args:
        run_args: arguments of the training.
        level: name of the training level.
        figures: reports of `agents.evaluate`, by evaluation level.
        name: name of the folder.
        files: names of the files in the folder.
        trial: kind of trial.
    """
    first, kind_card = next(iter(figures.values())), trial.card()
    rows = [[label, *kind_card.cells(report)] for label, report in figures.items()]
    shown = f"success and {trial.window.label} over the training"
    holds = {file: text.format(opset=OPSET, graph=kind_card.graph) for file, text in PARTS.items()}
    lines = [f"| `{file}` | {text} |" for file, text in holds.items() if file in files]
    commands = "\n".join(kind_card.use).format(name=name)
    parts = (
        f"---\n{yaml_text(metadata(run_args, figures, kind_card))}---",
        markdown_text(f"# {run_args['algo'].upper()} on {run_args['env']}, level {level}"),
        f"Trained for {run_args['steps']} {trial.step}s with seed {run_args['seed']}, action mode "
        f"{markdown_text(run_args['action_mode'])}.{_text(run_args)} Measured on {first[kind_card.judged]} "
        f"held-out {kind_card.judged.replace('picks', 'throws')} per level (seed {first['seed']}):",
        Grid("", ("level", *kind_card.header), rows).markdown(),
        f"[{kind_card.film}]({REPLAY})." if REPLAY in files else "",
        f"The {trial.step}s that it learned from, with its exploration:\n\n![{shown}]({CURVE})",
        f"```sh\n{commands}\n```",
        ELSEWHERE.format(actions=kind_card.actions) if GRAPH in files else "",
        "\n".join(["| file | what it holds |", "| --- | --- |", *lines]),
    )
    return "\n\n".join(part for part in parts if part) + "\n"


def _text(run_args: Mapping[str, Any]) -> str:
    """Sentences on stacked observations, base controller and training on flights, if not the defaults."""
    stack_text = (
        ""
        if run_args["stack"] == 1
        else f" It sees the last {run_args['stack']} observations of a shift, oldest first."
    )
    base_text = (
        ""
        if run_args["over"] == "analytic"
        else f" Its action is added to that of `{markdown_text(run_args['over'])}`."
    )
    flights = (
        " It learned from flights alone." if run_args["fidelity"] == "flight" and not run_args["full_last"] else ""
    )
    return stack_text + base_text + flights


def metadata(run_args: Mapping[str, Any], figures: Mapping[str, Mapping[str, Any]], kind_card: Card) -> dict[str, Any]:
    """Metadata for hubs: tags that find the policy, and its figures in `model-index`."""
    env_id, algo = run_args["env"].rpartition(":")[2], run_args["algo"]
    tags = ("reinforcement-learning", "deep-reinforcement-learning", "stable-baselines3", "robotics", "pnt_gym")
    results = [
        {
            "task": {"type": "reinforcement-learning", "name": "reinforcement-learning"},
            "dataset": {"name": f"{env_id}, level {level}", "type": env_id, "config": level},
            "metrics": [{**metric, "verified": False} for metric in _metrics(report, kind_card)],
        }
        for level, report in figures.items()
    ]
    return {
        "library_name": "stable-baselines3",
        "pipeline_tag": "reinforcement-learning",
        "license": "mit",
        "tags": [*tags, env_id, algo],
        "model-index": [{"name": algo.upper(), "results": results}],
    }


def _metrics(report: Mapping[str, Any], kind_card: Card) -> list[dict[str, Any]]:
    reward = np.array(kind_card.reward(report), dtype=np.float64)
    mean = {"type": "mean_reward", "value": f"{reward.mean():.2f} +/- {reward.std():.2f}", "name": kind_card.rewarded}
    return [
        mean,
        *({"type": key, "value": round(report[key], 4), "name": name} for key, name in kind_card.metrics.items()),
    ]


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
