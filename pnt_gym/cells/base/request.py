"""A throw that is asked for: what options of a reset say of it, and where in a row's random numbers it comes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Bools
from pnt_gym.cells.base.cell import Cell, Generators
from pnt_gym.errors import ConfigError, one_sentence

Request = Mapping[str, str]
"""A name each for those of `ASKED` that are asked for."""
ANYTHING: Final[Request] = MappingProxyType({})
ASKED: Final = ("item", "target")
MOST_DRAWS: Final = 4096
"""Throws looked at before one is said not to come: what comes once in 300 is missed once in a million requests."""
AT_FIRST: Final = 16
"""So many are looked at together, then twice as many as before: a hundred take hardly longer than ten."""
AT_ONCE: Final = 1024
"""Throws of all rows that are drawn together, at most."""


def requested(cell: Cell[Any, Any, Any, Any], options: Mapping[str, Any]) -> Request:
    """What options ask for, by name or index.

    Args:
        cell: where it is to be found.
        options: only those in `ASKED`.

    Raises:
        ConfigError: the cell has no such item or target.
    """
    return {what: _name(cell, what, given) for what, given in options.items()}


def lead(cell: Cell[Any, Any, Any, Any], generators: Generators, request: Request) -> None:
    """Set generators to where the first throw that each draws is what is asked for; the cell stays as it is.

    A generator jumps within its own sequence until that is so. Which jump is taken depends on nothing else.

    Raises:
        ConfigError: one of them does not come to it; all are as they were.
    """
    jumps, tried = np.full(len(generators), -1), 0
    while (pending := np.flatnonzero(jumps < 0)).size > 0:
        many = min(max(tried, AT_FIRST), max(AT_ONCE // pending.size, 1), MOST_DRAWS - tried)
        if many == 0:
            raise _missing(cell, request)
        scout = cell.scout([_jumped(generators[row], tried + k) for row in pending for k in range(many)])
        fits = _fits(scout, request).reshape(-1, many)
        found = fits.any(axis=1)
        jumps[pending[found]] = tried + fits[found].argmax(axis=1)
        tried += many
    for generator, jump in zip(generators, jumps, strict=True):
        generator.bit_generator.state = _jumped(generator, int(jump)).bit_generator.state


def _jumped(generator: np.random.Generator, jumps: int) -> np.random.Generator:
    """A generator of the same sequence, far ahead of this one."""
    bits: Any = generator.bit_generator
    return np.random.default_rng(bits.jumped(jumps))


def _fits(scout: Cell[Any, Any, Any, Any], request: Request) -> Bools:
    """Which rows of a cell that is only drawn from begin with what is asked for."""
    drawn = scout.first(np.arange(len(scout.generators)))
    found = {"item": drawn.kind, "target": scout.target_of(drawn)}
    fits = [np.array(_names(scout, what))[found[what]] == name for what, name in request.items()]
    return np.all(fits, axis=0)


def _names(cell: Cell[Any, Any, Any, Any], what: str) -> Sequence[str]:
    return cell.item_names if what == "item" else cell.target_names


def _name(cell: Cell[Any, Any, Any, Any], what: str, given: Any) -> str:
    names = _names(cell, what)
    if isinstance(given, str) and given in names:
        return given
    is_index = not isinstance(given, bool) and isinstance(given, Integral)
    if is_index and 0 <= int(given) < len(names):
        return names[int(given)]
    known = f"it must be one of {_listed(names)}, or an index from 0 to {len(names) - 1}"
    said = f"{what} is {one_sentence(repr(given), 80)}"
    raise ConfigError(f"{said}; {known if names else f'no {what} of level {cell.config.name!r} has a name'}")


def _missing(cell: Cell[Any, Any, Any, Any], request: Request) -> ConfigError:
    asked = " and ".join(f"{what} {name!r}" for what, name in request.items())
    there = " and ".join(f"{what}s {_listed(_names(cell, what))}" for what in request)
    said = f"{asked} did not come in {MOST_DRAWS} draws of level {cell.config.name!r}"
    return ConfigError(f"{said}, which has {there}")


def _listed(names: Sequence[str]) -> str:
    return one_sentence(", ".join(names), 150)
