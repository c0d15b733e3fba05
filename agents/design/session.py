"""A session of designing: the design, what was undone, the newest answer, and what is worth trying; no browser."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import isfinite
from typing import Any, Final, final

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import PntGymError

from ..ground.cli import EXTRAS, UsageError, describe_error
from ..ground.metrics import Interval
from ..ground.tables import percent
from ..line import reasons
from ..line.changes import Gain, gain, possible_changes
from ..line.layouts import What
from ..line.places import Improvement, Progress, improve
from .answers import DURATION, SEARCH, Answer, Judge, difference
from .changes import Change
from .worker import Worker

LONGEST: Final = 200
"""Designs that can be undone."""
TRIES: Final = 60
"""Layouts that a search of places tries."""


@final
@dataclass(frozen=True)
class Tried:
    """A change that was tried on a design."""

    line: LineConfig
    """The design with the change."""
    gain: Gain
    """What the change brings."""


@final
@dataclass(frozen=True)
class State:
    """What a page shows; a value, so that threads may read it at any time."""

    line: LineConfig
    """The design."""
    saved: LineConfig
    """The design with which others are compared."""
    number: int = 0
    """Number of the design, which grows with each change."""
    answer: Answer | None = None
    """The newest answer, which may be of an earlier design."""
    answered: int = -1
    """Number of the design that the answer is of."""
    saved_answer: Answer | None = None
    """The settled answer to the saved design."""
    refusal: str = ""
    """Why the last change was refused; empty where it was not."""
    note: str = ""
    """What the last search found."""
    tried: tuple[Tried, ...] = ()
    """Changes of the answered design that were tried, the best first."""
    doing: str = ""
    """What is being computed."""
    undone: tuple[LineConfig, ...] = field(default=(), repr=False)
    done: tuple[LineConfig, ...] = field(default=(), repr=False)

    @property
    def is_current(self) -> bool:
        """Whether the answer is of the design."""
        return self.answered == self.number

    @property
    def offers(self) -> list[Tried]:
        """Changes in the hands of a designer that bring something for sure."""
        return [each for each in self.tried if each.gain.points.low > 0.0 and is_same_task(self.line, each.line)]

    @property
    def causes(self) -> str:
        """What keeps the design from sorting more; empty before the answer is settled."""
        return self._reason(())

    @property
    def reason(self) -> str:
        """What keeps the design from sorting more, and what changes bring; empty before the answer is settled."""
        return self._reason([each.gain for each in self.tried])

    def _reason(self, gains: Sequence[Gain]) -> str:
        if self.answer is None or not (self.is_current and self.answer.is_settled):
            return ""
        return reasons.reason(self.answer.plan, gains).removeprefix("the reason: ")

    @property
    def over_saved(self) -> Interval | None:
        """What the design brings over the saved one; None while an answer is missing, or for the saved design."""
        if self.answer is None or self.saved_answer is None or not self.is_current or self.line == self.saved:
            return None
        return difference(self.answer, self.saved_answer) if self.answer.is_settled else None


def is_same_task(line: LineConfig, other: LineConfig) -> bool:
    """Whether two lines get the same objects, and neither has parts that fail less than the other's."""
    tasks = [
        (each.arrivals, each.down, each.cell.pick, each.cell.classifier, each.cell.bins.emptied)
        for each in (line, other)
    ]
    return tasks[0] == tasks[1]


def opened(line: LineConfig) -> LineConfig:
    """A line as a design: judged by shifts of two minutes and by tables of its own."""
    return LineConfig.load(line, throws="table", chances=None, duration=DURATION)


