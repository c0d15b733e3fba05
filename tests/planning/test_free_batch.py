import numpy as np
import pytest

from pnt_gym.planning import EllipticWorkspace, JerkTrajectory, MotionLimits
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.free_batch import FreeThrows, plan_free_throws
from pnt_gym.planning.free_optimum import fastest_throw
from pnt_gym.planning.free_rules import HandRules, check_throw

COUNT = 240
CEILING = -0.75
SPACE = EllipticWorkspace()


def scene(count=COUNT, seed=1, low=15.0, high=45.0):
    """Picks, targets, next picks and limits of the conveyor cell."""
    rng = np.random.default_rng(seed)
    picks, following = (rng.uniform((-0.3, -0.45, 0.0), (0.3, -0.2, 0.0), (count, 3)) for _ in range(2))
    targets = rng.uniform((-0.5, 0.25, 0.0), (0.5, 0.75, 0.0), (count, 3))
    belt = np.array([0.0, 0.0, -0.85])
    return picks + belt, targets + belt, following + belt, MotionLimits.t3kr(rng.uniform(low, high, count))


PICKS, TARGETS, FOLLOWING, LIMITS = scene()
FIELDS = ("release_time", "position", "velocity", "flight_time", "straight", "feasible")


@pytest.fixture(scope="module")
def throws():
    return plan_free_throws(PICKS, TARGETS, FOLLOWING, LIMITS, ceiling=CEILING)


def assert_good(throws: FreeThrows, targets, following, limits, ceiling, rules=None):
    """Every row that is called feasible keeps everything at 10 kHz and lands, and ends where it should."""
    rows = np.flatnonzero(throws.feasible)
    path = throws.path.take(rows)
    roof = np.broadcast_to(ceiling, throws.feasible.shape)[rows]
    rules = HandRules() if rules is None else rules
    check = check_throw(path, throws.release_time[rows], targets[rows], limits.take(rows), roof, rules)
    bad = ~check.good()
    assert not bad.any(), {"rows": rows[bad], **{name: value[bad] for name, value in check._asdict().items()}}
    np.testing.assert_allclose(path.end, following[rows], rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.knots.velocity[:, -1], 0.0, atol=1e-9)
    np.testing.assert_allclose(path.knots.acceleration[:, -1], 0.0, atol=1e-8)


def assert_still(throws: FreeThrows, picks):
    """Rows without a throw are NaN, and their hand stays where it is."""
    rows = ~throws.feasible
    for name in FIELDS[:4]:
        np.testing.assert_array_equal(np.isnan(getattr(throws, name)).reshape(len(rows), -1).any(axis=1), rows, name)
    assert not throws.straight[rows].any()
    assert not throws.path.duration[rows].any()
    np.testing.assert_array_equal(
        throws.path.sample(np.array([0.0, 0.1])).position[rows], picks[rows, None].repeat(2, 1)
    )


def test_every_throw_keeps_limits_and_rules_at_10_khz(throws):
    assert throws.feasible.mean() > 0.99
    assert throws.straight.mean() < 0.04
    assert_good(throws, TARGETS, FOLLOWING, LIMITS, CEILING)
    assert_still(throws, PICKS)


def test_the_told_release_is_that_of_the_path_and_hits(throws):
    rows = np.flatnonzero(throws.feasible)
    at = throws.path.take(rows).sample(throws.release_time[rows, None])
    np.testing.assert_allclose(at.position[:, 0], throws.position[rows], rtol=0, atol=1e-11)
    np.testing.assert_allclose(at.velocity[:, 0], throws.velocity[rows], rtol=0, atol=1e-10)
    np.testing.assert_allclose(at.acceleration[:, 0], 0.0, atol=1e-8)
    t = throws.flight_time[rows, None]
    landing = throws.position[rows] + t * throws.velocity[rows] - t * t * [0.0, 0.0, 0.5 * GRAVITY]
    np.testing.assert_allclose(landing, TARGETS[rows], rtol=0, atol=1e-10)
    assert (throws.velocity[rows, 2] < GRAVITY * throws.flight_time[rows]).all()
    assert (throws.position[rows, 2] <= CEILING + 1e-12).all()


def test_the_hand_comes_down_vertically_on_the_next_pick(throws):
    rows = np.flatnonzero(throws.feasible & ~throws.straight)
    path = throws.path.take(rows)
    duration = path.duration[:, None]
    for before in (0.005, 0.01, 0.02):
        place = path.sample(duration - before).position[:, 0]
        near = place[:, 2] < FOLLOWING[rows, 2] + 0.04
        assert near.any()
        np.testing.assert_allclose(place[near, :2], FOLLOWING[rows][near, :2], rtol=0, atol=1e-9)


