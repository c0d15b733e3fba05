"""A study: cases of a plan as jobs, each of which a measuring function of benchmarks/studies does, and their file."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, Final, cast, final

import pnt_gym
from pnt_gym.constants import WORLD

from ..ground.cli import UsageError, about, check_known
from ..ground.cluster import Needs
from ..ground.files import json_text, read_json
from ..ground.outputs import check_writable, deliver_json
from ..ground.places import SHIPPED
from ..ground.tables import console
from ..ground.versions import code_digest
from ..ground.work import Job, key
from ..results import study
from ..results.study import Amount, Case, Figures, Settings, StudyPlan

MEASURES: Final = "benchmarks.studies"
"""Package of the measuring functions; an installed package is without it."""
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
MOST_NAMED: Final = 80
"""Characters of a case in the name of a job's file."""


@final
class Study:
    """Every case of a plan, each measured by the function that its part names.

    Args:
        plan: the plan.
        out: file of the rows.
        parts: names of the parts that are measured, while rows of others are kept; empty for all parts.
        data: folder of measured data; None for a study that needs none.
        is_missing: whether only cases are measured of which the file has no row.

    Attributes:
        jobs: the cases that are measured.
        unit: unit of the costs of the jobs.
    """

    unit = "cases"

    def __init__(
        self,
        plan: StudyPlan,
        out: Path,
        parts: Collection[str],
        data: Path | None = None,
        *,
        is_missing: bool = False,
    ) -> None:
        check_writable(out)
        with about("--only"):
            cases = plan.cases(*parts)
        self._plan, self._out = plan, out
        self._head = {"study": plan.study, "version": pnt_gym.__version__, "world": WORLD}
        self._head |= {"seed": plan.seed, "throws": plan.throws}
        option = "--missing" if is_missing else "--only" if parts else ""
        self._kept = self._keep_rows(out, cases, option) if out.is_file() else []
        if is_missing:
            cases = [case for case in cases if not case.rows_of(self._kept)]
        for measure in {case.measure for case in cases}:
            measurement(measure)
        code = code_digest(CODE)
        self.jobs: list[Job] = []
        for case in _with_data(cases, data) if plan.needs_data else cases:
            name = re.sub(r"[^\w.]+", "-", "-".join(str(label) for label in case.labels.values()))[:MOST_NAMED]
            self.jobs.append(Job(name, key(case=case, code=code), partial(_measure, case)))

    def needs(self) -> Needs:
        """Requirements of the jobs on another machine; which of them train networks, the plan does not say."""
        return Needs(torch=True)

    def write(self, files: Sequence[Path]) -> None:
        """Write the rows in the files of the jobs and those that are kept, in the plan's order; print the new rows."""
        new: list[Figures] = [row for file in files for row in read_json(file)["rows"]]
        rows = [row for case in self._plan.cases() for row in case.rows_of(new) or case.rows_of(self._kept)]
        deliver_json(self._out, {**self._head, "rows": rows})
        for row in new:
            console().print(_line(row), markup=False, soft_wrap=True)

    def _keep_rows(self, out: Path, chosen: Sequence[Case], option: str) -> list[Figures]:
        """Rows of an earlier file of the study that stay; none where every case is measured.

        Args:
            out: the file.
            chosen: cases whose rows the file may lack, where there is an option.
            option: option by which rows stay; empty where every case is measured.

        Raises:
            UsageError: the file is of something else, or has no row of a case that is not measured.
        """
        data = read_json(out)
        study.check(out, data)
        is_same = {**self._head, "rows": data["rows"]} == data
        if option and not is_same:
            raise UsageError(
                f"{str(out)!r} is of another study, version, world, seed or number of throws; drop {option}"
            )
        cases = self._plan.cases()
        measured = chosen if option else []
        lacked = [case for case in cases if case not in measured and not case.rows_of(data["rows"])]
        if is_same and lacked:
            raise UsageError(
                f"{str(out)!r} lacks {len(lacked)} of the {len(cases)} cases of its study, the first of which is "
                f"{lacked[0]}; give --missing to measure these alone, without --only, or move the file away"
            )
        return data["rows"] if option else []


def _with_data(cases: Sequence[Case], folder: Path | None) -> list[Case]:
    """Cases whose settings name the folder of measured data, absolute, and what stands in the folder.

    Raises:
        UsageError: there is no such folder.
    """
    if folder is None or not folder.is_dir():
        given = "missing" if folder is None else repr(str(folder))
        raise UsageError(
            f"the study compares with measured data, and --data is {given}; give the folder of the data, "
            "docs/reality.md says where they come from"
        )
    contents = {file.name: key(content=file.read_bytes().hex()) for file in sorted(folder.glob("*.npz"))}
    data = {"data": str(folder.resolve()), "contents": contents}
    return [case._replace(settings={**case.settings, **data}) for case in cases]


def _measure(case: Case, _folder: Path) -> dict[str, list[Figures]]:
    """The rows of a case: one, or those of several controllers that were measured together.

    Raises:
        UsageError: a figure is no number, as the mean of no throws is.
    """
    with about(str(case)):
        figures = measurement(case.measure)(case.settings, case.amount)
        several = cast("Iterable[Figures]", [figures] if isinstance(figures, dict) else figures)
        rows = [{**case.labels, **row} for row in several]
        try:
            json_text(rows)
        except ValueError:
            raise UsageError("a figure is not a number; more throws are needed") from None
    return {"rows": rows}


def measurement(measure: str) -> Callable[[Settings, Amount], Figures | Iterable[Figures]]:
    """The measuring function of a name MODULE.FUNCTION.

    Raises:
        UsageError: there is none.
    """
    module, _, name = measure.partition(".")
    known = sorted(path.stem for path in (SHIPPED / MEASURES.replace(".", "/")).glob("*.py"))
    if not known:
        raise UsageError("studies are measured in a checkout: the installed package is without benchmarks/studies")
    with about("measure"):
        check_known("module of benchmarks/studies", [module], known)
    if str(SHIPPED) not in sys.path:
        sys.path.insert(0, str(SHIPPED))
    try:
        function = getattr(import_module(f"{MEASURES}.{module}"), name, None)
    except ImportError as error:
        raise UsageError(f"measure is {measure!r}, which needs more than is installed: {error}") from None
    if function is None:
        raise UsageError(f"measure is {measure!r}; {module} has no function {name}")
    return cast("Any", function)


def _line(row: Figures) -> str:
    """One line for people: labels, then numbers."""
    middles = ((name, value.get("value") if isinstance(value, Mapping) else value) for name, value in row.items())
    shown = ((name, value) for name, value in middles if value is not None and not isinstance(value, list))
    return "  ".join(f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}" for name, value in shown)
