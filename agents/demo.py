"""A first look: the planner, iterative learning and a trained policy throw the same objects."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from .controllers import make_controller
from .ground.cli import at_least, run
from .ground.environments import make_vector
from .ground.places import POLICY
from .ground.tables import comparison_table, console, throws_bar
from .judging.evaluation import NUM_ENVS, PRACTICE, held_out, practise
from .judging.throws import summary
from .learning.runs import read_arguments

PEERS: Final = {"analytic": ("analytic", 0), "virtual_goal": ("virtual_goal", PRACTICE)}
"""Controllers to compare with, and the throws they practise."""


@dataclass(frozen=True)
class Arguments:
    """Let the analytic planner and the trained policy that ships throw the same waste, and print what each is worth."""

    picks: int = 64
    """Throws of each."""
    seed: int = 0
    """Names the objects."""
    threads: int = 2
    """Threads that simulate; results do not depend on it."""


def main(arguments: Arguments) -> None:
    """Throw and print the table."""
    at_least(vars(arguments), picks=1, threads=1, seed=0)
    asked = read_arguments(POLICY)
    entries = {**PEERS, f"trained policy ({asked['algo']})": (str(POLICY), asked["steps"])}
    rows: list[tuple[str, int, dict[str, Any]]] = []
    made = make_vector(asked["env"], asked["level"], NUM_ENVS, arguments.threads, asked["action_mode"])
    with closing(made) as cell, throws_bar() as bar:
        for label, (name, throws) in entries.items():
            advance = partial(bar.advance, bar.add_task(label, total=arguments.picks))
            controller = make_controller(name, cell)
            controller.reset(arguments.seed)
            practise(controller, cell, throws, arguments.seed)
            found = held_out(controller, cell, arguments.picks, arguments.seed, progress=advance)
            rows.append((label, throws, summary(found)))
    title = f"{asked['env']}, level {asked['level']}: the same {arguments.picks} throws each"
    console().print(comparison_table(title, rows))


if __name__ == "__main__":
    run(main, Arguments, "agents.demo")