def test_it_is_aimed_short_by_the_tolerance():
    rows = slice(0, 32)
    short = plan_free_throws(
        PICKS[rows], TARGETS[rows], FOLLOWING[rows], LIMITS.take(rows), ceiling=CEILING, tolerance=0.005
    )
    gap = (TARGETS - PICKS)[rows]
    # The nearest point of the box of half-width delta around the target, on the way to it (Hassan et al., Eqs. 16-17).
    aims = TARGETS[rows] - 0.005 / np.abs(gap[:, :2]).max(axis=1)[:, None] * gap
    assert short.feasible.all()
    assert_good(short, aims, FOLLOWING[rows], LIMITS.take(rows), CEILING)


@pytest.mark.parametrize(
    "rules",
    [
        HandRules(workspace=SPACE),
        HandRules(window=0.01),
        HandRules(window=0.03, margin=0.5),
        HandRules(hand_cap=0.08),
        HandRules(clear_distance=0.0, hand_cap=np.inf),
        HandRules(approach=0.02, margin=0.9),
    ],
    ids=str,
)
def test_other_rules_are_kept_as_well(rules):
    rows = slice(0, 64)
    limits = LIMITS.take(rows)
    throws = plan_free_throws(PICKS[rows], TARGETS[rows], FOLLOWING[rows], limits, ceiling=CEILING, rules=rules)
    assert throws.feasible.mean() > 0.9
    assert_good(throws, TARGETS[rows], FOLLOWING[rows], limits, CEILING, rules)
    assert_still(throws, PICKS[rows])


def test_other_heights_are_kept_as_well():
    """Ceilings of 2 cm to 50 cm, targets and next picks up to 10 cm higher or lower."""
    rng = np.random.default_rng(12)
    count = 64
    high = np.array([0.0, 0.0, 0.1])
    targets, following = TARGETS[:count] + rng.uniform(-high, high, (count, 3)), FOLLOWING[:count].copy()
    following += rng.uniform(-high, 0.5 * high, (count, 3))
    ceiling = PICKS[:count, 2] + rng.uniform(0.02, 0.5, count)
    limits = LIMITS.take(slice(0, count))
    throws = plan_free_throws(PICKS[:count], targets, following, limits, ceiling=ceiling)
    assert throws.feasible.mean() > 0.8
    assert_good(throws, targets, following, limits, ceiling)
    assert_still(throws, PICKS[:count])
    assert (throws.position[throws.feasible, 2] <= ceiling[throws.feasible] + 1e-12).all()


def test_rows_that_fall_back_are_marked_and_thrown_along_a_line():
    """A ceiling at 5 mm leaves no room for a run-up; straight throws still exist at full performance."""
    rows = slice(0, 40)
    limits = MotionLimits.t3kr(100)
    ceiling = -0.845
    throws = plan_free_throws(PICKS[rows], TARGETS[rows], FOLLOWING[rows], limits, ceiling=ceiling)
    assert throws.straight.mean() > 0.5
    assert (throws.straight <= throws.feasible).all()
    line = np.flatnonzero(throws.straight)
    way = throws.position[line] - PICKS[line]
    along = way / np.linalg.norm(way, axis=1)[:, None]
    speed = np.linalg.norm(throws.velocity[line], axis=1)[:, None]
    np.testing.assert_allclose(throws.velocity[line] / speed, along, rtol=0, atol=1e-9)
    assert_good(throws, TARGETS[rows], FOLLOWING[rows], limits, ceiling)
    assert_still(throws, PICKS[rows])


def test_impossible_rows_are_told_and_disturb_no_other(throws):
    rows = np.arange(6)
    picks, targets, following = PICKS[rows].copy(), TARGETS[rows].copy(), FOLLOWING[rows].copy()
    ceiling = np.full(6, CEILING)
    targets[1, 2] += 5.0
    targets[2] = picks[2]
    ceiling[3] = -0.9
    following[4, 2] = CEILING + 0.3
    found = plan_free_throws(picks, targets, following, LIMITS.take(rows), ceiling=ceiling)
    assert found.feasible.tolist() == [True, False, False, False, False, True]
    assert_still(found, picks)
    for row in (0, 5):
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(found, name)[row], getattr(throws, name)[row], name)


def assert_same(part: FreeThrows, whole: FreeThrows, rows):
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[rows], name)
    for name in ("start", "durations", "jerks"):
        np.testing.assert_array_equal(getattr(part.path, name), getattr(whole.path, name)[rows], name)


