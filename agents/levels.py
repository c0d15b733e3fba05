"""The levels that ship: `pnt-gym levels`, or in a checkout `python -m agents.levels`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import takewhile
from typing import Annotated, Final

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.reading import yaml_text

from .ground.cli import UsageError, option, run
from .ground.tables import Grid, console

FAMILIES: Final[dict[str, type[LevelConfig]]] = {
    "PnT": ConveyorConfig,
    "PnTLine": LineConfig,
    "OneJoint": OneJointConfig,
    "GripperToss": GripperConfig,
}
"""Class of the levels by the first letters of the environments' ids."""


@dataclass(frozen=True)
class Arguments:
    """List the levels that ship with each family of environments, or print every setting of one level.

    A level of your own is a YAML file that holds only its differences from another level, such as `base: waste`.
    """

    show: Annotated[str | None, option("the list", "FAMILY/LEVEL")] = None
    """The level to print in full, for instance PnT/waste."""


def main(arguments: Arguments) -> None:
    """Print the list of levels, or the settings of one level."""
    levels = {f"{family}/{name}": (kind, name) for family, kind in FAMILIES.items() for name in kind.level_names()}
    if arguments.show is None:
        rows = [(key, _purpose(kind, name)) for key, (kind, name) in levels.items()]
        console().print(Grid("levels that ship", ("environments / level", "what it is"), rows).terminal())
    elif arguments.show in levels:
        kind, name = levels[arguments.show]
        print(yaml_text(kind.load(name).model_dump(mode="json")), end="")
    else:
        raise UsageError(f"unknown level {arguments.show!r}; shipped levels are {', '.join(levels)}")


def _purpose(kind: type[LevelConfig], name: str) -> str:
    """The first sentence of the comment that a level's file begins with."""
    lines = kind.file_of(name).read_text(encoding="utf-8").splitlines()
    comment = [line.lstrip("# ") for line in takewhile(lambda line: line.startswith("#"), lines)]
    return re.split(r"(?<=[^l][.:])\s", " ".join(comment), maxsplit=1)[0].rstrip(".:")


if __name__ == "__main__":
    run(main, Arguments, "agents.levels")
