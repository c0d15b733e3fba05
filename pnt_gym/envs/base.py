"""The Gymnasium facade over a core, and the facade of a single cell."""

from __future__ import annotations

import inspect
import os
import sys
import warnings
from abc import abstractmethod
from collections.abc import Mapping
from numbers import Integral
from types import MappingProxyType
from typing import Any, ClassVar, Final, Protocol, TypeAlias, Unpack, cast

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils import seeding
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Ints
from pnt_gym.cells.base.canvas import DRAWING_LOCK, FPS, RENDER_MODES, Picture, PictureSettings
from pnt_gym.cells.base.cell import Cell, Generators
from pnt_gym.cells.base.config import Level, LevelConfig, describes_a_cell, serialize_level
from pnt_gym.cells.base.core import Core, Step
from pnt_gym.cells.base.request import NO_REQUEST, REQUEST_OPTIONS, Request, requested_name
from pnt_gym.cells.base.view import View
from pnt_gym.engine import has_display
from pnt_gym.errors import ActionError, ConfigError, one_sentence
from pnt_gym.names import check_keywords, unknown_name

Observation: TypeAlias = Any
"""Observations: an array (N, D), or several arrays (N, ...) by name; of one environment without N."""
NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})
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
"""Sections of a manual, in Gymnasium's order."""
ARGUMENTS: Final = """\
| `threads` | int | 1 (vector: 2) | physics threads; results do not depend on it |
| `render_mode` | str or None | None | `rgb_array`: coming throw, `rgb_array_list`: last throw, `human` |
| `width` | int | 1280 | width of a frame [pixels], up to 1920 |
| `height` | int | 720 | height of a frame [pixels], up to 1080 |
| `camera` | mapping or None | None | `lookat` (x, y, z) [m], `distance` [m], `azimuth`, `elevation` [deg] to change |
| `num_envs` | int | 1 | number of cells; vector form alone (`gymnasium.make_vec`) |
| `autoreset_mode` | str or AutoresetMode | `"SameStep"` | vector form: `SameStep`, `NextStep` or `Disabled` |
| `max_episode_steps` | int or None | None | vector form: steps of an episode; `gymnasium.make` adds a TimeLimit |
| `disable_env_checker` | bool or None | None | vector form, which has no checker: True or None |

`reset(options={"item": ..., "target": ...})` chooses item, target or both for the first throw of an episode, by name or
index. The throw is drawn until it meets the request; later throws are drawn as always. In the vector form the request
holds for every cell that is reset; the option `reset_mask`, a boolean array, chooses these cells."""
"""Rows that the table of arguments has in every manual, and the options of a reset."""


class Entries(Protocol):
    """Entries of an observation, as a manual lists them."""

    def __len__(self) -> int:
        """Numbers in an observation."""
        ...

    def markdown(self) -> str:
        """One row per entry."""
        ...


class BatchedCore(Protocol):
    """The batched simulation behind an environment; row i is environment i. A `Core` throws once a step."""

    cell: Any
    config: Any
    terminates: bool
    observation_space: gym.Space[Any]
    action_space: gym.Space[Any]

    def reset(self, rows: Ints, generators: Generators, seeded: Bools | bool, request: Request = NO_REQUEST) -> object:
        """Begin new episodes in some rows; what is returned is for cores around this core."""

    def observe(self) -> Observation:
        """Observations (N, D), or several arrays (N, ...) by name."""
        ...

    def kinds(self) -> dict[str, NDArray[Any]]:
        """Entries of the info about the coming steps, (N, ...) each."""
        ...

    def step(self, actions: object, waiting: Bools | None = None) -> Step:
        """Take one step in every row; the step of rows that wait (N,) is undone."""
        ...

    def view(self) -> View:
        """View that draws the rows."""
        ...


