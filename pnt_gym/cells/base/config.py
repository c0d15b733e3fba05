"""Base classes of all cell configs: frozen sections, and levels that state only their differences from another level.

A level is its `base` plus differences. A level without a `base` differs from the level `nominal` of its family, and the
values of `nominal` are the defaults of the config. Shipped levels are YAML files in a folder with the robot's name; a
user's level is a file or a mapping of the same form.
"""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import deepcopy
from functools import cache, lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Self, TypeAlias, cast, get_args, get_origin

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError, to_jsonable_python

from pnt_gym.cells.base.merging import MergeRules, merge_levels
from pnt_gym.cells.base.problems import list_problems
from pnt_gym.errors import ConfigError, PntGymError, one_sentence
from pnt_gym.names import unknown_name
from pnt_gym.reading import ReadError, number_of, parsed_yaml, text_of

LARGEST_NUMBER: Final = 1e6
"""Bound of every number in a cell, in SI units or degrees; given as `lt`, which no single field uses for its bound."""
Positive = Annotated[float, Field(gt=0, lt=LARGEST_NUMBER, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, lt=LARGEST_NUMBER, allow_inf_nan=False)]
Duration = Annotated[float, Field(ge=0, le=10, allow_inf_nan=False)]
"""Simulated time [s]."""
Finite = Annotated[float, Field(gt=-LARGEST_NUMBER, lt=LARGEST_NUMBER, allow_inf_nan=False)]
Share = Annotated[float, Field(gt=0, le=1)]
Range = tuple[Finite, Finite]
LONGEST_NAME: Final = 100
"""Largest number of characters in a name."""


def check_printable(name: str) -> str:
    """Return a name, after refusing characters that would break a line of a table or reverse the text.

    Raises:
        PydanticCustomError: a character that is not printable.
    """
    if not name.isprintable():
        raise PydanticCustomError("unprintable", "it must be of printable characters")
    return name


def check_file_name(name: str) -> str:
    """Return a name, after refusing names whose file would lie in another folder or be hidden.

    Raises:
        PydanticCustomError: a separator of paths, or a point at the beginning.
    """
    if name.startswith(".") or "/" in name or "\\" in name:
        raise PydanticCustomError("path", "files are called so; it must not hold / or \\, or begin with a point")
    return name


Label = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME), AfterValidator(check_printable)]
"""A name for people; the name may stand in a table."""
FileName = Annotated[Label, AfterValidator(check_file_name)]
"""A name for people that is also the name of files."""
Level: TypeAlias = str | Path | BaseModel | Mapping[str, Any]
"""A shipped level's name, a YAML file, a mapping in the file's form, or a config."""
ROOT: Final = "nominal"
"""The level that all others of a family differ from."""


def _types(annotation: object) -> list[object]:
    """All types and literals that an annotation names, without the types of a mapping's keys."""
    parts = get_args(annotation)
    if isinstance(origin := get_origin(annotation), type) and issubclass(origin, Mapping):
        parts = parts[1:]
    return [annotation, *(kind for part in parts for kind in _types(part))]


def leaves_of(value: object) -> list[object]:
    """All values in lists and mappings, at any depth."""
    if isinstance(value, Mapping):
        value = list(cast("Mapping[object, object]", value).values())
    if isinstance(value, list | tuple):
        return [leaf for part in cast("Sequence[object]", value) for leaf in leaves_of(part)]
    return [value]


def _is_number(text: str) -> bool:
    """Whether pydantic would read a text as a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


class Section(BaseModel):
    """Abstract: part of a config; frozen, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    former: ClassVar[Mapping[str, str]] = {}
    """Keys of earlier versions, with what replaces them."""

    @field_validator("*", mode="before")
    @classmethod
    def _numbers_are_numbers(cls, value: object, info: ValidationInfo) -> object:
        """Refuse `true` instead of 1, and '1' in quotes, also in lists."""
        kinds = _types(cls.model_fields[str(info.field_name)].annotation)
        is_open = any(kind is Any or (isinstance(kind, type) and issubclass(kind, BaseModel)) for kind in kinds)
        leaves = [value] if is_open else leaves_of(value)
        if bool not in kinds and any(isinstance(leaf, bool) for leaf in leaves):
            raise PydanticCustomError("truth", "input should be a number or a section, not true or false")
        texts = [leaf for leaf in leaves if isinstance(leaf, str) and _is_number(leaf)]
        takes_text = any(kind is str or kind is Path or isinstance(kind, str) for kind in kinds)
        if texts and not (is_open or takes_text):
            hint = quotes_hint(texts[0])
            raise PydanticCustomError("text", "input should be a number, not text{hint}", {"hint": hint})
        return value


