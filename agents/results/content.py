"""What a result is: a readable head, the throws or work shifts of its rows, and policies, in files and in memory.

A result NAME.json is the head: plan, versions, table, comparisons, and for each row what it is of, its totals, and the
file of its policy. Beside the head lies the folder NAME. Its `rows.npz` holds the columns of all rows, see `columns`.
In memory a row has all of its columns as JSON values.

A file of results may be a stranger's, so its content is data of a checked form; `compare` checks what it shows.
"""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pnt_gym.cells.base.problems import list_problems
from pnt_gym.errors import one_sentence
from pnt_gym.reading import MOST_NUMBERS, arrays_of, bytes_of

from ..ground.archives import archive_of
from ..ground.cli import UsageError
from ..ground.files import MOST_RESULTS, check_form, read_json
from ..ground.outputs import check_ending, check_writable, deliver, deliver_json
from ..ground.versions import versions
from ..judging.rows import Amount, Count, check_model
from .columns import MOST_DECIMALS, TABLES, with_columns, without_columns
from .plan import Plan

ROW: Final = ("label", "throws", "seed", "level", "train_level")
"""What names a row of the results."""
ABOUT: Final = ("by", "about", "command")
"""What a submission says of itself, beside what a benchmark's file says."""
ROWS: Final = "rows.npz"
"""File of the columns of all rows."""
POLICY: Final = "policy"
"""Key of a row with the name of its policy's file."""
Text = Annotated[str, Field(max_length=2000)]
Result = dict[str, Any]
"""A row of results in memory: what names the row, `columns` by name, and `policy` where its policy is stored."""


class ResultRow(BaseModel):
    """One row: a controller after one learning, and its held-out throws or work shifts on one level."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    label: Text
    controller: Text
    throws: Count
    seed: Annotated[int, Field(ge=0)]
    level: Text
    train_level: Text
    learn_seconds: Amount
    policy: Annotated[str, Field(pattern=r"^[\w+-][\w.+-]{0,200}$")] = ""
    digests: dict[str, Text] = {}
    """Of earlier versions, which named policies by them."""
    columns: dict[str, Any]


class BenchmarkFile(BaseModel):
    """A file of `pnt-gym benchmark`, or of `pnt-gym submit`, which says more about itself."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    by: Text = ""
    about: Text = ""
    command: Text = ""
    learned_from: Count = 0
    """Throws that a submitted policy had learned from before, as who submits it says."""
    plan: dict[str, Any]
    versions: dict[str, Text]
    seconds: Amount
    trial: Text
    unit: Text
    step: Text
    figures: dict[str, Any]
    table: list[dict[str, Any]]
    comparisons: list[dict[str, Any]]
    decimals: dict[str, Annotated[int, Field(ge=0, le=MOST_DECIMALS)]] = {}
    """Decimals of the columns that are stored as whole numbers; missing in files of earlier versions."""
    policies: dict[str, str] = {}
    """Of earlier versions: policies by their digests, as text in base64, or the digest of one that is the same."""
    results: Annotated[list[ResultRow], Field(min_length=1)]


class Content(NamedTuple):
    """Content of a benchmark's file.

    Attributes:
        plan: the plan.
        data: everything by key, as JSON; `results` with all columns.
        path: path of the head.
    """

    plan: Plan
    data: dict[str, Any]
    path: Path

    @property
    def is_of_before(self) -> bool:
        """Whether an earlier version wrote the file, which kept everything in the head."""
        return "decimals" not in self.data

    def policy(self, row: Mapping[str, Any]) -> bytes | None:
        """Content of the file of a row's policy, which holds numbers alone; None if the policy is not stored.

        Raises:
            UsageError: the file is missing, too large, or no file.
        """
        if self.is_of_before:
            policies = self.data.get("policies", {})
            text = policies.get(row.get("digests", {}).get("policy"))
            try:
                return None if text is None else base64.b64decode(policies.get(text, text), validate=True)
            except (binascii.Error, ValueError):
                raise UsageError(f"{str(self.path)!r}: row {name_row(row)}: the policy is no text in base64") from None
        if POLICY not in row:
            return None
        file = folder_of(self.path) / row[POLICY]
        with check_form(file):
            return bytes_of(file, MOST_NUMBERS)


