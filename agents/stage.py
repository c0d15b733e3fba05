"""A cell in which a controller throws one object after the other, to be filmed or watched."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final, final

from .controllers import make_controller
from .environments import core_of, make_vector, stream_seed
from .evaluation import practise, thrown, usual_practice
from .throws import Throws
from .trained import setting

ENDLESS: Final = 10**9
"""Throws."""


@final
class Stage:
    """One cell with its controller, after its practice.

    Args:
        controller: as `--controller` takes it.
        env: as `--env` takes it; None for that of the controller's training, or the default.
        level: as `--level` takes it; None likewise.
        seed: names the objects.
        trust: load what runs code.
    """

    def __init__(self, controller: str, env: str | None, level: str | None, seed: int, *, trust: bool = False) -> None:
        env_id, level, mode = setting(controller, env, level, None)
        self._env = make_vector(env_id, level, num_envs=1, threads=1, action_mode=mode)
        try:
            self.core = core_of(self._env)
            thrower = make_controller(controller, self._env, trust=trust)
            thrower.reset(seed)
            practise(thrower, self._env, usual_practice(thrower), seed)
            self.view: Any = self.core.view()
        except BaseException:
            self._env.close()
            raise
        self.throws: Iterator[Throws] = thrown(thrower, self._env, ENDLESS, stream_seed("evaluate", seed))

    def close(self) -> None:
        """Free pictures and cell; safe to call twice."""
        self.view.close()
        self._env.close()
