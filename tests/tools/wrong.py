"""What can be wrong, by type: every option of every command, and every key of every level, each with wrong values."""

import dataclasses
import math
import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple, get_args, get_origin, get_type_hints

from agents.ground.console import COMMANDS
from pnt_gym.cells.base.catalogue import TYPICAL
from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.one_joint.config import OneJointConfig

MODULES: Final = {
    **{name: module for name, (module, _) in COMMANDS.items()},
    "reproduce": "reproduce.__main__",
    "report": "report.__main__",
}
"""Module below `agents` of each command."""
LINE: Final = ("--env", "PnTLine-v0", "--controller", "atc")
NEEDED: Final[dict[str, tuple[str, ...]]] = {
    "evaluate": ("--controller", "mlp"),
    "evaluate --controller": (),
    "evaluate --release": (*LINE, "--throws", "flight"),
    "compare": ("analytic", "mlp"),
    "play": ("--picture", "x.png"),
    "publish": ("kept", "--no-onnx", "--no-video"),
    "submit": ("analytic", "--by", "me"),
    "reproduce": ("choe",),
    "fit": ("--design", "1"),
    "benchmark": ("--config", "plan.yaml"),
    "verify": ("none.json",),
    "levels --like": ("--new", "x.yaml"),
}
"""Further words that a command needs, or that a single option needs instead of these."""
FAMILIES: Final[dict[type[LevelConfig], tuple[str, str]]] = {
    ConveyorConfig: ("PnTRelease-v0", "waste_plain"),
    GraspConfig: ("PnTGrasp-v0", "grasp"),
    LineConfig: ("PnTLine-v0", "single"),
    GripperConfig: ("GripperToss-v0", "nominal"),
    OneJointConfig: ("OneJointThrow-v0", "nominal"),
}
"""An environment and a level of each family of levels."""


class Option(NamedTuple):
    """An option, or a positional argument, of a command."""

    command: str
    name: str
    kinds: tuple[Any, ...]
    """Its type and all types in it."""
    word: str
    """What begins the option; empty for a positional argument."""
    is_needed: bool

    @property
    def has_one_value(self) -> bool:
        """Whether the option takes one value, and neither none nor a list."""
        return bool not in self.kinds and not any(get_origin(kind) is tuple for kind in self.kinds)


def module_of(command: str) -> str:
    """What `python -m` runs."""
    return f"agents.{command if ' ' in command else MODULES[command].removesuffix('.__main__')}"


@cache
def options() -> tuple[Option, ...]:
    """The options of all commands."""
    found: list[Option] = []
    for command, module in MODULES.items():
        kind = import_module(f"agents.{module}").Arguments
        hints = get_type_hints(kind, include_extras=True)
        for field in dataclasses.fields(kind):
            is_positional = "Positional" in repr(field.type) or "Positional" in repr(hints[field.name])
            word = "--option" if field.name == "settings" else f"--{field.name.replace('_', '-')}"
            is_needed = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
            parts = tuple(_flat(hints[field.name]))
            found.append(Option(command, field.name, parts, "" if is_positional else word, is_needed))
    return tuple(found)


def _flat(hint: Any) -> list[Any]:
    """A type and all types in it."""
    inner = () if get_origin(hint) is Literal else get_args(hint)
    return [hint, *(part for one in inner for part in _flat(one))]


class Key(NamedTuple):
    """A key of a level with a value that it cannot have."""

    family: type[LevelConfig]
    path: tuple[str | int, ...]
    how: str
    value: Any
    unit: str = ""
    """Unit that the description of the key names, for a value below or above its range."""

    @property
    def name(self) -> str:
        """What a sentence calls the key; a line has no random bins, whatever is wrong with them."""
        name = ".".join(map(str, self.path))
        return "cell.bins.random" if name.startswith("cell.bins.random") else name.removeprefix("cell.")

    def level(self) -> dict[str, Any]:
        """A level with the wrong value."""
        level: Any = {} if self.how == "missing" else self.value
        for part in reversed(self.path[:-1] if self.how == "missing" else self.path):
            level = [level] if isinstance(part, int) else {part: level}
        return {"base": FAMILIES[self.family][1], **level}


