"""Gymnasium facades over a core: one environment is one cell, a vector environment is N."""

from __future__ import annotations

import inspect
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from numbers import Integral
from typing import Any, ClassVar, Final

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from pnt_gym.cells.base.canvas import FPS, RENDER_MODES, SIZE, Picture
from pnt_gym.cells.base.config import Level, describes_a_cell, written
from pnt_gym.cells.base.core import Cell, Core, scalars
from pnt_gym.cells.base.features import FeatureTable
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.engine import has_display
from pnt_gym.errors import ActionError, ConfigError, OrderError, one_sentence

Observation = NDArray[np.float32]
SECTIONS: Final = (
    "Description",
    "Action Space",
    "Observation Space",
    "Rewards",
    "Starting State",
    "Episode End",
    "Arguments",
    "Version History",
)
"""Of a manual, as Gymnasium orders them."""
ARGUMENTS: Final = """\
| `threads` | int | 1 (vector: 2) | physics threads; results do not depend on it |
| `render_mode` | str or None | None | `rgb_array`: coming throw, `rgb_array_list`: last throw, `human` |
| `width` | int | 1280 | of a frame [pixels], up to 1920 |
| `height` | int | 720 | of a frame [pixels], up to 1080 |
| `camera` | mapping or None | None | `lookat` (x, y, z) [m], `distance` [m], `azimuth`, `elevation` [deg] to change |
| `num_envs` | int | 1 | only of the vector form, `gymnasium.make_vec` |"""
"""Rows that the table of arguments has in every manual."""


def _seed_of(value: Any) -> int | None:
    """A seed as Gymnasium takes it, or None."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < 0:
        raise ConfigError(f"seed is {one_sentence(repr(value), 80)}; it must be a whole number, at least 0")
    return int(value)


def _check_options(options: Any) -> None:
    if not (options is None or isinstance(options, dict)):
        raise ConfigError(f"options is {one_sentence(repr(options), 80)}; it must be a mapping, or None")


def completed(own: str, family: str) -> str:
    """A manual with the sections of its family; of a section that both have, the family's part comes first."""
    own, family = inspect.cleandoc(own), inspect.cleandoc(family)
    parts: dict[str, list[str]] = {title: [] for title in SECTIONS}
    for text in (family, own):
        for section in text.split("\n## ")[1:]:
            title, body = section.split("\n", 1)
            parts[title].append(body.strip())
    written = [f"## {title}\n\n" + "\n\n".join(bodies) for title, bodies in parts.items() if bodies]
    return "\n\n".join([own.split("\n\n", 1)[0], *written])


