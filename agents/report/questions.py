"""The questions that the results answer, in the order in which a reviewer asks: title, picture, answer, chapters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple, final

from pnt_gym.constants import WORLD

from ..ground.drawings import Figure
from ..ground.files import check_form, read_yaml
from ..ground.versions import world_of
from . import answers, contents, pays, pictures, templates
from .openings import OPENINGS, Opening
from .templates import NoFigure

Results = Mapping[str, Any]
"""Contents of files of results by name, without ".json"."""
VALUES: Final[Mapping[str, Callable[[Results], Mapping[str, Any]]]] = {
    "learning": answers.learning,
    "curves": pays.curves_values,
    "mismatch": pays.mismatch_values,
    "drift": answers.drift,
    "order": answers.order,
    "grasp": answers.grasp,
    "losses": answers.losses,
    "reality": answers.reality,
    "cells": answers.cells,
    "sorter": answers.sorter,
    "cup": answers.cup,
    "methods": answers.methods,
    "flight": answers.flight,
    "speed": answers.speed,
    "papers": answers.papers,
}
"""By the name of a question, the function that computes the values of its answer."""
DRAWINGS: Final[Mapping[str, Callable[[Results], Figure]]] = {
    "drift": pictures.drift,
    "grasp": pictures.grasp,
    "losses": pictures.losses,
    "reality": pictures.reality,
    "cells": pictures.cells,
    "sorter": pictures.sorter,
    "cup": pictures.cup,
    "flight": pictures.flight,
    "speed": pictures.speed,
    "papers": pictures.verdicts,
}
"""By the name of a question, the function that draws its picture, where no chapter's figures have the picture."""


@final
class Question(NamedTuple):
    """A question that one page of results answers.

    Attributes:
        name: of the page, `NAME.md`.
        title: the question itself.
        answer: template of the sentences with the numbers.
        picture: file of the drawing that the page begins with.
        sources: files of results that the answer needs, without ".json".
        command: what makes them.
        chapters: titles of the files whose tables belong to the question, by name; papers are titled by themselves.
    """

    name: str
    title: str
    answer: str
    picture: str
    sources: Sequence[str]
    command: str
    chapters: Mapping[str, str]

    def read(self, folder: Path) -> Results | None:
        """The contents of the sources in a folder of results; None where one of them is missing.

        Raises:
            UsageError: a file is no valid JSON.
        """
        files = {name: folder / f"{name}.json" for name in self.sources}
        if not all(path.is_file() for path in files.values()):
            return None
        return {name: contents.read(path) for name, path in files.items()}

    def older(self, folder: Path) -> str:
        """Sentence on sources of an older world in a folder of results; empty for other sources, and without them."""
        results = self.read(folder) or {}
        return contents.older(min(map(world_of, results.values()), default=WORLD))

    def answered(self, folder: Path) -> str | None:
        """The answer from the results in a folder; None where a source is missing, or of another plan."""
        results = self.read(folder)
        return None if results is None else self.answer_from(results, folder)

    def answer_from(self, results: Results, folder: Path) -> str | None:
        """The answer from contents that were read from a folder; None where they are of another plan.

        Raises:
            UsageError: the contents have another form.
        """
        with check_form(folder / f"{self.sources[0]}.json"):
            try:
                return templates.fill(self.answer, self._values(results))
            except NoFigure:
                return None

    def opening(self, folder: Path) -> Opening | None:
        """What the question's page opens with; None where a source is missing, or of another plan."""
        results = self.read(folder)
        if results is None:
            return None
        with check_form(folder / f"{self.sources[0]}.json"):
            try:
                return OPENINGS[self.name].filled(self._values(results))
            except NoFigure:
                return None

    def _values(self, results: Results) -> Mapping[str, Any]:
        return {**answers.WORDS, **VALUES[self.name](results)}


def _read() -> tuple[Question, ...]:
    entries = read_yaml(Path(__file__).with_name("questions.yaml"), "questions")
    return tuple(Question(name, **entry) for name, entry in entries.items())


QUESTIONS: Final = _read()
