"""Correction of a line's throws by a controller of single throws."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Ints
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.throws import Release

from ..controllers import make_controller
from ..controllers.protocol import Observation
from ..ground.cli import about
from ..ground.environments import make_vector

ENV = "PnTRelease-v0"


def make_release(name: str, config: LineConfig) -> Release:
    """Function that corrects throws by a controller of `PnTRelease-v0`.

    Args:
        name: name of a controller that needs no practice, or a run folder.
        config: level of the line.

    Raises:
        UsageError: the controller does not exist, or belongs to another environment.
    """
    env = make_vector(ENV, config.cell_of(0), 1, 1)
    with about("release"):
        controller = make_controller(name, env)
    env.close()

    def correct(observation: NDArray[np.float32], kind: Ints) -> NDArray[np.floating]:
        return controller.act(Observation(observation, kind))

    return correct
