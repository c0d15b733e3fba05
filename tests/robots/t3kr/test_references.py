"""Motor references: exact at the knots, close between them, and the same whatever else is in the batch."""

import numpy as np
import pytest

from pnt_gym.robots.joints import knot_count, upsample
from pnt_gym.robots.t3kr.kinematics import forward_kinematics, inverse_kinematics, joint_knots
from tests.tools.t3kr import joint_velocity, motor_torque

SPACING, STRIDE = 0.004, 4


def motions(rows, times, seed=0):
    """Smooth motions of up to 3 g, a different one per row."""
    rng = np.random.default_rng(seed)
    size, rate = rng.uniform(0.05, 0.15, (rows, 1, 3)), rng.uniform(5.0, 14.0, (rows, 1, 3))
    phase = rng.uniform(0.0, 6.0, (rows, 1, 3)) + rate * np.asarray(times)[:, None]
    centre = np.array([0.0, -0.2, -0.6])
    return centre + size * np.sin(phase), size * rate * np.cos(phase), -size * rate**2 * np.sin(phase)


def exact_controls(knots):
    """Controls (N, K, 12) of motors 0 to 3, one sample for each knot."""
    out = np.empty((*knots.position.shape[1:], 12))
    for channel, values in enumerate((knots.position, knots.velocity, knots.torque)):
        out[..., channel::3] = values.transpose(1, 2, 0)
    return out


def sampled(rows, steps, stride=STRIDE, payload=0.02, select=slice(None)):
    times = np.arange(knot_count(steps, stride)) * SPACING
    motion = (part[select] for part in motions(rows, times))
    knots = joint_knots(*motion, payload)
    return upsample(knots, SPACING, stride, np.empty((knots.position.shape[1], steps, 12)))


def test_knots_are_kinematics_and_dynamics():
    x, v, a = motions(3, np.linspace(0.0, 0.5, 50))
    knots = joint_knots(x, v, a, 0.1)
    np.testing.assert_array_equal(np.moveaxis(knots.position, 0, -1), inverse_kinematics(x))
    np.testing.assert_array_equal(np.moveaxis(knots.velocity, 0, -1), joint_velocity(x, v))
    np.testing.assert_array_equal(np.moveaxis(knots.torque, 0, -1), motor_torque(x, v, a, 0.1))


@pytest.mark.parametrize("stride", [1, 4, 10])
def test_samples_on_knots_are_exact_and_between_them_close(stride):
    steps = 10 * stride + 3
    fine = exact_controls(joint_knots(*motions(5, np.arange(steps) * SPACING / stride), 0.02))
    out = sampled(5, steps, stride)
    np.testing.assert_allclose(out[:, ::stride], fine[:, ::stride], rtol=0, atol=1e-12)
    tcp, wanted = forward_kinematics(out[..., 0::3]), motions(5, np.arange(steps) * SPACING / stride)[0]
    assert np.linalg.norm(tcp - wanted, axis=-1).max() < 1e-6
    assert np.abs(out - fine)[..., 1::3].max() < 1e-3
    assert np.abs(out - fine)[..., 2::3].max() < 0.2


@pytest.mark.parametrize("count", [1, 2, 3, 7, 64])
def test_a_row_does_not_depend_on_the_others(count):
    """Bit for bit; 64 rows of 251 knots also cross the block that is solved at once."""
    whole = sampled(64, 1000)
    for start in {0, 5, 64 - count} - set(range(65 - count, 64)):
        part = slice(start, start + count)
        assert np.array_equal(sampled(64, 1000, select=part), whole[part])


def test_further_columns_are_left_alone():
    out = np.full((2, 9, 17), 7.0)
    times = np.arange(knot_count(9, STRIDE)) * SPACING
    returned = upsample(joint_knots(*motions(2, times)), SPACING, STRIDE, out)
    assert returned is out
    assert (out[..., 12:] == 7.0).all()
    assert (out[..., :12] != 7.0).all()


def test_payload_may_change_along_the_motion():
    times = np.arange(6) * SPACING
    x, v, a = motions(2, times)
    mass = np.array([0.5, 0.5, 0.5, 0.0, 0.0, 0.0])
    torque = joint_knots(x, v, a, mass).torque
    np.testing.assert_array_equal(torque[:, :, :3], joint_knots(x, v, a, 0.5).torque[:, :, :3])
    np.testing.assert_array_equal(torque[:, :, 3:], joint_knots(x, v, a, 0.0).torque[:, :, 3:])


def test_out_of_reach_stays_in_its_row():
    x, v, a = motions(3, np.arange(3) * SPACING)
    x[1, 1] = [0.0, 0.0, -2.0]
    out = upsample(joint_knots(x, v, a), SPACING, STRIDE, np.empty((3, 9, 12)))
    assert np.isnan(out[1]).any()
    assert np.isfinite(out[[0, 2]]).all()


@pytest.mark.parametrize(("steps", "stride", "knots"), [(1, 4, 1), (2, 4, 2), (5, 4, 2), (6, 4, 3), (7, 1, 7)])
def test_knot_count_covers_the_last_sample(steps, stride, knots):
    assert knot_count(steps, stride) == knots
    assert (knots - 1) * stride >= steps - 1


@pytest.mark.parametrize(("steps", "stride"), [(0, 4), (4, 0), (-1, 1)])
def test_impossible_counts_are_refused(steps, stride):
    with pytest.raises(ValueError, match="at least 1"):
        knot_count(steps, stride)


@pytest.mark.parametrize("shape", [(2, 14, 12), (3, 9, 12), (2, 9, 11)])
def test_shapes_that_do_not_fit_are_refused(shape):
    knots = joint_knots(*motions(2, np.arange(3) * SPACING))
    with pytest.raises(ValueError, match="needs knots of shape"):
        upsample(knots, SPACING, STRIDE, np.empty(shape))


@pytest.mark.parametrize("spacing", [0.0, -0.004, np.nan])
def test_impossible_spacing_is_refused(spacing):
    knots = joint_knots(*motions(2, np.arange(3) * SPACING))
    with pytest.raises(ValueError, match="spacing"):
        upsample(knots, spacing, STRIDE, np.empty((2, 9, 12)))
