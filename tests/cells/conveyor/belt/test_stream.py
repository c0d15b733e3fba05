"""The objects on a belt: none lies on another, none is lost, and the stream is what its seed says."""

import numpy as np
import pytest

from pnt_gym.arrays import concatenate_records, take
from pnt_gym.cells.conveyor.belt.stream import AWAY, PASSED_PLACES, BeltStream
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from tests.tools.nightly import with_nightly
from tests.tools.outlines import outlines, overlap
from tests.tools.throws import same_bits, vary

LEVELS = tuple(
    name
    for name in ConveyorConfig.level_names()
    if not name.endswith("_plain") and not ConveyorConfig.load(name).drift.moves  # which is no matter of the belt
)
LONG, BELTS, RIDES = 25, 6, 100
DRAWN = BELTS * LONG * RIDES
"""Objects drawn for each level."""


def stream_of(config, length=LONG, rows=BELTS):
    generators = [np.random.default_rng([5, row]) for row in range(rows)]
    stream = BeltStream(PickPlanner(config), generators, length)
    stream.begin(np.arange(rows))
    return stream


def endless(config) -> tuple[Objects, np.ndarray]:
    """Objects (BELTS, K) in a row on each of some belts, and their centres (BELTS, K, 2)."""
    stream, queues, places = stream_of(config), [], []
    for _ in range(RIDES):
        travelled = config.belt.speed * 0.5 * len(queues)
        queues.append(stream.queue)
        places.append(stream.queue_x - travelled)  # where they would lie had the belt never moved
        everyone = np.full(BELTS, LONG)
        stream.ride(np.arange(BELTS), everyone, everyone, np.full(BELTS, 0.5 * config.belt.speed))
    objects, x = concatenate_records(queues, axis=1), np.concatenate(places, axis=1)
    return objects, np.stack([x, objects.draws.lane_y], axis=-1)


def overlapping(objects, centre, ahead):
    """Which objects overlap the one so many places before them, by drawn outlines."""
    shape = objects.kind[:, ahead:].shape
    behind = outlines(flat(take(objects, np.s_[:, ahead:])), centre[:, ahead:].reshape(-1, 2))
    before = outlines(flat(take(objects, np.s_[:, :-ahead])), centre[:, :-ahead].reshape(-1, 2))
    return overlap(behind, before).reshape(shape)


def flat(objects):
    """Objects (R, K) in one line."""
    rows, places = np.indices(objects.kind.shape)
    return take(objects, (rows.ravel(), places.ravel()))


@pytest.mark.parametrize("level", with_nightly(LEVELS, ["dense"]))
def test_no_object_lies_on_another_and_gaps_are_between_edges(level):
    """More than 100,000 objects over all levels; between neighbours along the belt lies the gap that was drawn."""
    config = vary(level, belt={"gap": "edge"})
    objects, centre = endless(config)
    assert objects.kind.size >= 15_000 and len(LEVELS) * DRAWN > 100_000
    for ahead in (1, 2, 3):
        assert not overlapping(objects, centre, ahead).any()
    drawn = outlines(flat(objects), centre.reshape(-1, 2))[..., 0]
    front, rear = (edge(axis=1).reshape(objects.kind.shape) for edge in (drawn.max, drawn.min))
    # Outlines of ellipses are drawn with 24 corners.
    np.testing.assert_allclose(rear[:, :-1] - front[:, 1:], objects.draws.gap[:, 1:], atol=1e-3)


@pytest.mark.parametrize(("level", "share"), [("nominal_plain", 0.04), ("waste_plain", 0.03), ("unseen_plain", 0.08)])
def test_from_centre_to_centre_as_many_objects_overlap_as_the_page_of_levels_says(level, share):
    """So the test above can fail."""
    objects, centre = endless(vary(level, belt={"gap": "centre"}))
    assert overlapping(objects, centre, 1).mean() == pytest.approx(share, abs=0.008)
    np.testing.assert_allclose(-np.diff(centre[..., 0], axis=1), objects.draws.gap[:, 1:], atol=1e-9)


def seen_of(stream, rides):
    """Mass and place on the belt's surface of all that a stream ever brings, when it is used up by some rides."""
    found, travelled = {}, np.zeros(len(stream.x))
    for taken, gone, elapsed in rides:
        for row, (mass, x) in enumerate(zip(stream.queue.mass, stream.queue_x - travelled[:, None], strict=True)):
            found |= {(row, m): p for m, p in zip(mass, x, strict=True)}
        rows = np.arange(len(stream.x))
        stream.ride(rows, taken(rows), gone(rows), np.full(len(rows), stream._belt.speed * elapsed))
        travelled += stream._belt.speed * elapsed
    return found


def test_with_gaps_between_edges_the_stream_is_the_same_whatever_is_taken():
    config = ConveyorConfig.load("dense")
    one_by_one = [(lambda rows: 0 * rows, lambda rows: 0 * rows, 0.7)] * 40
    random = np.random.default_rng(0)
    any_of_them = [
        (lambda rows: random.integers(0, 7, len(rows)), lambda rows: random.integers(0, 4, len(rows)), 0.31)
    ] * 40
    a, b = seen_of(stream_of(config, 8), one_by_one), seen_of(stream_of(config, 11), any_of_them)
    both = a.keys() & b.keys()
    assert len(both) > 30 * BELTS
    np.testing.assert_allclose([a[key] for key in both], [b[key] for key in both], atol=1e-9)


@pytest.mark.parametrize("gap", ["edge", "centre"])
def test_what_is_taken_goes_what_is_let_go_rides_on_and_all_else_stays(gap):
    stream = stream_of(vary("waste", belt={"gap": gap}), 7, rows=3)
    before, x = stream.objects.mass.copy(), stream.x.copy()
    stream.ride(np.array([0, 2]), np.array([3, 7]), np.array([2, 4]), stream._belt.speed * np.array([0.5, 0.25]))
    assert same_bits(stream.x[1], x[1])
    assert same_bits(stream.objects.mass[1], before[1])
    kept = np.delete(before[0], PASSED_PLACES + 3)
    assert same_bits(stream.objects.mass[0, :-3], kept[2:])
    assert same_bits(stream.objects.mass[2, :-4], before[2, 4:])
    assert np.allclose(
        stream.x[2, PASSED_PLACES - 4 : -4], x[2, PASSED_PLACES:] + 0.25 * stream._belt.speed, atol=1e-12
    )
    held = stream.x < AWAY / 2
    assert held.sum(axis=1).tolist() == [7 + 2, 7, 7 + 4]
    assert (np.diff(stream.x[:, PASSED_PLACES - 4 :], axis=1)[held[:, PASSED_PLACES - 4 : -1]] < 0.0).all()
