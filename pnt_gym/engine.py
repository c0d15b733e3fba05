"""MuJoCo, imported in one place: headless machines render offscreen, and the type checker sees Any.

MuJoCo chooses its OpenGL backend at the first import. Without a display its default (GLFW) aborts the process when a
picture is asked for, so an offscreen backend is chosen if its library is there and MUJOCO_GL is not set. Physics
needs none of them.
"""

import ctypes
import os
import sys
from typing import Any, TypeAlias

_OFFSCREEN = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}


def has_display() -> bool:
    """Whether a window can be opened."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _choose_backend() -> None:
    if has_display() or "MUJOCO_GL" in os.environ:
        return
    for backend, library in _OFFSCREEN.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        os.environ["MUJOCO_GL"] = backend
        return


_choose_backend()

import mujoco as _mujoco  # noqa: E402  # pyright: ignore[reportMissingTypeStubs]
from mujoco import batch as _batch  # noqa: E402  # pyright: ignore[reportMissingTypeStubs]

# MuJoCo's compiled modules ship no types.
mujoco: Any = _mujoco
Batch: Any = _batch.Batch

MjSpec: TypeAlias = Any
MjsBody: TypeAlias = Any
MjModel: TypeAlias = Any
MjData: TypeAlias = Any
GeomType: TypeAlias = Any
