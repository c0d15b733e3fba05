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

from pnt_gym.arrays import Bools

from ..ground.cli import Exit, UsageError, at_least, option, run
from ..ground.files import jsonable
from ..ground.outputs import check_writable, deliver_json
from ..ground.shipped import module_of
from ..ground.tables import Grid, console, throws_bar
from ..ground.versions import versions
from ..ground.work import UnfinishedError, limited_worker
from ..results import compare
from ..results.compare import check_submission, untrusted
from ..results.content import ABOUT, ROW, Content, name_row, other_versions, read_form
from ..results.entries import TRAINED
from ..results.plan import Piece, Plan, pieces, trial_of_plan
from .run import run_piece

EQUAL: Final = "equal"
DIFFERENT: Final = "different"
LEFT_OUT: Final = "left out"
VERDICTS: Final = (EQUAL, DIFFERENT, LEFT_OUT)
"""Verdicts, the best one first."""
BOUNDS: Final = {"along_m": 1e-4, "across_m": 1e-4, "error_m": 1e-4, "cycle_s": 1e-3}
"""Largest difference of a column's values that another processor explains, landings in m and times in s."""
FEW: Final = 0.01
"""Share of the throws that may differ by more, or have another outcome: a throw at a rim may fall to either side."""
EXIT_DIFFERENT: Final = 1
"""Exit code if a row could not be repeated."""
EXIT_LEFT_OUT: Final = 3
"""Exit code if rows of the sample were left out, and all others are equal."""


@dataclass(frozen=True)
class Arguments:
    """Compute a benchmark's figures from its throws anew, and throw a random sample of its rows again.

    A row is thrown with the policy that is stored for it. A controller without a stored policy learns again. A row is
    equal if it is of the same objects, and of all throws but one in a hundred the landings are within 0.1 mm, the times
    within 1 ms, and the outcomes the same. Exit code: 0 if all rows of the sample were thrown and are equal, 1 if a row
    is different, 3 if no row is different but some were left out, for instance because they took too long.
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
    learn: bool = False
    """Let controllers learn again whose policies are stored beside the file."""
    trust: bool = False
    """Import modules that the file names, whose code then runs."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write the verdicts to this file."""


def main(arguments: Arguments) -> None:
    """Repeat the sample, print the verdicts, and end with the exit code of the verdicts."""
    at_least(vars(arguments), rows=1, seed=0, throws=2)
    if not arguments.longest > 0.0:
        raise UsageError(f"--longest is {arguments.longest:g}; it must be above 0 s")
    check_writable(arguments.json)
    content = _read(arguments.file, trust=arguments.trust)
    results, made_by = content.data["results"], content.data["versions"]
    seed = secrets.randbelow(2**32) if arguments.seed is None else arguments.seed
    verdicts = _throw_again(content, choose(len(results), arguments.rows, seed), arguments)
    show(verdicts, len(results), seed)
    # Print what no repetition of the sample compares, and the versions here that the file does not have.
    timings = sorted(trial_of_plan(content.plan).record.timings)
    parts = ["times of learning", *timings]
    if arguments.throws is not None:
        parts += [f"throws of these rows after the first {arguments.throws}", "totals of rows"]
    console().print(f"not compared: {', '.join(parts)}")
    recorded = {"world": "1", **content.data["versions"]}
    for name, version in other_versions(recorded).items():
        console().print(f"the file was made with {name} {recorded.get(name, 'of no version')}; here is {version}")
    if arguments.json is not None:
        head = {"file": str(arguments.file), "rows": len(results), "seed": seed}
        deliver_json(arguments.json, {**head, "versions": versions(), "made_by": made_by, "verdicts": verdicts})
    counts = Counter(row["verdict"] for row in verdicts)
    if counts[DIFFERENT]:
        raise Exit(EXIT_DIFFERENT)
    if counts[LEFT_OUT]:
        raise Exit(EXIT_LEFT_OUT)


def _read(file: Path, *, trust: bool) -> Content:
    """Content of a file of results, whose figures are those of its throws.

    Raises:
        UsageError: the file is damaged, says other than its throws, or is a submission of other throws than the
            benchmark's; or it names a module that nobody trusts.
    """
    content = read_form(file)
    # Make sure that a module is imported only if the user trusts the file.
    names = [content.plan.env, *(name for entry in content.plan.entries for name in (entry.controller, *entry.also))]
    modules = [name for name in names if module_of(name) is not None]
    if modules and not trust:
        raise untrusted(file, modules[0])
    if trust:  # the module of a submission lies beside its file
        sys.path.insert(0, str(file.resolve().parent))
    if not content.data.keys().isdisjoint(ABOUT):  # a submission says something of itself
        check_submission(content)
    return compare.check(content, trust=trust)


def choose(count: int, rows: int, seed: int) -> list[int]:
    """Numbers of the rows of a sample, in the order of the file."""
    return sorted(np.random.default_rng(seed).choice(count, min(rows, count), replace=False).tolist())


