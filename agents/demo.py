"""Demonstration: the planner, iterative learning and a trained policy throw the same objects."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Final

from .ground.cli import NUM_ENVS, PRACTICE, at_least, run
from .ground.places import POLICY
from .ground.tables import console, throws_bar
from .judging.evaluation import evaluate_all
from .judging.trials import open_trial
from .learning.runs import RunFolder

PEERS: Final = {"analytic": ("analytic", 0), "virtual_goal": ("virtual_goal", PRACTICE)}
"""Controllers to compare the policy with, and the number of their practice throws."""

ELSEWHERE: Final = (
    "The trained policy holds for the cell of level {level}: its valve, its vacuum and its cup. For a cell that nobody "
    "measured, shipped:cells learns from the landings of each shift: pnt-gym evaluate --controller shipped:cells"
)
"""What a user of another cell should know."""


@dataclass(frozen=True)
class Arguments:
    """Let the analytic planner and the shipped policy throw the same waste, and print the figures of each."""

    picks: int = 64
    """Throws of each controller."""
    seed: int = 0
    """Seed of the objects."""
    threads: int = 2
    """Threads of the simulation; results do not depend on this number."""


def main(arguments: Arguments) -> None:
    """Evaluate the controllers and print the table."""
    at_least(vars(arguments), picks=1, threads=1, seed=0)
    run_args = RunFolder(POLICY).arguments
    entries = {**PEERS, f"trained policy ({run_args['algo']})": (str(POLICY), run_args["steps"])}
    opened = open_trial(run_args["env"], run_args["level"], NUM_ENVS, arguments.threads, run_args["action_mode"])
    with closing(opened) as trial, throws_bar() as bar:
        controllers = [(label, trial.controller(name), throws) for label, (name, throws) in entries.items()]
        for _, controller, _ in controllers:
            controller.reset(arguments.seed)
        rows = evaluate_all(
            trial, controllers, arguments.picks, arguments.seed, practice_seed=arguments.seed,
            progress=lambda label: partial(bar.advance, bar.add_task(label, total=arguments.picks)),
        )  # fmt: skip
        title = f"{run_args['env']}, level {run_args['level']}: the same {arguments.picks} {trial.unit} each"
    console().print(trial.record.comparison(title, rows))
    console().print(ELSEWHERE.format(level=run_args["level"]), markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    run(main, Arguments, "agents.demo")
