"""Carry out a sample of a benchmark's results again: `pnt-gym verify results/benchmark.json`."""

from __future__ import annotations

import secrets
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Final

import numpy as np
import tyro

from ..ground.cli import Exit, UsageError, at_least, option, run
from ..ground.files import jsonable
from ..ground.outputs import check_writable, deliver_json
from ..ground.shipped import module_of
from ..ground.tables import Grid, console, throws_bar
from ..ground.versions import versions
from ..ground.work import UnfinishedError, limited_worker
from ..results.content import ROW, Content, check_figures, name_row, read_form, untrusted
from ..results.entries import TRAINED, labels_of
from ..results.plan import Piece, Plan, pieces, trial_of_plan
from ..results.submission import check_submission, is_submission
from .run import run_piece
from .stored import POLICIES, Stored, stored_policy
from .verdicts import DIFFERENT, EQUAL, LEFT_OUT, NEAR, VERDICTS, judge

EXIT_DIFFERENT: Final = 1
"""Exit code if a row could not be repeated."""
EXIT_LEFT_OUT: Final = 3
"""Exit code if rows of the sample were left out, and all others are equal."""


@dataclass(frozen=True)
class Arguments:
    """Compute a benchmark's figures from its throws anew, and throw a random sample of its rows again.

    A row is thrown with the policy that the file stores for it. A controller without a stored policy learns again.
    Exit code: 0 if all rows of the sample were thrown and are equal, 1 if a row is different, 3 if no row is different
    but some were left out, for instance because they took too long.
    """

    file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="FILE")]
    """File that `benchmark` or `submit` wrote, for instance results/benchmark.json."""
    rows: int = 3
    """Rows of the sample; a row is one controller after one learning, on one level."""
    seed: Annotated[int | None, option("drawn, and printed", "N")] = None
    """Seed of the sample; nobody who wrote the file can know a seed that is drawn."""
    throws: Annotated[int | None, option("all", "N")] = None
    """Compare only the first N throws, or work shifts, of each row; totals of a row are not compared then."""
    longest: float = 300.0
    """Longest time for learning and throwing a row here [s]; a row that is not done then is left out."""
    near: bool = False
    """Accept rows whose throws differ by no more than another processor explains."""
    learn: bool = False
    """Let controllers learn again whose policies are stored in the file."""
    trust: bool = False
    """Import modules that the file names, whose code then runs."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write the verdicts to this file."""
    write: bool = False
    """Write the digests of policy, level and code here into the rows of FILE that are equal in all throws."""


def main(arguments: Arguments) -> None:
    """Repeat the sample, print the verdicts, and end with the exit code of the verdicts."""
    _check_arguments(arguments)
    content = _read(arguments.file, trust=arguments.trust)
    results, made_by = content.data["results"], content.data["versions"]
    others = {name: version for name, version in versions().items() if made_by.get(name) != version}
    if arguments.write and others:
        raise UsageError(f"--write: {str(arguments.file)!r} is of other versions")
    seed = secrets.randbelow(2**32) if arguments.seed is None else arguments.seed
    sample = choose(len(results), arguments.rows, seed)
    verdicts = _throw_again(content, sample, arguments, others)
    show(verdicts, len(results), seed, others, made_by)
    _say_what_is_unchecked(content.plan, arguments)
    if arguments.json is not None:
        head = {"file": str(arguments.file), "rows": len(results), "seed": seed}
        deliver_json(arguments.json, {**head, "versions": versions(), "made_by": made_by, "verdicts": verdicts})
    if arguments.write:
        deliver_json(arguments.file, content.data, indent=None)
    counts = Counter(row["verdict"] for row in verdicts)
    if counts[DIFFERENT] or (counts[NEAR] and not arguments.near):
        raise Exit(EXIT_DIFFERENT)
    if counts[LEFT_OUT]:
        raise Exit(EXIT_LEFT_OUT)


def _check_arguments(arguments: Arguments) -> None:
    at_least(vars(arguments), rows=1, seed=0, throws=2)
    if not arguments.longest > 0.0:
        raise UsageError(f"--longest is {arguments.longest:g}; it must be above 0 s")
    check_writable(arguments.json)
    if arguments.write and arguments.throws is not None:
        raise UsageError("--write goes without --throws: a row is equal if all of its throws are")


