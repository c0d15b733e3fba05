"""The complaints of pydantic about a level as one sentence that names everything that is wrong."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Final, TypeAlias, TypeVar, cast, final, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pnt_gym.errors import ConfigError, one_sentence
from pnt_gym.names import BRIEF, closest_name, join_names

MOST_TEXT: Final = 380
"""Characters of a sentence about a level, with room for the name of its file."""
MOST_KEYS: Final = 8
"""Keys that a sentence names."""
_FORM: Final = re.compile(r"(constrained-)?(float|int|str|bool)|[a-z-]+\[.*\]")
"""What pydantic adds to the place of a value that may have one of several forms: the form that it tried."""
_UNIT: Final = re.compile(r"\[([^\]]+)\]\.?$")
_BOUNDS: Final = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}
"""Kinds of pydantic's complaints about numbers beyond a bound."""
_LENGTHS: Final = {"too_short", "too_long"}
"""Kinds of pydantic's complaints about the length of a list."""
Place: TypeAlias = tuple[int | str, ...]
Checks: TypeAlias = Iterator[Callable[[], Iterator[str]]]
"""Checks of a config; each yields a clause for every problem."""
FAILURES: Final = (TypeError, ValueError, AttributeError, LookupError, ArithmeticError, ConfigError)
"""What a check may raise that meets an impossible value."""


def describe_problems(error: ValidationError, kind: type[BaseModel], further: Sequence[str] = ()) -> str:
    """All complaints of pydantic as one sentence: unknown keys, missing keys, and values that are not possible.

    Args:
        error: the complaints.
        kind: class of the config, for the keys that were perhaps meant.
        further: clauses that the whole config would yield, which pydantic checks only if all values are possible.
    """
    problems = error.errors()
    strangers = [p["loc"] for p in problems if p["type"] == "extra_forbidden"]
    unknown = [_unknown_key(place, kind, alone=len(strangers) == 1) for place in strangers]
    missing = [repr(_text(p["loc"])) for p in problems if _is_missing_key(p)]
    clauses = [
        *([f"unknown {_keys(unknown)}"] if unknown else []),
        *([f"{_keys(missing)} {'is' if len(missing) == 1 else 'are'} missing"] if missing else []),
        *_wrong_values(problems, kind),
        *(further if all(p["loc"] for p in problems) else ()),
    ]
    return join_clauses(clauses)


def join_clauses(clauses: Sequence[str]) -> str:
    """Clauses as one sentence of a bounded length; the first one always stands there, and the rest is counted."""
    text, *following = dict.fromkeys(clauses)
    for index, clause in enumerate(following):
        if len(text) + len(clause) > MOST_TEXT:
            return f"{text}; and {len(following) - index} more"
        text = f"{text}; {clause}"
    return text


def _keys(words: Sequence[str]) -> str:
    """Keys as a list of words; of very many the first ones."""
    if len(words) > MOST_KEYS:
        words = [*words[: MOST_KEYS - 1], f"{len(words) - MOST_KEYS + 1} more"]
    return f"key {words[0]}" if len(words) == 1 else f"keys {', '.join(words[:-1])} and {words[-1]}"


def _text(place: Place) -> str:
    return ".".join(str(part) for part in place)


def _is_missing_key(problem: ErrorDetails) -> bool:
    return problem["type"] == "missing" and isinstance(problem["loc"][-1], str)


def _wrong_values(problems: Sequence[ErrorDetails], kind: type[BaseModel]) -> Iterator[str]:
    """A clause about each value that is not possible; a value of several forms gets one clause."""
    forms: dict[Place, list[ErrorDetails]] = {}
    for problem in problems:
        place = problem["loc"]
        if problem["type"] == "extra_forbidden" or _is_missing_key(problem):
            continue
        if problem["type"] == "too_short" and any(_is_within(place, other["loc"]) for other in problems):
            continue  # pydantic does not count wrong values
        is_form = len(place) > 1 and _FORM.fullmatch(str(place[-1]))
        is_short = problem["type"] == "missing"  # a list of fixed length that ends too early
        forms.setdefault(place[:-1] if is_form or is_short else place, []).append(problem)
    for place, complaints in forms.items():
        if complaints[0]["type"] == "value_error":
            yield complaints[0]["msg"].removeprefix("Value error, ")
        else:
            value = one_sentence(repr(complaints[0]["input"]), 80)
            if complaints[-1]["type"] == "missing":
                message = f"input should have {cast('int', complaints[-1]['loc'][-1]) + 1} values"
            else:
                message = ", or ".join(_message(problem, place, kind) for problem in complaints)
            yield f"{_text(place) or 'it'} is {value}: {message}"


def _is_within(place: Place, part: Place) -> bool:
    return part[: len(place)] == place and part != place


def _message(problem: ErrorDetails, place: Place, kind: type[BaseModel]) -> str:
    if problem["type"] in ("model_type", "model_attributes_type", "dict_type"):
        section = _section_at(kind, place)
        return f"input should be a section{'' if section is None else f', with {_first_keys(section)}'}"
    if problem["type"] == "tuple_type":
        example = "" if problem["input"] is None else f", as in [{one_sentence(problem['input'], 40)}]"
        return f"input should be a list{example}"
    unit = f" {_unit_at(kind, place)}" if problem["type"] in _BOUNDS else ""
    words = f"{problem['msg'][0].lower()}{problem['msg'][1:]}".removeprefix("tuple ").replace(" after validation", "")
    hint = ""
    if problem["type"] == "literal_error":
        meant = closest_name(problem["input"], re.findall(r"'([^']*)'", problem["msg"]))
        hint = "" if meant is None else f"; did you mean {meant!r}?"
    return f"{'input ' if problem['type'] in _LENGTHS else ''}{words}{unit}".rstrip() + hint


