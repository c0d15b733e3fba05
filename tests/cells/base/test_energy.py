"""Positive work of motors, against kinetic energies that are known in closed form."""

import numpy as np
import pytest

from pnt_gym.arrays import in_order
from pnt_gym.cells.base.recorded import MotorRecord, loads_between, loads_of_steps

INERTIA = np.array([0.02, 0.3])
TURN, TIME = np.array([0.8, -1.1]), 0.5


def swing(times):
    """Torque and speed (K, 2) of two arms that turn from rest to rest, theta = turn (1 - cos(pi t / T)) / 2."""
    rate = np.pi / TIME
    speed = TURN / 2.0 * rate * np.sin(rate * times)[:, None]
    return INERTIA * TURN / 2.0 * rate**2 * np.cos(rate * times)[:, None], speed


def recorded(torque, speed):
    """A record (N, K, 2 J) of J motors whose columns stand in reverse order among others."""
    columns = 2 * np.arange(torque.shape[-1])[::-1].copy()
    sensors, rates = np.full((2, *torque.shape[:-1], 2 * torque.shape[-1]), 7.0)
    sensors[..., columns], rates[..., columns + 1] = torque, speed
    return MotorRecord(sensors, columns, rates, columns + 1)


def kinetic():
    """What is put in until the middle, where the arms are fastest; braking gives nothing back."""
    return (INERTIA * (TURN / 2.0 * np.pi / TIME) ** 2 / 2.0).sum()


def test_a_planned_motion_costs_its_largest_kinetic_energy():
    times = np.linspace(0.0, TIME, 2001)
    torque, speed = swing(times)
    assert loads_between(*in_order(torque.T[:, None], speed.T[:, None], times[None]))[1] == pytest.approx(
        [kinetic()], rel=1e-5
    )
    assert loads_between(*in_order(-torque.T[:, None], speed.T[:, None], times[None]))[1] == pytest.approx(
        [kinetic()], rel=1e-5
    )


def test_steps_of_a_leapfrog_cost_the_same():
    """Torque at the beginning of a step, speed in its middle, as the engine steps."""
    step, count = TIME / 5000, 5000
    begin = np.arange(count) * step
    torque, speed = swing(begin)[0], swing(begin + step / 2.0)[1]
    assert loads_of_steps(recorded(torque[None], speed[None]), np.array([count]), step)[1] == pytest.approx(
        [kinetic()], rel=1e-5
    )


def test_one_motor_does_not_live_on_what_another_brakes():
    torque, speed = np.array([[[2.0, -2.0]]]), np.array([[[3.0, 3.0]]])
    assert loads_of_steps(recorded(torque, speed), np.array([1]), 0.1)[1] == pytest.approx([0.6])


def total(parts):
    """Sums of rows from left to right."""
    return np.cumsum(parts, axis=1)[:, -1]


def test_loads_are_those_of_the_formulas_to_the_last_bit():
    random = np.random.default_rng(4)
    torque, speed = random.normal(size=(2, 7, 30, 4))
    torque[2, 3, 1] = np.nan
    largest, work = loads_of_steps(recorded(torque, speed), steps := random.integers(1, 31, size=7), 1e-3)
    counts = np.arange(30) < steps[:, None]
    assert_same(largest, np.where(counts, np.abs(torque).max(axis=2), 0.0).max(axis=1))
    before = np.concatenate([speed[:, :1], speed[:, :-1]], axis=1)
    power = np.maximum(torque * ((before + speed) / 2.0), 0.0).sum(axis=-1)
    assert_same(work, total(np.where(counts, power, 0.0) * 1e-3))
    times = np.cumsum(random.random(size=(7, 30)), axis=1)
    largest, work = loads_between(*in_order(np.moveaxis(torque, 2, 0), np.moveaxis(speed, 2, 0), times))
    power = np.maximum(torque * speed, 0.0).sum(axis=-1)
    assert_same(largest, np.abs(torque).max(axis=(1, 2)))
    assert_same(work, total((power[:, 1:] + power[:, :-1]) / 2.0 * np.diff(times, axis=1)))
    assert np.isnan(largest).tolist() == np.isnan(work).tolist() == [row == 2 for row in range(7)]


def assert_same(values, formula):
    """No bit differs."""
    np.testing.assert_array_equal(values, formula)