def seed_of(value: Any) -> int | None:
    """A seed as Gymnasium takes it, or None."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < 0:
        raise ConfigError(f"seed is {one_sentence(repr(value), 80)}; it must be a whole number, at least 0")
    return int(value)


def request_of(options: Any, core: BatchedCore, *others: str) -> Request:
    """The request for the first throw in the options of a reset; `others` are further names of options."""
    if not (options is None or isinstance(options, dict)):
        raise ConfigError(f"options is {one_sentence(repr(options), 80)}; it must be a mapping, or None")
    given, known = cast("dict[object, Any]", options or {}), (*REQUEST_OPTIONS, *others)
    for name in given:
        if name not in known:
            raise ConfigError(unknown_name("option", name, known))
    return {name: requested_name(core.cell, name, given[name]) for name in REQUEST_OPTIONS if name in given}


class Facade:
    """Abstract: the common part of single and vector environments.

    An environment pickles and copies with its state. The physics is a pure function of the state, so a copy continues
    like the original. Views are not copied: a copy opens a view of its own for its first picture.

    The docstring of an environment is its manual. The docstring of an abstract class holds the text of a whole family
    of environments, and the manual of each environment is completed with this text. Three marks are replaced:
    `{observations}` by the table `observes` of the class or of its family, `{entries}` by the number of entries of that
    table, and `{arguments}` by the arguments of every environment.
    """

    core: BatchedCore
    _picture: Picture
    _view: View | None = None
    _spec: EnvSpec | None = None
    _family: ClassVar[str] = ""
    """The manual of the family, before anything takes its place in it."""
    _table: ClassVar[Entries | None] = None

    @property
    def spec(self) -> EnvSpec | None:
        """Gymnasium's specification of the environment; a level given as an object is kept in the form of a file."""
        return self._spec

    @spec.setter
    def spec(self, value: EnvSpec | None) -> None:
        if value is not None and "level" in value.kwargs:
            value.kwargs["level"] = serialize_level(value.kwargs["level"])
        self._spec = value

    def __init_subclass__(cls, observes: Entries | None = None, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        cls._table = observes or cls._table
        if not cls.__doc__:
            return
        manual = inspect.cleandoc(cls.__doc__)
        if cls._family:
            # Of a section that both manuals have, the family's part comes first.
            parts: dict[str, list[str]] = {title: [] for title in SECTIONS}
            for text in (cls._family, manual):
                for section in text.split("\n## ")[1:]:
                    title, body = section.split("\n", 1)
                    parts[title].append(body.strip())
            written = [f"## {title}\n\n" + "\n\n".join(bodies) for title, bodies in parts.items() if bodies]
            manual = "\n\n".join([manual.split("\n\n", 1)[0], *written])
        elif "## Action Space" in manual:
            cls._family = manual
        if cls._table is not None:
            manual = manual.replace("{observations}", cls._table.markdown()).replace("{entries}", str(len(cls._table)))
        cls.__doc__ = manual.replace("{arguments}", ARGUMENTS)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_view": None}

    def _opened_view(self) -> View:
        with DRAWING_LOCK:
            if self._view is None:
                self._view = self.core.view()
                if self._picture != Picture():
                    self._view.aim(self._picture)
            return self._view

    def _close_view(self) -> None:
        with DRAWING_LOCK:
            if self._view is not None:
                self._view.close()
                self._view = None


class CoreEnv(Facade, gym.Env[Observation, NDArray[Any]]):  # pyright: ignore[reportIncompatibleVariableOverride]
    """Abstract: one row of a batched core. Subclasses make the core.

    Args:
        level: level of the cell.
        action_mode: meaning of an action; None for the cell's default.
        threads: threads of the physics; results do not depend on this number.
        render_mode: one of `RENDER_MODES`, or None.
        picture: width, height and camera, see `Picture`.

    Raises:
        ConfigError: an unknown argument, action mode or render mode, no working cell, or no picture.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": list(RENDER_MODES), "render_fps": FPS}  # pyright: ignore[reportIncompatibleVariableOverride]

    @classmethod
    def load_config(cls, level: Level) -> LevelConfig:
        """Config of a level, as the environment reads the level; a subclass can read it without making a cell."""
        return cls.make_core(level, None, 1, 1).config

    @classmethod
    @abstractmethod
    def make_core(cls, level: Level, action_mode: str | None, count: int, threads: int) -> Any:
        """A `BatchedCore` with `count` rows of a level and one action mode."""

    @check_keywords
    def __init__(
        self,
        level: Level = "nominal",
        action_mode: str | None = None,
        threads: int = 1,
        render_mode: str | None = None,
        **picture: Unpack[PictureSettings],
    ) -> None:
        offered: list[str] = type(self).metadata["render_modes"]
        if render_mode is not None and render_mode not in offered:
            raise ConfigError(unknown_name("render_mode", render_mode, [*offered, None]))
        if not has_display():  # what this machine can do; a class tells what there is
            modes = [mode for mode in offered if mode != "human"]
            vars(self)["metadata"] = {**self.metadata, "render_modes": modes}
        self._picture = Picture.of(**picture)
        self.core = self.make_core(level, action_mode, 1, threads)
        warn_of_threads(threads)
        self.observation_space = self.core.observation_space
        self.action_space = self.core.action_space
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: seed of the throws; None continues with the generator as it is.
            options: request for the first throw: "item", a name (or index) of `core.item_names`, and "target", a name
                (or index) of `core.cell.target_names`. Everything else is drawn, and later throws are drawn as always.

        Raises:
            ConfigError: the seed is no whole number, or no throw meets the request; the environment does not change.
        """
        request, number = request_of(options, self.core), seed_of(seed)
        generator = self.np_random if number is None else seeding.np_random(number)[0]
        self.core.reset(np.zeros(1, dtype=np.int64), [generator], number is not None, request)
        if number is not None:
            self._np_random, self._np_random_seed = generator, number
        self._show()
        return row_of(self.core.observe(), 0), scalars(self.core.kinds(), 0)

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
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
            row_of(result.observation, 0),
            float(result.reward[0]),
            over and terminates,
            over and not terminates,
            scalars(result.info, 0, result.partial),
        )

    def render(self) -> Any:
        """A frame of the coming pick (rgb_array), or the frames of the last throw (rgb_array_list)."""
        if self.render_mode is None or self.render_mode == "human":
            return None
        with DRAWING_LOCK:  # a view poses one model for all who ask
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


