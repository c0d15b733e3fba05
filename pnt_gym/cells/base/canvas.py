"""Offscreen and window rendering, and markers: shapes that are drawn and not simulated."""

from __future__ import annotations

import copy
import os
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Self, TypedDict, Unpack, final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.config import Finite, Positive, Section
from pnt_gym.cells.base.look import SceneLook, add_shape, light
from pnt_gym.cells.base.problems import list_problems
from pnt_gym.engine import MjData, MjModel, has_display, mujoco
from pnt_gym.errors import ConfigError

Frame = NDArray[np.uint8]

RENDER_MODES: Final = ("rgb_array", "rgb_array_list", "human")
FPS: Final = 30
SIZE: Final = (720, 1280)
"""Height and width of a frame [pixels]."""
LARGEST_SIZE: Final = (1080, 1920)
"""Largest height and width of a frame [pixels]."""
_LIBRARIES: Final = (
    "rendering needs an OpenGL library: install EGL (Debian and Ubuntu: apt-get install libegl1 libgl1-mesa-dri), "
    "or set MUJOCO_GL=osmesa with libosmesa6"
)
_BOUND: Final = ("mujoco.cgl",)
"""MuJoCo's OpenGL libraries that lock a context for the thread that draws first, until the context is freed."""
DRAWING_LOCK: Final = threading.RLock()
"""Lock around drawing, opening and closing a renderer: threads that draw at the same time wait for each other."""


@final
class Viewpoint(Section):
    """Changes of a cell's standard camera; None keeps the standard value."""

    lookat: tuple[Finite, Finite, Finite] | None = Field(
        default=None, description="Point in the middle of the picture [m]."
    )
    distance: Positive | None = Field(default=None, description="Distance of the camera from `lookat` [m].")
    azimuth: Finite | None = Field(default=None, description="Direction of the view in top view [deg].")
    elevation: Finite | None = Field(default=None, description="Direction of the view above the horizontal [deg].")


class PictureSettings(TypedDict, total=False):
    """Settings of a cell's pictures, as keywords: fields of `Picture`."""

    width: int
    height: int
    camera: Mapping[str, Any] | None


@final
class Picture(Section):
    """Size and camera of a cell's pictures."""

    width: int = Field(default=SIZE[1], ge=1, le=LARGEST_SIZE[1], strict=True, description="Width of a frame [pixels].")
    height: int = Field(
        default=SIZE[0], ge=1, le=LARGEST_SIZE[0], strict=True, description="Height of a frame [pixels]."
    )
    camera: Viewpoint = Viewpoint()

    @classmethod
    def of(cls, **settings: Unpack[PictureSettings]) -> Self:
        """A picture from a user's values; a camera that is None changes nothing.

        Raises:
            ConfigError: a value out of its range, or an unknown key of the camera.
        """
        try:
            return cls.model_validate({**settings, "camera": {} if (seen := settings.get("camera")) is None else seen})
        except ValidationError as error:
            raise ConfigError(*list_problems("picture", error, cls)) from None


@final
@dataclass(frozen=True)
class Marker:
    """A shape that is drawn and not simulated."""

    type: int
    size: Floats
    position: Floats
    frame: Floats
    """Rotation matrix (9,)."""
    rgba: Floats

    @classmethod
    def dot(cls, position: Floats, rgba: Floats, radius: float) -> Marker:
        """A small sphere."""
        return cls(int(mujoco.mjtGeom.mjGEOM_SPHERE.value), np.full(3, radius), position, np.eye(3).ravel(), rgba)

    @classmethod
    def all_of(cls, model: MjModel) -> list[Self]:
        """The geoms of a model whose bodies are at rest, as markers."""
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        columns = model.geom_type, model.geom_size, data.geom_xpos, data.geom_xmat, model.geom_rgba
        return [cls(int(kind), *rest) for kind, *rest in zip(*(np.array(column) for column in columns), strict=True)]

    @property
    def shape(self) -> tuple[Any, ...]:
        """What `write_shape` and `add_shape` take."""
        return self.type, self.size, self.position, self.frame, self.rgba.astype(np.float32)


