"""The vector form of any environment: N cells on one batch of simulations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from gymnasium import Space
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, replaced, take
from pnt_gym.cells.base.canvas import DRAWING, FPS, SIZE, Picture
from pnt_gym.cells.base.config import Level
from pnt_gym.envs.base import CoreEnv, Facade, Observation, request_of, seed_of
from pnt_gym.errors import ConfigError, OrderError, one_sentence


class ThrowVectorEnv(  # pyright: ignore[reportIncompatibleVariableOverride]
    Facade, VectorEnv[Observation, NDArray[np.floating], NDArray[Any]]
):
    """Abstract: N cells on one batch of simulations. Subclasses are made by `vector_form`.

    Args:
        num_envs: number of cells N.
        level: of the cells.
        action_mode: how an action is read; None for the cell's default.
        threads: of the physics; results do not depend on it.
        render_mode: "rgb_array" or None.
        width, height, camera: see `Picture`.
        autoreset_mode: when a cell whose episode is over begins anew: in the same step, in the next one, which throws
            nothing there, or never by itself.

    Raises:
        ConfigError: an unknown action, render or autoreset mode, no working cells, or no picture.
    """

    single: ClassVar[type[CoreEnv]]
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
        autoreset_mode: str | AutoresetMode = "SameStep",
    ) -> None:
        offered: list[str] = type(self).metadata["render_modes"]
        if render_mode is not None and render_mode not in offered:
            said = " or ".join([*map(repr, offered), "None"])
            raise ConfigError(f"render_mode is {render_mode!r}; a vector environment takes {said}")
        if autoreset_mode not in [*AutoresetMode, *(mode.value for mode in AutoresetMode)]:
            known = ", ".join(mode.value for mode in AutoresetMode)
            raise ConfigError(f"autoreset_mode is {one_sentence(repr(autoreset_mode), 80)}; it must be one of {known}")
        self._autoreset = AutoresetMode(autoreset_mode)
        vars(self)["metadata"] = {**self.metadata, "autoreset_mode": self._autoreset}
        self._picture = Picture.of(width, height, camera)
        self.core = self.single.make_core(level, action_mode, num_envs, threads)
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

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin episodes; row i of seed s is the single environment of seed s + i.

        Args:
            seed: one number, one per cell, or None to go on with the generators as they are.
            options: "reset_mask", a boolean array (num_envs,), restarts only the chosen cells; "item" and "target" are
                what the first throw of each has to be, as in the single environment.

        Raises:
            ConfigError: seeds that are no whole numbers, a list of them or a mask whose length is not the number of
                cells, or options that ask for what is not there or never comes; the environment is as it was.
            OrderError: the environment is closed.
        """
        if self.closed:
            raise OrderError("the environment is closed; make another one")
        request, mask, seeds = request_of(options, self.core, "reset_mask"), self._mask(options), self._seeds(seed)
        rows = np.flatnonzero(mask)
        generators = [self._generators[r] if seeds[r] is None else seeding.np_random(seeds[r])[0] for r in rows]
        if rows.size > 0:
            self.core.reset(rows, generators, np.array([seeds[r] is not None for r in rows]), request)
        for row, generator in zip(rows, generators, strict=True):
            self._generators[row] = generator
        self._begun, self._over = True, self._over & ~mask
        return self.core.observe(), self._masked(self.core.kinds())

    def step(
        self, actions: NDArray[np.floating]
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Throw in every cell; cells whose episode is over begin the next one as the autoreset mode says.

        The results of the throw stand in `info` for every cell; for cells that begin anew in the same step they are in
        `final_info` too, with the last observation in `final_obs`, as Gymnasium's own vector environments have them.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
            OrderError: the environment was not reset, or is closed; or cells are over that nothing resets.
        """
        if self.closed or not self._begun:
            state = "is closed; make another one" if self.closed else "was not reset; call reset before step"
            raise OrderError(f"the environment {state}")
        if self._over.any():
            observation, reward, over, info = self._step_and_renew(actions)
        else:
            result = self.core.step(actions)
            observation, reward, over, info = result.observation, result.reward, result.ended, self._masked(result.info)
        none = np.zeros(self.num_envs, dtype=np.bool_)
        if self._autoreset is not AutoresetMode.SAME_STEP:
            self._over = over.copy()
        elif over.any():
            last = np.full(self.num_envs, None, dtype=object)
            for row in np.flatnonzero(over):
                last[row] = observation[row].copy()
            final = self._masked({name: info[name] for name in info if not name.startswith("_")}, over)
            info |= {"final_obs": last, "_final_obs": over.copy()}
            info |= {"final_info": final, "_final_info": over.copy()}
            observation = self._renew(over, info)
        terminates = self.core.terminates
        return observation, reward, over if terminates else none, none if terminates else over, info

    def render(self) -> tuple[Any, ...] | None:
        """One frame of every cell's coming pick."""
        if self.render_mode is None:
            return None
        with DRAWING:  # a view poses one model for all who ask
            return tuple(self._opened_view().frame(row) for row in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Free the renderer."""
        self._close_view()

    def _step_and_renew(self, actions: NDArray[np.floating]) -> tuple[Observation, Floats, Bools, dict[str, Any]]:
        """Begin anew where an episode is over, and throw elsewhere; observation, reward, ends and info."""
        over, cell = self._over, self.core.cell
        if self._autoreset is AutoresetMode.DISABLED:
            cells = ", ".join(map(str, np.flatnonzero(over)))
            raise OrderError(f"the episodes of cells {cells} are over; reset them with the option 'reset_mask'")
        info: dict[str, Any] = {}
        reward, ended = np.zeros(self.num_envs), np.zeros(self.num_envs, dtype=np.bool_)
        if not over.all():
            # Every cell throws in a rollout; what these do is taken back, their random numbers included.
            context, waiting = cell.context, [self._generators[row] for row in np.flatnonzero(over)]
            states = [generator.bit_generator.state for generator in waiting]
            actions = np.array(actions)
            if actions.shape == (self.num_envs, *(self.core.action_space.shape or ())):
                actions[over] = 0.0
            result = self.core.step(actions)
            cell.context = replaced(cell.context, over, take(context, over))
            for generator, state in zip(waiting, states, strict=True):
                generator.bit_generator.state = state
            reward, ended = np.where(over, 0.0, result.reward), result.ended & ~over
            info = self._masked(result.info, ~over)
        return self._renew(over, info), reward, ended, info

    def _renew(self, over: Bools, info: dict[str, Any]) -> Observation:
        """Begin anew in some cells; what is seen of all."""
        rows = np.flatnonzero(over)
        self.core.reset(rows, [self._generators[row] for row in rows], seeded=False)
        info |= self._masked(self.core.kinds())
        return self.core.observe()

    def _mask(self, options: dict[str, Any] | None) -> NDArray[np.bool_]:
        """Which cells to restart: all, unless the options choose."""
        given: Any = (options or {}).get("reset_mask", np.ones(self.num_envs, dtype=np.bool_))
        try:
            mask: NDArray[Any] = np.asarray(given)
        except ValueError:  # rows of different lengths
            mask = np.zeros(0)
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
            said = one_sentence(repr(given), 80)
            raise ConfigError(f"reset_mask is {said}; it must be a boolean array of shape ({self.num_envs},)")
        return mask

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

    def _masked(self, info: dict[str, NDArray[Any]], rows: Bools | bool = True) -> dict[str, Any]:
        """Gymnasium's form of a vector info: every value with a mask of the rows it holds for."""
        mask = np.full(self.num_envs, rows)
        return {key: value for name, values in info.items() for key, value in ((name, values), (f"_{name}", mask))}


def vector_form(single: type[CoreEnv], pictured: bool = True) -> type[ThrowVectorEnv]:
    """The vector form of `SomethingEnv`, to be called `SomethingVectorEnv` in the same module.

    Args:
        single: of one cell.
        pictured: whether many can be drawn as well as one.
    """
    name = f"{single.__name__.removesuffix('Env')}VectorEnv"
    manual = f"N cells of `{single.__name__}` on one batch of simulations; row i of seed s is that one of seed s + i."
    metadata = {
        **ThrowVectorEnv.metadata,
        "render_modes": [m for m in single.metadata["render_modes"] if pictured and m == "rgb_array"],
    }
    form = {"single": single, "metadata": metadata, "__doc__": manual, "__module__": single.__module__}
    return type(name, (ThrowVectorEnv,), form)
