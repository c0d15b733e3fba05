"""Training from checkpoint to checkpoint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..controllers.between import wrap_env
from ..ground.bars import throws_bar
from ..ground.cli import UsageError
from ..ground.environments import Env, core_of, make_vector, stream_seed
from ..learning.runs import RunFolder
from ..learning.windows import Window

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

    from ..learning.progress import Stop
    from ..learning.vec_env import SameStepVecEnv


def open_flight_env(cell: Env, run_args: Mapping[str, Any], threads: int) -> Env | None:
    """The training's cells with only flights simulated, as the policy observes them; None for a full simulation.

    Raises:
        UsageError: the environment has no simulation of flights alone.
    """
    if run_args["fidelity"] == "full":
        return None
    config = core_of(cell).config
    if "fidelity" not in type(config).model_fields:
        raise UsageError(f"--fidelity flight: environment {run_args['env']!r} is simulated in full only")
    level = config.model_copy(update={"fidelity": "flight"})
    return wrap_env(
        make_vector(run_args["env"], level, run_args["num_envs"], threads, run_args["action_mode"]), run_args
    )


def learn(
    model: BaseAlgorithm,
    env: SameStepVecEnv,
    folder: RunFolder,
    run_args: Mapping[str, Any],
    stop: Stop,
    window: Window,
    *,
    quick: Env | None = None,
    until: int | None = None,
    tensorboard: bool = False,
    quiet: bool = False,
) -> None:
    """Train in legs from checkpoint to checkpoint, in `quick`, if given, until the last `full_last` throws.

    With `until` the training stops at this throw, and can go on later to the total number of throws.

    Each leg starts from newly seeded environments, whether or not the process was restarted in between. So a resumed
    run equals an uninterrupted run bit for bit.
    """
    from stable_baselines3.common.logger import Logger, configure  # noqa: PLC0415

    from ..learning.progress import ProgressCallback  # noqa: PLC0415
    from ..learning.sb3 import begin_leg  # noqa: PLC0415

    logger = configure(str(folder.path / "tensorboard"), ["tensorboard"]) if tensorboard else Logger(None, [])
    model.set_logger(logger)
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
        while model.num_timesteps < (until or total) and not stop.is_set:
            steps_done = model.num_timesteps
            env.env = quick if quick is not None and steps_done < change else full_env
            leg = min((steps_done // every + 1) * every, change if steps_done < change else total) - steps_done
            env.seed(stream_seed("train", run_args["seed"], steps_done))
            begin_leg(model, steps_done + leg, total)
            model._last_obs = None  # makes learn() reset the environment
            model.learn(leg, callback=callback, log_interval=16, reset_num_timesteps=False)
            folder.save_checkpoint(model)
    env.env = full_env