@final
class Canvas:
    """Offscreen pictures of models that share one layout; any thread may draw and close, one at a time.

    Args:
        camera: MuJoCo's camera.
        size: height and width of a frame [pixels].
        items: names of the items, in the order of their colours, for their looks.
    """

    def __init__(self, camera: Any, size: tuple[int, int] = SIZE, items: Sequence[str] = ()) -> None:
        self.camera = camera
        self.size = size
        self.samples = 1
        """Drawings of a picture, each with the lights elsewhere and shifted by a part of a pixel, whose mean it is."""
        self._items = items
        self._look: SceneLook | None = None
        self._renderer: Any = None
        self._thread = 0
        """Identifier of the thread that opened the renderer."""

    def aim(self, picture: Picture, samples: int = 1) -> None:
        """Set size and camera of all pictures from now on, and the number of drawings whose mean a picture is."""
        self.close()
        self.samples = samples
        self.size = (picture.height, picture.width)
        for name, value in picture.camera.model_dump(exclude_none=True).items():
            setattr(self.camera, name, value)

    def draw(self, model: MjModel, data: MjData, markers: Iterable[Marker]) -> Frame:
        """Draw a picture (height, width, 3) of a model and markers.

        Raises:
            ConfigError: no OpenGL library could be loaded, or the library draws in another thread only.
        """
        with DRAWING_LOCK:
            renderer = self._open_renderer(model)
            assert self._look is not None
            renderer.update_scene(data, self.camera)
            scene, own = renderer.scene, int(renderer.scene.ngeom)
            for marker in markers:
                add_shape(scene, *marker.shape)
            self._look.dress(scene, model, own)
            with renderer._gl_context.as_current():  # current for this picture only: other threads draw, too
                if self._look.move_belt(model, data):
                    mujoco.mjr_uploadTexture(self._look.model, renderer._mjr_context, self._look.belt)
                return self._mean_of_samples(renderer)

    def close(self) -> None:
        """Free the renderer; safe to call twice.

        Raises:
            ConfigError: the OpenGL library closes the renderer in another thread only.
        """
        with DRAWING_LOCK:
            if self._renderer is not None:
                self._check_thread()
                self._renderer.close()
                self._renderer = None

    def _mean_of_samples(self, renderer: Any) -> Frame:
        """The mean of drawings with the camera shifted inside a pixel and with the lights elsewhere."""
        scene, reach = renderer.scene, float(self.camera.distance)
        first, total = [copy.copy(camera) for camera in scene.camera], np.zeros((*self.size, 3))
        for sample in range(self.samples):
            share = sample / self.samples
            shift = np.array([0.0, 0.0]) if sample == 0 else (np.array([sample * 0.618, share]) % 1.0) - 0.5
            for camera, kept in zip(scene.camera, first, strict=True):
                pixel = (kept.frustum_top - kept.frustum_bottom) / self.size[0]
                camera.frustum_center = kept.frustum_center + shift[0] * pixel
                camera.frustum_bottom = kept.frustum_bottom + shift[1] * pixel
                camera.frustum_top = kept.frustum_top + shift[1] * pixel
            light(scene, share, reach)
            drawing = renderer.render()
            if self.samples == 1:
                return drawing.copy()
            total += drawing
        return np.asarray(np.rint(total / self.samples).astype(np.uint8))

    def _open_renderer(self, model: MjModel) -> Any:
        """The renderer, set to this model; one renderer draws all models, because all have the same layout."""
        if self._renderer is None:
            self._look = SceneLook(model, self.size, self._items, float(self.camera.distance), is_mean=self.samples > 1)
            self._renderer, self._thread = _new_renderer(self._look.model, self.size), threading.get_ident()
            flags = self._renderer.scene.flags
            flags[mujoco.mjtRndFlag.mjRND_REFLECTION], flags[mujoco.mjtRndFlag.mjRND_FOG] = 0, 1
        self._check_thread()
        self._renderer._model = model
        return self._renderer

    def _check_thread(self) -> None:
        """Make sure that this thread can use the renderer.

        Raises:
            ConfigError: the OpenGL library is bound to another thread.
        """
        library = mujoco.GLContext.__module__
        if library in _BOUND and threading.get_ident() != self._thread:
            raise ConfigError(f"{library} draws and closes pictures only in the thread that asked for the first one")


@final
class Window:
    """MuJoCo's interactive window on one model.

    Args:
        model: the model that the window shows and that `play` changes.
        data: the state that the window shows first.

    Raises:
        ConfigError: there is no display.
    """

    def __init__(self, model: MjModel, data: MjData) -> None:
        threads_before = set(threading.enumerate())
        self._window = _open_window(model, data)
        self._threads = set(threading.enumerate()) - threads_before
        self._model, self._data = model, data

    def play(self, states: Iterable[MjData], write_model: Callable[[MjModel], object]) -> None:
        """Show states, 1 / `FPS` seconds apart, in real time.

        Args:
            states: states of the simulation.
            write_model: writes the simulation's model into a given model.
        """
        for state in states:
            started = time.perf_counter()
            with self._window.lock():
                write_model(self._model)
                self._data.qpos[:] = state.qpos
                mujoco.mj_forward(self._model, self._data)
            self._window.sync()
            time.sleep(max(1.0 / FPS - (time.perf_counter() - started), 0.0))

    def close(self) -> None:
        """Close the window, and wait for the window's threads."""
        self._window.close()
        for thread in self._threads:  # a thread that still draws when Python ends crashes the process
            thread.join(timeout=5.0)


def rendering_problem() -> str | None:
    """Why this machine cannot render, in one sentence; None if the machine can."""
    try:
        _new_renderer(mujoco.MjSpec().compile(), (8, 8)).close()
    except ConfigError as error:
        return str(error)
    return None


def _new_renderer(model: MjModel, size: tuple[int, int]) -> Any:
    """An offscreen renderer whose OpenGL context is not current in any thread.

    Raises:
        ConfigError: no OpenGL library could be loaded.
    """
    if not has_display() and os.environ.get("MUJOCO_GL", "glfw") == "glfw":
        raise ConfigError(_LIBRARIES)  # asking GLFW here would abort the process
    try:
        # The OpenGL context of this thread stays as it was before, or without one.
        spare_context = mujoco.GLContext(1, 1)
        try:
            # At its end MuJoCo restores the context from before, whichever is current by then.
            with spare_context.as_current():
                return mujoco.Renderer(model, *size)
        finally:
            spare_context.free()
    except Exception as error:
        raise ConfigError(f"{_LIBRARIES} ({type(error).__name__}: {error})") from None


def _open_window(model: MjModel, data: MjData) -> Any:
    if not has_display():
        raise ConfigError("render_mode 'human' needs a display; use 'rgb_array' on a headless machine")
    from mujoco import viewer  # noqa: PLC0415  # pyright: ignore[reportMissingTypeStubs]

    window: Any = viewer
    return window.launch_passive(model, data, show_left_ui=False, show_right_ui=False)


if __name__ == "__main__":
    print(rendering_problem() or "rendering works on this machine")
