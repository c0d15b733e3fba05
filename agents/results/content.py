"""What a result is: a readable head, the throws or work shifts of its rows, and policies, in files and in memory.

A result NAME.json is the head: plan, versions, table, comparisons, and for each row what it is of, its totals, and the
file of its policy. Beside the head lies the folder NAME. Its `rows.npz` holds the columns of all rows, with an entry
for each throw or shift: letters, and whole numbers in units of the last decimal that the head gives for the column.
Rows with the same columns are a group, and a column of a group stands in one array: what its rows share is stored once.
Earlier versions wrote a table for each row, which is read too. In memory a row has all of its columns as JSON values.

A file of results may be a stranger's, so its content is data of a checked form; `compare` checks what it shows.
"""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pnt_gym.cells.base.problems import list_problems
from pnt_gym.errors import one_sentence
from pnt_gym.reading import MOST_NUMBERS, arrays_of, bytes_of

from ..ground.archives import archive_of
from ..ground.cli import UsageError
from ..ground.files import MOST_RESULTS, check_form, jsonable, read_json
from ..ground.outputs import check_ending, check_writable, deliver, deliver_json
from ..ground.versions import versions
from ..judging.rows import Amount, Count, check_model
from .plan import Plan

ROW: Final = ("label", "throws", "seed", "level", "train_level")
"""What names a row of the results."""
ABOUT: Final = ("by", "about", "command")
"""What a submission says of itself, beside what a benchmark's file says."""
ROWS: Final = "rows.npz"
"""File of the columns of all rows."""
GROUPS: Final = "groups"
"""Array with the group of each row; the array `GROUP NAME` holds a column of the group's rows (rows, entries, ...)."""
TABLES: Final = rf"{GROUPS}|\d+( .+)?"
"""Names of the arrays that hold columns; a number alone is a table of an earlier version."""
POLICY: Final = "policy"
"""Key of a row with the name of its policy's file."""
MOST_VALUES: Final = 2**24
"""Values in all tables of a result: as many numbers take half a gigabyte of memory."""
MOST_DECIMALS: Final = 6
"""Decimals up to which numbers are stored as whole ones."""
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


def is_submission(data: Mapping[str, Any]) -> bool:
    """Whether the content of a file of results is that of a submission."""
    return not data.keys().isdisjoint(ABOUT)


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


def with_columns(
    file: Path, heads: Sequence[Result], tables: Mapping[str, NDArray[Any]], decimals: Mapping[str, int]
) -> list[Result]:
    """Rows with the columns that the arrays of a file hold.

    Raises:
        UsageError: a column is missing or of another form.
    """
    rows: list[Result] = []
    left = MOST_VALUES
    split = _split if GROUPS in tables else _split_tables
    for head, stored in zip(heads, split(file, tables, len(heads)), strict=True):
        left -= sum(column.size for column in stored.values())
        if left < 0:
            raise UsageError(f"{str(file)!r} holds more than {MOST_VALUES:,} values")
        columns = {name: _values(file, name, column, decimals.get(name)) for name, column in stored.items()}
        rows.append({**head, "columns": {**head["columns"], **columns}})
    return rows


def _split(file: Path, tables: Mapping[str, NDArray[Any]], count: int) -> Iterator[dict[str, NDArray[Any]]]:
    """The stored columns of each row by name, from those of the groups.

    Raises:
        UsageError: the arrays are not of as many rows.
    """
    groups = tables[GROUPS]
    if groups.dtype.kind not in "iu" or groups.shape != (count,):
        raise UsageError(f"{str(file)!r} must name the group of each of the {count} rows")
    stored: list[dict[str, NDArray[Any]]] = [{} for _ in range(count)]
    for key, column in tables.items():
        if key == GROUPS:
            continue
        group, _, name = key.partition(" ")
        members = np.flatnonzero(groups == int(group))
        if not name or column.ndim < 2 or len(column) != len(members):
            raise UsageError(f"{str(file)!r}: {one_sentence(repr(key), 60)} does not hold {len(members)} rows")
        for row, values in zip(members, column, strict=True):
            stored[row][name] = values
    yield from stored


def _split_tables(file: Path, tables: Mapping[str, NDArray[Any]], count: int) -> Iterator[dict[str, NDArray[Any]]]:
    """The stored columns of each row by name, from tables of an earlier version.

    Raises:
        UsageError: a table is missing or of another form.
    """
    if tables.keys() != {str(number) for number in range(count)}:
        raise UsageError(f"{str(file)!r} must hold one table for each of the {count} rows")
    for number in range(count):
        table = tables[str(number)]
        names = table.dtype.names
        if names is None or table.ndim != 1 or not table.dtype.itemsize:
            raise UsageError(f"{str(file)!r}: {number} is no table")
        yield {name: table[name] for name in names}


