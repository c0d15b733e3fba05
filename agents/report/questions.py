"""The questions that the results answer, in the order in which a reviewer asks: title, picture, answer, chapters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple, final

from ..ground.drawings import Figure
from ..ground.files import check_form
from . import answers, pays, pictures
from .contents import read_results

Results = Mapping[str, Any]
"""Contents of files of results by name, without ".json"."""


@final
class Question(NamedTuple):
    """A question that one page of results answers.

    Attributes:
        name: of the page, `NAME.md`.
        title: the question itself.
        picture: file of the drawing that the page begins with.
        answer: one or two sentences with the numbers, from the contents of `sources`.
        sources: files of results that the answer needs, without ".json".
        command: what makes them.
        chapters: titles of the files whose tables belong to the question, by name; papers are titled by themselves.
        draw: draws the picture from the contents of `sources`; None where a chapter's figures have it.
    """

    name: str
    title: str
    picture: str
    answer: Callable[[Results], str]
    sources: Sequence[str]
    command: str
    chapters: Mapping[str, str]
    draw: Callable[[Results], Figure] | None = None

    def read(self, folder: Path) -> Results | None:
        """The contents of the sources in a folder of results; None where one of them is missing.

        Raises:
            UsageError: a file is no valid JSON.
        """
        files = {name: folder / f"{name}.json" for name in self.sources}
        if not all(path.is_file() for path in files.values()):
            return None
        return {name: read_results(path) for name, path in files.items()}

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
                return self.answer(results)
            except answers.NoAnswer:
                return None


QUESTIONS: Final = (
    Question(
        name="learning",
        title="Does learning pay, and how many throws does it take?",
        picture="sorted_per_min.svg",
        answer=answers.learning,
        sources=("benchmark",),
        command="make bench",
        chapters={
            "benchmark": "Every controller on every level",
            "processors": "The same throws on another processor",
            "precise": "A level that separates good controllers",
            "benchmark_precise": "Every controller on `precise`",
            "benchmark_peers": "Cells of other papers",
            "benchmark_goal": "The virtual goal and its gain K",
            "training": "Learning from flights",
            "offline": "Learning from given throws",
            "oracle": "What the oracle leaves",
            "sequential": "How many throws a comparison takes",
            "submissions": "What others have handed in",
        },
    ),
    Question(
        name="curves",
        title="How many throws does each learner need?",
        picture="curves.svg",
        answer=pays.curves_answer,
        sources=("curves",),
        command="make studies STUDIES=curves",
        chapters={"curves": "Every learner after 1 to 10,000 throws"},
    ),
    Question(
        name="mismatch",
        title="Where does learning begin to pay?",
        picture="mismatch.svg",
        answer=pays.mismatch_answer,
        sources=("mismatch",),
        command="make studies STUDIES=mismatch",
        chapters={"mismatch": "Gains over the mismatch"},
    ),
    Question(
        name="drift",
        title="What does drift cost, and what does adapting win back?",
        picture="benchmark_adapt_over_the_shift.svg",
        answer=answers.drift,
        sources=("benchmark_adapt",),
        command="python -m agents.benchmark --config configs/benchmark_adapt.yaml",
        chapters={
            "benchmark_adapt": "Every controller under every drift",
            "adaptation": "Cameras and new kinds of items",
            "fit": "What 40 landings tell of a cell",
            "fit_full": "The same of throws in full physics",
            "fit_use": "What a fitted level is worth",
        },
    ),
    Question(
        name="order",
        title="What is the order of picks worth?",
        picture="benchmark_line_value.svg",
        answer=answers.order,
        sources=("benchmark_line",),
        command="python -m agents.benchmark --config configs/benchmark_line.yaml",
        chapters={
            "benchmark_line": "Every controller on every line",
            "line": "Throws by table and simulated throws",
            "dispatch": "Rules at one robot",
        },
    ),
    Question(
        name="grasp",
        title="What is the place of the cup worth?",
        picture="grasp.svg",
        answer=answers.grasp,
        sources=("benchmark_grasp",),
        command="python -m agents.benchmark --config configs/benchmark_grasp.yaml",
        chapters={
            "benchmark_grasp": "Every rule, network and pace",
            "grasp_choices": "Tries, objects, stages and cups",
            "grasping": "Places without throws",
            "grasp_targets": "Seen and unseen kinds, near and far bins",
            "grasp_error": "What makes objects land off their targets",
        },
        draw=pictures.grasp,
    ),
    Question(
        name="losses",
        title="What does an honest cell lose, and where?",
        picture="losses.svg",
        answer=answers.losses,
        sources=("benchmark",),
        command="make bench",
        chapters={"physics": "Levels and mismatch, without learning"},
        draw=pictures.losses,
    ),
    Question(
        name="sorter",
        title="What do failed picks, wrong classes and full bins cost?",
        picture="sorter.svg",
        answer=answers.sorter,
        sources=("judged",),
        command="make studies STUDIES=judged",
        chapters={"judged": "Every effect in two cells", "neighbours": "Neighbours on the belt"},
        draw=pictures.sorter,
    ),
    Question(
        name="cup",
        title="What does the cup lose, and what does care cost?",
        picture="cup.svg",
        answer=answers.cup,
        sources=("grip",),
        command="make studies STUDIES=grip",
        chapters={"grip": "What the cup holds", "cup": "A soft cup"},
        draw=pictures.cup,
    ),
    Question(
        name="methods",
        title="Throw or place: which way to the bin is the best?",
        picture="methods.svg",
        answer=answers.methods,
        sources=("methods",),
        command="make studies STUDIES=methods",
        chapters={
            "methods": "Every method at every speed",
            "throwable": "Objects that air carries away",
        },
    ),
    Question(
        name="flight",
        title="How far is flight from full physics?",
        picture="flight.svg",
        answer=answers.flight,
        sources=("fidelity", "margins"),
        command='make studies STUDIES="fidelity margins"',
        chapters={
            "fidelity": "Level by level",
            "margins": "Flights judged before they come to rest",
        },
        draw=pictures.flight,
    ),
    Question(
        name="speed",
        title="How fast is it?",
        picture="speed.svg",
        answer=answers.speed,
        sources=("perf_envs", "perf_planner", "perf_shares", "perf_training", "perf_before"),
        command="make perf",
        chapters={
            "perf_envs": "Environments",
            "perf_planner": "The planner",
            "perf_shares": "Where the time of a step goes",
            "perf_training": "Where the time of a training goes",
            "perf_before": "A training beside that of older code",
        },
        draw=pictures.speed,
    ),
    Question(
        name="papers",
        title="What of the papers holds?",
        picture="verdicts.svg",
        answer=answers.papers,
        sources=("reproduction",),
        command="make reproduce",
        chapters={
            "reproduction": "",
        },
        draw=pictures.verdicts,
    ),
)
