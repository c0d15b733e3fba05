"""A training in the cells of a trial: new or resumed, until the training is done or a signal stops it."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from gymnasium.spaces import Dict

from ..controllers.between import wrap_env
from ..ground.cli import UsageError
from ..ground.files import lock_folder
from ..ground.places import module_name
from ..ground.streams import destination
from ..judging.trial import Trial
from ..learning.algorithms import ON_POLICY
from ..learning.runs import RunFolder, run_name
from .course import learn, open_flight_env
from .table import TABLE

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

    from ..learning.progress import Stop


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
        env, price = wrap_env(trial.env, self.run_args), trial.price(settings)
        # A failed pick teaches where to grasp, which only an agent that sees pictures decides.
        even = run_args["algo"] in ON_POLICY and not isinstance(env.single_observation_space, Dict)
        self._quick = open_flight_env(trial.env, self.run_args, threads)

        import torch  # noqa: PLC0415 - bad usage is answered without waiting for it

        from ..learning.vec_env import SameStepVecEnv  # noqa: PLC0415 - as above

        torch.set_num_threads(1)  # small networks are slower on many threads
        self.env = SameStepVecEnv(env, even=even, price=price)

    def create(self, folder: Path | None) -> tuple[RunFolder, BaseAlgorithm]:
        """A new run folder and its untrained model; for None a folder in `runs`, named after the training."""
        from ..learning.sb3 import build  # noqa: PLC0415 - imports torch

        config = self.trial.core.config
        model = build(self.run_args["algo"], self.env, self.settings, self.run_args["seed"])
        name = f"{run_name(self.run_args, config.name)}-{time.strftime('%Y%m%d-%H%M%S')}"
        place = destination(Path("runs") / name) if folder is None else folder
        return RunFolder.create(place, self.run_args, self.settings, config, model), model

    def learn(
        self, model: BaseAlgorithm, folder: RunFolder, stop: Stop, *, checkpoint_every: int | None = None, **how: Any
    ) -> None:
        """Train in legs.

        Args:
            model: the model that learns.
            folder: folder of the run.
            stop: checked after each batch.
            checkpoint_every: steps between checkpoints; None for the number in the training's arguments.
            how: further arguments of `agents.training.course.learn`.
        """
        run_args = (
            self.run_args if checkpoint_every is None else {**self.run_args, "checkpoint_every": checkpoint_every}
        )
        learn(model, self.env, folder, run_args, stop, self.trial.window(), quick=self._quick, **how)

    def close(self) -> None:
        """Close the cells of flights alone; the trial's own cells stay open."""
        if self._quick is not None:
            self._quick.close()


def run_session(
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
        session.learn(model, folder, stop, tensorboard=session.run_args["tensorboard"])
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
        folder.write_arguments(kept)
    if model.num_timesteps >= run_args["steps"] and (folder.path / TABLE).is_file():
        raise UsageError(
            f"run {str(folder.path)!r} has done {model.num_timesteps} throws of {run_args['steps']}; "
            "give a larger --steps to go on"
        )
    return model


def say_how_to_resume(folder: Path, env_id: str, steps: int, step: str) -> None:
    """Print the command that continues an interrupted run."""
    env_option = f" --env {env_id}" if ":" in env_id else ""
    command = f"python -m {module_name('agents.train')} --resume {folder}{env_option}"
    print(f"stopped after {steps} {step}s; continue with: {command}", file=sys.stderr)
