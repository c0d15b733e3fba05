"""The compiled formulas against the same mechanics written with whole arrays and matrices, on random rows."""

import numpy as np
import pytest

from pnt_gym.robots.joints import JointMotion, upsample
from pnt_gym.robots.t3kr.geometry import T3KR, T3krGeometry
from pnt_gym.robots.t3kr.kinematics import jacobian, joint_knots

LONGER = T3krGeometry(arm_length=0.8, rod_length=1.15, rod_mass=0.4, platform_mass=1.5, arm_com=0.4)


def random_motion(seed=0):
    rng = np.random.default_rng(seed)
    x = rng.uniform([-0.3, -0.5, -0.8], [0.3, 0.5, -0.2], (40, 3, 3))
    return x, 2.0 * rng.normal(size=x.shape), 60.0 * rng.normal(size=x.shape), rng.uniform(0.0, 2.0, (40, 3))


def arm_vectors(x, geometry):
    """Unit vectors along the arms, along the elbows' travel, and the rods from elbow to platform (..., 4, 3)."""
    frames = geometry.arms
    out = np.stack([np.cos(frames.azimuth), np.sin(frames.azimuth), 0.0 * frames.azimuth], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    d = x[..., None, :] + frames.attach - frames.pivot
    k = ((d**2).sum(axis=-1) + geometry.arm_length**2 - geometry.rod_length**2) / (2.0 * geometry.arm_length)
    d_x, d_z = (d * out).sum(axis=-1), d[..., 2]
    q = np.arctan2(d_z, d_x) + np.arccos(k / np.hypot(d_x, d_z))
    along = np.cos(q)[..., None] * out + np.sin(q)[..., None] * up
    return q, along, np.cos(q)[..., None] * up - np.sin(q)[..., None] * out, d - geometry.arm_length * along


@pytest.mark.parametrize("geometry", [T3KR, LONGER])
def test_joint_motion_is_that_of_vectors_and_matrices(geometry):
    x, v, a, payload = random_motion()
    q, along, travel, rod = arm_vectors(x, geometry)
    length, pair = geometry.arm_length, 2.0 * geometry.rod_mass
    lever = length * (rod * travel).sum(axis=-1)
    rows = rod / lever[..., None]
    q_dot = np.einsum("nkij,nkj->nki", rows, v)
    rod_rate = v[..., None, :] - length * q_dot[..., None] * travel
    spin = (length * q_dot**2)[..., None] * along
    q_ddot = ((rod * (a[..., None, :] + spin)).sum(axis=-1) + (rod_rate**2).sum(axis=-1)) / lever
    elbow = length * q_ddot[..., None] * travel - spin
    gravity = np.array([0.0, 0.0, 9.81])
    # Forces on the rods' ends: m (2 a + b) / 6 and half of the weight.
    at_elbow = pair * ((2.0 * elbow + a[..., None, :]) / 6.0 + gravity / 2.0)
    at_platform = pair * ((2.0 * a[..., None, :] + elbow) / 6.0 + gravity / 2.0)
    load = (geometry.platform_mass + payload)[..., None] * (a + gravity) + at_platform.sum(axis=-2)
    arm = geometry.arm_inertia + geometry.arm_mass * geometry.arm_com**2 + geometry.armature
    torque = arm * q_ddot + length * (at_elbow * travel).sum(axis=-1)
    torque += geometry.arm_mass * geometry.arm_com * 9.81 * np.cos(q)
    torque += np.einsum("nkji,nkj->nki", np.linalg.pinv(rows), load)
    ours = joint_knots(x, v, a, payload, geometry=geometry)
    for values, wanted in zip(vars(ours).values(), (q, q_dot, q_ddot, torque), strict=True):
        np.testing.assert_allclose(values.transpose(1, 2, 0), wanted, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(jacobian(x, geometry), rows, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("stride", "steps"), [(1, 9), (4, 33), (4, 30), (7, 57)])
def test_samples_are_the_hermite_polynomial_and_its_derivative(stride, steps):
    rng = np.random.default_rng(stride)
    knots, spacing = JointMotion(*rng.normal(size=(4, 4, 5, 9))), 0.02
    count = (steps + stride - 2) // stride + 1
    out = upsample(
        JointMotion(*(v[..., :count].copy() for v in vars(knots).values())), spacing, stride, np.empty((5, steps, 12))
    )
    for k in range(steps):
        knot, u = k // stride, (k % stride) / stride
        p, v, t = (values[..., knot] for values in (knots.position, knots.velocity, knots.torque))
        if u == 0.0:
            wanted = p, v, t
        else:
            p1, v1, t1 = (values[..., knot + 1] for values in (knots.position, knots.velocity, knots.torque))
            cubic = np.polynomial.Polynomial.fromroots  # the four Hermite polynomials, from their double roots
            h01, h10, h11 = -2.0 * cubic([0, 0, 1.5]), cubic([0, 1, 1]), cubic([0, 0, 1])
            place = p + h01(u) * (p1 - p) + spacing * (h10(u) * v + h11(u) * v1)
            rate = h01.deriv()(u) * (p1 - p) / spacing + h10.deriv()(u) * v + h11.deriv()(u) * v1
            wanted = place, rate, (1.0 - u) * t + u * t1
        for channel, values in enumerate(wanted):
            np.testing.assert_allclose(out[:, k, channel::3], values.T, rtol=1e-9, atol=1e-11)
