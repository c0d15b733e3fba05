"""A cell in which a controller acts step by step, for films, pictures and live viewers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, Final, final

from pnt_gym.cells.base.canvas import Picture
from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.view import ThrowView, record_video
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.line.view import LineView

from ..controllers.protocol import Controller
from ..ground.cli import UsageError
from ..ground.outputs import deliver, deliver_text
from ..judging.recorder import Recorder
from ..judging.trials import open_trial
from ..learning import trained
from .seen import SeenController, SeenView

RATE: Final = 60
"""Frames per second from which a picture's frame is chosen."""
SAMPLES: Final = 24
"""Drawings of a picture, whose mean it is: no stairs, and soft shadows."""


@final
class Stage:
    """One cell, or one line, with its controller, after its practice.

    Args:
        controller: as `--controller` takes it.
        env: as `--env` takes it; None for the environment of the controller's training, or the default.
        level: as `--level` takes it; None for the level of the controller's training, or the default.
        seed: seed of the objects.
        trust: load policies that run code.
        throws: how throws are computed, where levels leave the choice; None for the level's own setting.
        release: controller that corrects the throws of a line; None for no correction.

    Raises:
        UsageError: `throws` is given where levels leave no choice, or there is no such controller.
    """

    def __init__(
        self,
        controller: str,
        env: str | None,
        level: str | LevelConfig | None,
        seed: int,
        *,
        trust: bool = False,
        throws: str | None = None,
        release: str | None = None,
    ) -> None:
        env_id, level, mode = trained.resolve(controller, env, level, None)
        self._trial = open_trial(env_id, level, 1, 1, mode, throws)
        try:
            self.core = self._trial.core
            self._trial.correct_throws(release)
            actor = self._trial.controller(controller, trust=trust)
            if not hasattr(self.core, "view"):
                core = type(self.core).__name__
                raise UsageError(f"environment {env_id!r} has no pictures: its core, a {core}, has no method `view`")
            actor.reset(seed)
            actor = self._trial.practise(actor, self._trial.practice(actor), seed)
            self.view: Any = self.core.view()
            self._shown: Any = self.view
            self.seen: SeenController | None = None
            if isinstance(self.core, GraspCore):
                actor = self.seen = SeenController(actor, self.core)
                self._shown = SeenView(self.view, self.seen)
        except BaseException:
            self._trial.close()
            raise
        self._actor, self._seed = actor, seed
        self.steps: Iterator[Any] = self._trial.steps(actor, seed)

    def begin(self, watch: Callable[[Controller], Controller]) -> None:
        """Begin the steps anew, with the controller inside another one that watches the controller."""
        self.steps = self._trial.steps(watch(self._actor), self._seed)

    def film(self, file: Path, picks: int | None = None, slow: int = 1, log: Path | None = None) -> None:
        """Film a number of throws or decisions.

        Args:
            file: file of the video.
            picks: number of throws or decisions; None for the default of the kind of trial.
            slow: factor by which the video is slower than real time.
            log: file of a log of the filmed throws; None for no log.

        Raises:
            UsageError: a log is asked for, and the throws of the environment have none.
        """
        recorder = None if log is None else Recorder(self.core)
        if recorder is not None:
            self.begin(recorder.watch)
            self.steps = recorder.keep(self.steps)
        steps = self._trial.film_steps(self.steps, picks)
        deliver(file, lambda path: record_video(self._shown, steps, path, slow=slow))
        if recorder is not None and log is not None:
            deliver_text(log, recorder.text(self._seed))

    def advance(self, moment: float) -> None:
        """Carry out steps until a picture at a moment [s] can be drawn."""
        self._trial.advance(self.steps, moment)

    def draw(self, file: Path, moment: float) -> None:
        """Draw the last throw, or the line, at a moment [s], or at its end if the moment is later."""
        self.advance(moment)
        if isinstance(self.view, ThrowView | LineView):  # a user's own view draws as it likes
            self.view.aim(Picture(), SAMPLES)
        deliver(file, lambda path: self._write(path, moment))

    def _write(self, path: Path, moment: float) -> None:
        from PIL import Image  # noqa: PLC0415 - only pictures need it

        # Of a format with losses; PNG knows no quality.
        Image.fromarray(self._shown.at(moment, RATE)).save(path, quality=90)

    def close(self) -> None:
        """Close the view and the environment; safe to call twice."""
        self.view.close()
        self._trial.close()


def film(file: Path, *stage: Any, **options: Any) -> None:
    """Film the first steps of a new stage, whose arguments are those of `Stage`."""
    with closing(Stage(*stage, **options)) as new:
        new.film(file)