def quotes_hint(text: str) -> str:
    """Advice against quotes around a number, as the end of a sentence; empty for other text."""
    return "" if number_of(text.strip()) is None else f"; write {text.strip()} without quotes"


def check_ranges(section: Section, where: str, *names: str) -> None:
    """Make sure that ranges of a section do not run backwards.

    Args:
        section: the section.
        where: name of the section in the level, for the error.
        names: names of fields that are a `Range`.

    Raises:
        ValueError: a range whose first value is larger.
    """
    for name in names:
        low, high = getattr(section, name)
        if low > high:
            raise ValueError(f"{where}.{name} runs from {low} to {high}; the first value must not be larger")


class LevelConfig(Section):
    """Abstract: everything that describes a cell. Subclasses name the folder of their shipped levels."""

    folder: ClassVar[str | Path]
    """Name of the robot and of the folder with the robot's shipped levels; a path for a user's levels."""
    parent: ClassVar[type[LevelConfig] | None] = None
    """Family whose shipped levels are levels of this family too; None for no such family."""
    rules: ClassVar[MergeRules] = MergeRules()
    """How a level's differences are merged into its base."""
    trial: ClassVar[str] = "throws"
    """Trial that judges controllers: "throws", "work_shifts", or MODULE:CLASS of a trial of your own."""

    name: FileName = Field(default="custom", description="Name of the level, also part of the names of run folders.")
    mismatch: Annotated[float, Field(ge=0, le=3)] = Field(
        default=1.0,
        description="Factor m on every unmodelled effect: 0 makes the planner's predictions exact, 1 is realistic.",
    )

    @classmethod
    def load(cls, level: Level = ROOT, **changes: Any) -> Self:
        """A config from a shipped level's name, a YAML file, a mapping or a config.

        Args:
            level: what describes the cell.
            changes: top-level values that replace those of the level, e.g. `mismatch=0.5`.

        Raises:
            ConfigError: no such level or file, unknown key, a value out of its range, or the config of another cell.
        """
        if isinstance(level, cls):
            data, source = level.model_dump(exclude_unset=True), f"config {level.name!r}"
        elif isinstance(level, BaseModel):
            raise ConfigError(f"level is a {type(level).__name__}; this cell is described by a {cls.__name__}")
        elif isinstance(level, Mapping):
            data, source = cls.completed(level), "config"
        else:
            if not isinstance(level, str | Path):  # pyright: ignore[reportUnnecessaryIsInstance] - users are not checked
                text = one_sentence(repr(level), 80)
                raise ConfigError(f"level is {text}; it must be a level's name, a YAML file, a mapping or a config")
            data, source = cls._from_file(level, ()), f"level file {str(level)!r}"
        data.update(changes)
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            raise ConfigError(*list_problems(source, error, cls)) from None

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        if problems := [*self.problems()]:
            raise ValueError(*problems)
        return self

    def problems(self) -> Iterator[str]:
        """A sentence for each problem of values that are possible alone, and not together."""
        yield from ()

    @classmethod
    def file_of(cls, name: str) -> Path:
        """The file of a shipped level.

        Raises:
            ConfigError: there is no such level.
        """
        return _level_file(cls.shipped_files(), name)

    @classmethod
    def shipped_files(cls) -> dict[str, Path]:
        """Files of the shipped levels by name, with those of the parent family."""
        files = {} if cls.parent is None else cls.parent.shipped_files()
        return files | {path.stem: path for path in shipped_folder(cls.folder).glob("*.yaml")}

    def ships(self) -> bool:
        """Whether the config is a shipped level, unchanged."""
        return self.name in self.shipped_files() and self == self.load(self.name)

    def assumed(self) -> dict[str, dict[str, Any]]:
        """Values of items that the level does not give and that are assumed therefore, by item and key."""
        return {}

    def files(self) -> tuple[Path, ...]:
        """Files that the level names and that change its results."""
        return ()

    @classmethod
    def level_names(cls) -> tuple[str, ...]:
        """Names of the shipped levels, without those of the parent family."""
        return tuple(sorted(path.stem for path in shipped_folder(cls.folder).glob("*.yaml")))

    @classmethod
    def _from_file(cls, level: str | Path, above: tuple[str, ...]) -> dict[str, Any]:
        """A level merged with all its bases into one mapping; `above` are the files whose `base` leads to it."""
        files = cls.shipped_files()
        if level == ROOT and ROOT not in files:  # a family without shipped levels has its defaults
            return {"name": ROOT}
        path = _level_file(files, level)
        if str(path) in above:
            circle = " -> ".join(Path(p).stem for p in (*above, str(path)))
            raise ConfigError(f"level file {str(level)!r}: levels are their own base: {circle}")
        data = {"name": path.stem, **_read(path)}
        if path == files.get(ROOT):
            return data
        return cls._complete(cls.locate(data, path.parent), (*above, str(path)))

    @classmethod
    def locate(cls, data: dict[str, Any], folder: Path) -> dict[str, Any]:
        """The differences in a level's file, with paths to the files beside it that they name."""
        return locate_files(data, folder, "base")

    @classmethod
    def _complete(cls, data: Mapping[str, Any], above: tuple[str, ...]) -> dict[str, Any]:
        """A level's differences merged into its base."""
        differences = dict(data)
        base = differences.pop("base", ROOT)
        if not isinstance(base, str | Path):
            raise ConfigError(f"base is {base!r}; it must be the name of a level or a YAML file")
        return cls.merge(cls._from_file(base, above), differences)

    @classmethod
    def completed(cls, level: Mapping[str, Any]) -> dict[str, Any]:
        """A level's differences merged into its base."""
        return cls._complete({"name": "custom", **level}, ())

    @classmethod
    def merge(cls, below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
        """Differences `above` merged into the values `below` by the rules of this family."""
        return merge_levels(below, above, cls.rules)


def locate_files(data: Mapping[str, Any], folder: Path, *keys: str) -> dict[str, Any]:
    """A section, with the paths of those files in a folder that some of its keys name."""
    places = {key: str(folder / data[key]) for key in keys if isinstance(data.get(key), str)}
    # `os.path.isfile` is False, without an error, for a name that no file can have.
    return {**data, **{key: place for key, place in places.items() if os.path.isfile(place)}}


@contextmanager
def describes_a_cell() -> Generator[None, None, None]:
    """Context in which a cell is built from a level: each number may be possible alone, and all of them not together.

    Raises:
        ConfigError: engine, memory or arithmetic refuse the numbers.
    """
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except PntGymError:
        raise
    except (ValueError, ArithmeticError, MemoryError) as error:
        reason = one_sentence(error, 120)
        raise ConfigError(
            f"the level describes no cell that can be built, because one of its numbers is too extreme: {reason}"
        ) from error


def serialize_level(level: Level) -> str | dict[str, Any]:
    """A level in JSON types: a name or path as text, a mapping or a config in the form of a level file."""
    if isinstance(level, str | Path):
        return str(level)
    if isinstance(level, BaseModel):
        return level.model_dump(mode="json", exclude_unset=True)
    return cast("dict[str, Any]", to_jsonable_python(dict(level), fallback=repr))


def shipped_folder(folder: str | Path) -> Path:
    """Path of a folder of shipped files: inside an installed wheel, or beside the package in a checkout."""
    return folder if isinstance(folder, Path) else _shipped() / folder


@cache
def _shipped() -> Path:
    package = Path(__file__).resolve().parents[2]
    installed = package / "levels"
    return installed if installed.is_dir() else package.parent / "configs" / "cells"


def _level_file(files: Mapping[str, Path], level: str | Path) -> Path:
    text = str(level)
    if text in files:
        return files[text]
    path = Path(level)
    if not path.suffix:
        raise ConfigError(unknown_name("level", text, sorted(files), ", or give a YAML file"))
    if not os.path.exists(path):  # False, without an error, for a name that no file can have
        raise ConfigError(f"level file {text!r} does not exist")
    return path


_parsed = lru_cache(maxsize=64)(parsed_yaml)
"""Of text rather than of a file, which may change; a level is read whenever an environment of it is made."""


def _read(path: Path) -> dict[str, Any]:
    try:
        data = deepcopy(_parsed(text_of(path, form="YAML")))
    except ReadError as error:
        raise ConfigError(f"cannot read level file {str(path)!r}: {error}") from None
    if not isinstance(data, dict):
        raise ConfigError(f"level file {str(path)!r} must hold a mapping of settings, it holds {type(data).__name__}")
    return cast("dict[str, Any]", data)
