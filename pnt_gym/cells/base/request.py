"""Requests of a first throw: options of a reset name item and target, and a search finds generators that draw them."""

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
"""Requested names by the options in `ASKED`; options without a request are absent."""
ANYTHING: Final[Request] = MappingProxyType({})
ASKED: Final = ("item", "target")
MOST_DRAWS: Final = 4096
"""Draws per row before a request fails: a throw of probability 1/300 is missed once in a million requests."""
AT_FIRST: Final = 16
"""Draws per row in the first batch; each batch doubles the number so far, as a hundred draws cost little more than ten.
"""
AT_ONCE: Final = 1024
"""Largest number of draws in a batch, over all rows."""


def requested(cell: Cell[Any, Any, Any, Any], options: Mapping[str, Any]) -> Request:
    """The request in options of a reset, with names instead of indices.

    Args:
        cell: the cell with the names of items and targets.
        options: names or indices by the keys in `ASKED`.

    Raises:
        ConfigError: the cell has no such item or target.
    """
    return {what: _name(cell, what, given) for what, given in options.items()}


def lead(cell: Cell[Any, Any, Any, Any], generators: Generators, request: Request) -> None:
    """Advance generators to states from which the first throw fulfils a request; the cell does not change.

    A generator jumps ahead in its sequence until the next draw fulfils the request. The number of jumps depends only
    on the generator, the cell's config and the request.

    Raises:
        ConfigError: a generator does not draw the requested throw; all generators are unchanged.
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
    """A generator in the same sequence, a number of jumps ahead of the given one."""
    bits: Any = generator.bit_generator
    return np.random.default_rng(bits.jumped(jumps))


def _fits(scout: Cell[Any, Any, Any, Any], request: Request) -> Bools:
    """Which rows of a scout draw a first throw that fulfils the request (N,)."""
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
