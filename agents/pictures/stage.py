"""A cell in which a controller throws one object after the other, to be filmed or watched."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, takewhile
from typing import Any, Final, final

from ..controllers import make_controller
from ..controllers.protocol import Controller
from ..dispatchers.registry import line_controller, line_of, opened
from ..ground.environments import core_of, stream_seed
from ..judging.evaluation import practise, thrown, usual_practice
from ..learning.trained import setting
from .film import SECONDS, decisions

ENDLESS: Final = 10**9
"""Throws."""
PICKS: Final = 5
"""Throws of a video unless others are asked for."""


@final
class Stage:
    """One cell with its controller, after its practice; or a line with who decides there.

    Args:
        controller: as `--controller` takes it.
        env: as `--env` takes it; None for that of the controller's training, or the default.
        level: as `--level` takes it; None likewise.
        seed: names the objects.
        trust: load what runs code.
        throws: what becomes of those of a line; None for the level's own.

    Raises:
        UsageError: throws are asked for, and it is no line.
    """

    def __init__(
        self,
        controller: str,
        env: str | None,
        level: str | None,
        seed: int,
        *,
        trust: bool = False,
        throws: str | None = None,
    ) -> None:
        env_id, level, mode = setting(controller, env, level, None)
        self._env = opened(env_id, level, 1, 1, mode, throws)
        self._line = line_of(self._env)
        try:
            self.core: Any = core_of(self._env)
            thrower = self._thrower(controller, seed, trust)
            self.view: Any = self.core.view()
        except BaseException:
            self._env.close()
            raise
        begun = stream_seed("evaluate", seed)
        one_by_one = decisions(thrower, self._env, begun) if self._line else thrown(thrower, self._env, ENDLESS, begun)
        self.throws: Iterator[Any] = one_by_one

    def _thrower(self, name: str, seed: int, trust: bool) -> Controller:
        """The controller, after its practice; on a line there is none."""
        if self._line is not None:
            decider = line_controller(name, self._line)
            decider.reset(seed)
            return decider
        thrower = make_controller(name, self._env, trust=trust)
        thrower.reset(seed)
        practise(thrower, self._env, usual_practice(thrower), seed)
        return thrower

    def filmed(self, picks: int | None) -> Iterator[Any]:
        """So many throws, or decisions of a line; without a number as many as are usual."""
        if picks is None and self._line is not None:
            return takewhile(lambda time: time < SECONDS, self.throws)
        return islice(self.throws, PICKS if picks is None else picks)

    def advance(self, moment: float) -> None:
        """Throw once; on a line decide until a moment of its shift [s]."""
        if self._line is None:
            next(self.throws)
            return
        for time in self.throws:
            if time >= moment:
                break

    def close(self) -> None:
        """Free pictures and cell; safe to call twice."""
        self.view.close()
        self._env.close()
