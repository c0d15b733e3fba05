"""Keep a trained policy with its card: `python -m agents.publish runs/MY_RUN`."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
import yaml

from agents import runs
from agents.cli import UsageError, at_least, option, run
from agents.controllers import make_controller
from agents.environments import make_vector
from agents.evaluation import evaluate, summary
from agents.files import write_text
from agents.report.tables import markdown
from agents.tables import console, millimetres, success_text, throws_bar
from agents.versions import ROOT

FILES = ("model.zip", "args.yml", "config.yml", "env.yaml", "versions.json", "git.txt")
"""What of a run folder a user of the policy needs: all but the replay buffer and the checkpoints."""
LEVELS = dict.fromkeys(("PnTConveyor-v0", "PnTRelease-v0"), ("waste", "unseen"))
"""Levels that a policy is judged on unless others are named, by environment; the second has items it never saw."""


@dataclass(frozen=True)
class Arguments:
    """Copy the policy of a run folder, evaluate it on held-out throws, and write its card.

    The copy is a run folder that `agents.evaluate` and `agents.play` take; training cannot go on from it.
    """

    folder: Annotated[Path, tyro.conf.Positional]
    """The run folder."""
    to: Path = ROOT / "results" / "policies"
    """Where policies are kept; the copy gets a folder of its own in it."""
    levels: Annotated[
        tuple[str, ...] | None,
        option("waste unseen on the conveyor, elsewhere the level trained on", "LEVEL ..."),
    ] = None
    """Levels to evaluate on."""
    picks: int = 1000
    """Held-out throws per level."""
    seed: int = 0
    """Names the held-out objects."""


def main(arguments: Arguments) -> None:
    """Copy, evaluate, write the card."""
    at_least("picks", arguments.picks, 1)
    asked = runs.read_arguments(arguments.folder)
    runs.load_model(arguments.folder)
    trained_on = yaml.safe_load((arguments.folder / "env.yaml").read_text(encoding="utf-8"))["name"]
    target = arguments.to / f"{asked['env']}-{trained_on}-{asked['algo']}-seed{asked['seed']}"
    if target.exists():
        raise UsageError(f"{str(target)!r} exists already; remove it first")
    levels = {level: level for level in arguments.levels or LEVELS.get(asked["env"], ())}
    levels = levels or {trained_on: str(arguments.folder / "env.yaml")}
    figures = {name: figures_on(level, arguments, asked) for name, level in levels.items()}
    target.mkdir(parents=True)
    for name in FILES:
        if (arguments.folder / name).is_file():
            shutil.copy2(arguments.folder / name, target / name)
    write_text(target / "README.md", card(asked, trained_on, figures, arguments))
    console().print(f"policy and card in {target}")


def figures_on(level: str, arguments: Arguments, asked: Mapping[str, Any]) -> dict[str, Any]:
    """The policy's figures on one level."""
    env = make_vector(asked["env"], level, action_mode=asked["action_mode"])
    try:
        controller = make_controller(str(arguments.folder), env)
        with throws_bar(console()) as bar:
            task = bar.add_task(level, total=arguments.picks)
            throws = evaluate(controller, env, arguments.picks, arguments.seed, progress=lambda n: bar.advance(task, n))
    finally:
        env.close()
    return summary(throws)


def card(
    asked: Mapping[str, Any], trained_on: str, figures: Mapping[str, Mapping[str, Any]], arguments: Arguments
) -> str:
    """The card: YAML metadata as model hubs read it, then what the policy is and what it is worth."""
    metadata = {
        "library_name": "stable-baselines3",
        "tags": ["reinforcement-learning", "robotics", "pnt_gym", asked["env"], asked["algo"]],
    }
    header = ["level", "landing error", "95th percentile", "success (95 % interval)", "sorted/min"]
    lines = [
        "---",
        yaml.safe_dump(metadata, sort_keys=False).strip(),
        "---",
        "",
        f"# {asked['algo'].upper()} on {asked['env']}, level {trained_on}",
        "",
        f"Trained for {asked['steps']} throws with seed {asked['seed']}, action mode {asked['action_mode']}. "
        f"Measured on {arguments.picks} held-out throws per level (seed {arguments.seed}):",
        "",
        markdown(header, [_row(level, found) for level, found in figures.items()]),
        "",
        "Use it with `python -m agents.evaluate --controller` and this folder. Hyperparameters are in `config.yml`, "
        "the level in full in `env.yaml`, versions in `versions.json`.",
        "",
    ]
    return "\n".join(lines)


def _row(level: str, figures: Mapping[str, Any]) -> Sequence[str]:
    return (
        level,
        millimetres(figures["landing_error_mean_m"]),
        millimetres(figures["landing_error_p95_m"]),
        success_text(figures),
        f"{figures['sorted_per_min']:.1f}",
    )


if __name__ == "__main__":
    run(main, Arguments, "agents.publish")
