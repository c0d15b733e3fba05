"""A training: its arguments, its cells, and its legs from checkpoint to checkpoint."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from gymnasium.spaces import Dict

from ..controllers import between
from ..controllers.between import PLANNER
from ..ground.cli import UsageError
from ..ground.environments import Env, config_of, make_vector, stream_seed
from ..ground.files import lock_folder, write_json
from ..ground.streams import destination
from ..ground.tables import console, throws_bar
from ..judging import trials
from ..judging.evaluation import evaluate_all
from ..judging.trial import Trial
from ..learning import runs
from ..learning.hyperparameters import ON_POLICY, hyperparameters, training_size
from ..learning.runs import RunFolder
from ..learning.trained import importless_environment
from ..learning.windows import Window

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

    from ..learning.progress import Stop
    from ..learning.vec_env import SameStepVecEnv

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


def resolve(arguments: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
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
        # Arguments of the run in a folder, with those that the command line gives anew.
        folder = arguments["resume"]
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
    if arguments["out"] is not None:
        runs.check(arguments["out"])
    run_args = {**DEFAULTS, **options}
    if run_args["full_last"] and run_args["fidelity"] != "flight":
        raise UsageError("--full-last goes with --fidelity flight")
    run_args["level"] = run_args["level"] or LEVELS.get(run_args["env"])
    trial = trials.find(config_of(run_args["env"], run_args["level"]))
    usual = {
        "algo": trial.algorithms[0], "checkpoint_every": trial.checkpoint_every, "eval_picks": trial.usual_table
    }  # fmt: skip
    return {**run_args, **{name: value for name, value in usual.items() if run_args[name] is None}}


SEED: Final = 0
"""Seed of the held-out units."""
TABLE: Final = "evaluation.json"
"""File of the table in the run folder."""


def show(trial: Trial, folder: RunFolder, steps: int, run_args: Mapping[str, Any]) -> None:
    """Evaluate the policy and its peers, print the table, and write the table to the run folder.

    Args:
        trial: trial of the training.
        folder: folder of the run.
        steps: number of steps that the policy has learned from.
        run_args: arguments of the training; `eval_picks` is the number of units of each controller, None for the
            default of the kind of trial.
    """
    asked = run_args["eval_picks"]
    count = trial.usual_table if asked is None else asked
    learned = trial.policy(folder, None, run_args, f"learned ({run_args['algo']})")
    entries = [(trial.controller(name), practice) for name, practice in trial.peers(run_args).items()]
    for controller, _ in [*entries, (learned, 0)]:
        controller.reset(run_args["seed"])
    rows = evaluate_all(
        trial, [(controller.name, controller, practice) for controller, practice in entries], count, SEED,
        practice_seed=run_args["seed"],
    )  # fmt: skip
    rows += evaluate_all(trial, [(learned.name, learned, steps)], count, SEED)
    title = f"{count} held-out {trial.unit} each, level {trial.core.config.name}; run folder {folder.path}"
    console().print(trial.record.comparison(title, rows, trial.reference))
    table = [{"controller": name, "throws": learned_from, **summary} for name, learned_from, summary in rows]
    write_json(folder.path / TABLE, table)


def learn(
    model: BaseAlgorithm,
    env: SameStepVecEnv,
    folder: RunFolder,
    run_args: Mapping[str, Any],
    stop: Stop,
    window: Window,
    *,
    quick: Env | None = None,
    quiet: bool = False,
) -> None:
    """Train in legs from checkpoint to checkpoint, in `quick`, if given, until the last `full_last` throws.

    Each leg starts from newly seeded environments, whether or not the process was restarted in between. So a resumed
    run equals an uninterrupted run bit for bit.
    """
    from stable_baselines3.common.logger import Logger, configure  # noqa: PLC0415

    from ..learning import sb3  # noqa: PLC0415
    from ..learning.progress import ProgressCallback  # noqa: PLC0415

    is_logged = run_args.get("tensorboard", False)
    model.set_logger(configure(str(folder.path / "tensorboard"), ["tensorboard"]) if is_logged else Logger(None, []))
    total, every = run_args["steps"], run_args["checkpoint_every"]
    change, full_env = total - run_args.get("full_last", 0) if quick is not None else 0, env.env
    with throws_bar("rate", "success", "error", quiet=quiet) as bar:
        task = bar.add_task(
            f"{run_args['algo']} on {run_args['env']}",
            total=total,
            completed=model.num_timesteps,
            rate="",
            success="",
            error="",
        )

        def show(count: int, rate: float, success: float, figure: float) -> None:
            bar.update(
                task,
                advance=count,
                rate=f"{rate:.0f} {window.step}/s",
                success=f"{100 * success:.0f} % success",
                error=window.text(figure),
            )

        callback = ProgressCallback(folder.path / "progress.csv", model.num_timesteps, stop, window, show)
        while model.num_timesteps < (stop.until or total) and not stop.is_set:
            steps_done = model.num_timesteps
            env.env = quick if quick is not None and steps_done < change else full_env
            leg = min((steps_done // every + 1) * every, change if steps_done < change else total) - steps_done
            env.seed(stream_seed("train", run_args["seed"], steps_done))
            sb3.begin(model, steps_done + leg, total)
            model._last_obs = None  # makes learn() reset the environment
            model.learn(leg, callback=callback, log_interval=16, reset_num_timesteps=False)
            folder.save(model)
    env.env = full_env


@final
class Session:
    """Environments and arguments of a training: cells as the policy observes them, fully simulated or flights alone.

    Args:
        trial: trial of the cells.
        run_args: arguments of the training.
        settings: hyperparameters.
        threads: threads of the simulation.

    Raises:
        UsageError: the arguments ask for something that the cells do not have.
    """

    def __init__(self, trial: Trial, run_args: Mapping[str, Any], settings: Mapping[str, Any], threads: int) -> None:
        core = trial.core
        self.trial, self.settings = trial, settings
        self.run_args = {**run_args, "level": run_args["level"] or core.config.name, "action_mode": core.action_mode}
        env, price = between.wrap(trial.env, self.run_args), trial.price(settings)
        # A failed pick teaches where to grasp, which only an agent that sees pictures decides.
        even = run_args["algo"] in ON_POLICY and not isinstance(env.single_observation_space, Dict)
        self._quick: Env | None = None
        if run_args["fidelity"] != "full":  # the training's cells with flights alone, as the policy observes the cells
            if "fidelity" not in type(core.config).model_fields:
                raise UsageError(f"--fidelity flight: environment {run_args['env']!r} is simulated in full only")
            level = core.config.model_copy(update={"fidelity": "flight"})
            cells = make_vector(run_args["env"], level, run_args["num_envs"], threads, core.action_mode)
            self._quick = between.wrap(cells, self.run_args)

        import torch  # noqa: PLC0415 - bad usage is answered without waiting for it

        from ..learning.vec_env import SameStepVecEnv  # noqa: PLC0415 - as above

        torch.set_num_threads(1)  # small networks are slower on many threads
        self.env = SameStepVecEnv(env, even=even, price=price)

    def create(self, folder: Path | None) -> tuple[RunFolder, BaseAlgorithm]:
        """A new run folder and its untrained model; for None a folder in `runs`, named after the training."""
        from ..learning.sb3 import build  # noqa: PLC0415 - imports torch

        config = self.trial.core.config
        model = build(self.run_args["algo"], self.env, self.settings, self.run_args["seed"])
        name = f"{runs.name(self.run_args, config.name)}-{time.strftime('%Y%m%d-%H%M%S')}"
        place = destination(Path("runs") / name) if folder is None else folder
        return RunFolder.create(place, self.run_args, self.settings, config, model), model

    def learn(
        self,
        model: BaseAlgorithm,
        folder: RunFolder,
        stop: Stop,
        *,
        checkpoint_every: int | None = None,
        quiet: bool = False,
    ) -> None:
        """Train in legs.

        Args:
            model: the model that learns.
            folder: folder of the run.
            stop: checked after each batch.
            checkpoint_every: steps between checkpoints; None for the number in the training's arguments.
            quiet: show no progress.
        """
        run_args = (
            self.run_args if checkpoint_every is None else {**self.run_args, "checkpoint_every": checkpoint_every}
        )
        learn(model, self.env, folder, run_args, stop, self.trial.window(), quick=self._quick, quiet=quiet)

    def close(self) -> None:
        """Close the cells of flights alone; the trial's own cells stay open."""
        if self._quick is not None:
            self._quick.close()


