"""The complaints of pydantic about a level as sentences: one for each key that is wrong."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, TypeAlias, cast, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pnt_gym.errors import one_sentence
from pnt_gym.names import BRIEF, closest_name, join_names

MOST_LINES: Final = 12
"""Problems that an error lists; of more it says how many."""
_FORM: Final = re.compile(r"(constrained-)?(float|int|str|bool)|[a-z-]+\[.*\]")
"""What pydantic adds to the place of a value that may have one of several forms: the form that it tried."""
_UNIT: Final = re.compile(r"\[([^\]]+)\]\.?$")
_BOUNDS: Final = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}
"""Kinds of pydantic's complaints about numbers beyond a bound."""
_LENGTHS: Final = {"too_short", "too_long"}
"""Kinds of pydantic's complaints about the length of a list."""
Place: TypeAlias = tuple[int | str, ...]


def list_problems(subject: str, error: ValidationError, kind: type[BaseModel]) -> tuple[str, ...]:
    """Arguments of an error about a config: one sentence, or a head and a line for each problem.

    Args:
        subject: where the config stands, for the beginning of the sentence or of the head.
        error: the complaints.
        kind: class of the config, for the keys that were perhaps meant.
    """
    found = [
        cast("ErrorDetails", {**problem, "loc": _without_form(problem["loc"], kind)}) for problem in error.errors()
    ]
    problems = [*dict.fromkeys(_problems(found, kind))]
    if len(problems) == 1:
        return (f"{subject}: {problems[0]}",)
    rest = len(problems) - MOST_LINES
    shown = problems if rest <= 0 else [*problems[:MOST_LINES], f"and {rest} more"]
    return (f"{subject} has {len(problems)} problems:", *shown)


def _without_form(place: Place, kind: type[BaseModel]) -> Place:
    """The place of a value without the section's class, which pydantic adds where text may stand for the section."""
    if len(place) < 2:
        return place
    field = kind.model_fields.get(str(place[0]))
    forms = () if field is None else get_args(field.annotation)
    is_form = any(
        isinstance(form, type) and issubclass(form, BaseModel) and form.__name__ == place[1] for form in forms
    )
    return (place[0], *place[2:]) if is_form else place


def _problems(problems: Sequence[ErrorDetails], kind: type[BaseModel]) -> Iterator[str]:
    """A sentence about each unknown or former key, then about each missing key, then about each impossible value."""
    for problem in problems:
        if problem["type"] == "extra_forbidden":
            # An unknown key, with the key that was perhaps meant: one that is spelled alike, or that stands elsewhere.
            place = problem["loc"]
            key, section = str(place[-1]), _section_at(kind, place[:-1])
            former: Mapping[str, str] = getattr(section, "former", {})
            if key in former:
                yield f"key {_text(place)!r} is of an earlier version; {former[key]}"
                continue
            known = list(section.model_fields) if section else []
            alike = closest_name(key, known)
            hints = (
                [_text((*place[:-1], alike))]
                if alike
                else [path for path in _paths(kind) if path.split(".")[-1] == key]
            )
            if len(hints) == 1:
                further = f" (perhaps {hints[0]})"
            else:
                further = f"; known are {join_names([key], known, BRIEF)}" if known else ""
            yield f"unknown key {one_sentence(repr(_text(place)), 80) + further}"
    for problem in problems:
        if _is_missing_key(problem):
            yield f"key {_text(problem['loc'])!r} is missing"
    yield from _wrong_values(problems, kind)


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
        if problem["type"] == "too_short" and any(
            other["loc"][: len(place)] == place and other["loc"] != place for other in problems
        ):
            continue  # pydantic does not count wrong values
        is_form = len(place) > 1 and _FORM.fullmatch(str(place[-1]))
        is_short = problem["type"] == "missing"  # a list of fixed length that ends too early
        forms.setdefault(place[:-1] if is_form or is_short else place, []).append(problem)
    for place, complaints in forms.items():
        if complaints[0]["type"] == "value_error":
            yield from map(str, complaints[0].get("ctx", {})["error"].args)  # of the check's own ValueError
        else:
            value = one_sentence(repr(complaints[0]["input"]), 80)
            if complaints[-1]["type"] == "missing":
                message = f"input should have {cast('int', complaints[-1]['loc'][-1]) + 1} values"
            else:
                message = ", or ".join(_message(problem, place, kind) for problem in complaints)
            yield f"{_text(place) or 'it'} is {value}: {message}"


def _message(problem: ErrorDetails, place: Place, kind: type[BaseModel]) -> str:
    if problem["type"] in ("model_type", "model_attributes_type", "dict_type"):
        section = _section_at(kind, place)
        if section is None:
            return "input should be a section"
        # Keys that make clear what a section is: those that are needed, or the first ones.
        needed = [name for name, field in section.model_fields.items() if field.is_required()]
        *before, last = (needed or list(section.model_fields))[:3]
        return f"input should be a section, with {'keys ' + ', '.join(before) + ' and' if before else 'key'} {last}"
    if problem["type"] == "tuple_type":
        example = "" if problem["input"] is None else f", as in [{one_sentence(problem['input'], 40)}]"
        return f"input should be a list{example}"
    keys = [index for index, part in enumerate(place) if isinstance(part, str)]
    section = _section_at(kind, place[: keys[-1]]) if keys and problem["type"] in _BOUNDS else None
    field = None if section is None else section.model_fields.get(str(place[keys[-1]]))
    unit = ""
    if field is not None:
        # The unit of a number stands at the end of the description of its key.
        extra, found = cast("dict[str, str] | None", field.json_schema_extra), _UNIT.search(field.description or "")
        unit = f" {extra['unit'] if extra else found[1] if found else ''}"
    words = f"{problem['msg'][0].lower()}{problem['msg'][1:]}".removeprefix("tuple ").replace(" after validation", "")
    hint = ""
    if problem["type"] == "literal_error":
        meant = closest_name(problem["input"], re.findall(r"'([^']*)'", problem["msg"]))
        hint = "" if meant is None else f"; did you mean {meant!r}?"
    return f"{'input ' if problem['type'] in _LENGTHS else ''}{words}{unit}".rstrip() + hint


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
