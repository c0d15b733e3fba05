"""`fidelity: flight`: the same draws as the full physics, nearly the same landings, a fraction of the time."""

import numpy as np
import pytest

from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core

COUNT = 60
SAME = ("item", "bin", "target_x", "target_y", "residual_clipped", "picked", "dropped", "bin_depth")


def infos(level, fidelity, seed=0, count=COUNT):
    core = make_core({"base": level, "fidelity": fidelity}, count, seed=seed)
    return core.step(np.random.default_rng(seed).uniform(-0.4, 0.4, (count, 2))).info


# Without any delay objects are let go while the robot still settles after accelerating. A cup that yields costs a
# little: its swing is reckoned, not simulated.
BOUNDS = (
    {"ideal": 0.006}
    | dict.fromkeys(("nominal_plain", "waste_plain", "unseen_plain", "fast_plain"), 0.0025)
    | dict.fromkeys(("nominal", "waste", "unseen"), 0.003)
)


@pytest.mark.parametrize("level", with_nightly(BOUNDS, ["ideal", "waste_plain", "waste"]))
def test_flights_are_those_of_the_full_physics(level):
    flight, full = infos(level, "flight"), infos(level, "full")
    for name in SAME:
        np.testing.assert_array_equal(flight[name], full[name])
    assert full["picked"].all() == (level not in ("nominal", "waste", "unseen"))
    np.testing.assert_allclose(flight["grip_margin"], full["grip_margin"])
    np.testing.assert_allclose(flight["cycle_time"], full["cycle_time"], atol=1e-12)
    thrown = full["picked"] & ~full["dropped"] & ~flight["recontact"] & ~full["recontact"]
    for name in ("landing_along", "landing_across"):
        assert np.quantile(np.abs(flight[name] - full[name])[thrown], 0.95) < BOUNDS[level]
    assert (flight["is_success"] != full["is_success"]).mean() <= 0.06
    assert abs(flight["is_success"].mean() - full["is_success"].mean()) <= 0.05
    np.testing.assert_allclose(flight["peak_torque"], full["peak_torque"], atol=8.0)


def test_a_cup_that_comes_back_is_found_by_geometry():
    level = {"base": "waste_plain", "motion": {"follow_through": {"window": 0.0}}}
    told = []
    for fidelity in ("flight", "full"):
        core = make_core(level | {"fidelity": fidelity}, COUNT)
        told.append(core.step(np.zeros((COUNT, 2))).info["recontact"])
    flight, full = told
    assert full.sum() > COUNT / 10
    assert (flight & full).sum() > 0.6 * full.sum()
    assert (flight & ~full).sum() <= 0.1 * COUNT
