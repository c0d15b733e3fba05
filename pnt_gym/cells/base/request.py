"""Requests of a first throw: options of a reset name item and target, and a search finds generators that draw them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pnt_gym.cells.base.cell import Cell, Generators
from pnt_gym.errors import ConfigError, one_sentence
from pnt_gym.names import unknown_name

Request = Mapping[str, str]
"""Requested names by the options in `REQUEST_OPTIONS`; options without a request are absent."""
NO_REQUEST: Final[Request] = MappingProxyType({})
REQUEST_OPTIONS: Final = ("item", "target")
MOST_DRAWS: Final = 4096
"""Draws per row before a request fails: a throw of probability 1/300 is missed once in a million requests."""
FIRST_BATCH: Final = 16
"""Draws per row in the first batch; each batch doubles the number so far, as a hundred draws cost little more than ten.
"""
LARGEST_BATCH: Final = 1024
"""Largest number of draws in a batch, over all rows."""


def advance_to_request(cell: Cell[Any, Any, Any, Any], generators: Generators, request: Request) -> None:
    """Advance generators to states from which the first throw fulfils a request; the cell does not change.

    A generator jumps ahead in its sequence until the next draw fulfils the request. The number of jumps depends only
    on the generator, the cell's config and the request.

    Raises:
        ConfigError: a generator does not draw the requested throw; all generators are unchanged.
    """
    jumps, tried = np.full(len(generators), -1), 0
    while (pending := np.flatnonzero(jumps < 0)).size > 0:
        draws = min(max(tried, FIRST_BATCH), max(LARGEST_BATCH // pending.size, 1), MOST_DRAWS - tried)
        if draws == 0:
            request_text = " and ".join(f"{option} {name!r}" for option, name in request.items())
            lists = {option: one_sentence(", ".join(_names(cell, option)), 150) for option in request}
            names_text = " and ".join(f"{option}s {names}" for option, names in lists.items())
            sentence = f"{request_text} did not come in {MOST_DRAWS} draws of level {cell.config.name!r}"
            raise ConfigError(f"{sentence}, which has {names_text}")
        scout = cell.scout([_jump_ahead(generators[row], tried + k) for row in pending for k in range(draws)])
        drawn = scout.first(np.arange(len(scout.generators)))
        indices = {"item": drawn.kind, "target": scout.target_of(drawn)}
        matches = [np.array(_names(scout, option))[indices[option]] == name for option, name in request.items()]
        fits = np.all(matches, axis=0).reshape(-1, draws)
        fulfilled = fits.any(axis=1)
        jumps[pending[fulfilled]] = tried + fits[fulfilled].argmax(axis=1)
        tried += draws
    for generator, jump in zip(generators, jumps, strict=True):
        generator.bit_generator.state = _jump_ahead(generator, int(jump)).bit_generator.state


def _jump_ahead(generator: np.random.Generator, jumps: int) -> np.random.Generator:
    """A generator in the same sequence, a number of jumps ahead of the given one."""
    bits: Any = generator.bit_generator
    return np.random.default_rng(bits.jumped(jumps))


def _names(cell: Cell[Any, Any, Any, Any], option: str) -> Sequence[str]:
    return cell.item_names if option == "item" else cell.target_names


def requested_name(cell: Cell[Any, Any, Any, Any], option: str, value: Any) -> str:
    """The name of an item or target in an option of a reset, which may be an index.

    Raises:
        ConfigError: the cell has no such item or target.
    """
    names = _names(cell, option)
    if isinstance(value, str) and value in names:
        return value
    is_index = not isinstance(value, bool) and isinstance(value, Integral)
    if is_index and 0 <= int(value) < len(names):
        return names[int(value)]
    further = f", or an index from 0 to {len(names) - 1}" if names else f" with a name on level {cell.config.name!r}"
    raise ConfigError(unknown_name(option, value, names, further))
