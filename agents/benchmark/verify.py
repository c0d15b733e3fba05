"""Carry out a sample of a benchmark's results again: `pnt-gym verify results/benchmark.json`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Final

import numpy as np
import tyro

from ..ground.bars import throws_bar
from ..ground.cli import Exit, UsageError, at_least, option, run
from ..ground.files import check_form, jsonable, read_json
from ..ground.outputs import check_writable, deliver_json
from ..ground.shipped import module_of
from ..ground.tables import Grid, console
from ..ground.versions import versions
from .bounds import is_near
from .entries import TRAINED, labels_of
from .kept import plan_of_file
from .plan import Piece, Plan, pieces, trial_of_plan
from .run import run_piece
from .stored import POLICIES, Stored, stored_policy
from .submission import check_submission, is_submission

DIFFERENT: Final = 1
"""Exit code if a row could not be repeated."""
NEAR: Final = "equal within the bounds"
"""Verdict on rows of a processor that rounds otherwise, if they differ by no more than that explains."""
ROW: Final = ("label", "throws", "seed", "level", "train_level")
"""What names a row of the results."""


@dataclass(frozen=True)
class Arguments:
    """Throw a random sample of a benchmark's rows again, and compare every throw bit by bit.

    A row is thrown with the policy that the file stores for it. A controller without a stored policy learns again.
    """

    file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="FILE")]
    """File that `benchmark` wrote, for instance results/benchmark.json."""
    rows: int = 3
    """Rows of the sample; a row is one controller after one learning, on one level."""
    seed: int = 0
    """Seed of the sample."""
    throws: Annotated[int | None, option("all", "N")] = None
    """Compare only the first N throws, or work shifts, of each row; totals of a row are not compared then."""
    longest: float = 60.0
    """Longest learning of a row of the sample [s]; longer ones are left out unless their policy is stored."""
    learn: bool = False
    """Let controllers learn again whose policies are stored in the file."""
    trust: bool = False
    """Import modules that the file names, whose code then runs."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write the verdicts to this file."""
    write: bool = False
    """Write the digests of policy, level and code here into the rows of FILE that are equal in all throws."""


def main(arguments: Arguments) -> None:
    """Repeat the sample, print the verdicts, and end with exit code 1 if a row is different."""
    at_least(vars(arguments), rows=1, seed=0, throws=2)
    check_writable(arguments.json)
    if arguments.write and arguments.throws is not None:
        raise UsageError("--write goes without --throws: a row is equal if all of its throws are")
    data, plan = _read(arguments.file)
    with check_form(arguments.file):
        made_by, results = dict(data["versions"]), list(data["results"])
        policies = [stored_policy(dict(data.get(POLICIES, {})), row) for row in results]
        names = [dict(zip(ROW, (row[name] for name in ROW), strict=True)) for row in results]
    _check_trust(plan, trust=arguments.trust)
    if arguments.trust:  # the module of a submission lies beside its file
        sys.path.insert(0, str(arguments.file.resolve().parent))
    planned = pieces(plan)
    stored = [None if arguments.learn else policy for policy in policies]
    sample = choose(plan, planned, results, stored, arguments)
    others = {name: version for name, version in versions().items() if made_by.get(name) != version}
    if arguments.write and others:
        raise UsageError(f"--write: {str(arguments.file)!r} is of other versions")
    verdicts: list[dict[str, Any]] = []
    with throws_bar() as bar:
        task = bar.add_task("rows thrown again", total=len(sample))
        for index in sample:
            anew = repeat(planned, results[index], arguments.throws, stored[index])
            told = judge(comparable(planned, results[index], arguments.throws), anew, others)
            verdicts.append({**names[index], **told, "stored": stored[index] is not None})
            if arguments.write and told["difference"] is None:
                results[index]["digests"] = {**results[index].get("digests", {}), **anew["digests"]}
            bar.advance(task)
    show(verdicts, len(results), others, made_by)
    if arguments.json is not None:
        head = {"file": str(arguments.file), "rows": len(results), "seed": arguments.seed}
        deliver_json(arguments.json, {**head, "versions": versions(), "made_by": made_by, "verdicts": verdicts})
    if arguments.write:
        deliver_json(arguments.file, data, indent=None)
    if any(row["difference"] and row["verdict"] != NEAR for row in verdicts):
        raise Exit(DIFFERENT)


