import importlib
from functools import cache

import numpy as np
import pytest

from papers.common.casadi_module import load_casadi
from papers.common.fastest import NoMotionFound, fastest_motion
from pnt_gym.errors import PntGymError
from pnt_gym.planning import EllipticWorkspace, MotionLimits, min_time_scurve

T40 = MotionLimits.t3kr(40)
HERE, THERE = (-0.15, 0.0, -0.85), (0.15, 0.05, -0.83)
AREA = EllipticWorkspace(0.41, 0.80)
ALONG = ((0.3, -0.3, -0.8), (0.3, 0.3, -0.8), T40)
OUTWARD = {"start_velocity": (2.0, 0.0, 0.0), "floor": -0.9}


@cache
def motion(name):
    """One motion of each kind, solved once."""
    return {
        "line": lambda: fastest_motion((0.0, 0.0, 0.0), (0.3, 0.4, 0.0), T40),
        "short": lambda: fastest_motion((0.0, 0.0, 0.0), (0.0, 0.0, 0.02), T40),
        "lifted": lambda: fastest_motion(HERE, THERE, T40, lift=0.03, drop=0.05),
        "roofed": lambda: fastest_motion(HERE, THERE, T40, lift=0.03, drop=0.02, roof=-0.81),
        "lift only": lambda: fastest_motion(HERE, THERE, T40, lift=0.04, roof=-0.80),
        "moving": lambda: fastest_motion(HERE, THERE, T40, start_velocity=(0.0, 2.4, 0.0), floor=-0.86, roof=-0.8),
        "outward": lambda: fastest_motion(*ALONG, **OUTWARD),
        "turned back": lambda: fastest_motion(*ALONG, workspace=AREA, **OUTWARD),
    }[name]()


@pytest.mark.parametrize("bounds", [{}, {"floor": -1.0, "roof": -0.85, "workspace": AREA}])
def test_no_way_takes_no_time(bounds):
    path = fastest_motion(HERE, HERE, T40, **bounds)
    assert path.duration.tolist() == [0.0]
    assert path.durations.shape[0] == 1
    read = path.sample(np.array([-1.0, 0.0, 1.0]))
    np.testing.assert_array_equal(read.position, np.tile(HERE, (1, 3, 1)))
    assert not (read.velocity.any() or read.acceleration.any())


@pytest.mark.nightly
def test_no_way_still_takes_time_with_a_lift_or_a_velocity():
    up = fastest_motion(HERE, HERE, T40, lift=0.02, drop=0.02)
    # Jerk J for a time t, -J for (1 + sqrt 2) t until the hand turns at the top, and the same backwards.
    share = 1.0 + np.sqrt(2.0)
    rise = 1.0 / 6.0 + share / 2.0 + share**2 / 2.0 - share**3 / 6.0
    known = 2.0 * (1.0 + share) * np.cbrt(0.02 / (1200.0 * rise))
    assert known * (1.0 - 1e-6) <= float(up.duration[0]) <= known * (1.0 + 3e-3)
    loop = fastest_motion(HERE, HERE, T40, start_velocity=(0.1, 0.0, 0.0))
    assert loop.sample(np.linspace(0.0, float(loop.duration[0]), 99)).position[0, :, 0].max() > HERE[0] + 1e-4
    np.testing.assert_allclose(loop.end[0], HERE, rtol=0, atol=1e-8)


def test_a_straight_way_takes_as_long_as_the_s_curve():
    for name, way in (("line", 0.5), ("short", 0.02)):
        closed = float(min_time_scurve(way, T40).duration)
        found = float(motion(name).duration[0])
        # Equal pieces cannot switch the jerk just where the S-curve does, so they need a little longer.
        assert closed * (1.0 - 1e-6) <= found <= closed * (1.0 + 3e-3), name


@pytest.mark.nightly
def test_other_limits_are_met_as_well():
    for limits in (MotionLimits(1.0, 10.0, 100.0), MotionLimits(3.0, 15.0, 900.0)):
        closed = float(min_time_scurve(0.35, limits).duration)
        found = fastest_motion((0.1, 0.2, -0.8), (0.1, -0.15, -0.8), limits)
        assert closed * (1.0 - 1e-6) <= float(found.duration[0]) <= closed * (1.0 + 3e-3)
        for ratio in found.peak_ratios(limits):
            assert ratio[0] <= 1.0 + 1e-6


@pytest.mark.parametrize("name", ["line", "short", "lifted", "roofed", "lift only", "moving", "turned back"])
def test_norms_stay_within_the_limits_and_one_of_them_binds(name):
    path = motion(name)
    times = np.arange(0.0, float(path.duration[0]), 1e-4)
    read = path.sample(times)
    norms = [np.linalg.norm(x[0], axis=1) for x in (read.velocity, read.acceleration, path.jerk(times))]
    for values, most in zip(norms, T40.numbers(), strict=True):
        assert values.max() <= most * (1.0 + 1e-6)
    share = np.max([values / most for values, most in zip(norms, T40.numbers(), strict=True)], axis=0)
    # Time-optimal: at nearly all times some limit is reached.
    assert np.mean(share > 0.99) > 0.7


