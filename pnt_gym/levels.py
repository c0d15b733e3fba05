"""Levels: YAML files that hold only what differs from a cell's defaults, shipped ones and a user's own.

The levels of the conveyor lie in the folder of the shipped levels itself, those of any other cell in a sub-folder
that bears its name.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol, TypeVar, cast

import yaml
from pydantic import BaseModel, ValidationError

from pnt_gym.errors import ConfigError

ConfigT = TypeVar("ConfigT", bound=BaseModel)


class LevelConfig(Protocol):
    """A cell's config, as far as all cells have it."""

    @property
    def name(self) -> str:
        """Of the level."""
        ...

    def model_dump(self, *, mode: str = "python") -> dict[str, Any]:
        """All its values."""
        ...


def read_level(
    folder: str, model: type[ConfigT], level: str | Path | BaseModel | Mapping[str, Any], changes: Mapping[str, Any]
) -> ConfigT:
    """A cell's config from a shipped level's name, a YAML file, a mapping or a config.

    Args:
        folder: sub-folder of the shipped levels that holds the cell's own; "" for the folder itself.
        model: the cell's config, with a field `name`.
        level: a shipped level's name, a path to a YAML file, a mapping in the file's form, or a config as it is.
        changes: top-level values that replace those of the level.

    Raises:
        ConfigError: no such level or file, unknown key, a value out of its range, or the config of another cell.
    """
    if isinstance(level, model):
        data, source = level.model_dump(exclude_unset=True), f"config {getattr(level, 'name', '')!r}"
    elif isinstance(level, BaseModel):
        raise ConfigError(f"level is a {type(level).__name__}; this cell is described by a {model.__name__}")
    elif isinstance(level, Mapping):
        data, source = dict(level), "config"
    else:
        path = _find(folder, level)
        data, source = _read(path), f"level file {str(level)!r}"
        data.setdefault("name", path.stem)
    data.update(changes)
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise ConfigError(f"{source}: {_first_problem(error)}") from None


def level_names(folder: str = "") -> tuple[str, ...]:
    """Names of the shipped levels in a sub-folder."""
    return tuple(sorted(path.stem for path in _shipped(folder).glob("*.yaml")))


def _shipped(folder: str) -> Path:
    """A folder of shipped levels: inside an installed wheel, or beside the package in a checkout."""
    package = Path(__file__).resolve().parent
    installed = package / "levels"
    return (installed if installed.is_dir() else package.parent / "configs" / "cells") / folder


def _find(folder: str, level: str | Path) -> Path:
    text = str(level)
    names = level_names(folder)
    if text in names:
        return _shipped(folder) / f"{text}.yaml"
    path = Path(level)
    if not path.suffix:
        raise ConfigError(f"unknown level {text!r}; shipped levels are {', '.join(names)}, or give a YAML file")
    if not path.is_file():
        raise ConfigError(f"level file {text!r} does not exist")
    return path


def _read(path: Path) -> dict[str, Any]:
    try:
        data: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(f"level file {str(path)!r} is not valid YAML: {str(error).splitlines()[0]}") from None
    if not isinstance(data, dict):
        raise ConfigError(f"level file {str(path)!r} must hold a mapping of settings, it holds {type(data).__name__}")
    return cast("dict[str, Any]", data)


def _first_problem(error: ValidationError) -> str:
    """The first complaint of pydantic as one sentence."""
    problem = error.errors()[0]
    where = ".".join(str(part) for part in problem["loc"])
    message = problem["msg"].removeprefix("Value error, ")
    if problem["type"] == "extra_forbidden":
        return f"unknown key {where!r}"
    if problem["type"] == "value_error":
        return message
    if problem["type"] == "missing":
        return f"key {where!r} is missing"
    return f"{where} is {problem['input']!r}: {message[0].lower()}{message[1:]}"