def _read(file: Path, *, trust: bool) -> Content:
    """Content of a file of results, whose figures are those of its throws.

    Raises:
        UsageError: the file is damaged, says other than its throws, or is a submission of other throws than the
            benchmark's; or it names a module that nobody trusts.
    """
    content = read_form(file)
    _check_trust(file, content.plan, trust=trust)
    if trust:  # the module of a submission lies beside its file
        sys.path.insert(0, str(file.resolve().parent))
    if is_submission(content.data):
        check_submission(file, content)
    return check_figures(file, content, trust=trust)


def choose(count: int, rows: int, seed: int) -> list[int]:
    """Numbers of the rows of a sample, in the order of the file."""
    return sorted(np.random.default_rng(seed).choice(count, min(rows, count), replace=False).tolist())


def _throw_again(
    content: Content, sample: Sequence[int], arguments: Arguments, others: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Verdicts on the rows of a sample; rows that are equal get the digests here if that is asked for.

    Raises:
        UsageError: a stored policy is damaged.
    """
    plan, data = content
    results, planned = data["results"], pieces(plan)
    verdicts: list[dict[str, Any]] = []
    with throws_bar() as bar, limited_worker(arguments.longest) as worker:
        task = bar.add_task(f"rows thrown again, {arguments.longest:g} s each at most", total=len(sample))
        for index in sample:
            row = results[index]
            stored = None if arguments.learn else _policy(arguments.file, data.get(POLICIES, {}), row)
            head = {name: row[name] for name in ROW} | {"stored": stored is not None}
            try:
                anew = worker.call(repeat, find_piece(planned, row), row, arguments.throws, stored)
            except UnfinishedError as error:
                verdicts.append({**head, "verdict": LEFT_OUT, "difference": None, "why": str(error)})
            except UsageError as error:
                raise UsageError(f"{str(arguments.file)!r}: row {name_row(row)}: {error}") from None
            else:
                verdicts.append({**head, **judge(comparable(plan, row, arguments.throws), anew, others)})
                if arguments.write and verdicts[-1]["difference"] is None:
                    row["digests"] = {**row.get("digests", {}), **anew["digests"]}
            bar.advance(task)
    return verdicts


def _policy(file: Path, policies: Mapping[str, str], row: Mapping[str, Any]) -> Stored | None:
    """The policy that a file stores for a row.

    Raises:
        UsageError: the text is none of a policy.
    """
    try:
        return stored_policy(policies, row)
    except ValueError:
        raise UsageError(f"{str(file)!r}: row {name_row(row)}: the stored policy is no text in base64") from None


def find_piece(planned: Sequence[Piece], row: Mapping[str, Any]) -> Piece:
    """The piece of a plan that computes a row.

    Raises:
        UsageError: no piece of the plan does.
    """
    for piece in planned:
        if row["level"] in piece.levels and _is_of(piece, row):
            return piece
    raise UsageError(f"row {name_row(row)} is of no entry of the file's plan")


def _is_of(piece: Piece, row: Mapping[str, Any]) -> bool:
    """Whether a row is of the learning of a piece, on any level."""
    is_same = row["label"] in labels_of(piece.entry) and row["throws"] in piece.throws
    return is_same and (piece.seed, piece.train_level) == (row["seed"], row["train_level"])


def repeat(
    piece: Piece, row: Mapping[str, Any], count: int | None = None, stored: Stored | None = None
) -> dict[str, Any]:
    """A row computed anew, or its first throws; other levels and numbers of practice throws are left out.

    Args:
        piece: the piece of the plan that computes the row.
        row: the row of results.
        count: number of throws or work shifts; None for all.
        stored: policy to throw with; None to let the controller learn.

    Raises:
        UsageError: the stored policy is damaged.
    """
    plan = piece.plan
    if count is not None:
        piece = _shortened(piece, count)
    throws = piece.throws if piece.entry.controller in TRAINED else (row["throws"],)
    with TemporaryDirectory() as folder:
        anew = run_piece(replace(piece, levels=(row["level"],), throws=throws), Path(folder), stored)["results"]
    (result,) = [other for other in anew if (other["label"], other["throws"]) == (row["label"], row["throws"])]
    if stored is not None and result["digests"]["policy"] != row["digests"]["policy"]:
        raise UsageError("the stored policy has not the digest of its row")
    return comparable(plan, jsonable(result), count)


def _shortened(piece: Piece, count: int) -> Piece:
    """The same piece with fewer held-out throws or work shifts."""
    option = trial_of_plan(piece.plan).option
    entry = piece.entry.model_copy(update={"shifts": None})
    return replace(piece, plan=piece.plan.model_copy(update={option: count, "picks_on": {}}), entry=entry)


def comparable(plan: Plan, row: Mapping[str, Any], count: int | None) -> dict[str, Any]:
    """A row without times of the computation; with a count, its first throws alone and none of the totals of all."""
    timings = trial_of_plan(plan).record.timings
    columns = {name: column for name, column in row["columns"].items() if name not in timings}
    if count is not None:
        columns = {name: column[:count] for name, column in columns.items() if isinstance(column, list | str)}
    return {**row, "columns": columns}


def show(
    verdicts: Sequence[Mapping[str, Any]], count: int, seed: int, others: Mapping[str, str], made_by: Mapping[str, str]
) -> None:
    """Print a line for each row of the sample, and what the sample says of the file."""
    lines = [
        [row["label"], str(row["throws"] or "-"), str(row["seed"]), row["level"], row["verdict"], _where(row)]
        for row in verdicts
    ]
    header = ("controller", "learned from", "seed", "level", "verdict", "first difference")
    console().print(Grid(f"{len(verdicts)} of {count} rows, drawn by --seed {seed}", header, lines).terminal())
    counts = Counter(row["verdict"] for row in verdicts)
    words = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict] or verdict == EQUAL)
    console().print(f"figures of the file are those of its throws; of {len(verdicts)} rows {words}")
    console().print(f"{count - len(verdicts)} further rows were not thrown again")
    if count_stored := sum(row["stored"] for row in verdicts):
        console().print(f"stored policies threw {count_stored} of them; with --learn their controllers learn again")
    if count_elsewhere := sum(row.get("elsewhere", False) for row in verdicts):
        console().print(f"{count_elsewhere} of them are said to be of a processor that rounds otherwise")
    if counts[NEAR]:
        console().print("docs/reproducibility.md has the bounds of another processor; with --near they count as equal")
    if any(row.get("other_code", False) for row in verdicts):
        console().print("the file was made by another version of the code, which may throw otherwise")
    for name, version in others.items():
        console().print(f"the file was made with {name} {made_by.get(name, 'of no version')}; here is {version}")


def _say_what_is_unchecked(plan: Plan, arguments: Arguments) -> None:
    """Print what no repetition of the sample compares."""
    timings = sorted(trial_of_plan(plan).record.timings)
    parts = ["times of learning", *timings]
    if arguments.throws is not None:
        parts += [f"throws of these rows after the first {arguments.throws}", "totals of rows"]
    console().print(f"not compared: {', '.join(parts)}")


def _where(row: Mapping[str, Any]) -> str:
    difference = row["difference"]
    if difference is None:
        return row["why"] or "-"
    place = "" if difference["at"] is None else f", {difference['count']} throws, first {difference['at']}"
    return f"{difference['column']}{place}: {str(difference['file'])[:20]}, here {str(difference['here'])[:20]}"


def _check_trust(file: Path, plan: Plan, *, trust: bool) -> None:
    """Make sure that a module is imported only if the user trusts the file.

    Raises:
        UsageError: the plan names a module, and `trust` is not given.
    """
    names = [plan.env, *(name for entry in plan.entries for name in (entry.controller, *entry.also))]
    modules = [name for name in names if module_of(name) is not None]
    if modules and not trust:
        raise untrusted(file, modules[0])


if __name__ == "__main__":
    run(main, Arguments, "agents.benchmark.verify")