@pytest.mark.parametrize("name", ["lifted", "roofed", "lift only", "moving"])
def test_the_ends_are_met(name):
    path = motion(name)
    np.testing.assert_allclose(path.start[0], HERE, rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.end[0], THERE, rtol=0, atol=1e-8)
    np.testing.assert_allclose(path.knots.velocity[0, -1], 0.0, atol=1e-7)
    np.testing.assert_allclose(path.knots.acceleration[0, -1], 0.0, atol=1e-6)
    begin = (0.0, 2.4, 0.0) if name == "moving" else (0.0, 0.0, 0.0)
    np.testing.assert_allclose(path.knots.velocity[0, 0], begin, atol=1e-12)
    np.testing.assert_allclose(path.knots.acceleration[0, 0], 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "lift", "drop"), [("lifted", 0.03, 0.05), ("roofed", 0.03, 0.02), ("lift only", 0.04, 0)]
)
def test_lift_and_drop_are_vertical(name, lift, drop):
    path = motion(name)
    place = path.sample(np.linspace(0.0, float(path.duration[0]), 4000)).position[0]
    high = np.argmax(place[:, 2])
    for part, end, rise in ((place[:high], HERE, lift), (place[high:], THERE, drop)):
        low = part[part[:, 2] < end[2] + rise - 1e-7]
        # Where there is such a part, several samples lie on it.
        assert len(low) > 20 or rise == 0.0
        np.testing.assert_allclose(low[:, :2] - np.array(end)[:2], 0.0, atol=1e-8)


def test_the_drop_is_entered_without_a_stop():
    path = motion("lifted")
    read = path.sample(np.linspace(0.0, float(path.duration[0]), 4000))
    entered = np.flatnonzero(read.position[0, :, 2] >= THERE[2] + 0.05)[-1]
    assert read.velocity[0, entered, 2] < -0.3


def test_floor_and_roof_hold_between_the_borders_too():
    for name, low, high in (("roofed", HERE[2], -0.81), ("lift only", HERE[2], -0.80), ("moving", -0.86, -0.8)):
        path = motion(name)
        height = path.sample(np.arange(0.0, float(path.duration[0]), 1e-4)).position[0, :, 2]
        assert height.max() <= high + 1e-8
        assert height.min() >= low - 1e-8


def test_a_hand_that_moves_outwards_turns_before_the_border():
    free, bound = motion("outward"), motion("turned back")
    times = np.linspace(0.0, 0.4, 4001)
    assert AREA.margin(bound.sample(times).position).min() >= -1e-8
    assert AREA.margin(free.sample(times).position).min() < -0.01
    assert bound.duration[0] > free.duration[0]


@pytest.mark.nightly
def test_a_start_at_full_speed_towards_the_end_is_a_cruise_and_a_stop():
    ramp = 2.4 / 48.0 + 48.0 / 1200.0
    expected = (0.4 - 0.5 * 2.4 * ramp) / 2.4 + ramp
    path = fastest_motion((0.0, 0.0, 0.0), (0.4, 0.0, 0.0), T40, start_velocity=(2.4, 0.0, 0.0))
    assert expected * (1.0 - 1e-6) <= float(path.duration[0]) <= expected * (1.0 + 3e-3)


def test_a_turned_and_mirrored_problem_takes_the_same_time():
    known = float(motion("moving").duration[0])
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    for change, shift in ((turn, (0.2, -0.1, 0.0)), (turn @ np.diag([1.0, -1.0, 1.0]), (0.0, 0.3, 0.0))):
        start, end = (change @ np.array(point) + shift for point in (HERE, THERE))
        velocity = change @ np.array([0.0, 2.4, 0.0])
        path = fastest_motion(start, end, T40, start_velocity=velocity, floor=-0.86, roof=-0.8)
        assert float(path.duration[0]) == pytest.approx(known, rel=1e-5)


