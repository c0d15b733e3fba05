"""Taking, replacing and joining rows of records."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import (
    compute_by_mask,
    concatenate_records,
    put_rows,
    recompute_rows,
    replace_rows,
    stand_ins,
    take,
    take_rows,
)


class Pair(NamedTuple):
    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True)
class Whole:
    values: np.ndarray
    pair: Pair
    name: str = "name"
    total: float = field(init=False)

    def __post_init__(self):
        object.__setattr__(self, "total", float(self.values.sum()))


def whole(first=0):
    column = np.arange(first, first + 4)
    return Whole(column * 1.0, Pair(column, np.stack([column, -column], axis=1)))


def test_take_reaches_into_nested_records_and_makes_them_anew():
    taken = take(whole(), np.array([2, 0]))
    assert taken.values.tolist() == [2.0, 0.0]
    assert taken.pair.right.tolist() == [[2, -2], [0, 0]]
    assert (taken.name, taken.total) == ("name", 2.0)
    assert take(whole(), 3).pair.left == 3
    assert take(np.arange(3), [1]).tolist() == [1]


def test_replaced_leaves_the_record_as_it_was():
    record = whole()
    changed = replace_rows(record, np.array([1, 3]), take(whole(10), np.array([0, 1])))
    assert record.values.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert changed.values.tolist() == [0.0, 10.0, 2.0, 11.0]
    assert changed.pair.left.tolist() == [0, 10, 2, 11]
    assert changed.total == 23.0


def test_made_anew_are_only_the_rows_asked_for_from_their_own_rows_of_what_is_given():
    record, asked = whole(), []

    def make(values, name):
        asked.append((values.tolist(), name))
        return take(whole(10), np.arange(len(values)))

    changed = recompute_rows(record, np.array([False, True, False, True]), make, np.arange(4) * 2.0, "plain")
    assert asked == [([2.0, 6.0], "plain")]
    assert changed.values.tolist() == [0.0, 10.0, 2.0, 11.0]
    assert record.values.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert recompute_rows(record, np.zeros(4, dtype=bool), make, np.arange(4), "plain") is record
    assert len(asked) == 1


def test_rows_are_made_in_either_way_and_keep_their_places():
    def way(first):
        return lambda values, name: Whole(values + first, Pair(values.astype(int), values[:, None] - first), name)

    def made(which):
        return compute_by_mask(np.array(which), way(10), way(20), np.arange(4) * 1.0, "plain")

    mixed = made([False, True, False, True])
    assert mixed.values.tolist() == [20.0, 11.0, 22.0, 13.0]
    assert mixed.pair.right.tolist() == [[-20.0], [-9.0], [-18.0], [-7.0]]
    assert (mixed.name, mixed.total, mixed.pair.left.tolist()) == ("plain", 66.0, [0, 1, 2, 3])
    assert made([True] * 4).values.tolist() == [10.0, 11.0, 12.0, 13.0]
    assert made([False] * 4).values.tolist() == [20.0, 21.0, 22.0, 23.0]


def test_joined_rows_stand_one_after_the_other():
    both = concatenate_records([whole(), take(whole(10), [1])])
    assert both.pair.left.tolist() == [0, 1, 2, 3, 11]
    assert (both.name, both.total) == ("name", 17.0)


def test_dicts_of_arrays_are_records_too():
    column = np.arange(3)
    told = {"count": column, "name": "name", "pair": Pair(column, -column)}
    both = concatenate_records([take(told, slice(2)), take(told, [2, 2])])
    assert both["count"].tolist() == [0, 1, 2, 2]
    assert (both["name"], both["pair"].right.tolist()) == ("name", [0, -1, -2, -2])
    assert told["count"] is column


def test_all_rows_of_records_are_taken_and_put_without_a_copy():
    record, other = whole(), whole(10)
    assert take_rows((record, other), np.arange(4), 4)[1] is other
    some, same = take_rows((record, other), np.array([1, 3]), 4)
    assert (some.values.tolist(), same.pair.left.tolist()) == ([1.0, 3.0], [11, 13])
    assert put_rows(record, np.array([1, 3]), same, 4).values.tolist() == [0.0, 11.0, 2.0, 13.0]
    assert put_rows(record, np.arange(4), other, 4) is other
    assert put_rows(record, np.arange(0), take(other, []), 4) is record


def test_a_row_that_is_not_there_has_the_first_one_in_its_place():
    assert stand_ins(np.array([1, 3]), 5).tolist() == [0, 0, 0, 1, 0]
    assert stand_ins(np.arange(3), 3).tolist() == [0, 1, 2]
