"""The vector form of any environment: N cells on one batch of simulations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral
from typing import Any, ClassVar, Unpack

import numpy as np
from gymnasium import Space
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from pnt_gym.arrays import Bools
from pnt_gym.cells.base.canvas import DRAWING_LOCK, FPS, Picture, PictureSettings
from pnt_gym.cells.base.config import Level
from pnt_gym.cells.base.core import Step
from pnt_gym.envs.base import NOTHING, CoreEnv, Facade, Observation, request_of, row_of, seed_of, warn_of_threads
from pnt_gym.errors import ActionError, ConfigError, OrderError, one_sentence
from pnt_gym.names import check_keywords, unknown_name


class ThrowVectorEnv(  # pyright: ignore[reportIncompatibleVariableOverride]
    Facade, VectorEnv[Observation, NDArray[np.floating], NDArray[Any]]
):
    """Abstract: a vector environment of N cells on one batch of simulations. `vector_form` makes subclasses.

    Args:
        num_envs: number of cells N.
        level: level of the cells.
        action_mode: meaning of an action; None for the cells' default.
        threads: threads of the physics; results do not depend on this number.
        render_mode: "rgb_array" or None.
        autoreset_mode: when a cell begins a new episode: in the step that ends the old episode, in the next step, in
            which the cell does not throw, or only at a reset.
        max_episode_steps: steps after which an episode is truncated; None for the cells' own limit alone.
        disable_env_checker: True or None, as in calls of `gymnasium.make`; a vector environment has no checker.
        picture: width, height and camera, see `Picture`.

    Raises:
        ConfigError: an argument is unknown or out of its range, or the level describes no cell that works.
    """

    single: ClassVar[type[CoreEnv]]
    """Single environment: row i of the vector environment with seed s equals it with seed s + i."""

    metadata: ClassVar[dict[str, Any]] = {  # pyright: ignore[reportIncompatibleVariableOverride]
        "render_modes": ["rgb_array"],
        "render_fps": FPS,
        "autoreset_mode": AutoresetMode.SAME_STEP,
    }

    @check_keywords
    def __init__(
        self,
        num_envs: int = 1,
        level: Level = "nominal",
        action_mode: str | None = None,
        threads: int = 2,
        render_mode: str | None = None,
        autoreset_mode: str | AutoresetMode = "SameStep",
        max_episode_steps: int | None = None,
        disable_env_checker: bool | None = None,
        **picture: Unpack[PictureSettings],
    ) -> None:
        self._autoreset = self._checked(render_mode, autoreset_mode, disable_env_checker)
        if max_episode_steps is not None:
            limit: Any = max_episode_steps
            if isinstance(limit, bool) or not isinstance(limit, Integral) or int(limit) < 1:
                said = one_sentence(repr(limit), 80)
                raise ConfigError(f"max_episode_steps is {said}; it must be a whole number, at least 1, or None")
        self._limit = None if max_episode_steps is None else int(max_episode_steps)
        vars(self)["metadata"] = {**self.metadata, "autoreset_mode": self._autoreset}
        self._picture = Picture.of(**picture)
        self.core = self.single.make_core(level, action_mode, num_envs, threads)
        warn_of_threads(threads)
        self.num_envs = num_envs
        self.single_observation_space: Space[Any] = self.core.observation_space
        self.single_action_space: Space[Any] = self.core.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.render_mode = render_mode
        self._generators = [seeding.np_random(None)[0] for _ in range(num_envs)]
        self._begun = False
        self._over = np.zeros(num_envs, dtype=np.bool_)
        """Cells that wait for a reset."""
        self._steps = np.zeros(num_envs, dtype=np.int64)
        """Steps that each cell has taken in its episode."""
        self._failed = False
        """Whether a step ended with an error, which leaves some cells before a throw and other cells after it."""

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin episodes; row i of seed s is the single environment of seed s + i.

        Args:
            seed: one seed, a seed for each cell, or None to continue with the generators as they are.
            options: "reset_mask", a boolean array (num_envs,) of the cells to reset, by default all cells; the masks of
                the info mark these cells. "item" and "target" request the first throw of each of these cells, as in
                the single environment.

        Raises:
            ConfigError: a seed is no whole number, the length of seeds or mask is not the number of cells, or no throw
                meets the request; the environment does not change.
            OrderError: the environment is closed, or the last step failed and the mask leaves out cells.
        """
        if self.closed:
            raise OrderError("the environment is closed; make another one")
        request = request_of(options, self.core, "reset_mask")
        given: Any = (options or {}).get("reset_mask", np.ones(self.num_envs, dtype=np.bool_))
        try:
            mask: NDArray[Any] = np.asarray(given)
        except ValueError:  # rows of different lengths
            mask = np.zeros(0)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            said = one_sentence(repr(given), 80)
            raise ConfigError(f"reset_mask is {said}; it must be a boolean array of shape ({self.num_envs},)")
        seeds = self._seeds(seed)
        if self._failed and not mask.all():
            raise OrderError("the last step failed; reset all cells, without a reset_mask")
        rows = np.flatnonzero(mask)
        generators = [self._generators[r] if seeds[r] is None else seeding.np_random(seeds[r])[0] for r in rows]
        if rows.size > 0:
            self.core.reset(rows, generators, np.array([seeds[r] is not None for r in rows]), request)
        for row, generator in zip(rows, generators, strict=True):
            self._generators[row] = generator
        self._begun, self._failed, self._over = True, False, self._over & ~mask
        self._steps[mask] = 0
        return self.core.observe(), masked(self.core.kinds(), mask, every=True)

    def step(
        self, actions: NDArray[np.floating]
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Throw in every cell; a cell whose episode is over begins a new episode by the autoreset mode.

        A mask `_name` marks the cells for which `info[name]` holds, as in Gymnasium's own vector environments. For a
        cell that began a new episode in this step, only entries of a reset hold. In the mode `SameStep`, `final_info`
        has the results of such a cell, with masks, and `final_obs` its last observation; the arrays of `info` have the
        results of all cells too, so `info["landing_error"]` can be read directly. In other modes an array has NaN (or
        0) for cells that did not throw.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
            OrderError: the environment was not reset or is closed, a cell whose episode is over needs a reset, or the
                last step failed.
            PhysicsError: the engine warned, or stopped a simulation; all cells need a reset.
        """
        self._check_order()
        waiting, same = self._over, self._autoreset is AutoresetMode.SAME_STEP
        try:
            result = self._throw(actions, waiting)
        except ActionError:  # refused before the throw
            raise
        except BaseException:
            self._failed = True
            raise
        self._steps += ~waiting
        none = np.zeros(self.num_envs, dtype=np.bool_)
        cut = none if self._limit is None else ~waiting & (self._steps >= self._limit)
        terminated, truncated = (result.ended, cut) if self.core.terminates else (none, result.ended | cut)
        over = terminated | truncated
        renewed = over if same else waiting
        info = masked(result.info, ~renewed, result.partial, every=same)
        if same and over.any():
            last = np.full(self.num_envs, None, dtype=object)
            for row in np.flatnonzero(over):
                last[row] = row_of(result.observation, int(row))
            final = masked(result.info, over, result.partial)
            info |= {"final_obs": last, "_final_obs": over.copy(), "final_info": final, "_final_info": over.copy()}
        if not same:
            self._over = over
        observation = self._renew(renewed, info) if renewed.any() else result.observation
        return observation, result.reward, terminated, truncated, info

    def render(self) -> tuple[Any, ...] | None:
        """One frame of every cell's coming pick."""
        if self.render_mode is None:
            return None
        with DRAWING_LOCK:  # a view poses one model for all who ask
            return tuple(self._opened_view().frame(row) for row in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Free the renderer."""
        self._close_view()

    def _checked(self, render_mode: Any, autoreset_mode: Any, disable_env_checker: Any) -> AutoresetMode:
        """The autoreset mode, if that and other settings are among those that there are.

        Raises:
            ConfigError: one is not.
        """
        offered: list[str] = type(self).metadata["render_modes"]
        if render_mode is not None and render_mode not in offered:
            further = "; a single environment may have further ones"
            raise ConfigError(unknown_name("render_mode", render_mode, [*offered, None], further))
        if autoreset_mode not in [*AutoresetMode, *(mode.value for mode in AutoresetMode)]:
            raise ConfigError(unknown_name("autoreset_mode", autoreset_mode, [mode.value for mode in AutoresetMode]))
        if disable_env_checker is not None and disable_env_checker is not True:
            said = one_sentence(repr(disable_env_checker), 80)
            raise ConfigError(
                f"disable_env_checker is {said}; it must be True or None, as vector environments have no checker"
            )
        return AutoresetMode(autoreset_mode)

    def _check_order(self) -> None:
        """Make sure that every cell can step, or is reset in this step."""
        if self.closed or not self._begun:
            state = "is closed; make another one" if self.closed else "was not reset; call reset before step"
            raise OrderError(f"the environment {state}")
        if self._failed:
            raise OrderError("the last step failed; reset all cells before the next step")
        if self._autoreset is AutoresetMode.DISABLED and self._over.any():
            cells = ", ".join(map(str, np.flatnonzero(self._over)))
            raise OrderError(f"the episodes of cells {cells} are over; reset them with the option 'reset_mask'")

    def _throw(self, actions: NDArray[np.floating], waiting: Bools) -> Step:
        """Throw in the cells that do not wait for a reset; a rollout has all cells, so the core takes the rest back."""
        if not waiting.any():
            return self.core.step(actions)
        if waiting.all():
            return Step(self.core.observe(), np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=np.bool_), {})
        actions = np.array(actions)
        if actions.shape == (self.num_envs, *(self.core.action_space.shape or ())):
            actions[waiting] = 0
        result = self.core.step(actions, waiting)
        return Step(
            result.observation,
            np.where(waiting, 0.0, result.reward),
            result.ended & ~waiting,
            {name: _without(values, waiting) for name, values in result.info.items()},
            result.partial,
        )

    def _renew(self, over: Bools, info: dict[str, Any]) -> Observation:
        """Begin anew in some cells; what is seen of all."""
        rows = np.flatnonzero(over)
        self.core.reset(rows, [self._generators[row] for row in rows], seeded=False)
        self._steps[rows] = 0
        info |= masked(self.core.kinds(), np.ones(self.num_envs, dtype=np.bool_))
        return self.core.observe()

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        """The seed of every cell, None where it keeps its generator."""
        if isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str | bytes):
            seeds = [seed_of(value) for value in seed]
        else:
            first = seed_of(seed)
            seeds = [None if first is None else first + i for i in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise ConfigError(f"seed has {len(seeds)} entries; this environment has {self.num_envs} cells")
        return seeds


def masked(
    info: Mapping[str, NDArray[Any]], rows: Bools, partial: Mapping[str, Bools] = NOTHING, every: bool = False
) -> dict[str, Any]:
    """Gymnasium's form of a vector info: every value with a mask of the rows it holds for.

    Args:
        info: named results, (N, ...) each.
        rows: which rows have results (N,).
        partial: which rows do (N,), of results that only some rows have.
        every: whether results that no row has stay, with masks that are False.
    """
    result, has_rows = dict[str, Any](), every or rows.any()
    for name, values in info.items():
        mask = rows & partial[name] if name in partial else rows.copy()
        if every or (mask.any() if name in partial else has_rows):
            result[name], result[f"_{name}"] = values, mask
    return result


def _without(values: NDArray[Any], rows: Bools) -> NDArray[Any]:
    """A copy of values (N, ...) with NaN in some rows, or 0 where values are no floating numbers."""
    blank = values.copy()
    blank[rows] = np.nan if values.dtype.kind == "f" else 0
    return blank


def vector_form(single: type[CoreEnv], pictured: bool = True) -> type[ThrowVectorEnv]:
    """Make the vector form of `SomethingEnv`, which the same module should name `SomethingVectorEnv`.

    Args:
        single: environment of one cell.
        pictured: whether the vector form has pictures.
    """
    name = f"{single.__name__.removesuffix('Env')}VectorEnv"
    manual = f"N cells of `{single.__name__}` on one batch of simulations; row i of seed s is that one of seed s + i."
    metadata = {
        **ThrowVectorEnv.metadata,
        "render_modes": [m for m in single.metadata["render_modes"] if pictured and m == "rgb_array"],
    }
    form = {"single": single, "metadata": metadata, "__doc__": manual, "__module__": single.__module__}
    return type(name, (ThrowVectorEnv,), form)