def test_row_does_not_depend_on_its_batch(throws):
    shuffled = np.random.default_rng(5).permutation(COUNT)
    for rows in [shuffled, np.arange(33), np.array([7, 7]), *np.arange(0, COUNT, 40)[:, None]]:
        part = plan_free_throws(PICKS[rows], TARGETS[rows], FOLLOWING[rows], LIMITS.take(rows), ceiling=CEILING)
        assert_same(part, throws, rows)


def test_row_does_not_depend_on_its_batch_where_rows_fall_back():
    picks, targets, following, limits = scene(48, seed=2, low=90.0, high=100.0)

    def plan(rows):
        ceiling = np.where(rows % 2 == 0, -0.845, -0.65)
        return plan_free_throws(picks[rows], targets[rows], following[rows], limits.take(rows), ceiling=ceiling)

    whole = plan(np.arange(48))
    assert 0 < whole.straight.sum() < 48
    for rows in (np.arange(48)[::-1], np.array([0]), np.array([1]), np.arange(5, 20)):
        assert_same(plan(rows), whole, rows)


@pytest.mark.parametrize(
    ("pick", "target", "following", "percent"),
    [
        ((-0.2, -0.35, -0.85), (0.3, 0.4, -0.85), (-0.3, -0.35, -0.85), 40.0),
        ((-0.3, -0.35, -0.85), (0.45, 0.65, -0.85), (-0.2, -0.25, -0.85), 45.0),
    ],
    ids=["inside 40", "outside 45"],
)
def test_within_four_percent_of_the_optimum(pick, target, following, percent):
    """Cells of Table I of Hassan et al. 2022."""
    limits, rules = MotionLimits.t3kr(percent), HandRules(workspace=SPACE)
    given = {"ceiling": CEILING, "tolerance": 0.005, "rules": rules}
    best = fastest_throw(pick, target, following, limits, **given)
    quick = plan_free_throws([pick], [target], [following], limits, **given)
    assert quick.feasible[0]
    assert not quick.straight[0]
    assert best.duration * 0.999 < float(quick.path.duration[0]) < best.duration * 1.04


def test_one_set_of_limits_serves_all_rows():
    rows = slice(0, 3)
    given = (PICKS[rows], TARGETS[rows], FOLLOWING[rows])
    one = plan_free_throws(*given, MotionLimits.t3kr(40), ceiling=CEILING)
    each = plan_free_throws(*given, MotionLimits.t3kr([40.0] * 3), ceiling=[CEILING] * 3, tolerance=[0.0] * 3)
    assert_same(one, each, np.arange(3))
    assert isinstance(one.path, JerkTrajectory)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            {"next_picks": [(0.0, -0.3, -0.85), (0.46, 0.0, -0.85)]},
            r"next_picks row 1, \[0\.46, 0\.0, -0\.85\], lies",
        ),
        ({"picks": [(0.0, -0.81, -0.85), (0.0, -0.3, -0.85)]}, r"picks row 0, .* lies outside the workspace"),
        ({"picks": [(np.nan, 0.0, 0.0)] * 2}, r"picks must be finite, got nan"),
        ({"targets": [(np.inf, 0.0, 0.0)] * 2}, r"targets must be finite, got inf"),
        ({"next_picks": [(0.0, np.nan, 0.0)] * 2}, r"next_picks must be finite, got nan"),
        ({"picks": (0.0, -0.3, -0.85)}, r"picks must have shape \(N, 3\)"),
        ({"targets": np.zeros((2, 2))}, r"targets must have shape \(N, 3\)"),
        ({"targets": np.zeros((3, 3))}, "targets has 3"),
        ({"next_picks": np.zeros((1, 3))}, "next_picks has 1"),
        ({"ceiling": np.nan}, "ceiling must be finite"),
        ({"ceiling": np.zeros(3)}, r"ceiling must be one number or have shape \(2,\)"),
        ({"tolerance": -0.01}, "tolerance must not be negative"),
        ({"limits": MotionLimits.t3kr(np.array([30.0, 30.0, 30.0]))}, "limits hold 3 throws but 2"),
    ],
)
def test_bad_inputs_are_refused(changes, sentence):
    given = {"picks": PICKS[:2], "targets": TARGETS[:2], "next_picks": FOLLOWING[:2], "limits": MotionLimits.t3kr(40)}
    given |= {"ceiling": CEILING, "rules": HandRules(workspace=SPACE)} | changes
    with pytest.raises(ValueError, match=sentence) as caught:
        plan_free_throws(**given)
    assert "\n" not in str(caught.value)
