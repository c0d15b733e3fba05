"""A comparison of controllers: pieces of a plan as jobs, rows of an earlier file that stay, the file and its tables."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, final

from ..ground.cli import UsageError, about, check_known
from ..ground.cluster import Needs
from ..ground.tables import console
from ..ground.versions import versions
from ..results import compare, content, entries
from ..results.compare import assemble
from ..results.content import POLICY, other_versions, read_form
from ..results.plan import Piece, Plan, needs, pieces, trial_of_plan
from .run import Part, jobs

_BY_ROW = {"entries", "learned", "references", "floors"}
"""Keys of a plan on which the rows of other entries do not depend."""


@final
class Comparison:
    """Every controller of a plan on the same objects, compared throw by throw or shift by shift.

    Args:
        plan: the plan.
        out: file of the result.
        labels: labels of the entries that are computed, while rows of others are kept; empty for all entries.
        about: what a submission says of itself.

    Attributes:
        jobs: pieces of the entries that are computed.
        unit: unit of the costs of the jobs.
    """

    def __init__(
        self, plan: Plan, out: Path, labels: Collection[str] = (), about: Mapping[str, Any] | None = None
    ) -> None:
        content.check(out)
        self._plan, self._out, self._about = plan, out, about or {}
        self.jobs = jobs(_choose(pieces(plan), labels))
        self.unit = f"{trial_of_plan(plan).step}s"
        self._kept = _keep_rows(out, plan, labels) if labels else Part((), {}, 0.0)

    def needs(self) -> Needs:
        """Requirements of the jobs on another machine."""
        return needs(self._plan)

    def write(self, files: Sequence[Path]) -> None:
        """Write the results in the files of the jobs and the rows that are kept, and print the tables."""
        parts = [self._kept, *map(Part.read, files)]
        results = [result for part in parts for result in part.results]
        policies = {name: policy for part in parts for name, policy in part.policies.items()}
        comparison = assemble(self._plan, results)
        head = {**self._about, "plan": self._plan.model_dump(mode="json"), "versions": versions()}
        head |= {"seconds": sum(part.seconds for part in parts), **comparison}
        content.write(self._out, head, results, policies)
        show(self._plan, comparison["table"])


def show(plan: Plan, table: Sequence[Mapping[str, Any]]) -> None:
    """Print one table per level, with gains over the first reference, or over the first entry."""
    base = next(iter((*plan.references, *plan.entries))).label
    trial = trial_of_plan(plan)
    for level in plan.levels:
        rows = [(row["label"], row["throws"], row) for row in table if row["level"] == level]
        title = f"level {level}, {plan.count(trial, level)} {trial.unit} per seed"
        console().print(trial.record.comparison(title, rows, base))


def _choose(planned: Sequence[Piece], labels: Collection[str]) -> list[Piece]:
    """Pieces of the entries of these labels; all pieces when no label is given.

    Raises:
        UsageError: no entry of the plan has such a label.
    """
    known = dict.fromkeys(piece.entry.label for piece in planned)
    with about("--only"):
        check_known("label", labels, sorted(known))
    return [piece for piece in planned if not labels or piece.entry.label in labels]


def _keep_rows(file: Path, plan: Plan, labels: Collection[str]) -> Part:
    """Rows of a benchmark's file but those of the entries of these labels.

    Raises:
        UsageError: the file is of other versions, of other throws, or has no rows of an entry that is not computed.
    """
    content = read_form(file)
    if content.is_of_before:
        raise UsageError(f"{str(file)!r} is of an earlier version, which kept rows otherwise; drop --only")
    if changed := other_versions(content.data["versions"]):
        name, version = next(iter(changed.items()))
        made_by = {"world": "1", **content.data["versions"]}.get(name)
        raise UsageError(f"{str(file)!r} is of {name} {made_by}, here is {version}; drop --only")
    _check(file, plan, content.plan, labels)
    # The file's environment is that of the plan by now, whose modules the user trusts.
    data = compare.check(content, trust=True).data
    kept_labels = {label for entry in plan.entries if entry.label not in labels for label in entries.labels(entry)}
    kept = [row for row in data["results"] if row["label"] in kept_labels]
    policies = {row[POLICY]: content.policy(row) for row in kept if POLICY in row}
    return Part(kept, {name: policy for name, policy in policies.items() if policy is not None}, data["seconds"])


def _check(file: Path, plan: Plan, earlier: Plan, labels: Collection[str]) -> None:
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
