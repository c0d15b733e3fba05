"""Merging of a level's differences into the values of its base."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast


@dataclass(frozen=True)
class MergeRules:
    """Exceptions from merging mappings key by key; keys inside sections are written with dots."""

    alternatives: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    """Keys of a section that exclude each other: a level with one of these keys drops the others of its base."""
    wholes: frozenset[str] = frozenset()
    """Keys whose mapping replaces the mapping of the base."""
    dependents: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    """By key: keys of the base that a level drops if it gives the first key, because they speak of the old value."""


def merge_levels(below: Mapping[str, Any], above: Mapping[str, Any], rules: MergeRules) -> dict[str, Any]:
    """Values of `above` merged into those of `below`: mappings key by key, other values replace the value below.

    A section that is given as an object is complete and is not merged.
    """
    for key, dependents in rules.dependents.items():
        if _gives(above, key):
            for name in dependents:
                below = _without(below, name)
    return _merge(below, above, rules, "")


def _merge(below: Mapping[str, Any], above: Mapping[str, Any], rules: MergeRules, prefix: str) -> dict[str, Any]:
    merged = dict(below)
    for key, value in above.items():
        place, under = f"{prefix}{key}", merged.get(key)
        if isinstance(value, Mapping) and isinstance(under, Mapping) and place not in rules.wholes:
            new, old = cast("Mapping[str, Any]", value), cast("Mapping[str, Any]", under)
            group = rules.alternatives.get(place, ())
            excluded = [name for name in group if name not in new] if any(name in new for name in group) else []
            kept = {name: part for name, part in old.items() if name not in excluded}
            merged[key] = _merge(kept, new, rules, f"{place}.")
        else:
            merged[key] = value
    return merged


def _gives(level: Mapping[str, Any], place: str) -> bool:
    """Whether a level has a key, which may lie in a section."""
    key, _, inner = place.partition(".")
    value: Any = level.get(key)
    return key in level if not inner else isinstance(value, Mapping) and _gives(cast("Mapping[str, Any]", value), inner)


def _without(level: Mapping[str, Any], place: str) -> dict[str, Any]:
    """A level without a key, which may lie in a section."""
    key, _, inner = place.partition(".")
    value: Any = level.get(key)
    if not inner:
        return {name: part for name, part in level.items() if name != key}
    return (
        {**level, key: _without(cast("Mapping[str, Any]", value), inner)} if isinstance(value, Mapping) else {**level}
    )