# Reading


def matches(data: Any) -> bool:
    """Whether data are of a benchmark's file, a damaged one perhaps, and no other file of results."""
    return isinstance(data, dict) and "plan" in data


def other_versions(made_by: Mapping[str, str]) -> dict[str, str]:
    """Versions here, by name, that a file does not have or has otherwise; a file without a world is of the first."""
    here, made_by = versions(), {"world": "1", **made_by}
    names = [name for name in {**made_by, **here} if made_by.get(name) != here.get(name)]
    return {name: here.get(name, "none") for name in names}


def folder_of(path: Path) -> Path:
    """The folder beside the head of a result."""
    return path.with_suffix("")


def read_form(path: Path) -> Content:
    """Content of a benchmark's file of which the form alone is checked; no module is imported.

    Raises:
        UsageError: the file is missing or of another form.
    """
    data = read_json(path)
    if not matches(data):
        sources = "only files of `pnt-gym benchmark` and `pnt-gym submit` are verified"
        raise UsageError(f"{str(path)!r} has no plan: {sources}")
    return form(path, data)


def form(path: Path, data: dict[str, Any]) -> Content:
    """Content of a benchmark's file from its head, of which the form alone is checked.

    Raises:
        UsageError: the data are of another form.
    """
    check_model(path, BenchmarkFile, data)
    plan = _plan(path, data["plan"])
    if "decimals" in data:
        file = folder_of(path) / ROWS
        tables = arrays(file, TABLES)
        data = {**data, "results": with_columns(file, data["results"], tables, data["decimals"])}
    return Content(plan, data, path)


def _plan(file: Path, plan: Any) -> Plan:
    """The plan that a benchmark's file holds.

    Raises:
        UsageError: the plan contradicts itself.
    """
    try:
        # A file holds every key of its plan; keys of other kinds of trials, at their defaults, must not count as given.
        return Plan.model_validate(Plan.model_validate(plan).model_dump(exclude_defaults=True))
    except ValidationError as error:
        raise UsageError(*list_problems(f"plan in {str(file)!r}", error, Plan)) from None


def name_row(row: Mapping[str, Any]) -> str:
    """A row in words."""
    return ", ".join(f"{name} {one_sentence(row[name], 60)}" for name in ROW)


def arrays(file: Path, names: str) -> dict[str, NDArray[Any]]:
    """The arrays of a file.

    Raises:
        UsageError: the file is missing, too large, or none of arrays.
    """
    with check_form(file):
        return arrays_of(file, re.compile(names), MOST_RESULTS)


# Writing


def check(path: Path) -> None:
    """Make sure, before hours of work, that a result can be written.

    Raises:
        UsageError: the path has another ending than .json, or cannot be written.
    """
    check_writable(path)
    check_ending("out", path, (".json",))
    check_writable(folder_of(path) / ROWS)


def write(path: Path, head: Mapping[str, Any], results: Sequence[Result], policies: Mapping[str, bytes]) -> None:
    """Write a result: the files of its folder, then its head. Policies that only the result before named are removed.

    Args:
        path: path of the head.
        head: everything but the rows.
        results: the rows with all columns.
        policies: content of the policies by the names of their files, those that rows name.

    Raises:
        UsageError: a path cannot be written.
    """
    rows, decimals, tables = without_columns(results)
    files = {ROWS: archive_of(tables), **policies}
    for name in _named_policies(path) - {row.get(POLICY) for row in results}:
        (folder_of(path) / name).unlink(missing_ok=True)
    for name, content in files.items():
        deliver(folder_of(path) / name, lambda place, content=content: place.write_bytes(content))
    deliver_json(path, {**head, "decimals": decimals, "results": rows})


def _named_policies(path: Path) -> set[str]:
    """Names of the policies that the result at a path names; none where no readable result lies there."""
    try:
        names = {str(row[POLICY]) for row in read_json(path)["results"] if POLICY in row}
    except (UsageError, LookupError, TypeError):
        return set()
    return {name for name in names if Path(name).name == name}
