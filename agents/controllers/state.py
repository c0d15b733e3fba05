"""What controllers have learned, in .npz files."""

from __future__ import annotations

import errno
import os
import re
from pathlib import Path
from typing import Any, Final

import numpy as np

from pnt_gym.reading import AccessError, arrays_of

from ..ground.cli import UsageError
from ..ground.outputs import deliver
from .adaptive import IN_CONTEXT, STATIC, Adaptive
from .protocol import Learner

MISSING: Final = os.strerror(errno.ENOENT)
STATE: Final = re.compile(r"\w[\w .:-]*")
"""Names of the arrays that a controller saves."""


def save_state(controller: Learner, path: Path) -> None:
    """Write what a controller learned to a .npz file, at once."""
    arrays: dict[str, Any] = {"controller": np.array(knowledge(controller)[0]), **controller.state()}

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:  # given a name, numpy would append a suffix
            np.savez(file, **arrays)

    deliver(path, write)


def load_state(controller: Learner, path: Path) -> None:
    """Take over what a controller of the same name has saved.

    Raises:
        UsageError: the file is missing or damaged, or belongs to another controller.
    """
    owner, state = read_state(path)
    wanted = knowledge(controller)
    if owner not in wanted:
        raise UsageError(f"{str(path)!r} was saved by {owner!r}, not by {' or '.join(map(repr, wanted))}")
    try:
        controller.restore(state)
    except UsageError:
        raise
    except Exception:
        raise UsageError(f"{str(path)!r} holds no state of {owner!r} that is understood here") from None


def knowledge(controller: Learner) -> tuple[str, ...]:
    """Whose knowledge a controller can take over, first of what kind its own is: a static policy may lie under it."""
    if not isinstance(controller, Adaptive):
        return (controller.name,)
    return (IN_CONTEXT,) if controller.name == IN_CONTEXT else (STATIC, IN_CONTEXT)


def read_state(path: Path) -> tuple[str, dict[str, np.ndarray]]:
    """Whose knowledge a file holds, and what it is.

    Raises:
        UsageError: the file is missing or damaged.
    """
    try:
        state = arrays_of(path, STATE)
        return str(state.pop("controller")), state
    except AccessError as error:
        said = f"holds no saved controller: {error}" if str(error) != MISSING else "does not exist"
        raise UsageError(f"{str(path)!r} {said}") from None
    except Exception:  # there is no telling what a torn or foreign file upsets
        raise UsageError(f"{str(path)!r} holds no saved controller") from None
