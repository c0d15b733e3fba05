"""Arguments of a training: from the command line and the defaults, or from the run that is resumed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from ..controllers.between import PLANNER
from ..ground.cli import UsageError
from ..ground.environments import config_of
from ..judging.trials import trial_class
from ..learning.hyperparameters import hyperparameters, training_size
from ..learning.runs import RunFolder, check_new
from ..learning.trained import importless_environment

LEVELS: Final[Mapping[str, str]] = dict.fromkeys(("PnTConveyor-v0", "PnTRelease-v0"), "waste")
"""Default level of a training by environment: a level where learning improves the success, not only the landing."""
DEFAULTS: Final[Mapping[str, Any]] = {
    "env": "PnTConveyor-v0",
    "level": None,
    "fidelity": "full",
    "full_last": 0,
    "algo": None,
    "steps": None,
    "seed": 0,
    "num_envs": None,
    "action_mode": None,
    "checkpoint_every": None,
    "stack": 1,
    "over": PLANNER,
    "eval_picks": None,
    "tensorboard": False,
}
"""Default arguments of a new run, which its folder keeps; None for defaults of the kind of trial or of the
hyperparameters."""
ANEW: Final = ("steps", "eval_picks", "tensorboard")
"""Arguments that a resume may give anew; otherwise they are what the folder holds."""


def resolve_request(arguments: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arguments and hyperparameters of a run; hyperparameters give the default number of steps and cells.

    Raises:
        UsageError: see `request`; or the hyperparameters are missing or damaged.
    """
    run_args, resume = request(arguments), arguments["resume"]
    settings = hyperparameters(
        run_args["algo"], run_args["env"], resume / "config.yml" if resume else arguments["config"]
    )
    usual = training_size(run_args["algo"], run_args["env"], settings)
    return {**run_args, **{name: value for name, value in usual.items() if run_args[name] is None}}, settings


def request(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of a run: from the command line and the defaults, or from the run that is resumed.

    Args:
        arguments: options of the command; None where nothing was given.

    Raises:
        UsageError: an option is given that a resumed run has already fixed, or options contradict one another.
    """
    given = ((name, arguments[name]) for name in DEFAULTS)
    options = {name: value for name, value in given if value is not None and value is not False}
    if arguments["resume"] is not None:
        return _resume_request(arguments["resume"], arguments, options)
    if arguments["out"] is not None:
        check_new(arguments["out"])
    run_args = {**DEFAULTS, **options}
    if run_args["full_last"] and run_args["fidelity"] != "flight":
        raise UsageError("--full-last goes with --fidelity flight")
    run_args["level"] = run_args["level"] or LEVELS.get(run_args["env"])
    trial = trial_class(config_of(run_args["env"], run_args["level"]))
    usual = {
        "algo": trial.algorithms[0], "checkpoint_every": trial.checkpoint_every, "eval_picks": trial.usual_table
    }  # fmt: skip
    return {**run_args, **{name: value for name, value in usual.items() if run_args[name] is None}}


def _resume_request(folder: Path, arguments: Mapping[str, Any], options: dict[str, Any]) -> dict[str, Any]:
    """Arguments of the run in a folder, with those that the command line gives anew."""
    recorded = RunFolder(folder).arguments
    if options.get("env") == recorded["env"]:
        recorded["env"] = options.pop("env")
    else:
        importless_environment(folder, recorded["env"])
    fixed = [*(options.keys() - {*ANEW}), *(name for name in ("out", "config") if arguments[name] is not None)]
    if fixed:
        name = fixed[0].replace("_", "-")
        raise UsageError(
            f"--{name} cannot be changed with --resume, because the run folder holds its value; leave it out"
        )
    return {**recorded, **options}
