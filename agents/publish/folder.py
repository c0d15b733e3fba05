"""The folder of a published policy: its copied files, curve, film and graph."""

from __future__ import annotations

import io
import shutil
from collections.abc import Collection, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from pnt_gym.cells.base.canvas import Picture
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.line.view import LineView

from ..controllers.between import PLANNER
from ..ground.cli import UsageError
from ..ground.files import read_yaml
from ..judging.trial import Trial
from ..learning import runs
from ..learning.hyperparameters import RECURRENT
from ..pictures.stage import Stage
from . import onnx_graph
from .card import CURVE, GRAPH, REPLAY, curve

FILES: Final = (
    "policy.npz", "model.zip", "args.yml", "config.yml", "env.yaml", "versions.json", "git.txt", "progress.csv",
)  # fmt: skip
"""Files of a run folder that a user of the policy needs: all but the replay buffer and the checkpoints."""
FRAME: Final = Picture(width=640, height=368)
"""Size of the film: small, and a multiple of the codec's blocks."""


def level_and_folder_name(folder: Path, env_id: str, run_args: Mapping[str, Any]) -> tuple[str, str]:
    """Name of a run's training level, and name of the folder of its published policy.

    Raises:
        UsageError: the two make no valid folder's name.
    """
    level = read_yaml(folder / "env.yaml", "level")
    trained_on = level.get("name") if isinstance(level, dict) else None
    try:
        return str(trained_on), runs.name({**run_args, "env": env_id}, trained_on)
    except UsageError:
        raise UsageError(f"run folder {str(folder)!r} is damaged: env.yaml has name {trained_on!r}") from None


def check_model(folder: Path, *, is_copied: bool) -> None:
    """Make sure that a run's policy can be published, and that its model.zip, if that goes along, holds the same one.

    Raises:
        UsageError: the policies differ, see pictures, or a file is missing or damaged.
    """
    from ..policies import weights  # noqa: PLC0415 - imports torch

    run = runs.RunFolder(folder)
    if getattr(run.load_policy(), "eye", None) is not None:
        raise UsageError(f"the policy of {str(folder)!r} sees pictures; only policies of vectors are published")
    if not is_copied:
        return
    stored, rebuilt = (policy.numbers for policy in (run.load_policy(), weights.actor(run.load())))
    if stored.keys() != rebuilt.keys() or not all(np.array_equal(stored[name], rebuilt[name]) for name in stored):
        raise UsageError(
            f"run folder {str(folder)!r} is damaged: {runs.POLICY} and {runs.MODEL} are from different moments of "
            "the training; continue it with --resume to write both anew"
        )


def check(run_args: Mapping[str, Any]) -> None:
    """Make sure that a policy's ONNX graph can act like the policy: without memory and without a base controller.

    Raises:
        UsageError: the policy is recurrent, or is added to a base controller.
    """
    if run_args["algo"] in RECURRENT:
        raise UsageError(f"a policy of {run_args['algo']} has a memory, which policy.onnx cannot hold; give --no-onnx")
    if run_args["over"] != PLANNER:
        raise UsageError(f"policy.onnx would lack the controller {run_args['over']!r} under the policy; give --no-onnx")


def copy_run(folder: Path, parts: Path, left_out: Collection[str]) -> None:
    """Copy the files of a run folder that a user of the policy needs, but for some of them."""
    for name in FILES:
        if name not in left_out and (folder / name).is_file():
            shutil.copy2(folder / name, parts / name)


def fill(
    parts: Path,
    folder: Path,
    env_id: str,
    run_args: Mapping[str, Any],
    trial: type[Trial],
    *,
    onnx: bool,
    film_seed: int | None,
) -> None:
    """Write what a run folder lacks, all but the card, into the folder of a published policy.

    Args:
        parts: the new folder.
        folder: folder of the run.
        env_id: id of the run's environment.
        run_args: arguments of the training.
        trial: kind of trial.
        onnx: write the policy's ONNX graph.
        film_seed: seed of the film's objects; None for no film.
    """
    from PIL import Image  # noqa: PLC0415 - comes with Matplotlib, which only drawings need

    drawn = io.BytesIO()
    curve(folder / "progress.csv", trial).savefig(drawn, dpi=100)
    # Sixty-four colours are a third of the bytes; without metadata the same training gives the same bytes.
    Image.open(io.BytesIO(drawn.getvalue())).convert("RGB").quantize(64).save(parts / CURVE, optimize=True)
    if onnx:
        about = {name: str(run_args[name]) for name in ("env", "level", "algo", "steps", "seed", "action_mode")}
        onnx_graph.save(runs.RunFolder(folder).load_policy(), parts / GRAPH, about)
    if film_seed is not None:
        film(folder, env_id, film_seed, parts / REPLAY)


def film(folder: Path, env_id: str, seed: int, file: Path) -> None:
    """Film some steps of the policy on the level of its training, in small frames."""
    with closing(Stage(str(folder), env_id, None, seed)) as stage:
        if isinstance(stage.view, ThrowView | LineView):
            stage.view.aim(FRAME)
        stage.film(file)
