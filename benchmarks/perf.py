"""Measure the speeds of planners, grasping and environments.

`python benchmarks/perf.py planner envs/PnTLine-v0 --json FILE` measures these cases; without a name it measures all
cases. A name before a slash stands for all cases that begin with the name. Such cases share the form of their results.
"""

from __future__ import annotations

import os
import platform
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final

import tyro

import pnt_gym
from agents.ground.cli import UsageError, at_least, option, run
from agents.ground.outputs import check_writable, deliver_json
from agents.ground.versions import versions
from benchmarks.perf_cases import cells, codes, grasp, planning, shares
from benchmarks.timing import Options, Place, Row, figures, nest
from pnt_gym.constants import WORLD
from pnt_gym.names import unknown_name

CASES: Final[dict[str, Callable[[Options], Iterator[Row]]]] = {
    "planner": planning.planner,
    "grasp": grasp.grasp,
    "shares": shares.steps,
    "training": shares.training,
    "before/training": codes.training,
    "before/steps": codes.steps,
    **{f"envs/{env_id}": partial(cells.environment, env_id) for env_id in pnt_gym.ENV_IDS},
}
"""What sets a case up and gives its rows, by the case's name."""


@dataclass(frozen=True)
class Arguments(Options):
    """Time planners, grasping and environments; what is compared is timed in turn, in one run."""

    cases: Annotated[
        tyro.conf.Positional[tuple[str, ...]], tyro.conf.arg(metavar="CASE ...", help_behavior_hint="(default: all)")
    ] = ()
    """Names of cases or their beginnings."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write the figures to this file: those of one subject, or by subject where there are several."""
    list: bool = False
    """List the cases without measuring them."""


def main(arguments: Arguments) -> None:
    """Measure the cases that are asked for, print their figures and write them."""
    at_least({**vars(arguments), "threads": min(arguments.threads, default=0)}, repeats=1, cells=1, threads=1)
    names = select_cases(arguments.cases, has_older_code=arguments.before is not None)
    if arguments.list:
        print("\n".join(f"{name:28s}{summary(CASES[name])}" for name in names))
        return
    check_writable(arguments.json)
    packages = {name: version for name, version in versions().items() if version != "not installed"}
    print(f"{platform.machine()}, {os.cpu_count()} processors, {', '.join(map(' '.join, packages.items()))}")
    results: dict[Place, Any] = {}
    for name in names:
        subject = name.partition("/")[0]
        values = {(subject, *place): value for place, value in figures(CASES[name](arguments), arguments).items()}
        print("\n".join(lines(values)), flush=True)
        results |= values
    data = nest(results)
    if arguments.json is not None:
        deliver_json(arguments.json, {"world": WORLD, **(data if len(data) > 1 else next(iter(data.values())))})


def select_cases(names: Iterable[str], *, has_older_code: bool = True) -> list[str]:
    """The cases of these names or beginnings; without one, all that can be measured.

    Raises:
        UsageError: a name that no case has.
    """
    if unknown := [name for name in names if not any(f"{case}/".startswith(f"{name}/") for case in CASES)]:
        raise UsageError(unknown_name("case", unknown[0], CASES))
    beginnings = tuple(f"{name}/" for name in names)
    if not beginnings:
        return [case for case in CASES if has_older_code or not case.startswith("before/")]
    return [case for case in CASES if f"{case}/".startswith(beginnings)]


def summary(case: Any) -> str:
    """The first line of what a case says of itself."""
    return (getattr(case, "func", case).__doc__ or "").partition("\n")[0]


def lines(values: Mapping[Place, Any]) -> Iterator[str]:
    """The figures, those of one place together."""
    groups: dict[str, list[str]] = {}
    for place, value in values.items():
        text = f"{place[-1]} {value:,.4g}" if isinstance(value, float) else f"{place[-1]} {value}"
        groups.setdefault("/".join(map(str, place[:-1])), []).append(text)
    for place, text in groups.items():
        yield textwrap.fill(f"{place}: {', '.join(text)}", 120, subsequent_indent="  ")


if __name__ == "__main__":
    run(main, Arguments, "python benchmarks/perf.py", sys.argv[1:])