@pytest.mark.nightly
def test_a_longer_way_or_a_tighter_bound_is_never_faster():
    times = [float(fastest_motion((0, 0, 0), (way, 0, 0), T40, lift=0.02, drop=0.02).duration[0]) for way in (0.1, 0.3)]
    assert times[0] < times[1]
    slower = [
        MotionLimits(1.2, 48.0, 1200.0),
        MotionLimits(2.4, 24.0, 1200.0),
        MotionLimits(2.4, 48.0, 600.0),
    ]
    known = float(motion("roofed").duration[0])
    for limits in slower:
        path = fastest_motion(HERE, THERE, limits, lift=0.03, drop=0.02, roof=-0.81)
        assert float(path.duration[0]) > known * (1.0 - 1e-6)
    high = fastest_motion(HERE, THERE, T40, lift=0.03, drop=0.02)
    assert float(high.duration[0]) <= known * (1.0 + 1e-6)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"start": (np.nan, 0.0, 0.0)}, "start must be three finite numbers"),
        ({"end": (0.0, np.inf, 0.0)}, "end must be three finite numbers"),
        ({"end": (0.0, 0.0)}, "end must be three finite numbers"),
        ({"start_velocity": (0.0, np.nan, 0.0)}, "start_velocity must be three finite numbers"),
        ({"lift": -0.01}, "lift must be finite and not negative"),
        ({"drop": np.nan}, "drop must be finite and not negative"),
        ({"lift": 0.05, "start_velocity": (0.1, 0.0, 0.0)}, "cannot be lifted vertically"),
        ({"start_velocity": (2.0, 2.0, 0.0)}, r"start_velocity is 2\.828 m/s; the limit is 2\.4 m/s"),
        ({"workspace": EllipticWorkspace(0.1, 0.8)}, r"start \[-0\.15, 0\.0, -0\.85\] lies outside the workspace"),
        ({"start": (0.0, 0.0, -0.85), "workspace": EllipticWorkspace(0.1, 0.8)}, "end .* lies outside the workspace"),
        ({"floor": np.nan}, r"floor must be a height \[m\], got nan"),
        ({"roof": np.nan}, r"roof must be a height \[m\], got nan"),
        ({"end": HERE, "floor": np.nan}, r"floor must be a height"),
        ({"floor": -0.84}, r"floor -0\.84 m .*: start \+ lift at z = -0\.85 m and end \+ drop at z = -0\.83 m"),
        ({"floor": -0.82, "lift": 0.05}, r"floor -0\.82 m .*: start \+ lift at z = -0\.8 m and end \+ drop at z = -0"),
        ({"floor": np.inf}, "floor inf m must not lie above"),
        ({"lift": 0.06, "roof": -0.80}, r"start \+ lift lies at z = -0\.79 m, above the roof at -0\.8 m"),
        ({"drop": 0.06, "roof": -0.80}, r"end \+ drop lies at z = -0\.77 m, above the roof at -0\.8 m"),
        ({"lift": 0.1, "workspace": EllipticWorkspace(z_max=-0.8)}, r"start \+ lift .* lies outside the workspace"),
        ({"roof": -0.84}, r"end lies at z = -0\.83 m, above the roof"),
        ({"start": (0.0, 0.0, -0.80), "roof": -0.81}, r"start lies at z = -0\.8 m, above the roof at -0\.81 m"),
        ({"limits": MotionLimits.t3kr(np.array([30.0, 40.0]))}, "one set of limits"),
    ],
)
def test_bad_inputs_are_refused_in_one_sentence(changes, sentence):
    given = {"start": HERE, "end": THERE, "limits": T40} | changes
    with pytest.raises(ValueError, match=sentence) as caught:
        fastest_motion(given.pop("start"), given.pop("end"), given.pop("limits"), **given)
    assert "\n" not in str(caught.value)
    assert not isinstance(caught.value, NoMotionFound)


def test_a_floor_and_a_roof_that_touch_the_ends_are_no_error():
    touching = fastest_motion(HERE, THERE, T40, lift=0.05, floor=-0.85 + 0.05 - 0.03, roof=-0.85 + 0.05)
    assert float(touching.duration[0]) > float(motion("lift only").duration[0])
    # -0.88 + 0.05 is -0.83 but for a rounding.
    raised = fastest_motion((-0.15, 0.0, -0.88), THERE, T40, lift=0.05, floor=THERE[2], roof=THERE[2])
    np.testing.assert_allclose(raised.end[0], THERE, rtol=0, atol=1e-8)


@pytest.mark.parametrize("limits", [T40, pytest.param(MotionLimits(1.0, 5.0, 20.0), marks=pytest.mark.nightly)])
def test_a_hand_that_cannot_turn_inside_the_workspace_is_told_so(limits):
    """Three centimetres before the border at full speed, where a stop takes at least ten."""
    start, velocity = (0.38, 0.0, -0.8), (limits.numbers()[0], 0.0, 0.0)
    with pytest.raises(NoMotionFound, match=r"stays above -0\.900 m and below -0\.600 m and inside the workspace$"):
        fastest_motion(start, THERE, limits, start_velocity=velocity, floor=-0.9, roof=-0.6, workspace=AREA)


@pytest.mark.nightly
def test_a_stop_without_room_is_told_as_such():
    """Falling at full speed 5 mm above the floor."""
    with pytest.raises(NoMotionFound, match=r"no motion from .* was found that stays above -0\.855 m"):
        fastest_motion(HERE, THERE, T40, start_velocity=(0.0, 0.0, -2.4), floor=-0.855)


def test_without_casadi_the_error_says_what_to_install(monkeypatch):
    real = importlib.import_module

    def missing(name, *rest):
        if name == "casadi":
            raise ImportError(name)
        return real(name, *rest)

    load_casadi.cache_clear()
    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(PntGymError, match=r"need casadi; install it with: pip install 'pnt_gym\[optimal\]'"):
        fastest_motion(HERE, THERE, T40)
    load_casadi.cache_clear()
