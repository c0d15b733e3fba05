import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.motion import ease, ease_share
from pnt_gym.cells.gripper.planner import TossPlanner
from pnt_gym.robots.gripper import MOTOR_SPEED, check_pose, inverse_kinematics
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD

PLANNERS = {name: TossPlanner(GripperConfig.load(name)) for name in ("nominal", "drop")}
STEP = 0.0005


def draws(planner, count=60, seed=0):
    rng, table = np.random.default_rng(seed), planner.config.table
    kind = rng.integers(len(planner.config.items), size=count)
    return kind, np.stack([rng.uniform(*table.pick_x, count), rng.uniform(*table.pick_y, count)], axis=-1)


def poses(plans, step=STEP):
    return plans.pose(np.arange(0.0, plans.stop_time.max() + 0.02, step))


@pytest.mark.parametrize("name", PLANNERS)
def test_every_throw_is_planned_within_reach_and_motor_speed(name):
    plans = PLANNERS[name].plan(*draws(PLANNERS[name]))
    assert plans.feasible.all()
    way = poses(plans)
    check_pose(way)
    speed = np.abs(np.diff(inverse_kinematics(way), axis=1)) / STEP
    assert speed.max() <= MOTOR_SPEED


def test_drag_free_flight_from_the_release_meets_the_target():
    planner = PLANNERS["nominal"]
    plans = planner.plan(*draws(planner))
    position, velocity = plans.release - plans.hang[:, None] * [0.0, 0.0, 1.0], plans.velocity.copy()
    parts = 2000
    dt = (plans.flight_time / parts)[:, None]
    for _ in range(parts):  # exact for a constant acceleration
        position += velocity * dt - 0.5 * 9.81 * dt**2 * [0.0, 0.0, 1.0]
        velocity -= 9.81 * dt * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(position, plans.target, atol=1e-9)


@pytest.mark.parametrize("name", PLANNERS)
def test_the_motion_passes_pick_and_release_and_ends_at_rest(name):
    planner = PLANNERS[name]
    plans = planner.plan(*draws(planner, 20))
    at = plans.pose(
        np.stack([0 * plans.stop_time, plans.release_time, plans.stop_time, plans.stop_time + 1.0], axis=-1)
    )
    np.testing.assert_allclose(at[:, 0, :3], plans.pick, atol=1e-12)
    np.testing.assert_allclose(at[:, 1, :3], plans.release, atol=1e-12)
    np.testing.assert_allclose(at[:, 2], at[:, 3], atol=1e-12)
    np.testing.assert_allclose(at[:, 3, :3], plans.end, atol=1e-12)
    # The claws just touch the planned width at the release.
    np.testing.assert_allclose(at[:, 1, 3], plans.theta[:, 2], atol=1e-4)
    h = 1e-5
    around = plans.pose(plans.release_time[:, None] + np.array([-h, h]))[..., :3]
    np.testing.assert_allclose((around[:, 1] - around[:, 0]) / (2 * h), plans.velocity, atol=1e-6)


def test_the_line_to_the_release_is_straight():
    planner = PLANNERS["nominal"]
    plans = planner.plan(*draws(planner, 20))
    share = np.linspace(0.0, 1.0, 200)
    time = plans.line_time[:, None] + share * (plans.stop_time - plans.line_time)[:, None]
    way = plans.pose(time)[..., :3] - plans.start[:, None]
    assert np.abs(np.cross(way, plans.velocity[:, None])).max() < 1e-12


@pytest.mark.parametrize("name", PLANNERS)
def test_speed_is_continuous(name):
    planner = PLANNERS[name]
    jump = np.abs(np.diff(poses(planner.plan(*draws(planner, 20))), n=2, axis=1)) / STEP**2
    # Finite accelerations: with a step in speed these would be of the size of the speed over the step, 1000 m/s2.
    assert jump[..., :3].max() < 1.1 * planner.config.motion.acceleration
    assert jump[..., 3].max() < 6.0 * np.deg2rad(20.0) / planner.config.grip.opening**2


def test_a_correction_moves_the_release_and_the_opening_and_nothing_else():
    planner = PLANNERS["nominal"]
    kind, place = draws(planner, 30)
    plain = planner.plan(kind, place)
    plans = planner.plan(kind, place, np.tile([-0.010, 0.006, 0.012], (30, 1)))
    moved = plans.release - plain.release
    np.testing.assert_allclose((moved * plain.heading).sum(axis=1), -0.010, atol=1e-12)
    np.testing.assert_allclose(np.hypot(moved[:, 0], moved[:, 1]), np.hypot(0.010, 0.006), atol=1e-12)
    left = np.cross([0.0, 0.0, 1.0], plain.heading)
    np.testing.assert_allclose((moved * left).sum(axis=1), 0.006, atol=1e-12)
    np.testing.assert_array_equal(plans.velocity, plain.velocity)
    np.testing.assert_allclose(plans.open_time - plans.release_time - plain.open_time + plain.release_time, 0.012)


def test_a_correction_out_of_reach_is_not_feasible():
    planner = PLANNERS["nominal"]
    kind, place = draws(planner, 10)
    assert not planner.plan(kind, place, np.tile([0.2, 0.0, 0.0], (10, 1))).feasible.any()


def test_relaxed_pads_touch_the_planned_width_at_the_contact_angle():
    planner, claws = PLANNERS["nominal"], PROTOTYPE_BUILD.claws
    for item, contact in zip(planner.config.item_list(), planner.theta[:, 2], strict=True):
        gap = claws.width + 2.0 * claws.length * np.sin(contact - claws.theta)
        assert gap == pytest.approx(item.size[1])
        assert claws.gap(contact) == pytest.approx(gap)


@given(st.floats(0.0, 1.0))
def test_the_easing_is_inverted(value):
    assert ease(np.array(ease_share(value))) == pytest.approx(value, abs=1e-3)
