"""The only import of MuJoCo: headless machines render offscreen, and the type checker sees Any.

MuJoCo chooses its OpenGL backend at the first import. Without a display its default (GLFW) aborts the process when a
picture is asked for, so an offscreen backend is chosen if its library is there and MUJOCO_GL is not set. Physics
needs no backend, and no clock.
"""

import ctypes
import os
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from typing import Any, TypeAlias

_OFFSCREEN = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}


def has_display() -> bool:
    """Whether a window can be opened."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


if not has_display() and "MUJOCO_GL" not in os.environ:
    for _backend, _library in _OFFSCREEN.items():
        with suppress(OSError):
            ctypes.CDLL(_library)
            os.environ["MUJOCO_GL"] = _backend
            break

import mujoco as _mujoco  # noqa: E402  # pyright: ignore[reportMissingTypeStubs]
from mujoco import batch as _batch  # noqa: E402  # pyright: ignore[reportMissingTypeStubs]

# MuJoCo's compiled modules ship no types.
mujoco: Any = _mujoco
Batch: Any = _batch.Batch


# MuJoCo reads no clock in a step, which would take a tenth of it; `MjData.timer` stays zero in this process. MuJoCo's
# Python takes no null pointer for this callback. A library that does not give the symbol keeps the timers.
with suppress(AttributeError, OSError, ValueError):
    ctypes.c_void_p.in_dll(ctypes.CDLL(mujoco._callbacks.__file__), "mjcb_time").value = None


@contextmanager
def mute_warnings() -> Generator[None, None, None]:
    """Keep MuJoCo from printing its warnings or logging them to a file; a batch counts the warnings all the same."""
    handler = mujoco.get_mju_user_warning()
    # A C function that only reads the text: MuJoCo's threads cannot call a Python function.
    mujoco.set_mju_user_warning(None if sys.platform == "win32" else ctypes.CDLL(None).strlen)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(handler)


MjSpec: TypeAlias = Any
MjsBody: TypeAlias = Any
MjModel: TypeAlias = Any
MjData: TypeAlias = Any
GeomType: TypeAlias = Any