def _read(file: Path) -> tuple[Any, Plan]:
    """Content of a file of results, and the plan in it.

    Raises:
        UsageError: the file has another form, or is a submission with other throws than the benchmark's.
    """
    data = read_json(file)
    if not isinstance(data, dict) or "plan" not in data:
        sources = "only files of `pnt-gym benchmark` and `pnt-gym submit` are verified"
        raise UsageError(f"{str(file)!r} has no plan: {sources}")
    with check_form(file):
        plan = plan_of_file(file, data["plan"])
        if is_submission(data):
            check_submission(file, data, plan)
    return data, plan


def choose(
    plan: Plan,
    planned: Sequence[Piece],
    results: Sequence[Any],
    stored: Sequence[Stored | None],
    arguments: Arguments,
) -> list[int]:
    """Numbers of the rows of the sample, in the order of the file.

    Raises:
        UsageError: no row learned so quickly, or a row is of another plan.
    """
    seconds = [_seconds(find_piece(planned, row), results) for row in results]
    quick = [n for n, policy in enumerate(stored) if policy is not None or seconds[n] <= arguments.longest]
    if not quick:
        raise UsageError(f"--longest is {arguments.longest:g}; no row of plan {plan.name!r} learned so quickly")
    random = np.random.default_rng(arguments.seed)
    return sorted(random.choice(quick, min(arguments.rows, len(quick)), replace=False).tolist())


def find_piece(planned: Sequence[Piece], row: Mapping[str, Any]) -> Piece:
    """The piece of a plan that computes a row.

    Raises:
        UsageError: no piece of the plan does.
    """
    for piece in planned:
        if row["level"] in piece.levels and _is_of(piece, row):
            return piece
    raise UsageError(f"row {', '.join(f'{name} {row[name]}' for name in ROW)} is of no entry of the file's plan")


def _seconds(piece: Piece, results: Sequence[Any]) -> float:
    """Longest time of learning that a file records of a piece [s]: a training passes through its smaller counts."""
    return max(row["learn_seconds"] for row in results if _is_of(piece, row))


def _is_of(piece: Piece, row: Mapping[str, Any]) -> bool:
    """Whether a row is of the learning of a piece, on any level."""
    is_same = row["label"] in labels_of(piece.entry) and row["throws"] in piece.throws
    return is_same and (piece.seed, piece.train_level) == (row["seed"], row["train_level"])


def repeat(
    planned: Sequence[Piece], row: Mapping[str, Any], count: int | None = None, stored: Stored | None = None
) -> dict[str, Any]:
    """A row computed anew, or its first throws; other levels and numbers of practice throws are left out.

    Args:
        planned: pieces of the plan.
        row: the row of results.
        count: number of throws or work shifts; None for all.
        stored: policy to throw with; None to let the controller learn.

    Raises:
        UsageError: the stored policy is damaged.
    """
    piece = find_piece(planned, row)
    if count is not None:
        piece = _shortened(piece, count)
    throws = piece.throws if piece.entry.controller in TRAINED else (row["throws"],)
    with TemporaryDirectory() as folder:
        anew = run_piece(replace(piece, levels=(row["level"],), throws=throws), Path(folder), stored)["results"]
    (result,) = [other for other in anew if (other["label"], other["throws"]) == (row["label"], row["throws"])]
    if stored is not None and result["digests"]["policy"] != row["digests"]["policy"]:
        raise UsageError(f"the stored policy of {row['label']!r}, seed {row['seed']}, has not the digest of its row")
    return comparable(planned, jsonable(result), count)


def judge(row: Mapping[str, Any], anew: Mapping[str, Any], others: Mapping[str, str]) -> dict[str, Any]:
    """Verdict on a row by the same row computed anew, and the first difference; `others` has other versions here."""
    row_others = {**others, **other_code(row, anew)}
    is_elsewhere = rounds_otherwise(row, anew)
    difference = row_difference(row, anew, is_same_code=not row_others and not is_elsewhere)
    is_within = difference is not None and is_elsewhere and is_near(row["columns"], anew["columns"])
    text = NEAR if is_within else verdict(difference, row_others)
    return {"verdict": text, "difference": difference, "elsewhere": is_elsewhere}


def _shortened(piece: Piece, count: int) -> Piece:
    """The same piece with fewer held-out throws or work shifts."""
    option = trial_of_plan(piece.plan).option
    entry = piece.entry.model_copy(update={"shifts": None})
    return replace(piece, plan=piece.plan.model_copy(update={option: count, "picks_on": {}}), entry=entry)


