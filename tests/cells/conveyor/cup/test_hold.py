"""Objects that the cup cannot hold on the way: lost where statics says, in both fidelities, and saved by care."""

from functools import cache

import numpy as np
import pytest

from pnt_gym.cells.conveyor.cup.hold import grips, measured_hold, picked, smallest_margin
from pnt_gym.errors import ConfigError
from tests.tools.throws import make_core, whole_cycle

COUNT = 90
GRAVITY, LIP = 9.81, 0.018
ROUND = {
    "shape": "cylinder", "drag": 0.8, "seal_force": 20.0, "friction": 0.47, "rolling_friction": 0.002,
    "restitution": 0.2, "source": "a filled container, of a user's own",
}  # fmt: skip
HEAVY = {
    "base": "nominal_plain",
    "items": ["full_can", "jar"],
    "extra_items": [
        {"name": "full_can", "size": [0.115, 0.066, 0.066], "mass": 0.36, **ROUND},
        {"name": "jar", "size": [0.110, 0.070, 0.070], "mass": 0.20, **ROUND},
    ],
}


def core_of(level, **grip):
    return make_core({**level, "grip": grip} if grip else level, COUNT, threads=2)


@cache
def thrown(**grip):
    """Heavy objects: the config, picks, motions of their throws, whole cycles, and what is told of the throws."""
    core, zero = core_of(HEAVY, **grip), np.zeros((COUNT, 2))
    return core.config, core.context, *whole_cycle(core, core.plan(zero)[0]), core.step(zero).info


def test_a_cup_holds_on_the_way_to_the_release_whatever_follows():
    config, picks, motion, cycle, info = thrown(limit=True)
    alone = grips(picks, picked(picks, config), motion.path, motion.release_time, config)
    with_return = grips(picks, picked(picks, config), cycle.path, cycle.release_time, config)
    for name in ("margin", "lost_at", "picked"):
        np.testing.assert_array_equal(getattr(alone, name), getattr(with_return, name))
    np.testing.assert_array_equal(info["grip_margin"], alone.margin)
    np.testing.assert_array_equal(info["dropped"], alone.dropped)


def statics(config, picks, cycle):
    """The least margin of each throw, from positions of the hand by differences, throw by throw."""
    small, found = 1e-4, []
    for row in range(COUNT):
        times = np.arange(0.0, cycle.release_time[row], config.timestep)[None].repeat(COUNT, axis=0)
        place = [cycle.path.sample(np.maximum(times + k * small, 0.0)).position[row] for k in (-1, 0, 1)]
        a = (place[2] - 2.0 * place[1] + place[0])[1:] / small**2
        o, e = picks.objects, np.hypot(*picks.grasp[row])
        down, sideways = o.mass[row] * (GRAVITY + a[:, 2]), o.mass[row] * np.hypot(a[:, 0], a[:, 1])
        slip = o.seal[row] / (down + sideways / o.cup_friction[row])
        peel = o.seal[row] * LIP / (sideways * o.com_depth[row] + down * (e + LIP))
        found.append(min(slip.min(), peel.min()))
    return np.array(found)


def test_what_is_lost_agrees_with_statics_in_every_throw():
    config, picks, _, cycle, info = thrown(limit=True)
    least = statics(config, picks, cycle)
    np.testing.assert_allclose(info["grip_margin"], least, rtol=0.03)
    sure = np.abs(least - 1.0) > 0.03
    assert sure.mean() > 0.9
    np.testing.assert_array_equal(info["dropped"][sure], least[sure] < 1.0)
    np.testing.assert_array_equal(info["dropped"], info["grip_margin"] < 1.0)


def test_heavy_objects_are_lost_and_care_saves_them_for_time():
    rash, careful = thrown(limit=True)[-1], thrown(limit=True, safety=1.5)[-1]
    assert rash["dropped"].mean() > 0.5
    assert careful["dropped"].mean() < 0.03
    assert careful["is_success"].mean() > rash["is_success"].mean() + 0.4
    assert careful["cycle_time"].mean() > rash["cycle_time"].mean() + 0.05
    assert not (rash["is_success"] & rash["dropped"]).any()


def test_care_keeps_the_safety_that_is_asked_for_on_what_is_measured():
    _, picks, _, cycle, _ = thrown(limit=True, safety=1.5)
    times = np.linspace(0.0, 1.0, 200) * cycle.release_time[:, None]
    hold, acceleration = measured_hold(picks.objects, picks.belt_shift), cycle.path.sample(times).acceleration
    margin, _ = smallest_margin(hold, acceleration, np.full(len(times), 200), 1.0)
    assert margin.min() >= 1.5 * (1.0 - 1e-6)


def test_without_the_limit_everything_holds_and_only_the_margin_tells():
    info, lost = thrown()[-1], thrown(limit=True)[-1]
    assert not info["dropped"].any()
    np.testing.assert_array_equal(info["grip_margin"], lost["grip_margin"])
    assert info["is_success"].mean() > 0.9


def test_lost_objects_begin_where_the_hand_was_and_fall_short():
    _, picks, _, cycle, info = thrown(limit=True)
    lost = info["dropped"]
    reach = np.linalg.norm(cycle.release.position[lost] - picks.pick[lost], axis=1)
    assert (info["landing_along"][lost] < -0.5 * reach).all()


def test_flights_lose_the_same_objects():
    full = thrown(limit=True)[-1]
    flight = core_of({**HEAVY, "fidelity": "flight"}, limit=True).step(np.zeros((COUNT, 2))).info
    np.testing.assert_array_equal(full["dropped"], flight["dropped"])
    np.testing.assert_allclose(full["grip_margin"], flight["grip_margin"])


def test_the_planners_own_world_loses_nothing():
    core = core_of({**HEAVY, "mismatch": 0.0}, limit=True)
    info = core.step(np.zeros((COUNT, 2))).info
    assert not info["dropped"].any()
    assert (info["grip_margin"] > 1e6).all()


def test_objects_that_no_care_can_hold_ride_on():
    slippery = [{**entry, "seal_force": 4.0} for entry in HEAVY["extra_items"][1:]]
    with pytest.raises(ConfigError, match="no object has a feasible throw"):
        core_of({**HEAVY, "items": ["jar"], "extra_items": slippery}, limit=True, safety=2.0)