def _throw_again(content: Content, sample: Sequence[int], arguments: Arguments) -> list[dict[str, Any]]:
    """Verdicts on the rows of a sample.

    Raises:
        UsageError: a stored policy is damaged.
    """
    plan, data, file = content
    planned = {names: piece for piece in pieces(plan) for names in piece.rows}
    verdicts: list[dict[str, Any]] = []
    with throws_bar() as bar, limited_worker(arguments.longest) as worker:
        task = bar.add_task(f"rows thrown again, {arguments.longest:g} s each at most", total=len(sample))
        for row in (data["results"][index] for index in sample):
            policy = None if arguments.learn else content.policy(row)
            head = {name: row[name] for name in ROW} | {"stored": policy is not None}
            try:
                piece = planned[tuple(row[name] for name in ROW)]
                anew = worker.call(repeat, piece, row, arguments.throws, policy)
            except UnfinishedError as error:
                verdicts.append({**head, "verdict": LEFT_OUT, "difference": None, "why": str(error)})
            except UsageError as error:
                raise UsageError(f"{str(file)!r}: row {name_row(row)}: {error}") from None
            else:
                columns = comparable(plan, row["columns"], arguments.throws)
                verdicts.append({**head, **judge(columns, anew), "why": None})
            bar.advance(task)
    return verdicts


def repeat(
    piece: Piece, row: Mapping[str, Any], count: int | None = None, policy: bytes | None = None
) -> dict[str, Any]:
    """Columns of a row computed anew, or its first throws; other levels and numbers of practice throws are left out.

    Args:
        piece: the piece of the plan that computes the row.
        row: the row of results.
        count: number of throws or work shifts; None for all.
        policy: content of the file of a policy to throw with; None to let the controller learn.

    Raises:
        UsageError: the policy is damaged.
    """
    plan = piece.plan
    if count is not None:
        # The same piece with fewer held-out throws or work shifts.
        option = trial_of_plan(piece.plan).option
        entry = piece.entry.model_copy(update={"shifts": None})
        piece = replace(piece, plan=piece.plan.model_copy(update={option: count, "picks_on": {}}), entry=entry)
    throws = piece.throws if piece.entry.controller in TRAINED and policy is None else (row["throws"],)
    with TemporaryDirectory() as folder:
        anew = run_piece(replace(piece, levels=(row["level"],), throws=throws), Path(folder), policy).results
    (result,) = [other for other in anew if (other["label"], other["throws"]) == (row["label"], row["throws"])]
    return comparable(plan, jsonable(result["columns"]), count)


def comparable(plan: Plan, columns: Mapping[str, Any], count: int | None) -> dict[str, Any]:
    """Columns without times of the computation; with a count, of the first throws alone and without totals of all."""
    timings = trial_of_plan(plan).record.timings
    kept = {name: column for name, column in columns.items() if name not in timings}
    if count is None:
        return kept
    return {name: column[:count] for name, column in kept.items() if isinstance(column, list | str)}


def show(verdicts: Sequence[Mapping[str, Any]], count: int, seed: int) -> None:
    """Print a line for each row of the sample, and what the sample says of the file."""
    lines = [
        [row["label"], str(row["throws"] or "-"), str(row["seed"]), row["level"], row["verdict"], _name(row)]
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


def _name(row: Mapping[str, Any]) -> str:
    difference = row["difference"]
    if difference is None:
        return row["why"] or "-"
    place = "" if difference["at"] is None else f", {difference['count']} of them, first {difference['at']}"
    return f"{difference['column']}{place}: {str(difference['file'])[:20]}, here {str(difference['here'])[:20]}"


def judge(columns: Mapping[str, Any], anew: Mapping[str, Any]) -> dict[str, Any]:
    """Verdict on the columns of a row by the same columns computed anew, and the first throw that differs.

    What the file says of its making has no part in it.
    """
    names = [name for name in dict.fromkeys((*columns, *anew)) if columns.get(name) != anew.get(name)]
    difference: dict[str, Any] | None = None
    if names:
        before, now = columns.get(names[0]), anew.get(names[0])
        difference = {"column": names[0], "at": None, "file": before, "here": now, "count": 1}
        if isinstance(before, list | str) and isinstance(now, list | str) and len(before) == len(now):
            at, *others = (number for number, (x, y) in enumerate(zip(before, now, strict=True)) if x != y)
            difference |= {"at": at, "file": before[at], "here": now[at], "count": 1 + len(others)}
    return {"verdict": EQUAL if is_near(columns, anew) else DIFFERENT, "difference": difference}


def is_near(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    """Whether the columns of two rows agree within the bounds: the same objects, and all but few throws the same.

    Columns without a bound must be equal; totals may differ by as many throws as may have another outcome.
    """
    count = len(old.get("outcome", ""))
    far = np.zeros(count, dtype=np.bool_)
    for name in dict.fromkeys((*old, *new)):
        before, now = old.get(name), new.get(name)
        if before == now:
            continue
        if isinstance(before, list | str) and isinstance(now, list | str):
            if name not in (*BOUNDS, "outcome") or not len(before) == len(now) == count:
                return False
            far |= _are_far(before, now, BOUNDS.get(name))
            continue
        if not (count and isinstance(before, int | float) and isinstance(now, int | float)):
            return False
        if abs(before - now) > FEW * max(count, abs(now)):
            return False
    return not far.any() or float(far.mean()) <= FEW


def _are_far(before: Any, now: Any, bound: float | None) -> Bools:
    """Which throws differ, by more than the bound if there is one."""
    if bound is None:
        return np.array([x != y for x, y in zip(before, now, strict=True)], dtype=np.bool_)
    left, right = (np.array([np.nan if x is None else x for x in side], dtype=np.float64) for side in (before, now))
    is_far = np.abs(left - right) > bound + 1e-9  # the bound itself is within, however its decimals round
    return is_far | (np.isnan(left) != np.isnan(right))


if __name__ == "__main__":
    run(main, Arguments, "agents.benchmark.verify")
