"""Digests by which a row of results says what acted, where, and by which code."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from pnt_gym.reading import MOST_NUMBERS, bytes_of

from ..controllers.protocol import Controller, Learner
from ..ground.files import json_text
from ..ground.parcel import user_code_digest
from ..ground.shipped import module_of, policy_place
from ..ground.versions import code_digest
from ..learning.runs import POLICY
from .entries import is_learned

CODE: Final = ("pnt_gym/**/*.py", "agents/controllers/*.py", "agents/dispatchers/*.py")
"""Code on which results depend and which is loaded by a name; all other code is found by following imports."""
LENGTH: Final = 32
"""Hexadecimal digits of a digest in a row: 128 bits, which nobody finds a second text for."""


def results_code() -> str:
    """Digest of the code on which results depend."""
    return code_digest(CODE, ["agents.benchmark.run"])


def level_digest(config: Any) -> str:
    """Digest of a level: of every value of its config, defaults included."""
    return bytes_digest(json_text(config.model_dump(mode="json")).encode())


def file_digest(name: str) -> str:
    """Digest of a trained policy: of its file, or of the policy in a run folder."""
    place = policy_place(name)
    return hashlib.sha256(bytes_of(place / POLICY if place.is_dir() else place, MOST_NUMBERS)).hexdigest()


def policy_digest(name: str, controller: Controller) -> str:
    """Digest of a controller that does not train: its name, a user's code, its file, and what it has learned."""
    parts = [name.encode()]
    module = module_of(name)
    if module is not None:
        parts.append(user_code_digest(module).encode())
    elif is_learned(name):
        parts.append(file_digest(name).encode())
    if isinstance(controller, Learner):
        parts.append(_state_bytes(controller.state()))
    return bytes_digest(b"\n".join(parts))


def _state_bytes(state: Mapping[str, Any]) -> bytes:
    """Learned arrays in the order of their names, with type and shape."""
    arrays = ((name, np.ascontiguousarray(state[name])) for name in sorted(state))
    return b"\n".join(f"{name} {array.dtype} {array.shape} ".encode() + array.tobytes() for name, array in arrays)


def bytes_digest(content: bytes) -> str:
    """Digest of a content, as short as rows hold digests."""
    return hashlib.sha256(content).hexdigest()[:LENGTH]
