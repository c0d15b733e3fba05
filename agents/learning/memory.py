"""Replay buffer and random state of a training run, in files of numbers that cannot contain code."""

from __future__ import annotations

import json
import random
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.reading import arrays_of, json_of

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm


HEADER: Final = 1024
"""Largest size of an array's header in a file [bytes]."""


def save_memory(memory: Any, path: Path) -> None:
    """Write the throws in a replay buffer to a .npz file."""
    rows: dict[str, Any] = {name: array[: memory.size()] for name, array in _arrays(memory).items()}
    np.savez(path, pos=memory.pos, full=memory.full, **rows)


def load_memory(memory: Any, path: Path) -> None:
    """Fill a new replay buffer from a file that `save_memory` has written.

    Raises:
        ValueError: the file is of a buffer of another size, or of another kind, or its numbers are not finite.
    """
    arrays = _arrays(memory)
    names = re.compile("|".join([*arrays, "pos", "full"]))
    stored = arrays_of(path, names, sum(array.nbytes + HEADER for array in arrays.values()) + 4 * HEADER)
    pos, full = int(stored["pos"]), bool(stored["full"])
    if not 0 <= pos < memory.buffer_size:
        raise ValueError(f"pos is {pos}; it must be from 0 to {memory.buffer_size - 1}")
    for name, array in arrays.items():
        rows, values = array[: None if full else pos], stored[name]
        if (values.shape, values.dtype) != (rows.shape, rows.dtype):
            raise ValueError(f"{name} is {values.dtype} {values.shape}; it must be {rows.dtype} {rows.shape}")
        if not np.isfinite(values).all():
            raise ValueError(f"{name} has numbers that are not finite")
        rows[:] = values
    memory.pos, memory.full = pos, full


def _arrays(memory: Any) -> dict[str, NDArray[Any]]:
    """Arrays of a replay buffer by name; of one for pictures beside vectors, those in its dictionaries too."""
    parts = {name: value for name, value in vars(memory).items() if isinstance(value, dict)}
    inner = {f"{name}_{key}": array for name, part in parts.items() for key, array in part.items()}
    return {name: value for name, value in {**vars(memory), **inner}.items() if isinstance(value, np.ndarray)}


def save_random(model: BaseAlgorithm, path: Path) -> None:
    """Write the state of every random generator of a training as JSON."""
    import torch  # noqa: PLC0415 - a second to import

    name, words, *position = np.random.get_state()  # noqa: NPY002 - the generator that stable-baselines3 draws from
    state = {
        "torch": torch.get_rng_state().tolist(),
        "numpy": [name, np.asarray(words).tolist(), *position],
        "python": random.getstate(),
        "actions": model.action_space.np_random.bit_generator.state,
    }
    path.write_text(json.dumps(state), encoding="utf-8")


def load_random(model: BaseAlgorithm, path: Path) -> None:
    """Set every random generator to the state that `save_random` has written."""
    import torch  # noqa: PLC0415 - as above

    state = json_of(path)
    torch.set_rng_state(torch.tensor(state["torch"], dtype=torch.uint8))
    np.random.set_state(tuple(state["numpy"]))  # noqa: NPY002 - as above
    version, words, gauss = state["python"]
    random.setstate((version, tuple(words), gauss))
    model.action_space.np_random.bit_generator.state = state["actions"]
