"""A comparison of controllers: pieces of a plan as jobs, rows of an earlier file that stay, the file and its tables."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, final

from ..ground.cli import UsageError, about, check_known
from ..ground.cluster import Needs
from ..ground.outputs import deliver_json
from ..ground.tables import console
from ..ground.versions import versions
from ..ground.work import JobValues
from ..judging.record import Result
from ..results.compare import assemble
from ..results.content import check_figures, read_form
from ..results.entries import labels_of
from ..results.plan import Piece, Plan, needs, pieces, trial_of_plan
from .run import jobs
from .stored import POLICIES, stored_policies

_BY_ROW = {"entries", "learned", "references", "floors"}
"""Keys of a plan on which the rows of other entries do not depend."""


@final
class Comparison:
    """Every controller of a plan on the same objects, compared throw by throw or shift by shift.

    Attributes:
        jobs: pieces of the entries that are computed.
        unit: unit of the costs of the jobs.
    """

    def __init__(self, plan: Plan, out: Path, labels: Collection[str]) -> None:
        self._plan = plan
        self.jobs = jobs(choose_pieces(pieces(plan), labels))
        self.unit = f"{trial_of_plan(plan).step}s"
        self._kept = keep_rows(out, plan, labels) if labels else KeptRows((), 0.0, {})

    def needs(self) -> Needs:
        """Requirements of the jobs on another machine."""
        return needs(self._plan)

    def write(self, out: Path, parts: Sequence[JobValues]) -> None:
        """Write the results of the jobs and the rows that are kept, and print the tables."""
        results = [*self._kept.rows, *(result for part in parts for result in part["results"])]
        policies = {**self._kept.policies, **stored_policies(parts)}
        comparison = assemble(self._plan, results)
        seconds = self._kept.seconds + sum(part["seconds"] for part in parts)
        head = {"plan": self._plan.model_dump(mode="json"), "versions": versions(), "seconds": seconds}
        deliver_json(out, {**head, **comparison, POLICIES: policies, "results": results}, indent=None)
        show(self._plan, comparison["table"])


def show(plan: Plan, table: Sequence[Mapping[str, Any]]) -> None:
    """Print one table per level, with gains over the first reference, or over the first entry."""
    base = next(iter((*plan.references, *plan.entries))).label
    trial = trial_of_plan(plan)
    for level in plan.levels:
        rows = [(row["label"], row["throws"], row) for row in table if row["level"] == level]
        title = f"level {level}, {plan.count_of(trial, level)} {trial.unit} per seed"
        console().print(trial.record.comparison(title, rows, base))


class KeptRows(NamedTuple):
    """Rows of an earlier file, the seconds that these and others took, and the policies stored for the rows."""

    rows: Sequence[Result]
    seconds: float
    policies: Mapping[str, str]


def choose_pieces(planned: Sequence[Piece], labels: Collection[str]) -> list[Piece]:
    """Pieces of the entries of these labels; all pieces when no label is given.

    Raises:
        UsageError: no entry of the plan has such a label.
    """
    known = dict.fromkeys(piece.entry.label for piece in planned)
    with about("--only"):
        check_known("label", labels, sorted(known))
    return [piece for piece in planned if not labels or piece.entry.label in labels]


def keep_rows(file: Path, plan: Plan, labels: Collection[str]) -> KeptRows:
    """Rows of a benchmark's file but those of the entries of these labels.

    Raises:
        UsageError: the file is of other versions, of other throws, or has no rows of an entry that is not computed.
    """
    content = read_form(file)
    made_by = content.data["versions"]
    if made_by != versions():
        name = next(name for name in {**made_by, **versions()} if made_by.get(name) != versions().get(name))
        raise UsageError(f"{str(file)!r} is of {name} {made_by.get(name)}, here is {versions().get(name)}; drop --only")
    _check_plan(file, plan, content.plan, labels)
    # The file's environment is that of the plan by now, whose modules the user trusts.
    data = check_figures(file, content, trust=True).data
    kept_labels = {label for entry in plan.entries if entry.label not in labels for label in labels_of(entry)}
    kept = [row for row in data["results"] if row["label"] in kept_labels]
    used = {row.get("digests", {}).get("policy") for row in kept}
    return KeptRows(
        kept, data["seconds"], {digest: text for digest, text in data.get(POLICIES, {}).items() if digest in used}
    )


def _check_plan(file: Path, plan: Plan, earlier: Plan, labels: Collection[str]) -> None:
    """Make sure that a file's rows are those that the plan would give.

    Raises:
        UsageError: the file is of other throws, or an entry that is not computed is missing or has other settings.
    """
    if plan.model_dump(exclude=_BY_ROW) != earlier.model_dump(exclude=_BY_ROW):
        raise UsageError(f"{str(file)!r} is of a plan with other throws; drop --only")
    entries = {entry.label: entry for entry in earlier.entries}
    for entry in plan.entries:
        if entry.label not in labels and entry != entries.get(entry.label):
            raise UsageError(
                f"{str(file)!r} has no rows of entry {entry.label!r} as the plan has it; name it in --only"
            )