def _values(file: Path, name: str, column: NDArray[Any], decimals: int | None) -> Any:
    """A column of a table as JSON values: a text, or a list of numbers in which None is a missing one."""
    kind = column.dtype.kind
    if column.dtype == np.dtype("S1") and column.ndim == 1:
        return column.tobytes().decode("latin-1")
    if kind not in "bif" or column.ndim > 2:
        raise UsageError(f"{str(file)!r}: column {one_sentence(repr(name), 60)} holds neither letters nor numbers")
    if kind != "i" or decimals is None:
        return jsonable(column)
    return jsonable(np.where(column == np.iinfo(column.dtype).min, np.nan, column / 10**decimals))


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


def without_columns(results: Sequence[Result]) -> tuple[list[Result], dict[str, int], dict[str, NDArray[Any]]]:
    """Rows without what arrays hold of them; the decimals of columns; and the arrays by name."""
    found = [_arrays(row["columns"]) for row in results]
    decimals = _decimals(found)
    forms = [tuple((name, array.dtype.kind, array.shape) for name, array in arrays.items()) for arrays in found]
    groups = list(dict.fromkeys(forms))
    tables = {GROUPS: np.array([groups.index(form) for form in forms], dtype=np.uint16)}
    for group, columns in enumerate(groups):
        members = [arrays for arrays, form in zip(found, forms, strict=True) if form == columns]
        for name, *_ in columns:
            whole = np.stack([arrays[name] for arrays in members])
            tables[f"{group} {name}"] = _stored(whole, decimals.get(name))
    rows: list[Result] = []
    for row, arrays in zip(results, found, strict=True):
        rest = {name: value for name, value in row["columns"].items() if name not in arrays}
        rows.append({**row, "columns": rest})
    return rows, decimals, tables


def _arrays(columns: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """The columns with an entry for each throw or shift, as arrays; names, totals and other values stay in the head."""
    found: dict[str, NDArray[Any]] = {}
    for name, values in columns.items():
        array = _array(values) if isinstance(values, list | str) else None
        if array is not None and len(array) == len(next(iter(found.values()), array)):
            found[name] = array
    return found


def _array(values: list[Any] | str) -> NDArray[Any] | None:
    """Letters, or numbers of which None is NaN; None where there are other values, or lists of several lengths."""
    if isinstance(values, str):
        return np.array([*values], dtype="S1") if values.isascii() else None
    try:
        array = np.array(values)
    except ValueError:
        return None
    if array.dtype.kind == "O" and all(value is None or type(value) in (int, float) for value in array.flat):
        array = array.astype(np.float64)
    return array if array.dtype.kind in "bif" and array.ndim <= 2 and array.size else None


def _decimals(found: Sequence[Mapping[str, NDArray[Any]]]) -> dict[str, int]:
    """The decimals of a column's numbers, by column; without columns that whole numbers cannot hold."""
    columns: dict[str, list[NDArray[Any]]] = {}
    for name, array in (entry for arrays in found for entry in arrays.items()):
        columns.setdefault(name, []).append(array)
    exact: dict[str, int] = {}
    for name, arrays in columns.items():
        if any(array.dtype.kind == "f" for array in arrays):
            decimals = next((d for d in range(MOST_DECIMALS + 1) if _fits(arrays, d)), None)
            exact |= {} if decimals is None else {name: decimals}
    return exact


def _fits(arrays: Sequence[NDArray[Any]], decimals: int) -> bool:
    """Whether numbers can be stored as whole ones, in units of a decimal."""
    for array in arrays:
        numbers = array[np.isfinite(array)]
        units = np.round(numbers * 10.0**decimals)
        if np.any(np.abs(units) >= 2.0**53) or np.any(units / 10**decimals != numbers):
            return False
    return True


def _stored(array: NDArray[Any], decimals: int | None) -> NDArray[Any]:
    """A column in the smallest whole numbers that hold it; letters, and numbers of more decimals, as they are."""
    if array.dtype.kind not in "if" or (array.dtype.kind == "f" and decimals is None):
        return array
    is_missing = ~np.isfinite(array)
    units = np.where(is_missing, 0, np.round(array * 10 ** (decimals or 0))).astype(np.int64)
    low, high = units.min(), units.max()
    kind = next(k for k in (np.int8, np.int16, np.int32, np.int64) if np.iinfo(k).min < low and high <= np.iinfo(k).max)
    return np.where(is_missing, np.iinfo(kind).min, units).astype(kind)
