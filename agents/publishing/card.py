"""The card of a published policy, as people and as model hubs read it, and its training as a picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.reading import text_of, yaml_text

from ..ground.cli import UsageError
from ..ground.drawings import COLOURS, Figure, dress, subplots
from ..ground.files import MOST_RESULTS
from ..ground.tables import Grid, landing_cells, markdown_text, percent
from ..learning.runs import CHOOSING
from .onnx_graph import OPSET

CURVE: Final = "curve.png"
"""Hubs show no SVG."""
REPLAY: Final = "replay.mp4"
"""The name under which hubs look for a film."""
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
"""Files of the folder, and what they hold."""
ELSEWHERE: Final = """Observations and actions are those of the environment's manual. Without this package, wherever
there is an ONNX runtime:

```python
import onnxruntime

session = onnxruntime.InferenceSession("policy.onnx")
(actions,) = session.run(["action"], {{"observation": observations}})  # (N, D) float32 to {actions}
```"""


@final
@dataclass(frozen=True)
class Said:
    """What cards say of one kind of policies."""

    count: str
    """What is learned from."""
    judged: str
    """Key of the figure that tells how many of what it was judged on."""
    header: tuple[str, ...]
    cells: Callable[[Mapping[str, Any]], list[str]]
    """Of a table of figures by level, but for the level."""
    reward: Callable[[Mapping[str, Any]], Sequence[float]]
    """What hubs are told as rewards, of an evaluation."""
    rewarded: str
    metrics: Mapping[str, str]
    """Figures beside it that hubs are told, and what they are called there."""
    film: str
    shown: str
    """What the curve of the training shows."""
    use: tuple[str, ...]
    """Commands."""
    graph: str
    """What the graph gives."""
    actions: str
    """The same where it is called."""


THROWS: Final = Said(
    count="throws",
    judged="picks",
    header=("landing error", "95th percentile", "under 30 mm", "success (95 % interval)", "sorted/min"),
    cells=lambda found: [*landing_cells(found), f"{found['sorted_per_min']:.1f}"],
    reward=lambda found: [throw["reward"] for throw in found["throws"]],
    rewarded="reward of a throw",
    metrics={
        "success_rate": "share of throws that succeed",
        "landing_error_mean_m": "landing error, mean [m]",
        "sorted_per_min": "sorted picks per minute",
    },
    film="A film of some throws",
    shown="success and landing error over the throws of the training",
    use=("pnt-gym evaluate --controller {name} --picks 200", "pnt-gym play --controller {name} --video throws.mp4"),
    graph="`observation` (N, D) to `action` (N, A)",
    actions="(N, A) float32",
)
SHIFTS: Final = Said(
    count="decisions",
    judged="shifts",
    header=("value/min (95 % interval)", "sorted/min", "recovery", "recovery of value", "ms/decision"),
    cells=lambda found: [
        f"{found['value_per_min']:.1f} ({found['value_per_min_low']:.1f}..{found['value_per_min_high']:.1f})",
        f"{found['sorted_per_min']:.1f}",
        *(percent(found[name]) for name in ("recovery", "value_recovery")),
        f"{found['ms_per_decision']:.2f}",
    ],
    reward=lambda found: found["by_shift"]["value_per_min"],
    rewarded="value per minute of a shift",
    metrics={
        "sorted_per_min": "sorted picks per minute",
        "recovery": "share of all objects that came which was sorted",
        "value_recovery": "share of their value",
    },
    film="A film of the line at work",
    shown="success and value per minute over the decisions of the training",
    use=(
        "pnt-gym evaluate --controller {name} --shifts 100",
        "pnt-gym play --controller {name} --video line.mp4",
    ),
    graph="`observation` (N, D) to the choice `action` (N,) and the `scores` (N, C) of all that there are",
    actions="(N,) int64",
)


def said_of(algo: str) -> Said:
    """What cards say of policies of an algorithm."""
    return SHIFTS if algo in CHOOSING else THROWS


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
    found, said = next(iter(figures.values())), said_of(asked["algo"])
    rows = [[label, *said.cells(one)] for label, one in figures.items()]
    holds = {file: text.format(opset=OPSET, graph=said.graph) for file, text in PARTS.items()}
    lines = [f"| `{file}` | {text} |" for file, text in holds.items() if file in files]
    commands = "\n".join(said.use).format(name=name)
    parts = (
        f"---\n{yaml_text(metadata(asked, figures))}---",
        markdown_text(f"# {asked['algo'].upper()} on {asked['env']}, level {level}"),
        f"Trained for {asked['steps']} {said.count} with seed {asked['seed']}, action mode "
        f"{markdown_text(asked['action_mode'])}.{_between(asked)} Measured on {found[said.judged]} held-out "
        f"{said.judged.replace('picks', 'throws')} per level (seed {found['seed']}):",
        Grid("", ("level", *said.header), rows).markdown(),
        f"[{said.film}]({REPLAY})." if REPLAY in files else "",
        f"The {said.count} that it learned from, with its exploration:\n\n![{said.shown}]({CURVE})",
        f"```sh\n{commands}\n```",
        ELSEWHERE.format(actions=said.actions) if GRAPH in files else "",
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
            "metrics": [{**metric, "verified": False} for metric in _metrics(found, said_of(algo))],
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


def _metrics(found: Mapping[str, Any], said: Said) -> list[dict[str, Any]]:
    reward = np.array(said.reward(found), dtype=np.float64)
    mean = {"type": "mean_reward", "value": f"{reward.mean():.2f} +/- {reward.std():.2f}", "name": said.rewarded}
    return [mean, *({"type": key, "value": round(found[key], 4), "name": name} for key, name in said.metrics.items())]


def curve(progress: Path, algo: str) -> Figure:
    """Success, and landing error or value per minute, over what a training learned from.

    Raises:
        UsageError: progress.csv is missing, or was not written by a training.
    """
    count, _, success, figure_, _ = _columns(progress)
    said, figure, (left, right) = said_of(algo), *subplots(1, 2, (9.0, 3.2))
    left.plot(count, 100.0 * success, color=COLOURS[0])
    dress(left, said.count, "success [%]", ylim=(0.0, 102.0))
    error = said is THROWS
    right.plot(count, 1000.0 * figure_ if error else figure_, color=COLOURS[1])
    dress(right, said.count, "landing error, mean [mm]" if error else "value per minute", ylim=(0.0, None))
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
