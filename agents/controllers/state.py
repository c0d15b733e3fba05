"""Saving and loading of the learned state of controllers, in .npz files."""

from __future__ import annotations

import errno
import os
import re
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np

from pnt_gym.errors import one_sentence
from pnt_gym.reading import AccessError, arrays_of

from ..ground.archives import save_arrays
from ..ground.cli import UsageError
from ..ground.outputs import deliver
from .adaptive import IN_CONTEXT, STATIC, Adaptive
from .protocol import Controller, Learner, State, learns

MISSING: Final = os.strerror(errno.ENOENT)
STATE: Final = re.compile(r"\w[\w .:-]*")
"""Pattern of the names of the arrays that a controller saves."""
KINDS: Final = "fiubU"
"""Kinds of these arrays: real and whole numbers, truths and text."""


def check(controller: Controller, **options: Any) -> None:
    """Make sure that a controller learns, if any option that only learning gives an effect was given.

    Raises:
        UsageError: such an option was given, and the controller does not learn.
    """
    for name, value in options.items():
        if value and not learns(controller):
            raise UsageError(f"--{name} has no effect: controller {controller.name!r} has no method `learn`")


def steps(controller: Controller, usual: int, practice: int | None, load: Path | None, save: Path | None) -> int:
    """Load a learning controller's state if that is asked for, and return the controller's number of practice steps.

    Args:
        controller: the controller to be judged.
        usual: steps of practice by default.
        practice: steps of practice given by the user, or None.
        load: file of a saved state, or None.
        save: file to which the learned state will be saved, or None.

    Raises:
        UsageError: practice or a file is given for a controller that does not learn, or the file does not fit this
            controller.
    """
    check(controller, practice=practice)
    if not isinstance(controller, Learner):
        for name, file in (("load", load), ("save", save)):
            if file is not None:
                raise UsageError(f"--{name}: controller {controller.name!r} learns nothing that could be saved")
    elif load is not None:
        load_state(controller, load)
        return practice or 0
    return (usual if practice is None else practice) if learns(controller) else 0


def save_state(controller: Stored, path: Path) -> None:
    """Write the learned state of a controller to a .npz file, atomically."""
    write_state(_names(controller)[0], controller.state(), path)


def write_state(name: str, state: State, path: Path) -> None:
    """Write the state of a controller of a name to a .npz file, atomically."""
    deliver(path, lambda place: save_arrays(place, {"controller": name, **state}))


class Stored(Protocol):
    """A controller whose state files keep."""

    @property
    def name(self) -> str:
        """Name of the controller."""
        ...

    def state(self) -> State:
        """Arrays by name."""
        ...

    def restore(self, state: State) -> None:
        """Load such arrays."""
        ...


def load_state(controller: Stored, path: Path) -> None:
    """Load the saved state of a controller of the same name.

    Raises:
        UsageError: the file is missing or damaged, or belongs to another controller.
    """
    owner, state = read(path)
    names = _names(controller)
    if owner not in names:
        raise UsageError(f"{str(path)!r} was saved by {owner!r}, not by {' or '.join(map(repr, names))}")
    try:
        controller.restore(state)
        kept = controller.state()
    except UsageError:
        raise
    except Exception:
        raise UsageError(f"{str(path)!r} holds no state of {owner!r} that this version can read") from None
    # What was understood is what would be saved.
    if any(np.shape(kept[name]) != state[name].shape for name in kept.keys() & state.keys()):
        raise UsageError(f"{str(path)!r} holds no state of {owner!r} that this version can read")


def _names(controller: Stored) -> tuple[str, ...]:
    """Names of controllers whose state a controller can load, its own first; adaptive ones contain a static policy."""
    if not isinstance(controller, Adaptive):
        return (controller.name,)
    return (IN_CONTEXT,) if controller.name == IN_CONTEXT else (STATIC, IN_CONTEXT)


def read(path: Path) -> tuple[str, dict[str, np.ndarray]]:
    """Name of the controller in a file, and its state.

    Raises:
        UsageError: the file is missing or damaged.
    """
    try:
        state = arrays_of(path, STATE)
        owner = str(state.pop("controller"))
    except AccessError as error:
        reason = f"holds no saved controller: {error}" if str(error) != MISSING else "does not exist"
        raise UsageError(f"{str(path)!r} {reason}") from None
    except Exception:  # a damaged or foreign file may raise anything
        raise UsageError(f"{str(path)!r} holds no saved controller") from None
    for name, array in state.items():
        if array.dtype.kind not in KINDS:
            kind = one_sentence(array.dtype, 40)
            raise UsageError(f"{str(path)!r} holds no saved controller: {name!r} is {kind}, no real numbers or text")
    return owner, state