def run(
    session: Session, out: Path | None, resume: Path | None, new_steps: int | None
) -> tuple[RunFolder, int, int | None]:
    """Train until the training is done or stopped.

    Args:
        session: session of the training.
        out: folder of a new run; None for a folder in `runs`.
        resume: folder of the run to resume; None for a new run.
        new_steps: total number of steps from the command line; None if not given.

    Returns:
        The run folder, the number of steps done, and the number of the signal that stopped the training, if one did.
    """
    from ..learning.progress import Stop  # noqa: PLC0415 - imports torch

    with Stop().listen() as stop, ExitStack() as ends:
        if resume is not None:
            ends.enter_context(lock_folder(resume))
            folder = RunFolder(resume)
            model = _restore(session, folder, new_steps)
        else:
            folder, model = session.create(None if out is None else destination(out))
            ends.enter_context(lock_folder(folder.path))
            ends.enter_context(folder.remove_on_error())
        session.learn(model, folder, stop)
    return folder, model.num_timesteps, stop.number


def _restore(session: Session, folder: RunFolder, new_steps: int | None) -> BaseAlgorithm:
    """Model of a resumed run, from its last checkpoint.

    Raises:
        UsageError: the run has already done all its steps.
    """
    model, run_args, recorded = folder.restore(session.env), session.run_args, folder.arguments
    goes_on = new_steps is not None and new_steps > model.num_timesteps
    if goes_on:
        (folder.path / TABLE).unlink(missing_ok=True)  # of fewer throws
    kept = run_args if goes_on else {**run_args, "steps": recorded["steps"]}
    if kept != recorded:
        folder.write(kept)
    if model.num_timesteps >= run_args["steps"] and (folder.path / TABLE).is_file():
        raise UsageError(
            f"run {str(folder.path)!r} has done {model.num_timesteps} throws of {run_args['steps']}; "
            "give a larger --steps to go on"
        )
    return model
