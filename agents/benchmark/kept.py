"""Rows that a benchmark keeps of an earlier file, so that only the entries that are named are computed anew."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from pnt_gym.cells.base.problems import describe_problems

from ..ground.cli import UsageError, about, check_known
from ..ground.files import check_form, read_json
from ..ground.versions import versions
from ..judging.record import Result
from .entries import labels_of
from .plan import Piece, Plan
from .stored import POLICIES

_BY_ROW = {"entries", "learned", "references", "floors"}
"""Keys of a plan on which the rows of other entries do not depend."""


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
    data = read_json(file)
    with check_form(file):
        earlier, made_by, seconds = plan_of_file(file, data["plan"]), dict(data["versions"]), float(data["seconds"])
        rows, policies = list[Result](data["results"]), dict[str, str](data.get(POLICIES, {}))
    if made_by != versions():
        name = next(name for name in {**made_by, **versions()} if made_by.get(name) != versions().get(name))
        raise UsageError(f"{str(file)!r} is of {name} {made_by.get(name)}, here is {versions().get(name)}; drop --only")
    _check_plan(file, plan, earlier, labels)
    kept_labels = {label for entry in plan.entries if entry.label not in labels for label in labels_of(entry)}
    kept = [row for row in rows if row["label"] in kept_labels]
    used = {row.get("digests", {}).get("policy") for row in kept}
    return KeptRows(kept, seconds, {digest: text for digest, text in policies.items() if digest in used})


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


def plan_of_file(file: Path, plan: Any) -> Plan:
    """The plan that a benchmark's file holds.

    Raises:
        UsageError: the plan contradicts itself.
    """
    try:
        # A file holds every key of its plan; keys of other kinds of trials, at their defaults, must not count as given.
        return Plan.model_validate(Plan.model_validate(plan).model_dump(exclude_defaults=True))
    except ValidationError as error:
        raise UsageError(f"plan in {str(file)!r}: {describe_problems(error, Plan)}") from None
