"""Kinds of rows whose columns are attributes: columns are copies, and rows are taken, replaced and written."""

import copy
import pickle
from typing import final

import numpy as np
import pytest

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.grasp.attempts import Attempts
from pnt_gym.errors import PntGymError
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.rows import Columns, Pair, field


@final
class Mark(Columns):
    place: Pair = field("m", "place")


@final
class Piece(Columns):
    kind: Ints = field("-", "item")
    mass: Floats = field("kg", "mass")
    mark: Mark = field("-", "mark")


def pieces(count):
    rows = np.arange(count)
    return Piece(Piece.zeros(count, kind=rows, mass=rows / 8.0, mark=Mark.zeros(count, place=rows[:, None] + 0.5)))


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda columns: pickle.loads(pickle.dumps(columns))])
def test_columns_are_taken_replaced_and_written_and_those_read_before_stay(copied):
    whole = copied(pieces(4))
    mass, some = whole.mass, take(whole, np.array([3, 1]))
    assert (some.kind.tolist(), some.mass.tolist(), some.mark.place[:, 0].tolist()) == (
        [3, 1],
        [0.375, 0.125],
        [3.5, 1.5],
    )
    changed = whole.replace(mass=np.ones(4), mark=Mark(Mark.zeros(4)))
    assert (changed.kind.tolist(), changed.mass.sum(), changed.mark.place.any()) == ([0, 1, 2, 3], 4.0, False)
    whole.put(np.array([0, 2]), some)
    assert whole.kind.tolist() == [3, 1, 1, 3]
    assert (mass.tolist(), whole.mass.tolist()) == ([0.0, 0.125, 0.25, 0.375], [0.375, 0.125, 0.125, 0.375])
    assert all(column.flags.c_contiguous for column in (whole.mass, whole.mark.place))


@final
class OlderPickle:
    """What an older version pickled for a class whose objects had their columns as state."""

    def __init__(self, kind):
        self.kind = kind

    def __reduce__(self):
        return self.kind.__new__, (self.kind,), ({"pick": np.zeros(1)}, False)


@pytest.mark.parametrize("kind", [Objects, Context, Attempts, ReleaseBatch])
def test_columns_that_an_older_version_pickled_are_refused(kind):
    with pytest.raises(PntGymError, match=f"holds {kind.__name__} of an older version"):
        pickle.loads(pickle.dumps(OlderPickle(kind)))
