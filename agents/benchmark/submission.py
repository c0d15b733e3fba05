"""A submission: one controller on the benchmark's held-out throws, in a file of its own that anyone can verify."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from pnt_gym.cells.base.problems import list_problems

from ..ground.cli import UsageError
from ..ground.environments import import_user_module
from ..ground.places import at
from ..ground.shipped import is_shipped, module_of
from ..learning.runs import POLICY
from ..results import submission
from ..results.plan import Plan, read_plan

RUN_FILES: Final = ("args.yml", "config.yml", "env.yaml", "versions.json", POLICY)
"""Files of a run folder from which its policy can be judged."""


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
    frame = read_plan(submission.BENCHMARK)
    entry = {"label": name, "controller": controller, "throws": (throws,)}
    values = frame.model_dump(include={*submission.FRAME, "train_level"}, exclude_defaults=True)
    try:
        return Plan.model_validate({**values, "name": name, "seeds": tuple(range(seeds)), "entries": (entry,)})
    except ValidationError as error:
        raise UsageError(*list_problems(f"submission {name!r}", error, Plan)) from None


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
