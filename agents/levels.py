"""The levels that ship, and files of levels: `pnt-gym levels`, or in a checkout `python -m agents.levels`."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import distribution
from pathlib import Path
from typing import Annotated

from .ground import levels
from .ground.cli import UsageError, option, run
from .ground.levels import purpose, shipped_levels, starter_text
from .ground.outputs import check_ending, deliver_text
from .ground.shipped import POLICIES, PREFIX
from .ground.tables import Grid, console


@dataclass(frozen=True)
class Arguments:
    """List the levels that ship with each family of environments, print every setting of a level, or begin a new one.

    A level of your own is a YAML file that holds only its differences from another level, such as `base: waste`.
    """

    show: Annotated[str | None, option("the list", "FAMILY/LEVEL|LEVEL|FILE.yaml")] = None
    """The level to print in full, for instance PnT/waste, skills3 or my_cell.yaml."""
    new: Annotated[Path | None, option("none", "FILE.yaml")] = None
    """Write a commented level to start from to this new file."""
    like: Annotated[str | None, option("PnT/waste", "FAMILY/LEVEL|LEVEL")] = None
    """The shipped level that a new level begins as."""
    mjcf: Annotated[Path | None, option("none", "DIR")] = None
    """Write the robots as MJCF to this new folder, each with scene, licence and notes, as in a model collection."""


def main(arguments: Arguments) -> None:
    """Print the list of levels or the settings of one level, or write a new level or the robots' models."""
    if arguments.mjcf is not None:
        write_models(arguments.mjcf)
    elif arguments.new is not None:
        file, like = arguments.new, arguments.like or "PnT/waste"
        check_ending("new", file, (".yaml", ".yml"))
        family, kind, name = levels.find(like)
        if name not in kind.level_names():
            raise UsageError(f"--like is {like!r}; it must be a shipped level, such as PnT/waste or PnTLine/skills3")
        if file.exists():
            raise UsageError(f"{str(file)!r} exists already; give --new another name")
        deliver_text(file, starter_text(kind.load(name), file.stem, f"{family}/{name}"))
        console().print(f"{file} is the level {family}/{name}; change it, and give it as --level {file}")
    elif arguments.like is not None:
        raise UsageError("--like goes with --new FILE.yaml, the file of the new level")
    elif arguments.show is not None:
        print(levels.text(arguments.show), end="")
    else:
        rows = [(f"{family}/{name}", purpose(kind, name)) for family, kind, name in shipped_levels()]
        console().print(Grid("levels that ship", ("environments / level", "what it is"), rows).terminal())
        policies = ", ".join(f"{PREFIX}{name} ({policy.env})" for name, policy in POLICIES.items())
        console().print(f"policies that ship, see `pnt-gym controllers`: {policies}")


def write_models(folder: Path) -> None:
    """Write the robots as MJCF to a new folder.

    Raises:
        UsageError: the folder exists and is not empty.
    """
    from pnt_gym.robots.collection import MODELS, write_texts  # noqa: PLC0415 - loads the engine

    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"--mjcf is {str(folder)!r}, which exists and is not empty; give another folder")
    package = distribution("pnt_gym")
    licence = package.read_text("licenses/LICENSE") or "MIT License, the pnt_gym authors\n"
    for path, text in write_texts(licence, package.version).items():
        deliver_text(folder / path, text)
    *others, last = MODELS
    console().print(
        f"{folder} has the robots {', '.join(others)} and {last}; begin with {folder / others[0] / 'scene.xml'}"
    )


if __name__ == "__main__":
    run(main, Arguments, "agents.levels")
