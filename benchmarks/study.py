"""Measure a study: `python benchmarks/study.py grip --json results/grip.json`.

A plan says which cases are measured and by what; plans that ship stand in configs/studies. The file is written after
each case. Each row has a digest of its case, the versions and the code; a case with a row of the same digest in the
file is not measured again.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Final, cast

import tyro

import pnt_gym
from agents.ground.cli import UsageError, at_least, check_known, option, run
from agents.ground.files import json_text, read_json, write_json
from agents.ground.outputs import check_writable
from agents.ground.versions import versions
from agents.jobs.code import code_digest
from agents.report.study_plan import Case, Part, StudyPlan, read_study, shipped_study
from agents.results.study import check_study, is_study
from benchmarks.studies.cells import Amount, Figures
from pnt_gym.names import unknown_name

ROOMS: Final = ("judging", "controllers", "dispatchers", "grasping", "learning", "training", "fit")
"""Rooms of agents on which figures depend."""
CODE: Final = (
    "pnt_gym/**/*.py",
    *(f"agents/{room}/**/*.py" for room in ROOMS),
    "benchmarks/studies/*.py",
    "configs/cells/**/*.yaml",
    "results/policies/**/*.npz",
)
"""What figures depend on beside the plan and the versions."""
DIGEST: Final = "digest"
"""Key of a row's digest."""
LENGTH: Final = 16
"""Digits of a digest: 64 bits."""


@dataclass(frozen=True)
class Arguments:
    """Measure the cases of a study, print their figures and write them."""

    plan: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="PLAN")]
    """Name of a study that ships, or a YAML file."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write the figures to this file, and go on with those that it holds."""
    throws: Annotated[int | None, option("the plan's", "INT")] = None
    """Throws of each case, or work shifts."""
    seed: Annotated[int | None, option("the plan's", "INT")] = None
    """Seed of the thrown objects."""
    parts: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, option("all", "PART"), tyro.conf.arg(name="part")] = ()
    """Measure this part of the plan alone; may be given several times."""
    threads: int = 2
    """Threads of the simulation; results do not depend on this number."""
    share: Annotated[str, option("1/1", "K/N")] = "1/1"
    """Measure only the K-th of every N cases, so that N processes or machines share a study."""
    join: Annotated[tuple[Path, ...], option("none", "FILE ...")] = ()
    """Begin with what these files hold of the same study; their rows stay, whatever their code: each has its digest."""


def main(arguments: Arguments) -> None:
    """Measure what the file does not hold yet."""
    at_least(vars(arguments), throws=1, seed=0, threads=1)
    check_writable(arguments.json)
    plan = read_study(Path(arguments.plan)) if arguments.plan.endswith(".yaml") else shipped_study(arguments.plan)
    throws = plan.throws if arguments.throws is None else arguments.throws
    seed = plan.seed if arguments.seed is None else arguments.seed
    first, count = read_share(arguments.share)
    cases = chosen_cases(plan, arguments.parts)[first - 1 :: count]
    result = load_progress(arguments.json, head(plan, throws, seed))
    joined = joined_rows(plan, result, arguments.join)
    result["rows"] = in_order(plan, joined, result["rows"])
    if arguments.join and arguments.json is not None:
        write_json(arguments.json, result)
    basis = [versions(), code_digest(CODE)]
    for part, case in cases:
        digest = hashlib.sha256(json_text([case, part.measure, basis]).encode()).hexdigest()[:LENGTH]
        if is_held(case, result["rows"], digest) or is_held(case, joined):
            continue
        amount = Amount(part.count(throws), seed, arguments.threads)
        figures = as_rows(measurement(part)(case.settings, amount))
        rows = [{**case.labels, **row, DIGEST: digest} for row in figures]
        check_numbers(case, rows)
        print("\n".join(map(line, rows)), flush=True)
        result["rows"] = in_order(plan, rows, result["rows"])
        if arguments.json is not None:
            write_json(arguments.json, result)


def chosen_cases(plan: StudyPlan, names: Iterable[str]) -> list[tuple[Part, Case]]:
    """Cases of the parts of these names, or of all parts without a name.

    Raises:
        UsageError: the study has no such part.
    """
    check_known("part", names, plan.parts)
    parts = {name: part for name, part in plan.parts.items() if not names or name in names}
    return [(part, case) for name, part in parts.items() for case in plan.cases(name)]


