"""Objects are pure functions of standard draws; the release delay is the formula of the vacuum's decay."""

import numpy as np
import pytest

from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.drawing import NORMALS, UNIFORMS, release_delay
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.sections import Suction
from tests.tools.throws import objects_from_draws, parts_of, same_bits, vary

MANY = 20_000
WASTE = ConveyorConfig.load("waste_plain")


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
    columns, suction = np.array([[seal, mass, 0.004, 0.009]]).T, Suction(leak=leak, leak_reference=20.0)
    assert release_delay(*columns, suction)[0] == pytest.approx(delay, abs=1e-15)


def test_delays_of_waste_have_the_calibrated_size(many):
    """The level was calibrated at 19, 36 and 55 ms (5th, 50th and 95th percentile)."""
    np.testing.assert_allclose(np.percentile(many.delay, [5, 50, 95]), [0.019, 0.036, 0.055], atol=0.004)
