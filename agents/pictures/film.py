"""A film of a line at work: what is simulated is what is shown."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from ..controllers.protocol import Controller
from ..dispatchers.registry import the_line
from ..ground.environments import Env
from ..judging.decisions import observed_line

SECONDS: Final = 12.0
"""Of a shift that a film shows unless something else is asked for [s]."""


def decisions(controller: Controller, env: Env, env_seed: int, seconds: float = np.inf) -> Iterator[float]:
    """Work the first shift of one line, decision by decision.

    Args:
        controller: who decides.
        env: a single line.
        env_seed: of the environment; row 0 of many lines has the same shift.
        seconds: of the shift; it ends at its own end at the latest [s].

    Yields:
        Time of the next decision, since the begin of the shift [s].
    """
    core = the_line(env)
    features, _ = env.reset(seed=env_seed)
    over = False
    while not over and core.cell.state.clock[0] < seconds:
        features, _, _, truncated, _ = env.step(controller.act(observed_line(features)))
        over = bool(truncated[0])
        yield float(core.cell.state.clock[0])
