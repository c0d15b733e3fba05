"""Keep a trained policy with its card: `python -m agents.publish runs/MY_RUN`."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import tyro

from pnt_gym.cells.base.canvas import Picture
from pnt_gym.cells.base.view import ThrowView, record_video
from pnt_gym.cells.line.view import LineView

from .controllers.between import PLANNER
from .ground.cli import UsageError, at_least, option, run
from .ground.environments import make_vector
from .ground.files import read_yaml, sweep, unfinished, write_text
from .ground.places import MADE
from .ground.tables import console, throws_bar
from .judging.evaluation import evaluate
from .learning import runs
from .learning.trained import own_environment
from .pictures.stage import Stage
from .publishing.card import CURVE, GRAPH, REPLAY, card, curve
from .publishing.onnx_graph import save_onnx

FILES = (
    "policy.npz", "model.zip", "args.yml", "config.yml", "env.yaml", "versions.json", "git.txt", "progress.csv",
)  # fmt: skip
"""What of a run folder a user of the policy needs: all but the replay buffer and the checkpoints."""
LEVELS = dict.fromkeys(("PnTConveyor-v0", "PnTRelease-v0"), ("waste", "unseen"))
"""Levels that a policy is judged on unless others are named, by environment; the second has items it never saw."""
PICKS: Final = 1000
SHIFTS: Final = 100
"""How many throws or shifts a policy is judged on unless others are asked for."""
FILMED: Final = 5
"""Throws of the film."""
FRAME: Final = Picture(width=640, height=368)
"""Small, and in whole blocks of the codec."""


@dataclass(frozen=True)
class Arguments:
    """Copy the policy of a run folder, evaluate it on held-out throws or shifts, film it, and write its card.

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
    picks: Annotated[int | None, option("1000", "N")] = None
    """Held-out throws per level."""
    shifts: Annotated[int | None, option("100", "N")] = None
    """Held-out shifts per level, of a policy that chooses at a line."""
    seed: int = 0
    """Names the held-out objects."""
    onnx: bool = True
    """Write policy.onnx, the policy for runtimes in other languages and on other machines."""
    video: bool = True
    """Write replay.mp4, a film of some throws, or of a line at work, which needs an OpenGL library."""


def main(arguments: Arguments) -> None:
    """Copy, draw, film, evaluate, write the card: a folder that is there in full or not at all."""
    at_least(vars(arguments), picks=1, shifts=1, seed=0)
    folder, asked = arguments.folder, runs.read_arguments(arguments.folder)
    count = counted(arguments, asked)
    env_id = arguments.env or own_environment(folder, asked["env"])
    trained_on, name = names(folder, env_id, asked)
    target = arguments.to / name
    if target.exists():
        raise UsageError(f"{str(target)!r} exists already; remove it first")
    check_model(folder)
    if arguments.onnx:
        check_graph(asked)
    levels = {level: level for level in arguments.levels or LEVELS.get(env_id, ())}
    levels = levels or {trained_on: str(folder / "env.yaml")}
    for level in levels.values():
        make_vector(env_id, level, 1, 1, asked["action_mode"]).close()  # an error now, not after the film
    sweep(arguments.to)
    parts = unfinished(target)
    try:
        parts.mkdir(parents=True)
        fill(parts, arguments, env_id, asked)
        mode = asked["action_mode"]
        found = {label: figures_on(env_id, level, arguments, count, mode) for label, level in levels.items()}
        files = {path.name for path in parts.iterdir()}
        write_text(parts / "README.md", card(asked, trained_on, found, name, files))
        parts.rename(target)
    finally:
        shutil.rmtree(parts, ignore_errors=True)
    console().print(f"policy and card in {target}")