def read_share(text: str) -> tuple[int, int]:
    """K and N of a share K/N.

    Raises:
        UsageError: the text is no such share.
    """
    first, slash, count = text.partition("/")
    if not (slash and first.isdecimal() and count.isdecimal() and 1 <= int(first) <= int(count)):
        raise UsageError(f"--share is {text!r}; it must be K/N with K from 1 to N, for instance 2/16")
    return int(first), int(count)


def joined_rows(plan: StudyPlan, result: dict[str, Any], files: Iterable[Path]) -> list[Figures]:
    """Rows of other files of the same study, of each case those of the first file that has some.

    Raises:
        UsageError: a file is of another study, or of other amounts.
    """
    rows: list[Figures] = []
    for file in files:
        data = read_json(file)
        check_study(file, data)
        if {**result, "rows": data.get("rows")} != data:
            raise UsageError(f"--join: {str(file)!r} is of another study, or of other amounts")
        rows = in_order(plan, rows, data["rows"])
    return rows


def in_order(plan: StudyPlan, first: list[Figures], second: list[Figures]) -> list[Figures]:
    """Rows in the order of the plan's cases; the second rows of those cases alone of which there are no first ones."""
    cases = [case for name in plan.parts for case in plan.cases(name)]
    return [row for case in cases for row in (first if is_held(case, first) else second) if is_of(case, row)]


def head(plan: StudyPlan, throws: int, seed: int) -> dict[str, Any]:
    """What the rows have in common, as the file of a study begins."""
    return {"study": plan.study, "version": pnt_gym.__version__, "seed": seed, "throws": throws}


def load_progress(path: Path | None, fresh: dict[str, Any]) -> dict[str, Any]:
    """What the file holds of the same study and amounts, or nothing yet."""
    data = read_json(path) if path is not None and path.exists() else {}
    if path is None or not is_study(data):
        return {**fresh, "rows": []}
    check_study(path, data)
    return data if {**fresh, "rows": data["rows"]} == data else {**fresh, "rows": []}


def measurement(part: Part) -> Callable[[dict[str, Any], Amount], Figures | Iterable[Figures]]:
    """The function that measures the cases of a part.

    Raises:
        UsageError: there is none.
    """
    module, _, name = part.measure.partition(".")
    folder = Path(__file__).with_name("studies")
    if not (folder / f"{module}.py").is_file():
        modules = sorted(path.stem for path in folder.glob("*.py"))
        raise UsageError(f"measure: {unknown_name('module of benchmarks/studies', module, modules)}")
    function = getattr(import_module(f"benchmarks.studies.{module}"), name, None)
    if function is None:
        raise UsageError(f"measure is {part.measure!r}; {module} has no function {name}")
    return function


def is_of(case: Case, row: Figures) -> bool:
    """Whether a row is of a case."""
    return case.labels.items() <= row.items()


def is_held(case: Case, rows: Iterable[Figures], digest: str | None = None) -> bool:
    """Whether rows of a case are there, with a digest or with any."""
    return any(is_of(case, row) and digest in (None, row.get(DIGEST)) for row in rows)


def as_rows(figures: Figures | Iterable[Figures]) -> list[Figures]:
    """The rows of a case: one, or those of several controllers that were measured together."""
    return [cast("Figures", figures)] if isinstance(figures, dict) else [*figures]


def check_numbers(case: Case, rows: list[Figures]) -> None:
    """Make sure that every figure is a number.

    Raises:
        UsageError: one is none, as the mean of no throws is.
    """
    try:
        json_text(rows)
    except ValueError:
        labels = ", ".join(f"{name} {label}" for name, label in case.labels.items())
        raise UsageError(f"{labels}: a figure is not a number; more --throws are needed") from None


def line(row: Figures) -> str:
    """One line for people: labels, then numbers."""
    texts = {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in row.items()}
    return "  ".join(
        f"{name} {value['value']:.4g}" if isinstance(value, dict) and "value" in value else f"{name} {value}"
        for name, value in texts.items()
        if name != DIGEST and (not isinstance(value, dict | list) or "value" in value)
    )


if __name__ == "__main__":
    run(main, Arguments, "python benchmarks/study.py", sys.argv[1:])
