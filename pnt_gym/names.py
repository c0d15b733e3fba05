"""Names that users give: the one sentence about an unknown name, and keywords that a function does not have."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Sequence
from difflib import SequenceMatcher
from functools import wraps
from typing import Any, Final, ParamSpec, TypeVar, get_args, get_type_hints

from pnt_gym.errors import ConfigError, one_sentence

MOST_TEXT: Final = 220
"""Characters of the known names in a sentence; of more names the sentence has those that are spelled most alike."""
BRIEF: Final = 80
"""The same in a clause of a longer sentence."""
ALIKE: Final = 0.7
"""Likeness, from 0 to 1, from which on a name was perhaps meant: one wrong letter of four, or two swapped of five."""
_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


def likeness(name: object, known: object) -> float:
    """How alike two names are spelled, from 0 to 1.

    Upper case, the sign between words, and what stands before the last / or : of the known name alone do not count.
    """
    plain, whole = (str(text)[:200].lower().replace("-", "_") for text in (name, known))
    last = re.split("[/:]", whole)[-1]
    others = {whole} if re.search("[/:]", plain) else {whole, last}
    return max(SequenceMatcher(None, plain, other).ratio() for other in others)


def closest_name(name: object, known: Iterable[object], alike: float = ALIKE) -> str | None:
    """The known name that was perhaps meant; None if no known name is spelled alike, or several just as much."""
    names = {str(other): likeness(name, other) for other in known}
    most = max(names.values(), default=0.0)
    best = [other for other, value in names.items() if value == most]
    return best[0] if most >= alike and len(best) == 1 else None


def unknown_name(kind: str, name: object, known: Iterable[object], further: str = "", room: int = MOST_TEXT) -> str:
    """Sentence about an unknown name; the arguments are those of `unknown_names`."""
    return unknown_names(kind, [name], known, further, room)


def unknown_names(
    kind: str, names: Sequence[object], known: Iterable[object], further: str = "", room: int = MOST_TEXT
) -> str:
    """Sentence about unknown names: the names that were perhaps meant, and the names that there are.

    Args:
        kind: what is named, such as "level".
        names: the unknown names, at least one.
        known: the names that there are.
        further: end of the sentence, such as ", or a YAML file".
        room: characters of the list of known names; of a longer list the names that are spelled most alike are there.
    """
    others = [str(other) for other in known]
    meant = dict.fromkeys(other for name in names if (other := closest_name(name, others)) is not None)
    head = f"unknown {kind}{'' if len(names) == 1 else 's'} {list_names(names)}"
    if not others:
        return f"{head}; there is none{further}"
    hint = f"; did you mean {list_names([*meant])}?" if meant else ";"
    return f"{head}{hint} known are {join_names(names, others, room)}{further}"


def list_names(names: Sequence[object]) -> str:
    """Names in quotes as a list of words: 'a', 'b' and 'c'."""
    words = [one_sentence(repr(name), 80 if len(names) == 1 else 60) for name in names]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def join_names(names: Sequence[object], known: Sequence[str], room: int = MOST_TEXT) -> str:
    """Known names with commas; if there is no room for all, those that are spelled most like some names."""
    if len(", ".join(known)) <= room:
        return ", ".join(known)
    few = list[str]()
    for other in sorted(known, key=lambda other: -max(likeness(name, other) for name in names)):
        if few and len(", ".join([*few, other])) > room:
            break
        few.append(one_sentence(other, 80))
    return f"{', '.join(few)} and {len(known) - len(few)} more"


def keywords(function: Callable[..., Any]) -> list[str]:
    """Names of the keywords that a function takes, those of an unpacked `TypedDict` included."""
    known = list[str]()
    for name, part in inspect.signature(function).parameters.items():
        if part.kind is inspect.Parameter.VAR_KEYWORD:
            (settings,) = get_args(get_type_hints(function)[name])
            known += settings.__annotations__
        elif name != "self":
            known.append(name)
    return known


def check_keywords(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """Return a function that refuses keyword arguments which it does not have, and names those that it has.

    Python would raise a TypeError without the valid names, and Gymnasium adds all arguments to a TypeError.
    """
    known = keywords(function)

    @wraps(function)
    def call(*args: _Parameters.args, **kwargs: _Parameters.kwargs) -> _Result:
        if unknown := [name for name in kwargs if name not in known]:
            raise ConfigError(unknown_names("argument", unknown, known))
        return function(*args, **kwargs)

    return call
