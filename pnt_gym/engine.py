"""MuJoCo, imported in one place: headless machines render through EGL, and the type checker sees Any.

MuJoCo chooses its OpenGL backend at the first import. Without a display its default (GLFW) aborts the process, so EGL
is chosen unless the user has set MUJOCO_GL.
"""

import os
import sys
from typing import Any, TypeAlias

if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco as _mujoco  # pyright: ignore[reportMissingTypeStubs]
from mujoco import batch as _batch  # pyright: ignore[reportMissingTypeStubs]

# MuJoCo's compiled modules ship no types.
mujoco: Any = _mujoco
Batch: Any = _batch.Batch

MjSpec: TypeAlias = Any
MjsBody: TypeAlias = Any
MjModel: TypeAlias = Any
MjData: TypeAlias = Any
GeomType: TypeAlias = Any
