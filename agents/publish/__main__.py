"""Publish a trained policy with its card: `python -m agents.publish runs/MY_RUN`."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from ..ground.cli import UsageError, at_least, check_libraries, option, run
from ..ground.environments import config_of
from ..ground.files import sweep, temporary_path, write_text
from ..ground.outputs import check_drawing, check_writable
from ..ground.places import MADE
from ..ground.tables import console, throws_bar
from ..judging import trials
from ..judging.evaluation import evaluate
from ..learning.runs import MODEL, RunFolder
from ..learning.trained import importless_environment
from .card import card
from .folder import check, check_model, copy_run, fill, level_and_folder_name

LEVELS: Mapping[str, tuple[str, ...]] = dict.fromkeys(("PnTConveyor-v0", "PnTRelease-v0"), ("waste", "unseen"))
"""Default levels of the evaluation by environment; the second level has items that were not in training."""


@dataclass(frozen=True)
class Arguments:
    """Copy the policy of a run folder, evaluate it on held-out throws or shifts, film it, and write its card.

    The copy is a run folder that `evaluate` and `play` take; training cannot go on from the copy.
    """

    folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN_DIR")]
    """The run folder."""
    env: Annotated[str | None, option("that of the run folder", "MODULE:ID")] = None
    """The environment, if a module of yours registers it and has to be imported."""
    to: Path = MADE / "results" / "policies"
    """Folder of the published policies; the copy becomes a new folder in it."""
    levels: Annotated[
        tuple[str, ...] | None,
        option("waste unseen on the conveyor, elsewhere the level trained on", "LEVEL ..."),
    ] = None
    """Levels to evaluate on."""
    picks: Annotated[int | None, option("1000", "N")] = None
    """Held-out throws per level."""
    shifts: Annotated[int | None, option("100", "N")] = None
    """Held-out work shifts per level, for a policy that chooses objects on a line."""
    seed: int = 0
    """Seed of the held-out objects."""
    model: bool = True
    """Copy model.zip, the policy with critics and optimisers for stable-baselines3: most of the folder's bytes."""
    onnx: bool = True
    """Write policy.onnx, the policy for ONNX runtimes in other languages and on other machines."""
    video: bool = True
    """Write replay.mp4, a film of some throws or of a line at work; rendering needs an OpenGL library."""


def main(arguments: Arguments) -> None:
    """Copy, draw, film and evaluate the policy and write its card; the folder appears complete or not at all."""
    at_least(vars(arguments), picks=1, shifts=1, seed=0)
    folder, run_args = arguments.folder, RunFolder(arguments.folder).arguments
    env_id = arguments.env or importless_environment(folder, run_args["env"])
    trained_on, name = level_and_folder_name(folder, env_id, run_args)
    trial = trials.find(config_of(env_id, str(folder / "env.yaml")))
    trials.check(trial, {"picks": arguments.picks, "shifts": arguments.shifts}, env_id)
    target = arguments.to / name
    if target.exists():
        raise UsageError(f"{str(target)!r} exists already; remove it first")
    check_libraries("torch", "matplotlib", *(["onnx", "onnxruntime"] if arguments.onnx else []))
    check_drawing(film=target if arguments.video else None)
    check_writable(target / "README.md")
    check_model(folder, is_copied=arguments.model)
    if arguments.onnx:
        check(run_args)
    levels = {level: level for level in arguments.levels or LEVELS.get(env_id, ())}
    levels = levels or {trained_on: str(folder / "env.yaml")}
    for level in levels.values():
        config_of(env_id, level)  # an error now, not after the film
    sweep(arguments.to)
    parts = temporary_path(target)
    try:
        parts.mkdir(parents=True)
        film_seed = arguments.seed if arguments.video else None
        left_out = () if arguments.model else (MODEL,)
        copy_run(folder, parts, left_out)
        fill(parts, folder, env_id, run_args, trial, onnx=arguments.onnx, film_seed=film_seed)
        count = getattr(arguments, trial.option, None) or trial.usual_card
        reports = {label: report(env_id, level, count, arguments, run_args) for label, level in levels.items()}
        files = {path.name for path in parts.iterdir()}
        write_text(parts / "README.md", card(run_args, trained_on, reports, name, files, trial))
        parts.rename(target)
    finally:
        shutil.rmtree(parts, ignore_errors=True)
        with suppress(OSError):  # it holds other policies, or the new one
            arguments.to.rmdir()
    console().print(f"policy and card in {target}")


def report(env_id: str, level: str, count: int, arguments: Arguments, run_args: dict[str, Any]) -> dict[str, Any]:
    """Evaluation of the policy on one level, as `agents.evaluate` reports it."""
    options: dict[str, Any] = {"level": level, "action_mode": run_args["action_mode"]}
    with throws_bar() as bar:
        task = bar.add_task(level, total=count)
        options["progress"] = lambda _, steps: bar.advance(task, steps)
        return evaluate(str(arguments.folder), env_id, count, arguments.seed, **options)


if __name__ == "__main__":
    run(main, Arguments, "agents.publish")
