"""Levels from the files that ship, and every setting from the configs that read them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final, get_args, get_origin

import yaml
from pydantic.fields import FieldInfo
from pydantic_core import to_jsonable_python

from agents.ground.levels import FAMILIES
from pnt_gym.cells.base.catalogue import BY_SHAPE
from pnt_gym.cells.base.config import ROOT, LevelConfig, Section
from pnt_gym.cells.base.items import Item
from pnt_gym.reading import yaml_text

from .marks import attributes, fence, table

TITLES: Final = {
    "PnT": "conveyor",
    "PnTLine": "line",
    "OneJoint": "one-joint arm",
    "GripperToss": "gripper robot",
    "PnTGrasp": "cell that grasps",
}
"""Names of the families of `agents.levels` on these pages."""


def _parts(family: str, name: str) -> tuple[str, str, str]:
    """The comment at the beginning of a level's file, the name of its base, and the text after the comment."""
    text = FAMILIES[family].file_of(name).read_text(encoding="utf-8")
    head = re.match(r"(?:#.*\n)*", text)
    comment = head[0] if head else ""
    base = "" if name == ROOT else str(yaml.safe_load(text).get("base", ROOT))
    return " ".join(line.lstrip("# ") for line in comment.splitlines()), base, text.removeprefix(comment)


def _anchor(family: str, name: str) -> str:
    """Anchor of the heading of a level's file, as Sphinx and code hosts make anchors."""
    return f"{name} of the {TITLES[family]}".replace(" ", "-")


def level_table(family: str) -> str:
    """A table of a family's levels, the root of all first."""
    rows: list[tuple[str, str, str]] = []
    for name in sorted(FAMILIES[family].level_names(), key=lambda name: name != ROOT):
        comment, base, _ = _parts(family, name)
        rows.append((f"[`{name}`](#{_anchor(family, name)})", f"`{base}`" if base else "-", comment))
    return table(("level", "differs from", "what it is"), rows)


def level_files(family: str) -> str:
    """The text of every level's file."""
    blocks: list[str] = []
    for name in FAMILIES[family].level_names():
        _, _, body = _parts(family, name)
        blocks += [f"### `{name}` of the {TITLES[family]}", fence(body, "yaml")]
    return "\n\n".join(blocks)


def setting_table(family: str) -> str:
    """Every setting of a family with its default, unit and reason, without those of its parent family."""
    kind = FAMILIES[family]
    known = set() if kind.parent is None else {key for key, *_ in _settings(kind.parent, "")}
    rows = [(f"`{key}`", *facts) for key, *facts in _settings(kind, "") if key not in known]
    return table(("key", "default or *required*", "meaning"), rows)


def _settings(section: type[Section], above: str) -> Iterator[tuple[str, str, str]]:
    for name, field in section.model_fields.items():
        inner, is_many = _section(field.annotation)
        if inner is not None and issubclass(inner, LevelConfig):  # of another family, with settings of its own
            yield f"{above}{name}", _default(section, name, field), field.description or ""
            continue
        if inner is None or is_many or not isinstance(field.default, inner):
            yield f"{above}{name}", _default(section, name, field), _meaning(section, name, field)
        if inner is not None:
            yield from _settings(inner, f"{above}{name}{'[]' * is_many}.")


def _default(section: type[Section], name: str, field: FieldInfo) -> str:
    """The default of a setting; what a level needs and does not give, the level `nominal` gives."""
    if section is Item:
        return item_default(name)
    return f"that of `{ROOT}`" if issubclass(section, LevelConfig) and field.is_required() else format_default(field)


def _meaning(section: type[Section], name: str, field: FieldInfo) -> str:
    """The description of a setting, or its entry in the docstring of its section."""
    return (field.description or attributes(section).get(name, "")).replace("|", "\\|")


def _section(annotation: Any) -> tuple[type[Section] | None, bool]:
    """The section that a setting is or holds, None for another setting, and whether the setting holds many sections."""
    for kind in (annotation, *get_args(annotation)):
        if isinstance(kind, type) and issubclass(kind, Section):
            return kind, get_origin(annotation) is tuple
    return None, False


def format_default(field: FieldInfo) -> str:
    """The default of a setting, as a file of YAML writes it."""
    if field.is_required():
        return "*required*"
    value = _rounded(to_jsonable_python(field.get_default(call_default_factory=True)))
    return f"`{yaml_text([value], default_flow_style=True, width=1000).strip()[1:-1]}`"


def _rounded(value: Any) -> Any:
    """A value with its numbers to six digits, which is enough to read."""
    if isinstance(value, list):
        return [_rounded(entry) for entry in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


def item_default(name: str) -> str:
    """The default of a key of an item; an entry of a level has defaults that the item itself has not."""
    if name in BY_SHAPE:
        return "by shape"
    return "`not given`" if name == "source" else format_default(Item.model_fields[name])
