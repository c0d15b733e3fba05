"""Keep a trained policy with its card: `python -m agents.publish runs/MY_RUN`."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
import yaml

from . import runs
from .cli import UsageError, at_least, option, run
from .evaluation import evaluate
from .files import read_yaml, sweep, unfinished, write_text
from .places import MADE
from .tables import Grid, console, landing_cells, markdown_text, throws_bar
from .trained import own_environment

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
    env: Annotated[str | None, option("that of the run folder", "MODULE:ID")] = None
    """The environment, if a module of yours has to be imported for it."""
    to: Path = MADE / "results" / "policies"
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
    at_least(vars(arguments), picks=1)
    asked = runs.read_arguments(arguments.folder)
    env_id = arguments.env or own_environment(arguments.folder, asked["env"])
    runs.load_model(arguments.folder)
    level = read_yaml(arguments.folder / "env.yaml", "level")
    trained_on = level.get("name") if isinstance(level, dict) else None
    name = f"{env_id.rpartition(':')[2]}-{trained_on}-{asked['algo']}-seed{asked['seed']}"
    if not isinstance(trained_on, str) or Path(name).name != name:
        raise UsageError(f"run folder {str(arguments.folder)!r} is damaged: env.yaml has name {trained_on!r}")
    target = arguments.to / name
    if target.exists():
        raise UsageError(f"{str(target)!r} exists already; remove it first")
    levels = {level: level for level in arguments.levels or LEVELS.get(env_id, ())}
    levels = levels or {trained_on: str(arguments.folder / "env.yaml")}
    figures = {name: figures_on(env_id, level, arguments, asked["action_mode"]) for name, level in levels.items()}
    sweep(arguments.to)
    parts = unfinished(target)
    parts.mkdir(parents=True)
    for name in FILES:
        if (arguments.folder / name).is_file():
            shutil.copy2(arguments.folder / name, parts / name)
    write_text(parts / "README.md", card(asked, trained_on, figures, arguments))
    parts.rename(target)
    console().print(f"policy and card in {target}")


def figures_on(env_id: str, level: str, arguments: Arguments, action_mode: str) -> dict[str, Any]:
    """The policy's figures on one level."""
    folder, picks, seed = str(arguments.folder), arguments.picks, arguments.seed
    with throws_bar() as bar:
        task = bar.add_task(level, total=picks)

        def show(_: str, throws: int) -> None:
            bar.advance(task, throws)

        return evaluate(folder, env_id, picks, seed, progress=show, level=level, action_mode=action_mode)


def card(
    asked: Mapping[str, Any], trained_on: str, figures: Mapping[str, Mapping[str, Any]], arguments: Arguments
) -> str:
    """The card: YAML metadata as model hubs read it, then what the policy is and what it is worth."""
    metadata = {
        "library_name": "stable-baselines3",
        "tags": ["reinforcement-learning", "robotics", "pnt_gym", asked["env"], asked["algo"]],
    }
    header = ["level", "landing error", "95th percentile", "success (95 % interval)", "sorted/min"]
    rows = [[level, *landing_cells(found), f"{found['sorted_per_min']:.1f}"] for level, found in figures.items()]
    parts = (
        f"---\n{yaml.safe_dump(metadata, sort_keys=False)}---",
        markdown_text(f"# {asked['algo'].upper()} on {asked['env']}, level {trained_on}"),
        f"Trained for {asked['steps']} throws with seed {asked['seed']}, action mode "
        f"{markdown_text(asked['action_mode'])}. Measured on {arguments.picks} held-out throws per level "
        f"(seed {arguments.seed}):",
        Grid("", header, rows).markdown(),
        "Use it with `python -m agents.evaluate --controller` and this folder. Hyperparameters are in `config.yml`, "
        "the level in full in `env.yaml`, versions in `versions.json`.\n",
    )
    return "\n\n".join(parts)


if __name__ == "__main__":
    run(main, Arguments, "agents.publish")