class ThrowEnv(CoreEnv):
    """Abstract: an environment of one cell, with one throw a step. Subclasses make the cell."""

    @classmethod
    @abstractmethod
    def make_cell(cls, level: Level, count: int, threads: int) -> Cell[Any, Any, Any, Any]:
        """`count` cells of a level."""

    @classmethod
    def make_core(cls, level: Level, action_mode: str | None, count: int, threads: int) -> Core:
        """Core with `count` cells of a level and one action mode."""
        with describes_a_cell():
            return Core(cls.make_cell(level, count, threads), action_mode)


def warn_of_threads(threads: int) -> None:
    """Warn of more threads than this process may use at the same time; two, the default of vector forms, are fine."""
    cores = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
    if threads > max(cores, 2):
        warnings.warn(
            f"threads is {threads}, more than this process has cores ({cores}); results are the same, and steps take "
            "longer",
            stacklevel=3,
        )


def row_of(observation: Observation, row: int) -> Observation:
    """A copy of one row of observations."""
    if isinstance(observation, Mapping):
        arrays = cast("Mapping[str, NDArray[Any]]", observation)
        return {name: values[row].copy() for name, values in arrays.items()}
    return observation[row].copy()


def scalars(info: Mapping[str, NDArray[Any]], row: int, partial: Mapping[str, Bools] = NOTHING) -> dict[str, Any]:
    """One row of a step's info as plain Python values; what is several numbers there stays an array.

    Args:
        info: named results of N rows.
        row: which one.
        partial: rows (N,) that have a result, of results that only some rows have.
    """
    values_by_name: dict[str, Any] = {}
    for name, values in info.items():
        if name not in partial or partial[name][row]:
            values_by_name[name] = values[row].item() if values.ndim == 1 else values[row].copy()
    return values_by_name
