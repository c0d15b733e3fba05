"""A submission: one controller on the benchmark's held-out throws, in a file of its own that anyone can verify."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from pnt_gym.cells.base.problems import describe_problems

from ..ground.cli import UsageError
from ..ground.environments import import_user_module
from ..ground.files import check_form
from ..ground.places import SHIPPED, at
from ..ground.shipped import is_shipped, module_of
from ..learning.runs import POLICY
from .plan import Plan, read_plan

BENCHMARK: Final = SHIPPED / "configs" / "benchmark.yaml"
"""Plan whose held-out throws every submission throws."""
FRAME: Final = ("env", "levels", "inline", "picks", "picks_on", "seed", "num_envs")
"""Keys of a plan by which held-out throws are named."""
RUN_FILES: Final = ("args.yml", "config.yml", "env.yaml", "versions.json", POLICY)
"""Files of a run folder from which its policy can be judged."""
ABOUT: Final = ("by", "about", "command")
"""What a submission says of itself, beside what a benchmark's file says."""


def submission_plan(name: str, controller: str, throws: int, seeds: int) -> Plan:
    """The plan of a submission: one entry on the benchmark's held-out throws.

    Args:
        name: name of the submission, and label of its entry.
        controller: as an entry of a benchmark's plan names it.
        throws: throws to learn from before the held-out ones; 0 for none.
        seeds: number of learnings, of a controller that learns.

    Raises:
        UsageError: the controller is unknown, or has to learn and may not, or the reverse.
    """
    frame = read_plan(BENCHMARK)
    entry = {"label": name, "controller": controller, "throws": (throws,)}
    values = frame.model_dump(include={*FRAME, "train_level"}, exclude_defaults=True)
    try:
        return Plan.model_validate({**values, "name": name, "seeds": tuple(range(seeds)), "entries": (entry,)})
    except ValidationError as error:
        raise UsageError(f"submission {name!r}: {describe_problems(error, Plan)}") from None


def submission_name(controller: str) -> str:
    """The usual name of a submission: that of the module, of the run folder, or of the controller."""
    return module_of(controller) or (controller.rpartition(":")[2] if is_shipped(controller) else Path(controller).stem)


def take_along(controller: str, name: str, folder: Path) -> str:
    """Copy what a submission needs beside its file; return the name of the controller there.

    A user's module is copied as it is, and a run folder without its checkpoints. Other controllers need nothing.

    Raises:
        UsageError: the module is no single file or has another name than the submission, or a file is missing.
    """
    module = module_of(controller)
    if module is not None:
        return _take_module(controller, module, name, folder)
    if is_shipped(controller) or not at(controller).is_dir():
        return controller
    source, target = at(controller), folder / name
    if source.resolve() != target.resolve():
        target.mkdir(parents=True, exist_ok=True)
        for file in RUN_FILES:
            if not (source / file).is_file():
                raise UsageError(f"run folder {str(source)!r} has no {file}")
            shutil.copyfile(source / file, target / file)
    return str(target) if len(target.parts) > 1 else f"./{target}"


def _take_module(controller: str, module: str, name: str, folder: Path) -> str:
    imported = import_user_module(module)
    file = Path(imported.__file__ or "")
    if hasattr(imported, "__path__") or "." in module or file.suffix != ".py":
        raise UsageError(f"module {module!r} is not one file in the working folder; a submission is one .py file")
    if module != name:
        raise UsageError(f"--name is {name!r}; a submission has the name of its module, {module!r}")
    if file.resolve() != (folder / file.name).resolve():
        shutil.copyfile(file, folder / file.name)
    return controller


def is_submission(data: Mapping[str, Any]) -> bool:
    """Whether the content of a file of results is that of a submission."""
    return not data.keys().isdisjoint(ABOUT)


def check_submission(path: Path, data: Mapping[str, Any], plan: Plan) -> None:
    """Check the content of a submission's file, with the plan in it.

    Raises:
        UsageError: the file has another form, or its throws are not the benchmark's.
    """
    with check_form(path):
        missing = [name for name in (*ABOUT, "versions", "table") if name not in data]
        digests = [row["digests"]["code"] and row["digests"]["policy"] for row in data["results"]]
        labels = {row["label"] for row in data["results"]}
    if missing:
        raise UsageError(f"submission {str(path)!r} has no {missing[0]!r}")
    if not digests or not all(digests) or labels != {path.stem}:
        raise UsageError(f"submission {str(path)!r}: its rows must have the label {path.stem!r} and digests")
    frame = read_plan(BENCHMARK)
    for key in FRAME:
        if getattr(plan, key) != getattr(frame, key):
            raise UsageError(
                f"submission {str(path)!r} has {key} {getattr(plan, key)!r}; the benchmark has {getattr(frame, key)!r}"
            )
