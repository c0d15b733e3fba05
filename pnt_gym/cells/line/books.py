"""Books of every object that comes along N lines: attempts, fate, robot and bin, decision by decision."""

from __future__ import annotations

from typing import Any, Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take

NOBODY: Final = -1
"""Robot index of an object that no robot took, and bin index of an object that lies in no bin."""


class Accounts(NamedTuple):
    """Entries of the books for objects, S."""

    since: Floats
    """Time from which an object may be taken; infinity for objects that are gone [s]."""
    attempts: Ints
    """Number of attempts to pick each object."""
    fate: Ints
    """Value of `Fate` of each object."""
    taker: Ints
    """Robot that took each object; -1 for none."""
    ended_in: Ints
    """Bin of the taker in which each object lies; -1 for none."""

    @classmethod
    def fresh(cls, count: int, objects: int) -> Self:
        """Entries of objects that no robot has touched (N, M)."""
        zeros, no_robot = np.zeros((count, objects), dtype=np.int64), np.full((count, objects), NOBODY)
        return cls(np.zeros((count, objects)), zeros, zeros.copy(), no_robot, no_robot.copy())


@final
class Books:
    """Entries of N x M objects; books are immutable, and a write costs the same however long the shift is.

    The latest books hold all entries. Earlier books hold the entries that later writes replaced; reading earlier books
    costs a copy.

    Args:
        entries: entries of all objects (N, M); no other code may write to these arrays.
    """

    def __init__(self, entries: Accounts) -> None:
        self._entries: Accounts | None = entries
        self._next: tuple[Books, Any, Accounts] | None = None

    def at(self, index: Any) -> Accounts:
        """Entries of some objects.

        Args:
            index: arrays of lines, or of lines and objects.
        """
        return take(self.read(), index)

    def since(self, index: Any) -> Floats:
        """Times from which objects may be taken, for any index of lines and objects, S; read only [s]."""
        return self.read().since[index]

    def whole(self) -> Accounts:
        """A copy of all entries (N, M)."""
        entries = self.read()
        return entries if self._entries is None else _copy(entries)

    def write(self, index: Any, entries: Accounts) -> Books:
        """Books with new entries for some objects; these books do not change.

        Args:
            index: arrays of lines, or of lines and objects; no object twice.
            entries: the new entries of these objects.
        """
        columns = self.read()
        before = take(columns, index)
        _put(columns, index, entries)
        return self.overwritten(columns, index, before)

    def overwritten(self, columns: Accounts, index: Any, before: Accounts) -> Books:
        """Books whose entries `read` has given and the caller has overwritten; these books do not change.

        Args:
            columns: all entries, as `read` has given them, with the new entries.
            index: see `write`.
            before: the earlier entries of these objects.
        """
        after = Books(columns)
        if self._entries is not None:
            self._entries, self._next = None, (after, index, before)
        return after

    def read(self) -> Accounts:
        """All entries (N, M): the arrays of the latest books, or a copy with every later write undone; read only."""
        current, changes = self, list[tuple[Any, Accounts]]()
        while current._entries is None:
            assert current._next is not None  # earlier books always refer to the books that hold their entries
            current, index, before = current._next
            changes.append((index, before))
        columns = current._entries if current is self else _copy(current._entries)
        for index, before in reversed(changes):
            _put(columns, index, before)
        return columns

    def __getstate__(self) -> dict[str, Any]:
        """State for copies and pickles, with all entries and without the later books."""
        return {"_entries": self.whole(), "_next": None}


def _copy(entries: Accounts) -> Accounts:
    return take(entries, np.arange(len(entries.since)))


def _put(columns: Accounts, index: Any, entries: Accounts) -> None:
    """Write entries at an index, in place."""
    for column, values in zip(columns, entries, strict=True):
        column[index] = values