@final
class Session:
    """A design that changes, and a thread that judges the newest design.

    Args:
        line: the first design.
        tell: called, in any thread, with each new state.
    """

    def __init__(self, line: LineConfig, tell: Callable[[State], object] = lambda state: None) -> None:
        line = opened(line)
        self._lock = threading.RLock()
        self._state = State(line, line)
        self._tell = tell
        self._judge, self._ends_search = Judge(), threading.Event()
        self.worker = Worker()
        self.worker.ask(self._answer)

    @property
    def state(self) -> State:
        """The state now."""
        return self._state

    def close(self) -> None:
        """End the thread; safe to call twice."""
        self.worker.close()

    # Changes of the design.

    def change(self, change: Change) -> bool:
        """Change the design; whether it was possible. A design that is refused leaves the design before."""
        with self._lock:
            before = self._state.line
            try:
                line = change(before)
            except PntGymError as error:
                return self.refuse(error)
            if line == before:
                self._set(refusal="")
                return True
            self._go(line, done=(*self._state.done, before)[-LONGEST:], undone=())
        return True

    def begin(self, read: Callable[[], LineConfig]) -> bool:
        """Begin with another line, which is also the one to compare with; whether it could be read."""
        with self._lock:
            before = self._state.line
            try:
                line = opened(read())
            except PntGymError as error:
                return self.refuse(error)
            self._go(line, saved=line, saved_answer=None, done=(*self._state.done, before)[-LONGEST:], undone=())
        return True

    def undo(self) -> None:
        """Go back to the design before, if there is one."""
        with self._lock:
            if self._state.done:
                *done, line = self._state.done
                self._go(line, done=tuple(done), undone=(*self._state.undone, self._state.line))

    def redo(self) -> None:
        """Go forward to the design that was undone last, if there is one."""
        with self._lock:
            if self._state.undone:
                *undone, line = self._state.undone
                self._go(line, undone=tuple(undone), done=(*self._state.done, self._state.line))

    def keep(self) -> None:
        """Compare with the present design from now on."""
        with self._lock:
            answer = self._state.answer
            is_settled = answer is not None and answer.is_settled and self._state.is_current
            self._set(saved=self._state.line, saved_answer=answer if is_settled else None)
            self.worker.ask(self._answer)

    def improve(self, what: What) -> None:
        """Search for better places of bins, robots or both; the design changes if the full physics agrees."""
        self._ends_search.clear()
        self.worker.ask(partial(self._improve, what))

    def end_search(self) -> None:
        """End a search with what it has found so far."""
        self._ends_search.set()

    def refuse(self, error: PntGymError) -> bool:
        """Tell why something was not done; False."""
        sentence = describe_error(error).replace("\n", " ")
        self._set(refusal=sentence.removeprefix(f"config {self._state.line.name!r}: "))
        return False

    def _go(self, line: LineConfig, **values: Any) -> None:
        self._set(line=line, number=self._state.number + 1, refusal="", note="", tried=(), **values)
        self.worker.ask(self._answer)

    def _set(self, **values: Any) -> None:
        """Replace some values of the state, and tell the new state."""
        with self._lock:
            self._state = replace(self._state, **values)
        self._tell(self._state)

    # Answers.

    def _answer(self, is_stale: Callable[[], bool]) -> None:
        """Judge the newest design: at once, then so that it holds; then the saved design, and what is worth trying."""
        number, line = self._state.number, self._state.line
        try:
            for is_settled in (False, True):
                if is_stale():
                    return
                self._set(doing="settling the figures" if is_settled else "judging")
                answer = self._judge.answer(line, is_settled)
                if number != self._state.number:
                    return
                self._set(answer=answer, answered=number)
            self._judge_saved(is_stale)
            self._try_changes(number, is_stale)
        except PntGymError as error:
            self.refuse(error)
        finally:
            self._set(doing="")

    def _judge_saved(self, is_stale: Callable[[], bool]) -> None:
        """Judge the saved design, unless it is judged already."""
        if self._state.saved_answer is None and not is_stale():
            saved, answer = self._state.saved, self._state.answer
            is_same = answer is not None and answer.is_settled and saved == self._state.line
            found = answer if is_same else self._judge.answer(saved, True)
            with self._lock:
                if self._state.saved == saved:
                    self._set(saved_answer=found)

    def _try_changes(self, number: int, is_stale: Callable[[], bool]) -> None:
        """Try, one by one, what may mend the design, and keep what each change brings."""
        answer = self._state.answer
        if answer is None:
            return
        for change in possible_changes(answer.line, reasons.worst_item(answer.plan)):
            if is_stale() or number != self._state.number:
                return
            self._set(doing=f"trying {change.what} {change.to}".rstrip())
            try:
                judged = self._judge.answer(change.config, True)
            except PntGymError:
                continue  # no line that could be judged
            tried = Tried(change.config, gain(change, judged.plan, answer.plan))
            with self._lock:
                if number == self._state.number:
                    best = sorted((*self._state.tried, tried), key=lambda each: -each.gain.points.value)
                    self._set(tried=tuple(best))

    def _improve(self, what: What, is_stale: Callable[[], bool]) -> None:
        """Search for better places, until the design changes."""
        number = self._state.number

        def tell(progress: Progress) -> None:
            if is_stale() or number != self._state.number:
                raise _StaleError
            best = f"best so far {percent(progress.best)}" if isfinite(progress.best) else "none so far"
            self._set(doing=f"{progress.stage}: {progress.tried} of {progress.tries} layouts, {best}")

        try:
            found = improve(
                self._state.line, SEARCH, what, tries=TRIES, tell=tell, should_stop=self._ends_search.is_set
            )
            with self._lock:
                if number == self._state.number:
                    self._take(found)
        except _StaleError:
            pass  # the newer design is judged next
        except ModuleNotFoundError as error:
            self.refuse(UsageError(f"a search needs {error.name}: pip install 'pnt_gym[{EXTRAS[str(error.name)]}]'"))
        except PntGymError as error:
            self.refuse(error)
        finally:
            self._set(doing="")

    def _take(self, found: Improvement) -> None:
        """Take the places that a search found, if they are better beyond doubt."""
        before = self._state.line
        if found.gain.excludes_zero and found.gain.value > 0.0:
            self._go(opened(found.config), done=(*self._state.done, before)[-LONGEST:], undone=())
        self._set(note=found.sentence)


class _StaleError(Exception):
    """The design has changed, and nobody waits for the search any more."""
