"""Positive work of motors, against kinetic energies that are known in closed form."""

import numpy as np
import pytest

from pnt_gym.cells.base.energy import work_between, work_of_steps

INERTIA = np.array([0.02, 0.3])
TURN, TIME = np.array([0.8, -1.1]), 0.5


def swing(times):
    """Torque and speed (K, 2) of two arms that turn from rest to rest, theta = turn (1 - cos(pi t / T)) / 2."""
    rate = np.pi / TIME
    speed = TURN / 2.0 * rate * np.sin(rate * times)[:, None]
    return INERTIA * TURN / 2.0 * rate**2 * np.cos(rate * times)[:, None], speed


def kinetic():
    """What is put in until the middle, where the arms are fastest; braking gives nothing back."""
    return (INERTIA * (TURN / 2.0 * np.pi / TIME) ** 2 / 2.0).sum()


def test_a_planned_motion_costs_its_largest_kinetic_energy():
    times = np.linspace(0.0, TIME, 2001)
    torque, speed = swing(times)
    assert work_between(torque[None], speed[None], times[None]) == pytest.approx([kinetic()], rel=1e-5)
    assert work_between(-torque[None], speed[None], times[None]) == pytest.approx([kinetic()], rel=1e-5)


def test_steps_of_a_leapfrog_cost_the_same():
    """Torque at the beginning of a step, speed in its middle, as the engine steps."""
    step, count = TIME / 5000, 5000
    begin = np.arange(count) * step
    torque, speed = swing(begin)[0], swing(begin + step / 2.0)[1]
    assert work_of_steps(torque[None], speed[None], np.array([count]), step) == pytest.approx([kinetic()], rel=1e-5)


def test_one_motor_does_not_live_on_what_another_brakes():
    torque, speed = np.array([[[2.0, -2.0]]]), np.array([[[3.0, 3.0]]])
    assert work_of_steps(torque, speed, np.array([1]), 0.1) == pytest.approx([0.6])