def counted(arguments: Arguments, asked: Mapping[str, Any]) -> int:
    """Held-out throws, or shifts, per level.

    Raises:
        UsageError: the other ones were asked for.
    """
    line = asked["algo"] in runs.CHOOSING
    if (arguments.picks if line else arguments.shifts) is not None:
        other, its = ("--picks", "throws") if line else ("--shifts", "a line")
        raise UsageError(f"{other} goes with {its}, and not with a policy of {asked['algo']}")
    return (arguments.shifts or SHIFTS) if line else (arguments.picks or PICKS)


def names(folder: Path, env_id: str, asked: Mapping[str, Any]) -> tuple[str, str]:
    """Name of the level that a run was trained on, and that of the folder to publish it in.

    Raises:
        UsageError: they would not make a folder's name.
    """
    level = read_yaml(folder / "env.yaml", "level")
    trained_on = level.get("name") if isinstance(level, dict) else None
    try:
        return str(trained_on), runs.name_of({**asked, "env": env_id}, trained_on)
    except UsageError:
        raise UsageError(f"run folder {str(folder)!r} is damaged: env.yaml has name {trained_on!r}") from None


def check_model(folder: Path) -> None:
    """Make sure that a run's two files of its newest policy are of the same throw.

    Raises:
        UsageError: they are not, or one is missing or damaged.
    """
    from .policies.weights import actor_of  # noqa: PLC0415 - imports torch

    kept, made = (actor.numbers for actor in (runs.load_numbers(folder), actor_of(runs.load_model(folder))))
    if kept.keys() != made.keys() or not all(np.array_equal(kept[name], made[name]) for name in kept):
        raise UsageError(
            f"run folder {str(folder)!r} is damaged: {runs.POLICY} and {runs.MODEL} are not of the same throw; "
            "training that goes on with --resume mends it"
        )


def check_graph(asked: Mapping[str, Any]) -> None:
    """Make sure that a graph of the policy alone does what the policy does.

    Raises:
        UsageError: it is not all of it.
    """
    if asked["algo"] in runs.RECURRENT:
        raise UsageError(f"a policy of {asked['algo']} remembers, which policy.onnx has no place for; give --no-onnx")
    if asked["over"] != PLANNER:
        raise UsageError(f"policy.onnx would lack the controller {asked['over']!r} under the policy; give --no-onnx")


def fill(parts: Path, arguments: Arguments, env_id: str, asked: Mapping[str, Any]) -> None:
    """Everything but the card."""
    for name in FILES:
        if (arguments.folder / name).is_file():
            shutil.copy2(arguments.folder / name, parts / name)
    # Neither a date nor a version: the same bytes for the same training.
    curve(arguments.folder / "progress.csv", asked["algo"]).savefig(parts / CURVE, dpi=100, metadata={"Software": None})
    if arguments.onnx:
        about = {name: str(asked[name]) for name in ("env", "level", "algo", "steps", "seed", "action_mode")}
        save_onnx(runs.load_numbers(arguments.folder), parts / GRAPH, about)
    if arguments.video:
        film(arguments, env_id, parts / REPLAY, None if asked["algo"] in runs.CHOOSING else FILMED)


def film(arguments: Arguments, env_id: str, file: Path, picks: int | None) -> None:
    """Some throws on the level of the training, or the begin of a shift of a line."""
    with closing(Stage(str(arguments.folder), env_id, None, arguments.seed)) as stage:
        if isinstance(stage.view, ThrowView | LineView):
            stage.view.aim(FRAME)
        record_video(stage.view, stage.filmed(picks), file)


def figures_on(env_id: str, level: str, arguments: Arguments, count: int, action_mode: str) -> dict[str, Any]:
    """The policy's figures on one level, of so many throws or shifts."""
    folder, seed = str(arguments.folder), arguments.seed
    with throws_bar() as bar:
        task = bar.add_task(level, total=count)

        def show(_: str, done: int) -> None:
            bar.advance(task, done)

        return evaluate(folder, env_id, count, seed, progress=show, level=level, action_mode=action_mode)


if __name__ == "__main__":
    run(main, Arguments, "agents.publish")
