"""Measure a controller on held-out throws or shifts, as a result that anyone can verify: `pnt-gym submit`."""

from __future__ import annotations

import shlex
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

import tyro
from pydantic import ValidationError

from pnt_gym.cells.base.problems import list_problems

from ..ground.cli import UsageError, at_least, check_known, option, run
from ..ground.cluster import Needs, pool
from ..ground.environments import import_user_module
from ..ground.places import MADE, at
from ..ground.shipped import is_shipped, module_of
from ..ground.tables import console
from ..ground.work import keep_missing
from ..learning.runs import POLICY
from ..results import compare, content
from ..results.plan import Plan, read_plan
from .comparison import Comparison

RUN_FILES: Final = ("args.yml", "config.yml", "env.yaml", "versions.json", POLICY)
"""Files of a run folder from which its policy can be judged."""
NUMBERS: Final = ".npz"
"""Ending of a file beside a module with the numbers that the module reads."""
MOST_BYTES: Final = 400_000
"""Size of such a file: as of a policy that a benchmark stores."""


@dataclass(frozen=True)
class Arguments:
    """Let a controller learn, throw a benchmark's held-out throws or work its shifts, and write NAME.json.

    The throws lie in the folder NAME beside the file, and a copy of your module, or of the policy of your run folder,
    stands there too. Numbers that your module reads go along if they lie beside it in a file of its name, MODULE.npz.
    `pnt-gym verify NAME.json` throws a sample of the outcomes again.
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
    env: Annotated[str | None, option("PnTRelease-v0", "ID")] = None
    """PnTRelease-v0, PnTGrasp-v0 or PnTLine-v0: the environment whose benchmark has the held-out throws or shifts."""
    learned_from: int = 0
    """Throws that your policy has learned from already, as you say; those of --throws are counted."""
    throws: int = 0
    """Throws to learn from before the held-out ones, on the benchmark's level for learning."""
    seeds: int = 5
    """Number of learnings of a controller that learns, each from other throws; as many as the benchmark has."""
    jobs: int = 2
    """Processes side by side, one thread each."""
    out: Annotated[Path | None, option("results/submissions", "DIR")] = None
    """Folder of the submission."""


def main(arguments: Arguments) -> None:
    """Measure the controller, and write the submission and what it needs."""
    at_least(vars(arguments), throws=0, learned_from=0, seeds=1, jobs=1)
    env = arguments.env or next(iter(compare.BENCHMARKS))
    check_known("environment", [env], compare.BENCHMARKS)
    if arguments.throws and arguments.learned_from:
        raise UsageError("--learned-from is of a policy that has learned; a controller with --throws learns here")
    if not arguments.by.strip():
        raise UsageError("--by is empty; it must be the name of the person who hands the submission in")
    name = arguments.name or submission_name(arguments.controller)
    folder = arguments.out or MADE / "results" / "submissions"
    file = folder / f"{name}.json"
    content.check(file)
    folder.mkdir(parents=True, exist_ok=True)
    controller = take_along(arguments.controller, name, folder)
    plan = _plan(name, env, controller, arguments.throws, arguments.seeds)
    # The command line that gives the same throws.
    words = ["pnt-gym", "submit", arguments.controller, "--by", arguments.by]
    words += ["--throws", str(arguments.throws), "--seeds", str(arguments.seeds)] if arguments.throws else []
    words += ["--env", arguments.env] if arguments.env else []
    words += ["--learned-from", str(arguments.learned_from)] if arguments.learned_from else []
    about: dict[str, Any] = {"by": arguments.by, "about": arguments.about, "command": shlex.join(words)}
    about |= {"learned_from": arguments.learned_from} if arguments.learned_from else {}
    planned = Comparison(plan, file, about=about)
    workers = pool(arguments.jobs, None, Needs())
    planned.write(keep_missing(planned.jobs, MADE / "runs" / "submissions" / name, workers, unit=planned.unit))
    console().print(f"the submission is {file}; `pnt-gym verify {file}` repeats it")


def _plan(name: str, env: str, controller: str, throws: int, seeds: int) -> Plan:
    """The plan of a submission: one entry on the benchmark's held-out throws.

    Args:
        name: name of the submission, and label of its entry.
        env: environment of the benchmark.
        controller: as an entry of a benchmark's plan names it.
        throws: throws to learn from before the held-out ones; 0 for none.
        seeds: number of learnings, of a controller that learns.

    Raises:
        UsageError: the controller is unknown, or has to learn and may not, or the reverse.
    """
    frame = read_plan(compare.BENCHMARKS[env])
    entry = {"label": name, "controller": controller, "throws": (throws,)}
    values = frame.model_dump(include={*compare.FRAME, "train_level"}, exclude_defaults=True)
    try:
        return Plan.model_validate({**values, "name": name, "seeds": tuple(range(seeds)), "entries": (entry,)})
    except ValidationError as error:
        raise UsageError(*list_problems(f"submission {name!r}", error, Plan)) from None


def submission_name(controller: str) -> str:
    """The usual name of a submission: that of the module, of the run folder, or of the controller."""
    return module_of(controller) or (controller.rpartition(":")[2] if is_shipped(controller) else Path(controller).stem)


def take_along(controller: str, name: str, folder: Path) -> str:
    """Copy what a submission needs beside its file; return the name of the controller there.

    A user's module is copied as it is with the numbers beside it, and a run folder without its checkpoints. Other
    controllers need nothing.

    Raises:
        UsageError: the module is no single file or has another name than the submission, or a file is missing or too
            large.
    """
    if (module := module_of(controller)) is not None:
        file = Path(import_user_module(module).__file__ or "")
        if file.name != f"{module}.py":
            raise UsageError(f"module {module!r} is not one file in the working folder; a submission is one .py file")
        if module != name:
            raise UsageError(f"--name is {name!r}; a submission has the name of its module, {module!r}")
        _copy(file, folder / file.name)
        if (numbers := file.with_suffix(NUMBERS)).is_file():
            if numbers.stat().st_size > MOST_BYTES:
                raise UsageError(
                    f"{numbers.name} has {numbers.stat().st_size:,} bytes; at most {MOST_BYTES:,} go along"
                )
            _copy(numbers, folder / numbers.name)
        return controller
    if is_shipped(controller) or not at(controller).is_dir():
        return controller
    target = folder / name
    for file in (at(controller) / part for part in RUN_FILES):
        if not file.is_file():
            raise UsageError(f"run folder {controller!r} has no {file.name}")
        _copy(file, target / file.name)
    return str(target) if len(target.parts) > 1 else f"./{target}"


def _copy(file: Path, target: Path) -> None:
    """Copy a file, unless the file is there already."""
    if file.resolve() != target.resolve():
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, target)


if __name__ == "__main__":
    run(main, Arguments, "agents.benchmark.submit")
