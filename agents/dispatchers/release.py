"""Throws of a line that are corrected by a controller of single throws."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Ints
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.throws import Release

from ..controllers import make_controller
from ..controllers.protocol import Observation
from ..ground.environments import make_vector

ENV = "PnTRelease-v0"


def releaser(name: str, core: LineCore) -> Release:
    """What corrects throws as a controller of `PnTRelease-v0` does.

    Args:
        name: of a controller that needs no practice, or a run folder.
        core: the lines.

    Raises:
        UsageError: there is none, or it is of another environment.
    """
    env = make_vector(ENV, core.config.cell_of(0), 1, 1)
    controller = make_controller(name, env)
    env.close()

    def corrected(observation: NDArray[np.float32], kind: Ints) -> NDArray[np.floating]:
        return controller.act(Observation(observation, kind))

    return corrected
