"""Measure a controller on the benchmark's held-out throws, as a file that anyone can verify: `pnt-gym submit`."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from ..ground.cli import UsageError, at_least, option, run
from ..ground.cluster import Needs, pool
from ..ground.outputs import check_writable, deliver_json
from ..ground.places import MADE
from ..ground.tables import console
from ..ground.versions import versions
from ..ground.work import do_missing
from ..results.compare import assemble
from ..results.plan import pieces
from .comparison import show
from .run import jobs
from .stored import POLICIES, stored_policies
from .submission import submission_name, submission_plan, take_along


@dataclass(frozen=True)
class Arguments:
    """Let a controller learn, throw the held-out throws of the benchmark, and write the outcomes to NAME.json.

    Beside the file stands a copy of your module, or of the policy of your run folder. `pnt-gym verify NAME.json` throws
    a sample of the outcomes again.
    """

    controller: Annotated[
        str, tyro.conf.Positional, tyro.conf.arg(metavar="MODULE:CLASS|RUN_DIR|NAME", name="controller")
    ]
    """A class in one file of yours, the folder of a training run, or a controller's name."""
    by: str
    """Who submits the controller."""
    about: Annotated[str, option("none", "SENTENCE")] = ""
    """One sentence about the controller."""
    name: Annotated[str | None, option("that of the module, folder or controller", "NAME")] = None
    """Name of the submission."""
    throws: int = 0
    """Throws to learn from before the held-out ones, on the benchmark's level for learning."""
    seeds: int = 10
    """Number of learnings of a controller that learns, each from other throws."""
    jobs: int = 2
    """Processes side by side, one thread each."""
    out: Annotated[Path | None, option("results/submissions", "DIR")] = None
    """Folder of the submission."""


def main(arguments: Arguments) -> None:
    """Measure the controller, and write the submission and what it needs."""
    at_least(vars(arguments), throws=0, seeds=1, jobs=1)
    if not arguments.by.strip():
        raise UsageError("--by is empty; it must be the name of the person who hands the submission in")
    name = arguments.name or submission_name(arguments.controller)
    folder = arguments.out or MADE / "results" / "submissions"
    file = folder / f"{name}.json"
    check_writable(file)
    folder.mkdir(parents=True, exist_ok=True)
    controller = take_along(arguments.controller, name, folder)
    plan = submission_plan(name, controller, arguments.throws, arguments.seeds)
    workers = pool(arguments.jobs, None, Needs())
    parts = do_missing(jobs(pieces(plan)), MADE / "runs" / "submissions" / name, workers, unit="throws")
    results = [result for part in parts for result in part["results"]]
    comparison = assemble(plan, results)
    head = {"by": arguments.by, "about": arguments.about, "command": _command(arguments)}
    head |= {"plan": plan.model_dump(mode="json"), "versions": versions()}
    seconds = sum(part["seconds"] for part in parts)
    policies = stored_policies(parts)
    deliver_json(file, {**head, "seconds": seconds, **comparison, POLICIES: policies, "results": results}, indent=None)
    show(plan, comparison["table"])
    console().print(f"the submission is {file}; `pnt-gym verify {file}` repeats it")


def _command(arguments: Arguments) -> str:
    """The command line that gives the same throws."""
    words = ["pnt-gym", "submit", arguments.controller, "--by", arguments.by]
    words += ["--throws", str(arguments.throws), "--seeds", str(arguments.seeds)] if arguments.throws else []
    return shlex.join(words)


if __name__ == "__main__":
    run(main, Arguments, "agents.benchmark.submit")
