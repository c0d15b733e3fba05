"""Diagnosis for a bug report: `pnt-gym doctor`, or in a checkout `python -m agents.doctor`."""

from __future__ import annotations

import os
import platform
import time
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from .ground.cli import NUM_ENVS, run
from .ground.versions import versions


@dataclass(frozen=True)
class Arguments:
    """Print versions, threads and whether rendering works, and simulate throws for a second."""


def main(arguments: Arguments) -> None:
    """Print the diagnosis as a table."""
    self_test = throw_for_a_second()  # first: what only pictures and tables need is imported afterwards
    from pnt_gym.cells.base.canvas import rendering_problem

    from .ground.tables import Grid, console

    threads = os.environ.get("OMP_NUM_THREADS", "not set: set it to 1 before trainings on a machine with other work")
    rows = [
        ("system", platform.platform()),
        *versions().items(),
        ("cores", f"{os.cpu_count()}, OMP_NUM_THREADS {threads}"),
        ("pictures", f"{rendering_problem() or 'rendering works'}; MUJOCO_GL {os.environ.get('MUJOCO_GL', 'not set')}"),
        ("self-test", self_test),
    ]
    console().print(Grid("pnt_gym", ("what", "found"), rows).terminal())


def throw_for_a_second() -> str:
    """Number, rate and success rate of the planner's throws simulated within a second, in one sentence."""
    from .ground.environments import make_vector

    with closing(make_vector("PnTRelease-v0", "nominal", NUM_ENVS, os.cpu_count() or 1)) as env:
        env.reset(seed=0)
        planned = np.zeros(env.action_space.shape or ())
        env.step(planned)  # warms up
        successes, begin = list[float](), time.perf_counter()
        while (seconds := time.perf_counter() - begin) < 1.0:
            successes += env.step(planned)[-1]["is_success"].tolist()
    return f"{len(successes)} throws, {len(successes) / seconds:.0f} a second, {100 * np.mean(successes):.0f} % succeed"


if __name__ == "__main__":
    run(main, Arguments, "agents.doctor")