def comparable(planned: Sequence[Piece], row: Mapping[str, Any], count: int | None) -> dict[str, Any]:
    """A row without times of the computation; with a count, its first throws alone and none of the totals of all."""
    timings = trial_of_plan(planned[0].plan).record.timings
    columns = {name: column for name, column in row["columns"].items() if name not in timings}
    if count is not None:
        columns = {name: column[:count] for name, column in columns.items() if isinstance(column, list | str)}
    return {**row, "columns": columns}


def row_difference(row: Mapping[str, Any], anew: Mapping[str, Any], *, is_same_code: bool) -> dict[str, Any] | None:
    """First difference of two rows; None if all throws agree, and under the same code level and policy as well.

    Another version may describe the same level or policy with other words, so that throws alone count there.
    """
    difference = first_difference(row["columns"], anew["columns"])
    if difference is not None or not is_same_code:
        return difference
    digests, digests_here = row.get("digests", {}), anew["digests"]
    for name in ("level", "policy"):
        if name in digests and digests[name] != digests_here[name]:
            return {"column": name, "at": None, "file": digests[name], "here": digests_here[name], "count": 1}
    return None


def other_code(row: Mapping[str, Any], anew: Mapping[str, Any]) -> dict[str, str]:
    """The digest of the code here, if the row has another one."""
    code = anew["digests"]["code"]
    return {"code": code} if row.get("digests", {}).get("code", code) != code else {}


def rounds_otherwise(row: Mapping[str, Any], anew: Mapping[str, Any]) -> bool:
    """Whether a row is of a processor whose arithmetic, or whose torch where torch computed anew, is not that here."""
    made_on, here = row.get("digests", {}), anew["digests"]
    return any(name in here and made_on.get(name, here[name]) != here[name] for name in ("arithmetic", "torch"))


def first_difference(old: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any] | None:
    """First column that differs, at which throw, both values and the number of differing throws; None if all agree."""
    for name in (*old, *(name for name in new if name not in old)):
        before, now = old.get(name), new.get(name)
        if before == now:
            continue
        if not (isinstance(before, list | str) and isinstance(now, list | str) and len(before) == len(now)):
            return {"column": name, "at": None, "file": before, "here": now, "count": 1}
        places = [n for n, (x, y) in enumerate(zip(before, now, strict=True)) if x != y]
        return {
            "column": name,
            "at": places[0],
            "file": before[places[0]],
            "here": now[places[0]],
            "count": len(places),
        }
    return None


def verdict(difference: Mapping[str, Any] | None, others: Mapping[str, str]) -> str:
    """`equal`, `different`, or `made by another version` where versions or code differ as well as throws."""
    if difference is None:
        return "equal"
    return "made by another version" if others else "different"


def show(
    verdicts: Sequence[Mapping[str, Any]], count: int, others: Mapping[str, str], made_by: Mapping[str, str]
) -> None:
    """Print a line for each row of the sample, and what the sample says of the file."""
    lines = [
        [row["label"], str(row["throws"] or "-"), str(row["seed"]), row["level"], row["verdict"], _where(row)]
        for row in verdicts
    ]
    title = f"{len(verdicts)} of {count} rows thrown again"
    header = ("controller", "learned from", "seed", "level", "verdict", "first difference")
    console().print(Grid(title, header, lines).terminal())
    count_stored = sum(row["stored"] for row in verdicts)
    if count_stored:
        console().print(f"stored policies threw {count_stored} of them; with --learn their controllers learn again")
    count_elsewhere = sum(row["elsewhere"] for row in verdicts)
    if count_elsewhere:
        bounds = "docs/reproducibility.md has the bounds"
        console().print(f"{count_elsewhere} of them are of a processor that rounds otherwise; {bounds}")
    for name, version in others.items():
        console().print(f"the file was made with {name} {made_by.get(name, 'of no version')}; here is {version}")


def _where(row: Mapping[str, Any]) -> str:
    difference = row["difference"]
    if difference is None:
        return "-"
    place = "" if difference["at"] is None else f", {difference['count']} throws, first {difference['at']}"
    return f"{difference['column']}{place}: {str(difference['file'])[:20]}, here {str(difference['here'])[:20]}"


def _check_trust(plan: Plan, *, trust: bool) -> None:
    """Make sure that a module is imported only if the user trusts the file.

    Raises:
        UsageError: the plan names a module, and `trust` is not given.
    """
    names = [plan.env, *(name for entry in plan.entries for name in (entry.controller, *entry.also))]
    modules = [name for name in names if module_of(name) is not None]
    if modules and not trust:
        raise UsageError(
            f"the file names {modules[0]!r}: importing the module runs its code; give --trust if it is yours"
        )


if __name__ == "__main__":
    run(main, Arguments, "agents.benchmark.verify")
