"""The levels that ship, by family, and one level by its name or file."""

from __future__ import annotations

import re
from itertools import takewhile
from pathlib import Path
from typing import Final

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.names import unknown_name
from pnt_gym.reading import ReadError, yaml_of, yaml_text

from .cli import UsageError
from .starters import assumed_text

FAMILIES: Final[dict[str, type[LevelConfig]]] = {
    "PnT": ConveyorConfig,
    "PnTLine": LineConfig,
    "OneJoint": OneJointConfig,
    "GripperToss": GripperConfig,
    "PnTGrasp": GraspConfig,
}
"""Class of the levels by the first letters of the environments' ids."""


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
    names = [f"{family}/{name}" for family, _, name in shipped_levels()]
    raise UsageError(unknown_name("level", text, names, ", or give a YAML file"))


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


def purpose(kind: type[LevelConfig], name: str) -> str:
    """The first sentence of the comment that a level's file begins with."""
    lines = kind.file_of(name).read_text(encoding="utf-8").splitlines()
    comment = [line.lstrip("# ") for line in takewhile(lambda line: line.startswith("#"), lines)]
    return re.split(r"(?<=[^l][.:])\s", " ".join(comment), maxsplit=1)[0].rstrip(".:")
