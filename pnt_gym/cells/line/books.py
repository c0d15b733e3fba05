"""What has become of every object that comes along N lines, decision by decision."""

from __future__ import annotations

from typing import Any, Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take

NOBODY: Final = -1
"""Robot that took what nobody took, and bin of what lies in none."""


class Accounts(NamedTuple):
    """What is known of objects, S."""

    since: Floats
    """From when on an object may be taken; infinity for those that are gone [s]."""
    attempts: Ints
    """How often each has been tried."""
    fate: Ints
    """See `Fate`."""
    taker: Ints
    """Robot that took each, -1 for none."""
    ended_in: Ints
    """Bin in which each lies, of the robot that took it; -1 for none."""

    @classmethod
    def fresh(cls, count: int, objects: int) -> Self:
        """Objects that nobody has touched (N, M)."""
        never, nobody = np.zeros((count, objects), dtype=np.int64), np.full((count, objects), NOBODY)
        return cls(np.zeros((count, objects)), never, never.copy(), nobody, nobody.copy())


@final
class Books:
    """Accounts of N x M objects; books are values, and a change costs what it changes, however long the shift.

    The latest books hold all entries. Earlier ones hold what the next ones wrote over, and cost a copy to read.

    Args:
        entries: of all objects (N, M); nobody else may write there.
    """

    def __init__(self, entries: Accounts) -> None:
        self._entries: Accounts | None = entries
        self._next: tuple[Books, Any, Accounts] | None = None

    def at(self, index: Any) -> Accounts:
        """The entries of some objects.

        Args:
            index: arrays of lines, or of lines and objects.
        """
        return take(self._read(), index)

    def since(self, index: Any) -> Floats:
        """From when on objects at any index of lines and numbers may be taken, S; to read only [s]."""
        return self._read().since[index]

    def whole(self) -> Accounts:
        """A copy of all entries (N, M)."""
        entries = self._read()
        return entries if self._entries is None else _copy(entries)

    def write(self, index: Any, entries: Accounts) -> Books:
        """Books in which some objects have other entries; these books stay as they are.

        Args:
            index: arrays of lines, or of lines and objects; none twice.
            entries: of these objects.
        """
        latest = self._entries is not None
        columns = self._read()
        before, after = take(columns, index), Books(columns)
        _put(columns, index, entries)
        if latest:
            self._entries, self._next = None, (after, index, before)
        return after

    def _read(self) -> Accounts:
        """All entries (N, M): those that the latest books hold, or a copy in which they are as they were."""
        book, later = self, list[tuple[Any, Accounts]]()
        while book._entries is None:
            assert book._next is not None  # who gave the entries away knows to whom
            book, index, before = book._next
            later.append((index, before))
        columns = book._entries if book is self else _copy(book._entries)
        for index, before in reversed(later):
            _put(columns, index, before)
        return columns

    def __getstate__(self) -> dict[str, Any]:
        """Copies and pickles stand alone."""
        return {"_entries": self.whole(), "_next": None}


def _copy(entries: Accounts) -> Accounts:
    return take(entries, np.arange(len(entries.since)))


def _put(columns: Accounts, index: Any, entries: Accounts) -> None:
    """Write over some entries, in place."""
    for column, values in zip(columns, entries, strict=True):
        column[index] = values
