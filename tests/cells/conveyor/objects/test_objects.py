"""Objects are pure functions of standard draws; the release delay is the formula of the vacuum's decay."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig, Suction
from pnt_gym.cells.conveyor.objects.drawing import NORMALS, UNIFORMS, objects_from_draws, release_delay
from pnt_gym.cells.conveyor.objects.records import Objects
from tests.tools.throws import NO_SPREAD, parts_of, same_bits, vary

MANY = 20_000
WASTE = ConveyorConfig.load("waste_plain")
HIDDEN_EFFECTS = ("delay", "jitter", "grasp", "spin", "belt_error")


def draws(count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((count, NORMALS)), rng.random((count, UNIFORMS))


def objects(config, count=MANY, seed=0) -> Objects:
    return objects_from_draws(*draws(count, seed), config, item_arrays(config.item_list()))


@pytest.fixture(scope="module")
def many():
    return objects(WASTE)


def assert_same(a: Objects, b: Objects, but=()):
    other = parts_of(b)
    for name, values in parts_of(a).items():
        assert name in but or same_bits(values, other[name]), name


def test_equal_draws_give_equal_objects_and_leave_the_draws_alone():
    normals, uniforms = draws(50)
    before = normals.copy(), uniforms.copy()
    table = item_arrays(WASTE.item_list())
    assert_same(
        objects_from_draws(normals, uniforms, WASTE, table), objects_from_draws(normals, uniforms, WASTE, table)
    )
    assert same_bits(normals, before[0])
    assert same_bits(uniforms, before[1])


def test_measured_minus_true_is_the_sensor_noise(many):
    noise = WASTE.noise
    assert np.std(np.log(many.measured.mass / many.mass)) == pytest.approx(noise.mass, rel=0.03)
    assert np.std(np.log(many.measured.seal / many.seal)) == pytest.approx(noise.seal, rel=0.03)
    assert np.std(many.measured.yaw - many.yaw) == pytest.approx(noise.yaw, rel=0.03)
    assert np.std(many.measured.size[:, :2] - many.size[:, :2]) == pytest.approx(noise.size, rel=0.03)
    assert np.std(many.measured.grasp_noise) == pytest.approx(noise.grasp, rel=0.03)
    assert same_bits(many.measured.size[:, 2], many.size[:, 2])


def test_spreads_are_the_configured_ones(many):
    table, spread = item_arrays(WASTE.item_list()), WASTE.spread
    empty = ~table.container[many.kind]
    mass = np.log(many.mass / table.mass[many.kind])[empty]
    seal = np.log(many.seal / table.seal_force[many.kind])
    drag = np.log(many.drag / table.drag[many.kind])
    volume = np.log(many.size[:, 0] / table.size[many.kind, 0])
    assert mass.mean() == pytest.approx(0.0, abs=0.01)
    assert mass.std() == pytest.approx(spread.mass, rel=0.03)
    assert seal.std() == pytest.approx(spread.seal, rel=0.03)
    assert drag.std() == pytest.approx(spread.drag, rel=0.03)
    assert volume.std() == pytest.approx(np.hypot(spread.size, spread.size_axis), rel=0.03)
    assert many.grasp.std() == pytest.approx(spread.grasp, rel=0.03)
    assert many.belt_error.std() == pytest.approx(spread.belt_speed, rel=0.03)


def test_every_item_and_speed_comes_up_equally_often(many):
    kinds = np.bincount(many.kind, minlength=len(WASTE.items)) / MANY
    np.testing.assert_allclose(kinds, 1 / len(WASTE.items), atol=0.008)
    share = [np.mean(many.percent == p) for p in WASTE.limits.percent]
    np.testing.assert_allclose(share, 1 / 3, atol=0.015)
    assert sum(share) == pytest.approx(1.0)


def test_places_and_yaw_fill_their_ranges(many):
    belt = WASTE.belt
    for values, (low, high) in (
        (many.yaw, (-np.pi / 2, np.pi / 2)),
        (many.draws.lane_y, belt.lane_y),
        (many.draws.gap, belt.spacing),
    ):
        assert low <= values.min() < low + 0.01 * (high - low)
        assert high - 0.01 * (high - low) < values.max() <= high
        assert values.mean() == pytest.approx((low + high) / 2, abs=0.02 * (high - low))


def test_only_containers_carry_a_residue_and_as_often_as_configured():
    config = vary("waste_plain", spread={"mass": 0.0})
    o, table = objects(config), item_arrays(config.item_list())
    ratio, container = o.mass / table.mass[o.kind], table.container[o.kind]
    np.testing.assert_allclose(ratio[~container], 1.0, rtol=1e-12)
    assert ratio[container].max() <= 1 + config.spread.residue
    assert np.mean(ratio[container] > 1.0) == pytest.approx(config.spread.residue_chance, abs=0.02)


def test_the_centre_of_mass_stays_inside(many):
    depth = many.com_depth / many.size[:, 2]
    noise = 5 * WASTE.spread.height / many.size[:, 2]
    assert (depth > 0.05 - noise).all()
    assert (depth < 0.95 + noise).all()
    assert (many.size > 0.0).all()
    assert (many.mass > 0.0).all()
    assert (many.delay >= 0.0).all()


def test_cylinders_keep_one_diameter(many):
    cylinder = many.shape == 1
    assert cylinder.any()
    assert same_bits(many.size[cylinder, 1], many.size[cylinder, 2])
    assert (many.size[~cylinder, 1] != many.size[~cylinder, 2]).all()


def test_mismatch_zero_kills_every_hidden_effect():
    o = objects(vary("waste_plain", mismatch=0.0))
    for name in HIDDEN_EFFECTS:
        np.testing.assert_array_equal(getattr(o, name), 0.0, err_msg=name)
    assert same_bits(o.known_depth, o.com_depth)


def test_mismatch_zero_leaves_catalogue_and_noise():
    with_, without = objects(WASTE), objects(vary("waste_plain", mismatch=0.0))
    # The height error is a hidden effect, and moves the centre of mass.
    assert_same(with_, without, but=(*HIDDEN_EFFECTS, "known_depth", "com_depth"))
    assert np.abs(with_.com_depth - without.com_depth).std() < 0.003


@given(st.floats(0.1, 3.0))
@settings(max_examples=15, deadline=None)
def test_hidden_effects_grow_with_the_dial(m):
    one, other = objects(WASTE, 200), objects(vary("waste_plain", mismatch=m), 200)
    np.testing.assert_allclose(other.grasp, m * one.grasp, rtol=1e-12)
    np.testing.assert_allclose(other.spin, m * one.spin, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(other.jitter, m * one.jitter, rtol=1e-12)
    np.testing.assert_allclose(other.belt_error, m * one.belt_error, rtol=1e-12)
    positive = (one.delay > 0.0) & (other.delay > 0.0)
    np.testing.assert_allclose(other.delay[positive], m * one.delay[positive], rtol=1e-9)
    np.testing.assert_allclose(other.known_depth, max(1 - m, 0) * other.com_depth, rtol=1e-12)


def test_without_spread_all_objects_of_a_kind_are_those_of_the_catalogue():
    config = vary("waste_plain", spread=NO_SPREAD)
    o, table = objects(config, 500), item_arrays(config.item_list())
    np.testing.assert_allclose(o.mass, table.mass[o.kind], rtol=1e-14)
    np.testing.assert_allclose(o.size, table.size[o.kind], rtol=1e-14)
    np.testing.assert_allclose(o.drag, table.drag[o.kind], rtol=1e-14)
    np.testing.assert_allclose(o.com_depth, table.com_depth[o.kind] * table.size[o.kind, 2], rtol=1e-14)
    np.testing.assert_array_equal(o.spin, 0.0)


def test_an_off_centre_grip_turns_the_object_about_the_level_axis_beside_it():
    """An object gripped at +x of its centre gains spin about -y, one gripped at +y spin about +x... per metre."""
    config = vary("nominal_plain", spread={"spin": 0.0, "spin_per_offset": 30.0})
    o = objects(config, 100)
    np.testing.assert_allclose(o.spin[:, 0], 30.0 * o.grasp[:, 1], rtol=1e-12)
    np.testing.assert_allclose(o.spin[:, 1], -30.0 * o.grasp[:, 0], rtol=1e-12)
    np.testing.assert_array_equal(o.spin[:, 2], 0.0)


# Suction. Each expected value was worked out by hand from valve + tau_e ln(F0 / (m g)).


@pytest.mark.parametrize(
    ("seal", "mass", "leak", "delay"),
    [
        # F0 = 20 N and m g = 20 / e^3 N: ln = 3, so 4 ms + 9 ms * 3.
        (20.0, 20.0 / np.exp(3.0) / 9.81, 0.25, 0.031),
        # F0 = 4 N leaks: the factor is 1 + 0.25 (5 - 1) = 2, so tau_e = 4.5 ms; ln(F0 / (m g)) = 2.
        (4.0, 4.0 / np.exp(2.0) / 9.81, 0.25, 0.013),
        # F0 = 0.1 N does not hold: ln(0.1 / 9.81) = -4.6 would be 37 ms before the command.
        (0.1, 1.0, 0.0, 0.0),
    ],
    ids=["tight", "leaking", "none"],
)
def test_the_delay_of_a_seal(seal, mass, leak, delay):
    suction = Suction(valve=0.004, tau=0.009, leak=leak, leak_reference=20.0)
    assert release_delay(np.array([seal]), np.array([mass]), suction)[0] == pytest.approx(delay, abs=1e-15)


@given(
    seal=st.floats(1.0, 60.0),
    mass=st.floats(0.002, 0.06),
    more=st.floats(1.01, 3.0),
)
def test_delay_grows_with_the_seal_and_falls_with_the_mass(seal, mass, more):
    suction = Suction()

    def delay(f, m):
        return release_delay(np.array([f]), np.array([m]), suction)[0]

    assert delay(seal * more, mass) > delay(seal, mass)
    assert delay(seal, mass * more) < delay(seal, mass)


def test_delays_of_waste_have_the_calibrated_size(many):
    """The level was calibrated at 19, 36 and 55 ms (5th, 50th and 95th percentile)."""
    np.testing.assert_allclose(np.percentile(many.delay, [5, 50, 95]), [0.019, 0.036, 0.055], atol=0.004)


def test_jitter_is_part_of_the_delay(many):
    rest = many.delay - many.jitter
    np.testing.assert_allclose(rest, release_delay(many.seal, many.mass, WASTE.suction), rtol=1e-9, atol=1e-12)
    assert many.jitter.std() == pytest.approx(WASTE.suction.jitter, rel=0.03)
