"""Train a residual policy: `python -m agents.train --env PnTConveyor-v0`."""

from __future__ import annotations

import sys
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from .ground.cli import Exit, at_least, option, run
from .ground.places import module_name
from .judging.trials import open_trial
from .learning.hyperparameters import MASKED, RESIDUAL, Algorithm
from .training import session
from .training.session import Session


@dataclass(frozen=True)
class Arguments:
    """Train a policy that corrects the planner's throws, or chooses objects on a line, and compare controllers."""

    env: Annotated[str | None, option("PnTConveyor-v0", "ID|MODULE:ID")] = None
    """Environment id; MODULE:ID imports a module of yours first, which registers the id."""
    level: Annotated[str | None, option("waste at the conveyor, elsewhere nominal", "NAME|FILE.yaml")] = None
    """A shipped level's name or a YAML file."""
    fidelity: Annotated[Literal["full", "flight"] | None, option("the level's own", "full|flight")] = None
    """Simulation during training; flight is several times as fast. The evaluation uses the level's own fidelity."""
    full_last: Annotated[int | None, option("0", "N")] = None
    """With --fidelity flight: the last N throws of the training are simulated in full."""
    algo: Annotated[Algorithm | None, option("sac; residual_ppo on a line", "|".join((*RESIDUAL, *MASKED)))] = None
    """Learning algorithm; the last two choose objects on a line."""
    steps: Annotated[int | None, option("n_timesteps of --config, or as the resumed run was asked for", "N")] = None
    """Throws (on a line decisions) of the whole training, also those before a resume, in whole batches."""
    seed: Annotated[int | None, option("0", "S")] = None
    """Seed of the networks, the exploration and the objects."""
    out: Annotated[Path | None, option("runs/ENV-LEVEL-ALGO-seedS-TIME", "DIR")] = None
    """Run folder."""
    resume: Annotated[Path | None, option("a new run", "DIR")] = None
    """Continue the run of this folder as it was asked for; --steps, --eval-picks, --tensorboard may be given anew."""
    num_envs: Annotated[int | None, option("n_envs of --config", "N")] = None
    """Cells simulated side by side."""
    threads: int = 2
    """Threads of the simulation; results do not depend on this number."""
    action_mode: Annotated[str | None, option("the environment's own", "MODE")] = None
    """Meaning of an action: one of the environment's action modes, e.g. release_point, release_xyz, virtual_goal."""
    checkpoint_every: Annotated[int | None, option("2000; 125000 on a line", "N")] = None
    """Throws between two checkpoints; the run can be continued from the last checkpoint."""
    config: Annotated[Path | None, option("configs/rl/ALGO.yml", "FILE.yml")] = None
    """File of hyperparameters in RL-Zoo syntax; also a shipped file, such as configs/rl/residual_ppo_long.yml."""
    eval_picks: Annotated[int | None, option("320; 32 shifts on a line; that of the resumed run", "N")] = None
    """Held-out throws, or shifts of a line, per controller in the table at the end; 0 for no table."""
    stack: Annotated[int | None, option("1", "K")] = None
    """Number of last observations of the shift that the policy receives at once; more than 1 on PnTAdapt-v0."""
    over: Annotated[str | None, option("analytic", "CONTROLLER")] = None
    """Base controller, e.g. static or kalman: the policy's action is added to the action of this controller."""
    tensorboard: bool = False
    """Also log the losses for TensorBoard, in the run folder; a resume of the run goes on logging."""


def main(arguments: Arguments) -> None:
    """Train the policy, and print its comparison with other controllers."""
    least = {"steps": 1, "num_envs": 1, "checkpoint_every": 1, "threads": 1, "stack": 1}
    at_least(vars(arguments), **least, seed=0, eval_picks=0, full_last=0)
    run_args, settings = session.resolve(vars(arguments))
    resume, threads = arguments.resume, arguments.threads
    level = run_args["level"] if resume is None else str(resume / "env.yaml")
    with closing(open_trial(run_args["env"], level, run_args["num_envs"], threads, run_args["action_mode"])) as trial:
        trial.check_training(run_args)
        settings = trial.hyperparameters(run_args, settings) if resume is None else settings
        with closing(Session(trial, run_args, settings, threads)) as training:
            ended = session.run(training, arguments.out, resume, arguments.steps)
            folder, steps, signal = ended
            if signal is not None:
                own = f" --env {run_args['env']}" if ":" in run_args["env"] else ""  # a module that is to be imported
                command = f"python -m {module_name('agents.train')} --resume {folder.path}{own}"
                print(f"stopped after {steps} {trial.step}s; continue with: {command}", file=sys.stderr)
                raise Exit(128 + signal)
            if training.run_args["eval_picks"] != 0:
                session.show(trial, folder, steps, training.run_args)


if __name__ == "__main__":
    run(main, Arguments, "agents.train")
