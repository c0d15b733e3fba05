"""The levels that ship, one level by its name or file, and levels as text."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import takewhile
from pathlib import Path
from textwrap import wrap
from typing import Any, Final

from pydantic import BaseModel

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.names import unknown_name
from pnt_gym.reading import ReadError, yaml_of, yaml_text

from .cli import UsageError
from .tables import console

WIDTH: Final = 120
SORTING: Final = ("items", "extra_items", "mix", "limits.percent", "belt.speed", "bins", "classifier")
"""Keys of a sorting cell that differ from plant to plant."""
STARTERS: Final[Mapping[type[LevelConfig], tuple[str, ...]]] = {
    ConveyorConfig: ("mismatch", *SORTING),
    LineConfig: ("cell.mismatch", *(f"cell.{key}" for key in SORTING), "robots", "arrivals", "value", "duration"),
}
"""Keys of a new level by family; new levels of other families have the keys that the old level gives."""
EXAMPLE: Final = "- {name: lid, shape: box, size: [0.07, 0.07, 0.012], mass: 0.006}"
"""An item of one's own, which a new level shows where it has none."""


def starter_text(config: LevelConfig, name: str, label: str) -> str:
    """Text of a level's file that differs from a shipped level in its name alone, with a comment on each key.

    Args:
        config: the shipped level.
        name: name of the new level.
        label: family and name of the shipped level, as `pnt-gym levels` lists it.
    """
    given: Any = yaml_of(config.file_of(config.name))
    usual = tuple(key for key in given if key not in ("name", "base"))
    head = (
        f"A level to start from: as it stands it is the level {label}. Change what differs in your cell, and leave out "
        f"what does not: a key that is left out has its value from the base. `pnt-gym levels --show {label}` prints "
        "all keys."
    )
    blocks = [_comment(head, ""), yaml_text({"name": name, "base": config.name})]
    blocks += _section(config, STARTERS.get(type(config), usual), "")
    return "\n".join(blocks)


def _section(section: BaseModel, keys: tuple[str, ...], indent: str) -> Iterator[str]:
    """Text of some keys of a section, a block each; keys with dots lie in inner sections."""
    for key in dict.fromkeys(key.partition(".")[0] for key in keys):
        value, inner = getattr(section, key), tuple(k.partition(".")[2] for k in keys if k.partition(".")[0] == key)
        if inner == ("",) and isinstance(value, BaseModel):
            inner = tuple(value.model_dump(exclude_unset=True))
        if isinstance(value, BaseModel):
            if blocks := list(_section(value, inner, f"{indent}  ")):
                yield f"{indent}{key}:\n" + "".join(blocks)
        elif key == "extra_items" and not value:
            text = _comment(type(section).model_fields[key].description or "", indent)
            yield f"{text}{indent}# {key}:\n{indent}#   {EXAMPLE}\n"
        elif value is not None:
            yield _comment(type(section).model_fields[key].description or "", indent) + _entry(section, key, indent)


def _entry(section: BaseModel, key: str, indent: str) -> str:
    """One key and its value, a list of sections line by line."""
    data: Any = section.model_dump(mode="json", include={key}, exclude_unset=True).get(key)
    data = section.model_dump(mode="json", include={key})[key] if data is None else data
    layout: dict[str, Any] = {"default_flow_style": True, "width": WIDTH - len(indent) - 24}
    if isinstance(data, list) and data and isinstance(data[0], dict):
        parts = [yaml_text(part, **layout).rstrip().replace("\n", f"\n{indent}   ") for part in data]
        return f"{indent}{key}:\n" + "".join(f"{indent}  - {part}\n" for part in parts)
    if isinstance(data, dict) and any(isinstance(part, dict) for part in data.values()):
        parts = [yaml_text({name: part}, **layout).strip()[1:-1] for name, part in data.items()]
        return f"{indent}{key}:\n" + "".join(f"{indent}  {part}\n" for part in parts)
    text = yaml_text({key: data}, **layout).strip()[1:-1].replace("\n", f"\n{indent}")
    return f"{indent}{text}\n"


def _comment(text: str, indent: str) -> str:
    return "".join(f"{indent}# {line}\n" for line in wrap(text, WIDTH - len(indent) - 2))


def assumed_text(config: LevelConfig) -> str:
    """A sentence on each item of a level's own with values that the level does not give; empty where there is none."""
    texts = {name: [f"{key} {_text(v)}" for key, v in values.items()] for name, values in config.assumed().items()}
    return "\n".join(f"{name}: assumed, as the level does not say: {', '.join(text)}" for name, text in texts.items())


def values(config: Any) -> dict[str, Any]:
    """What is assumed of a level's own items, as an entry of a result; empty where nothing is."""
    values = config.assumed() if isinstance(config, LevelConfig) else {}
    items = {name: {key: _as_json(value) for key, value in of_item.items()} for name, of_item in values.items()}
    return {"assumed": items} if items else {}


def show(config: Any) -> None:
    """Print what is assumed of a level's own items, if anything is."""
    text = assumed_text(config) if isinstance(config, LevelConfig) else ""
    if text:
        console().print(text)


def _as_json(value: Any) -> Any:
    """A value of a level as a value of JSON."""
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    return [_as_json(part) for part in value] if isinstance(value, tuple) else value


def _text(value: Any) -> str:
    if isinstance(value, tuple) and any(isinstance(part, BaseModel) for part in value):
        return f"({len(value)} of them)"
    return f"{value:g}" if isinstance(value, float) else str(value)


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


def find(text: str) -> tuple[str, type[LevelConfig], str]:
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
        # The family of a level's file: the one that has most of the file's keys, and its base.
        try:
            data = yaml_of(text)
        except ReadError as error:
            raise UsageError(f"cannot read level file {text!r}: {error}") from None
        keys = set(data) if isinstance(data, dict) else set()
        base = data.get("base") if keys else None
        scores = {
            family: 2 * len(keys & set(kind.model_fields)) + (base in kind.level_names())
            for family, kind in FAMILIES.items()
        }
        family = max(scores, key=lambda family: scores[family])
        return family, FAMILIES[family], text
    families = [family for family, kind in FAMILIES.items() if text in kind.level_names()]
    if len(families) == 1:
        return families[0], FAMILIES[families[0]], text
    if families:
        raise UsageError(f"level {text!r} is one of {', '.join(f'{family}/{text}' for family in families)}; name one")
    names = [f"{family}/{name}" for family, _, name in shipped_levels()]
    raise UsageError(unknown_name("level", text, names, ", or give a YAML file"))


def text(text: str) -> str:
    """Every setting of a level as YAML; comments say which values of items are assumed."""
    _, kind, name = find(text)
    config = kind.load(name)
    notes = "".join(f"# {line}\n" for line in assumed_text(config).splitlines())
    return notes + yaml_text(config.model_dump(mode="json"))


def purpose(kind: type[LevelConfig], name: str) -> str:
    """The first sentence of the comment that a level's file begins with."""
    lines = kind.file_of(name).read_text(encoding="utf-8").splitlines()
    comment = [line.lstrip("# ") for line in takewhile(lambda line: line.startswith("#"), lines)]
    return re.split(r"(?<=[^l][.:])\s", " ".join(comment), maxsplit=1)[0].rstrip(".:")
