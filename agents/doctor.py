"""Diagnosis for a bug report: `pnt-gym doctor`, or in a checkout `python -m agents.doctor`."""

from __future__ import annotations

import os
import platform
import time
from contextlib import closing
from dataclasses import dataclass

from .ground.amounts import NUM_ENVS
from .ground.cli import run
from .ground.tables import Grid, console
from .ground.versions import versions


@dataclass(frozen=True)
class Arguments:
    """Print versions, threads and whether rendering works, and simulate throws for a second."""


def main(arguments: Arguments) -> None:
    """Print the diagnosis as a table."""
    from pnt_gym.cells.base.canvas import rendering_problem

    threads = os.environ.get("OMP_NUM_THREADS", "not set: set it to 1 before trainings on a machine with other work")
    rows = [
        ("system", platform.platform()),
        *versions().items(),
        ("cores", f"{os.cpu_count()}, OMP_NUM_THREADS {threads}"),
        ("pictures", f"{rendering_problem() or 'rendering works'}; MUJOCO_GL {os.environ.get('MUJOCO_GL', 'not set')}"),
        ("self-test", throw_for_a_second()),
    ]
    console().print(Grid("pnt_gym", ("what", "found"), rows).terminal())


def throw_for_a_second() -> str:
    """Number, rate and success rate of the planner's throws simulated within a second, in one sentence."""
    from .controllers import make_controller
    from .ground.environments import make_vector
    from .judging.loop import throw_batches

    with closing(make_vector("PnTRelease-v0", "nominal", NUM_ENVS, os.cpu_count() or 1)) as env:
        batches = throw_batches(make_controller("analytic", env), env, 100 * NUM_ENVS, 0)
        next(batches)  # warms up
        count, successes, begin = 0, 0, time.perf_counter()
        for throws in batches:
            count += len(throws)
            successes += int(throws.is_success.sum())
            if time.perf_counter() - begin > 1.0:
                break
        rate = count / (time.perf_counter() - begin)
    return f"{count} throws, {rate:.0f} a second, {100 * successes / count:.0f} % succeed"


if __name__ == "__main__":
    run(main, Arguments, "agents.doctor")