def _unit_at(kind: type[BaseModel], place: Place) -> str:
    """Unit of a number, from the end of the description of its key; empty where there is none."""
    keys = [index for index, part in enumerate(place) if isinstance(part, str)]
    section = _section_at(kind, place[: keys[-1]]) if keys else None
    field = None if section is None else section.model_fields.get(str(place[keys[-1]]))
    if field is None:
        return ""
    extra = cast("dict[str, str] | None", field.json_schema_extra)
    unit = _UNIT.search(field.description or "")
    return extra["unit"] if extra else unit[1] if unit else ""


def _first_keys(section: type[BaseModel]) -> str:
    """Keys that make clear what a section is: those that are needed, or the first ones."""
    needed = [name for name, field in section.model_fields.items() if field.is_required()]
    return _keys((needed or list(section.model_fields))[:3])


def _unknown_key(place: Place, kind: type[BaseModel], *, alone: bool) -> str:
    """An unknown key, with the key that was perhaps meant: one that is spelled alike, or that stands elsewhere.

    A key that is alone and like no other is followed by keys that there are.
    """
    key, section = str(place[-1]), _section_at(kind, place[:-1])
    known = list(section.model_fields) if section else []
    alike = closest_name(key, known)
    hints = [_text((*place[:-1], alike))] if alike else [path for path in _paths(kind) if path.split(".")[-1] == key]
    if len(hints) == 1:
        further = f" (perhaps {hints[0]})"
    else:
        further = f"; known are {join_names([key], known, BRIEF)}" if alone and known else ""
    return one_sentence(repr(_text(place)), 80) + further


def _sections_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """The sections that an annotation names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _sections_in(part)


def _section_at(kind: type[BaseModel], place: Place) -> type[BaseModel] | None:
    """The class of the section at a place; None where there is none."""
    section: type[BaseModel] | None = kind
    for part in place:
        if isinstance(part, str) and section is not None:
            field = section.model_fields.get(part)
            section = None if field is None else next(_sections_in(field.annotation), None)
    return section


def _paths(kind: type[BaseModel], above: str = "") -> Iterator[str]:
    """Paths of all keys of single sections."""
    for name, field in kind.model_fields.items():
        yield f"{above}{name}"
        section = next(_sections_in(field.annotation), None)
        if section is not None and get_origin(field.annotation) is not tuple:
            yield from _paths(section, f"{above}{name}.")


@final
class Impossible:
    """Stands for a value that is not possible: whatever computes or compares with it fails."""

    __hash__: ClassVar[None] = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        raise TypeError("the value is not possible")

    def __bool__(self) -> bool:
        raise TypeError("the value is not possible")


def without_impossible(kind: type[BaseModel], data: Mapping[str, Any]) -> dict[str, Any]:
    """A config's data with `Impossible` for every value of which pydantic complains.

    Sections and lists whose own check fails stay, because their parts are possible.
    """
    values, problems = cast("dict[str, Any]", _open(data)), list[ErrorDetails]()
    try:
        kind.model_validate(data)
    except ValidationError as error:
        problems = error.errors()
    for problem in problems:
        above: Any = {}
        part: Any = values
        last: int | str = ""
        for key in problem["loc"]:
            if not _has(part, key):  # the form that pydantic tried
                break
            above, last, part = part, key, part[key]
        if not (problem["type"] in ("missing", "value_error") and isinstance(part, dict | list)):
            above[last] = Impossible()
    return values


def _open(value: Any) -> Any:
    """A copy of a level's mappings and lists."""
    if isinstance(value, Mapping):
        return {key: _open(entry) for key, entry in cast("Mapping[Any, Any]", value).items()}
    return [_open(entry) for entry in cast("Sequence[Any]", value)] if isinstance(value, list | tuple) else value


def _has(part: Any, key: int | str) -> bool:
    if isinstance(part, list):
        return isinstance(key, int) and key < len(cast("list[Any]", part))
    return isinstance(part, dict) and key in part


LooseConfig = TypeVar("LooseConfig", bound=BaseModel)


def construct_loosely(kind: type[LooseConfig], data: Mapping[str, Any]) -> LooseConfig:
    """A config with sections and defaults, of values that are not validated."""
    values: dict[str, Any] = {}
    for name in kind.model_fields.keys() & data.keys():
        section = next(_sections_in(kind.model_fields[name].annotation), None)
        values[name] = _part(section, data[name])
    return kind.model_construct(**values)


def _part(section: type[BaseModel] | None, value: Any) -> Any:
    """A value of a config that is not validated; mappings are sections where the config has sections."""
    if isinstance(value, list | tuple):
        return tuple(_part(section, entry) for entry in cast("Sequence[Any]", value))
    if section is not None and isinstance(value, Mapping):
        return construct_loosely(section, cast("Mapping[str, Any]", value))
    return value


def check_all(checks: Checks) -> None:
    """Make sure that no check finds a problem.

    Raises:
        ValueError: one does; the message names all problems.
    """
    clauses = [clause for check in checks for clause in check()]
    if clauses:
        raise ValueError(join_clauses(clauses))
