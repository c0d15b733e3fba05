"""Records whose columns are computed when they are read: packed in one block, or at the end of a short chain."""

import copy
import gc
import pickle
import weakref
from dataclasses import dataclass, fields

import numpy as np
import pytest

from pnt_gym.arrays import Floats, Ints, concatenate_records, replace_rows, take
from pnt_gym.records import MOST_UNREAD, Record


@dataclass(frozen=True)
class Inner(Record):
    angle: Floats


@dataclass(frozen=True)
class Outer(Record):
    kind: Ints
    size: Floats
    inner: Inner
    corner: Floats


ROWS, PLACES = 5, 3
INDICES = (
    np.array([3, 0, 3]), np.array([True, False, True, True, False]), 2, np.s_[1:4], np.s_[:, None], np.s_[:, 1],
    (np.array([[0], [4]]), np.array([2, 0])),
)  # fmt: skip


def plain(seed=0):
    """A record of 5 x 3 rows, not packed."""
    random = np.random.default_rng(seed)
    shape = ROWS, PLACES
    return Outer(
        random.integers(0, 9, shape),
        random.random((*shape, 3)),
        Inner(random.random(shape)),
        random.random((*shape, 2, 2)),
    )


def assert_equal(record, expected):
    for field in fields(expected):
        values, wanted = getattr(record, field.name), getattr(expected, field.name)
        if isinstance(wanted, Record):
            assert_equal(values, wanted)
        else:
            np.testing.assert_array_equal(values, wanted)
            assert values.dtype == wanted.dtype


def indexed(index, seed=0):
    """The rows of `plain`, indexed column by column."""
    outer = plain(seed)
    return Outer(outer.kind[index], outer.size[index], Inner(outer.inner.angle[index]), outer.corner[index])


@pytest.mark.parametrize("record", [plain(), plain().pack()], ids=["plain", "packed"])
@pytest.mark.parametrize("index", INDICES, ids=str)
def test_rows_are_those_of_every_column(record, index):
    assert_equal(take(record, index), indexed(index))


@pytest.mark.parametrize("kinds", [(True, True), (True, False), (False, True), (False, False)], ids=str)
def test_rows_are_replaced_and_joined_whether_packed_or_not(kinds):
    first, second = (plain(seed).pack() if packed else plain(seed) for seed, packed in enumerate(kinds))
    rows = np.array([4, 1])
    joined, replaced = concatenate_records([first, second]), replace_rows(first, rows, take(second, rows))
    assert_equal(take(joined, np.s_[:ROWS]), plain(0))
    assert_equal(take(joined, np.s_[ROWS:]), plain(1))
    assert_equal(take(replaced, rows), indexed(rows, 1))
    assert_equal(take(replaced, np.array([0, 2, 3])), indexed(np.array([0, 2, 3])))
    assert_equal(first, plain(0))


def test_another_column_leaves_the_rest_and_the_record_as_they_were():
    for record in (plain(), plain().pack(), take(plain(), np.s_[:])):
        changed = record.replace(size=np.zeros((ROWS, PLACES, 3)))
        assert not take(changed, 1).size.any()
        assert_equal(changed.replace(size=record.size), plain())
        assert_equal(record, plain())
    with pytest.raises(AssertionError, match="sise"):
        plain().replace(sise=np.zeros(3))


def test_an_index_may_change_after_the_rows_are_taken():
    index = np.array([0, 1])
    for record in (plain(), plain().pack()):
        rows = take(record, index)
        index[:] = 3
        assert_equal(rows, indexed(np.array([0, 1])))
        index[:] = 0, 1


@pytest.mark.parametrize(
    "record", [plain(), plain().pack(), take(plain(), np.s_[:])], ids=["plain", "packed", "unread"]
)
def test_copies_and_pickles_are_equal_and_join_the_original(record):
    for other in (copy.deepcopy(record), pickle.loads(pickle.dumps(record))):
        assert_equal(other, plain())
        assert_equal(take(concatenate_records([record, other]), np.s_[ROWS:]), plain())


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda record: pickle.loads(pickle.dumps(record))])
def test_a_copy_whose_columns_were_read_can_be_overwritten(copied):
    record, source = plain().pack(), plain(1).pack()
    assert_equal(record, plain())
    again = copied(record)
    again.overwrite(np.s_[:], source)
    assert_equal(again, plain(1))
    assert_equal(record, plain())


def test_only_columns_of_the_record_exist():
    for record in (plain(), plain().pack(), take(plain(), 0)):
        with pytest.raises(AttributeError, match="'Outer' has no attribute 'volume'"):
            _ = record.volume


def test_long_chains_do_not_keep_old_rows_alive():
    record, sources = plain(), []
    for step in range(4 * MOST_UNREAD):
        source = plain(step)
        sources.append(weakref.ref(source))
        record = replace_rows(record, np.array([step % ROWS]), take(source, np.array([0])))
        del source
    gc.collect()
    assert sum(source() is not None for source in sources) <= 2 * MOST_UNREAD
    assert record.kind[step % ROWS].tolist() == plain(step).kind[0].tolist()