class Facade:
    """Abstract: what single and vector environments have in common.

    An environment pickles and copies with its state: the physics is a pure function of it, so a copy goes on as the
    original would. Views stay behind: a copy opens its own when it is asked for a picture.

    The docstring of an environment is its manual. What holds for a whole family stands in the docstring of their
    abstract class, once; every environment's own is completed with it. The table that a class `observes` by takes the
    place of `{observations}`, what can be said to every environment that of `{arguments}`.
    """

    core: Core
    _picture: Picture
    _view: ThrowView | None = None
    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """How Gymnasium made the environment; a level given as an object stands there in the form of a file."""
        return self._spec

    @spec.setter
    def spec(self, value: EnvSpec | None) -> None:
        if value is not None and "level" in value.kwargs:
            value.kwargs["level"] = written(value.kwargs["level"])
        self._spec = value

    def __init_subclass__(cls, observes: FeatureTable | None = None, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if cls.__doc__ and observes:
            manual = inspect.cleandoc(cls.__doc__).replace("{observations}", observes.markdown())
            cls.__doc__ = manual.replace("{arguments}", ARGUMENTS)
        family = next((base.__doc__ for base in cls.__mro__[1:] if "## Action Space" in (base.__doc__ or "")), None)
        if cls.__doc__ and family:
            cls.__doc__ = completed(cls.__doc__, family)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_view": None}

    def _opened_view(self) -> ThrowView:
        if self._view is None:
            self._view = self.core.view()
            if self._picture != Picture():
                self._view.aim(self._picture)
        return self._view

    def _close_view(self) -> None:
        if self._view is not None:
            self._view.close()
            self._view = None


class ThrowEnv(Facade, gym.Env[Observation, NDArray[np.floating]]):  # pyright: ignore[reportIncompatibleVariableOverride]
    """Abstract: one cell, one throw a step. Subclasses say which.

    Args:
        level: of the cell.
        action_mode: how an action is read; None for the cell's default.
        threads: of the physics; results do not depend on it.
        render_mode: one of `RENDER_MODES`, or None.
        width, height, camera: see `Picture`.

    Raises:
        ConfigError: an unknown action or render mode, no working cell, or no picture.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": list(RENDER_MODES), "render_fps": FPS}  # pyright: ignore[reportIncompatibleVariableOverride]

    @classmethod
    @abstractmethod
    def make_cell(cls, level: Level, count: int, threads: int) -> Cell[Any, Any, Any, Any]:
        """`count` cells of a level."""

    @classmethod
    def make_core(cls, level: Level, action_mode: str | None, count: int, threads: int) -> Core:
        """`count` cells of a level behind one way to act."""
        with describes_a_cell():
            return Core(cls.make_cell(level, count, threads), action_mode)

    def __init__(
        self,
        level: Level = "nominal",
        action_mode: str | None = None,
        threads: int = 1,
        render_mode: str | None = None,
        width: int = SIZE[1],
        height: int = SIZE[0],
        camera: Mapping[str, Any] | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise ConfigError(f"render_mode is {render_mode!r}; it must be one of {', '.join(RENDER_MODES)}, or None")
        if not has_display():  # what this machine can do; a class tells what there is
            modes = [mode for mode in RENDER_MODES if mode != "human"]
            vars(self)["metadata"] = {**self.metadata, "render_modes": modes}
        self._picture = Picture.of(width, height, camera)
        self.core = self.make_core(level, action_mode, 1, threads)
        self.observation_space = self.core.observation_space
        self.action_space = self.core.action_space
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; `options` are not used.

        Raises:
            ConfigError: a seed that is no whole number, or options that are no mapping.
        """
        _check_options(options)
        super().reset(seed=_seed_of(seed))
        self.core.reset(np.zeros(1, dtype=np.int64), [self.np_random], seeded=seed is not None)
        self._show()
        return self.core.observe()[0], scalars(self.core.kinds(), 0)

    def step(self, action: NDArray[np.floating]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Throw the object under the cup and move above the next one.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        try:
            array = np.asanyarray(action)  # a masked array stays one, for the core to refuse
        except ValueError:
            raise ActionError(f"action is {one_sentence(repr(action), 80)}; it must be an array of numbers") from None
        if array.shape != self.action_space.shape:
            raise ActionError(f"action has shape {array.shape}; this environment needs {self.action_space.shape}")
        result = self.core.step(array[None])
        self._show()
        over, terminates = bool(result.ended[0]), self.core.terminates
        return (
            result.observation[0],
            float(result.reward[0]),
            over and terminates,
            over and not terminates,
            scalars(result.info, 0),
        )

    def render(self) -> Any:
        """A frame of the coming pick (rgb_array), or the frames of the last throw (rgb_array_list)."""
        if self.render_mode is None or self.render_mode == "human":
            return None
        return self._opened_view().render(self.render_mode)

    def close(self) -> None:
        """Free the renderer and its window; safe to call twice."""
        self._close_view()

    def _show(self) -> None:
        """Open the view before the first throw, so that it is recorded; play it where there is a window."""
        if self.render_mode is not None:
            self._opened_view()
        if self.render_mode == "human":
            self._opened_view().show()


class ThrowVectorEnv(  # pyright: ignore[reportIncompatibleVariableOverride]
    Facade, VectorEnv[Observation, NDArray[np.floating], NDArray[Any]]
):
    """Abstract: N cells on one batch of simulations, autoreset in the same step. Subclasses name their single form.

    Args:
        num_envs: number of cells N.
        level: of the cells.
        action_mode: how an action is read; None for the cell's default.
        threads: of the physics; results do not depend on it.
        render_mode: "rgb_array" or None.
        width, height, camera: see `Picture`.

    Raises:
        ConfigError: an unknown action or render mode, no working cells, or no picture.
    """

    single: ClassVar[type[ThrowEnv]]
    """Row i of seed s is this one of seed s + i."""

    metadata: ClassVar[dict[str, Any]] = {  # pyright: ignore[reportIncompatibleVariableOverride]
        "render_modes": ["rgb_array"],
        "render_fps": FPS,
        "autoreset_mode": AutoresetMode.SAME_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        level: Level = "nominal",
        action_mode: str | None = None,
        threads: int = 2,
        render_mode: str | None = None,
        width: int = SIZE[1],
        height: int = SIZE[0],
        camera: Mapping[str, Any] | None = None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ConfigError(f"render_mode is {render_mode!r}; a vector environment takes 'rgb_array' or None")
        self._picture = Picture.of(width, height, camera)
        self.core = self.single.make_core(level, action_mode, num_envs, threads)
        self.num_envs = num_envs
        self.single_observation_space = self.core.observation_space
        self.single_action_space = self.core.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.render_mode = render_mode
        self._generators = [seeding.np_random(None)[0] for _ in range(num_envs)]
        self._begun = False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin episodes; row i of seed s is the single environment of seed s + i.

        Args:
            seed: one number, one per cell, or None to go on with the generators as they are.
            options: "reset_mask", a boolean array (num_envs,), restarts only the chosen cells.

        Raises:
            ConfigError: seeds that are no whole numbers, or a list of them or a mask whose length is not the number of
                cells.
            OrderError: the environment is closed.
        """
        if self.closed:
            raise OrderError("the environment is closed; make another one")
        mask = self._mask(options)
        for given, chosen in self._seed(seed, mask).items():
            rows = np.array(chosen, dtype=np.int64)
            if rows.size > 0:
                self.core.reset(rows, [self._generators[r] for r in rows], seeded=given)
        self._begun = True
        return self.core.observe(), self._masked(self.core.kinds())

    def step(
        self, actions: NDArray[np.floating]
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Throw in every cell; cells whose episode ends begin the next one in the same step.

        The results of the throw stand in `info` for every cell; for cells whose episode ended they are in
        `final_info` too, with the last observation in `final_obs`, as Gymnasium's own vector environments have them.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
            OrderError: the environment was not reset, or is closed.
        """
        if self.closed or not self._begun:
            state = "is closed; make another one" if self.closed else "was not reset; call reset before step"
            raise OrderError(f"the environment {state}")
        result = self.core.step(actions)
        info = self._masked(result.info)
        observation = result.observation
        rows = np.flatnonzero(result.ended)
        if rows.size > 0:
            last = np.full(self.num_envs, None, dtype=object)
            for row in rows:
                last[row] = observation[row].copy()
            final = dict(info)
            info |= {"final_obs": last, "_final_obs": result.ended.copy()}
            info |= {"final_info": final, "_final_info": result.ended.copy()}
            self.core.reset(rows, [self._generators[r] for r in rows], seeded=False)
            observation = self.core.observe()
            info |= self._masked(self.core.kinds())
        terminates = self.core.terminates
        none = np.zeros(self.num_envs, dtype=np.bool_)
        over = result.ended
        return observation, result.reward, over if terminates else none, none if terminates else over, info

    def render(self) -> tuple[Any, ...] | None:
        """One frame of every cell's coming pick."""
        if self.render_mode is None:
            return None
        return tuple(self._opened_view().frame(row) for row in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Free the renderer."""
        self._close_view()

    def _mask(self, options: dict[str, Any] | None) -> NDArray[np.bool_]:
        """Which cells to restart: all, unless the options choose."""
        _check_options(options)
        given: Any = (options or {}).get("reset_mask", np.ones(self.num_envs, dtype=np.bool_))
        try:
            mask: NDArray[Any] = np.asarray(given)
        except ValueError:  # rows of different lengths
            mask = np.zeros(0)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            said = one_sentence(repr(given), 80)
            raise ConfigError(f"reset_mask is {said}; it must be a boolean array of shape ({self.num_envs},)")
        return mask

    def _seed(self, seed: int | Sequence[int | None] | None, mask: NDArray[np.bool_]) -> dict[bool, list[int]]:
        """Reseed the generators of the chosen rows; which got a seed (True) and which keep theirs (False)."""
        if isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str | bytes):
            seeds = [_seed_of(value) for value in seed]
        else:
            first = _seed_of(seed)
            seeds = [None if first is None else first + i for i in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise ConfigError(f"seed has {len(seeds)} entries; this environment has {self.num_envs} cells")
        chosen = {row: value for row, value in enumerate(seeds) if mask[row]}
        for row, value in chosen.items():
            if value is not None:
                self._generators[row] = seeding.np_random(value)[0]
        return {given: [r for r, v in chosen.items() if (v is not None) == given] for given in (True, False)}

    def _masked(self, info: dict[str, NDArray[Any]]) -> dict[str, Any]:
        """Gymnasium's form of a vector info: every value with a mask of the rows it holds for."""
        every = np.ones(self.num_envs, dtype=np.bool_)
        return {key: value for name, values in info.items() for key, value in ((name, values), (f"_{name}", every))}
