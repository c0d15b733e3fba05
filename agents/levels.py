"""The levels that ship, and files of levels: `pnt-gym levels`, or in a checkout `python -m agents.levels`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Annotated, Final

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.reading import ReadError, yaml_of, yaml_text

from .ground.cli import UsageError, option, run
from .ground.outputs import check_ending, deliver_text
from .ground.shipped import POLICIES, PREFIX
from .ground.starters import assumed_text, starter_text
from .ground.tables import Grid, console

FAMILIES: Final[dict[str, type[LevelConfig]]] = {
    "PnT": ConveyorConfig,
    "PnTLine": LineConfig,
    "OneJoint": OneJointConfig,
    "GripperToss": GripperConfig,
    "PnTGrasp": GraspConfig,
}
"""Class of the levels by the first letters of the environments' ids."""


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


def main(arguments: Arguments) -> None:
    """Print the list of levels or the settings of one level, or write a new level."""
    if arguments.new is not None:
        write_starter(arguments.new, arguments.like or "PnT/waste")
    elif arguments.like is not None:
        raise UsageError("--like goes with --new FILE.yaml, the file of the new level")
    elif arguments.show is not None:
        print(full_text(arguments.show), end="")
    else:
        rows = [(f"{family}/{name}", purpose(kind, name)) for family, kind, name in shipped_levels()]
        console().print(Grid("levels that ship", ("environments / level", "what it is"), rows).terminal())
        policies = ", ".join(f"{PREFIX}{name} ({policy.env})" for name, policy in POLICIES.items())
        console().print(f"policies that ship, see `pnt-gym controllers`: {policies}")


def shipped_levels() -> list[tuple[str, type[LevelConfig], str]]:
    """Family, class and name of every shipped level."""
    return [(family, kind, name) for family, kind in FAMILIES.items() for name in kind.level_names()]


def find_level(text: str) -> tuple[str, type[LevelConfig], str]:
    """Family, class and name or file of a level.

    Args:
        text: FAMILY/LEVEL, the name of a level that only one family has, or a YAML file.

    Raises:
        UsageError: there is no such level, or several families have a level of this name.
    """
    family, _, name = text.partition("/")
    if family in FAMILIES and (name in FAMILIES[family].level_names() or Path(name).suffix):
        return family, FAMILIES[family], name
    if Path(text).suffix:
        family = _family_of(text)
        return family, FAMILIES[family], text
    families = [family for family, kind in FAMILIES.items() if text in kind.level_names()]
    if len(families) == 1:
        return families[0], FAMILIES[families[0]], text
    if families:
        raise UsageError(f"level {text!r} is one of {', '.join(f'{family}/{text}' for family in families)}; name one")
    names = ", ".join(f"{family}/{name}" for family, _, name in shipped_levels())
    raise UsageError(f"unknown level {text!r}; shipped levels are {names}, or give a YAML file")


def _family_of(file: str) -> str:
    """The family of a level's file: the one that has most of the file's keys, and its base."""
    try:
        data = yaml_of(file)
    except ReadError as error:
        raise UsageError(f"cannot read level file {file!r}: {error}") from None
    keys = set(data) if isinstance(data, dict) else set()
    base = data.get("base") if keys else None
    scores = {
        family: 2 * len(keys & set(kind.model_fields)) + (base in kind.level_names())
        for family, kind in FAMILIES.items()
    }
    return max(scores, key=lambda family: scores[family])


def full_text(text: str) -> str:
    """Every setting of a level as YAML; comments say which values of items are assumed."""
    _, kind, name = find_level(text)
    config = kind.load(name)
    notes = "".join(f"# {line}\n" for line in assumed_text(config).splitlines())
    return notes + yaml_text(config.model_dump(mode="json"))


def write_starter(file: Path, like: str) -> None:
    """Write a commented level to start from.

    Raises:
        UsageError: the file exists, or there is no such shipped level.
    """
    check_ending("new", file, (".yaml", ".yml"))
    family, kind, name = find_level(like)
    if name not in kind.level_names():
        raise UsageError(f"--like is {like!r}; it must be a shipped level, such as PnT/waste or PnTLine/skills3")
    if file.exists():
        raise UsageError(f"{str(file)!r} exists already; give --new another name")
    deliver_text(file, starter_text(kind.load(name), file.stem, f"{family}/{name}"))
    console().print(f"{file} is the level {family}/{name}; change it, and give it as --level {file}")


def purpose(kind: type[LevelConfig], name: str) -> str:
    """The first sentence of the comment that a level's file begins with."""
    lines = kind.file_of(name).read_text(encoding="utf-8").splitlines()
    comment = [line.lstrip("# ") for line in takewhile(lambda line: line.startswith("#"), lines)]
    return re.split(r"(?<=[^l][.:])\s", " ".join(comment), maxsplit=1)[0].rstrip(".:")


if __name__ == "__main__":
    run(main, Arguments, "agents.levels")
