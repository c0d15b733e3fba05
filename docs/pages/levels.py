"""Levels from the files that ship, and every setting from the configs that read them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final, get_args, get_origin

import yaml
from pydantic.fields import FieldInfo
from pydantic_core import to_jsonable_python

from agents.ground.levels import FAMILIES
from agents.ground.places import SHIPPED
from pnt_gym.cells.base.catalogue import BY_SHAPE
from pnt_gym.cells.base.config import ROOT, LevelConfig, Section
from pnt_gym.cells.base.items import Item
from pnt_gym.reading import yaml_text

from .marks import attributes, table

USUAL: Final = "PnT"
"""The family whose settings other families need not repeat."""


def _comment_and_base(family: str, name: str) -> tuple[str, str]:
    """The comment at the beginning of a level's file, and the name of its base."""
    text = FAMILIES[family].file_of(name).read_text(encoding="utf-8")
    comment = re.match(r"(?:#.*\n)*", text)
    base = "" if name == ROOT else str(yaml.safe_load(text).get("base", ROOT))
    return " ".join(line.lstrip("# ") for line in (comment[0] if comment else "").splitlines()), base


def level_table(family: str) -> str:
    """A table of a family's levels, the root of all first; each name leads to the level's file."""
    rows: list[tuple[str, str, str]] = []
    for name in sorted(FAMILIES[family].level_names(), key=lambda name: name != ROOT):
        comment, base = _comment_and_base(family, name)
        file = FAMILIES[family].file_of(name).relative_to(SHIPPED).as_posix()
        rows.append((f"[`{name}`](../{file})", f"`{base}`" if base else "-", comment))
    return table(("level", "differs from", "what it is"), rows)


def setting_table(family: str) -> str:
    """Every setting of a family with its default, unit and reason, without those that the conveyor or a parent has."""
    kind = FAMILIES[family]
    known = set() if kind.parent is None else {key for key, *_ in settings(kind.parent, "")}
    usual = set() if family == USUAL else {*settings(FAMILIES[USUAL], "")}
    own = (setting for setting in settings(kind, "") if setting[0] not in known and setting not in usual)
    rows = [(f"`{key}`", *facts) for key, *facts in own]
    return table(("key", "default or *required*", "meaning"), rows)


def settings(section: type[Section], above: str) -> Iterator[tuple[str, str, str]]:
    """Key, default and meaning of every setting of a section and below, without the keys of an item."""
    for name, field in section.model_fields.items():
        inner, is_many = _section(field.annotation)
        if inner is not None and issubclass(inner, LevelConfig):  # of another family, with settings of its own
            yield f"{above}{name}", _default(section, name, field), field.description or ""
            continue
        if inner is None or is_many or not isinstance(field.default, inner):
            yield f"{above}{name}", _default(section, name, field), _meaning(section, name, field)
        if inner is not None and inner is not Item:  # whose keys have a table of their own
            yield from settings(inner, f"{above}{name}{'[]' * is_many}.")


def _default(section: type[Section], name: str, field: FieldInfo) -> str:
    """The default of a setting; what a level needs and does not give, the level `nominal` gives."""
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