@cache
def keys(family: type[LevelConfig]) -> tuple[Key, ...]:
    """All keys of a family of levels, each with values of another type, below and above its range, and unknown keys."""
    schema = family.model_json_schema()
    return tuple(Key(family, *case) for case in _wrong(schema, schema.get("$defs", {}), ()))


@cache
def lacks(family: type[LevelConfig]) -> tuple[Key, ...]:
    """All keys that an entry of a list needs, each left out."""
    schema = family.model_json_schema()
    return tuple(Key(family, *case) for case in _missing(schema, schema.get("$defs", {}), ()))


def _missing(
    schema: Mapping[str, Any], sections: Mapping[str, Any], place: tuple[str | int, ...]
) -> Iterator[tuple[tuple[str | int, ...], str, Any]]:
    """Place of each key that a section in a list needs; its level has an empty entry there."""
    form = _opened(schema, sections)
    for name, part in form.get("properties", {}).items():
        items = _opened(part.get("items", {}), sections)
        needed = set(items.get("required", ())) - ({*TYPICAL["box"], "source"} if name == "extra_items" else set())
        yield from (((*place, name, 0, key), "missing", None) for key in sorted(needed))
        yield from _missing(part, sections, (*place, name))


def _wrong(
    schema: Mapping[str, Any], sections: Mapping[str, Any], place: tuple[str | int, ...]
) -> Iterator[tuple[Any, ...]]:
    """Place, what is wrong, the value and a number's unit, for the part of a level that a schema describes."""
    forms = [_opened(form, sections) for form in schema.get("anyOf", [schema])]
    for form in forms:
        if "properties" in form:
            yield (*place, "nonesuch"), "unknown", 1
            for name, part in form["properties"].items():
                yield from _wrong(part, sections, (*place, name))
        for entry in (form.get("items"), *form.get("prefixItems", [])[:1]):
            yield from _wrong(entry, sections, (*place, 0)) if entry else ()
        if isinstance(form.get("additionalProperties"), dict):
            yield from _wrong(form["additionalProperties"], sections, (*place, "x"))
    if not place:
        return
    kinds = {form.get("type") for form in forms}
    yield place, "type", 5 if kinds & {"object", "array"} else [[]]
    if kinds & {"number", "integer"}:
        unit = "".join(re.findall(r"\[(.*?)\]", schema.get("description", ""))[-1:])
        yield place, "type", "zzz"
        yield place, "type", math.nan
        for how, closed, opened in (("below", "minimum", "exclusiveMinimum"), ("above", "maximum", "exclusiveMaximum")):
            values = [value for form in forms if (value := _bound(form, closed, opened)) is not None]
            yield from ((place, how, value, unit) for value in values[:1])


def _bound(form: Mapping[str, Any], closed: str, opened: str) -> float | None:
    """The nearest value beyond a bound; None where there is none."""
    if opened in form and closed not in form:
        return form[opened]
    if closed not in form:
        return None
    step = 1 if form["type"] == "integer" else 1e-3 * max(1.0, abs(form[closed]))
    return form[closed] - step if closed == "minimum" else form[closed] + step


def _opened(form: Mapping[str, Any], sections: Mapping[str, Any]) -> Mapping[str, Any]:
    """A form, or the section that the form refers to."""
    return sections[form["$ref"].rpartition("/")[2]] if "$ref" in form else form


def files_in(folder: Path) -> list[tuple[Path, int]]:
    """Files and folders in a folder, and when each file was last written."""
    return sorted((path, path.stat().st_mtime_ns if path.is_file() else 0) for path in folder.rglob("*"))
