"""Training from checkpoint to checkpoint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..controllers.between import as_seen
from ..ground.cli import UsageError
from ..ground.environments import Env, core_of, make_vector, stream_seed
from ..ground.tables import throws_bar
from ..learning.runs import RunFolder
from ..learning.windows import Window

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

    from ..learning.progress import Stop
    from ..learning.vec_env import SameStepVecEnv


def in_flight(cell: Env, asked: Mapping[str, Any], threads: int) -> Env | None:
    """The training's cells with only flights simulated, as the policy observes them; None for a full simulation.

    Raises:
        UsageError: the environment has no simulation of flights alone.
    """
    if asked["fidelity"] == "full":
        return None
    config = core_of(cell).config
    if "fidelity" not in type(config).model_fields:
        raise UsageError(f"--fidelity flight: environment {asked['env']!r} is simulated in full only")
    level = config.model_copy(update={"fidelity": "flight"})
    return as_seen(make_vector(asked["env"], level, asked["num_envs"], threads, asked["action_mode"]), asked)


def learn(
    model: BaseAlgorithm,
    env: SameStepVecEnv,
    folder: RunFolder,
    asked: Mapping[str, Any],
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
    total, every = asked["steps"], asked["checkpoint_every"]
    change, judged = total - asked.get("full_last", 0) if quick is not None else 0, env.env
    with throws_bar("rate", "success", "error") as bar:
        bar.live.auto_refresh = not quiet
        task = bar.add_task(
            f"{asked['algo']} on {asked['env']}",
            total=total,
            completed=model.num_timesteps,
            rate="",
            success="",
            error="",
            visible=not quiet,
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
        while model.num_timesteps < (until or total) and not stop.asked:
            done = model.num_timesteps
            env.env = quick if quick is not None and done < change else judged
            leg = min((done // every + 1) * every, change if done < change else total) - done
            env.seed(stream_seed("train", asked["seed"], done))
            begin_leg(model, done + leg, total)
            model._last_obs = None  # makes learn() reset the environment
            model.learn(leg, callback=callback, log_interval=16, reset_num_timesteps=False)
            folder.save_checkpoint(model)
    env.env = judged
