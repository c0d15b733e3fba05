"""Honesty of the physics: without mismatch the plan comes true, and each effect alone does what its formula says."""

import pickle

import mujoco
import numpy as np
import pytest

from agents.ground.metrics import wilson
from pnt_gym.cells.base import settling
from pnt_gym.cells.base.plant import Recording
from pnt_gym.cells.conveyor import plant
from pnt_gym.errors import PhysicsError
from pnt_gym.planning.motion.ballistics import landing_point
from pnt_gym.robots.joints import JointMotion
from tests.tools.throws import NO_DELAY, NO_SPREAD, item, make_core, same_bits, vary, with_objects

THROWS = 200
GRAVITY = 9.81


@pytest.fixture(scope="module")
def ideal():
    """The planner's own world: 200 throws with zero action, what is told of them, and their outcome."""
    core = make_core("ideal", THROWS)
    context, judged, throw = core.context, [], core.cell.throw
    core.cell.throw = lambda plans: judged.append(throw(plans)) or judged[0]
    return context, core.step(np.zeros((THROWS, 2))).info, judged[0]


def test_the_planner_is_right_in_its_own_world(ideal):
    """The level's figure is 99 % of 1,000 throws; a sample of 200 must not speak against it."""
    _, info, _ = ideal
    assert info["landing_error"].mean() < 0.005
    assert info["landing_error"].max() < 0.010
    assert info["in_opening"].all()
    assert wilson(int(info["is_success"].sum()), THROWS).high >= 0.99
    assert not info["recontact"].any()
    assert not info["residual_clipped"].any()


def test_errors_are_measured_from_the_target(ideal):
    context, info, outcome = ideal
    miss = outcome.landing - context.target[:, :2]
    np.testing.assert_allclose(np.linalg.norm(miss, axis=1), info["landing_error"], atol=1e-12)
    along = np.einsum("ni,ni->n", miss, context.direction)
    np.testing.assert_allclose(info["landing_along"], along, atol=1e-12)
    squares = info["landing_along"] ** 2 + info["landing_across"] ** 2
    np.testing.assert_allclose(squares, info["landing_error"] ** 2, atol=1e-12)


def test_motors_stay_below_their_torque_and_the_hand_near_its_path(ideal):
    _, info, outcome = ideal
    assert info["peak_torque"].min() > 20.0
    assert info["peak_torque"].max() < 530.0
    assert outcome.tracking_error.max() < 0.002


@pytest.mark.parametrize("level", ["waste", "tight"])
def test_motors_stay_below_their_torque_with_large_corrections(level):
    core = make_core(level, 60, seed=2)
    info = core.step(np.random.default_rng(0).uniform(-1, 1, (60, 2))).info
    assert info["peak_torque"].max() < 530.0


def states_after_release(recording: Recording, count: int):
    """Time, position, velocity and world's angular velocity (count, 10) from the first state without grip on."""
    model, data = recording.model, mujoco.MjData(recording.model)
    mujoco.mj_setState(model, data, recording.state, int(mujoco.mjtState.mjSTATE_INTEGRATION))
    nu, joint = model.nu, model.joint("object")
    q, v = int(joint.qposadr[0]), int(joint.dofadr[0])
    release = int(np.argmin(recording.control[:, nu + model.equality("grip").id]))
    rows = []
    for control in recording.control[: release + count]:
        data.ctrl[:], data.eq_active[:] = control[:nu], control[nu:] > 0
        mujoco.mj_step(model, data)
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, data.qpos[q + 3 : q + 7])
        spin = turn.reshape(3, 3) @ data.qvel[v + 3 : v + 6]
        rows.append(np.concatenate([[data.time], data.qpos[q : q + 3], data.qvel[v : v + 3], spin]))
    return np.array(rows[release:])


def recorded(core) -> Recording:
    core.cell.plant.record_row = 0
    core.step(np.zeros((core.count, 2)))
    return core.cell.plant.recording


@pytest.mark.parametrize("timestep", [0.001, 0.0004])
def test_a_flight_without_mismatch_is_a_parabola(timestep):
    core = make_core(vary("ideal", timestep=timestep), 1, seed=4)
    flight = core.context.plan.flight_time[0]
    states = states_after_release(recorded(core), int(0.9 * flight / timestep))
    t = (states[:, 0] - states[0, 0])[:, None]
    start, velocity = states[0, 1:4], states[0, 4:7]
    parabola = start + velocity * t - [0, 0, 0.5 * GRAVITY] * t**2
    np.testing.assert_allclose(states[:, 1:3], parabola[:, :2], atol=1e-9)
    np.testing.assert_allclose(states[:, 4:6], np.broadcast_to(velocity[:2], (len(t), 2)), atol=1e-9)
    # Euler's steps fall behind the parabola by g h t / 2 and by nothing else.
    lag = 0.5 * GRAVITY * timestep * t[:, 0]
    np.testing.assert_allclose(parabola[:, 2] - states[:, 3], lag, atol=1e-9)


def test_the_object_leaves_with_the_planned_velocity():
    core = make_core(vary("ideal", timestep=0.0004), 1, seed=4)
    plan = core.context.plan
    state = states_after_release(recorded(core), 1)[0]
    np.testing.assert_allclose(state[1:4], plan.position[0], atol=0.003)
    np.testing.assert_allclose(state[4:7], plan.velocity[0] - [0, 0, GRAVITY * 0.0004], atol=0.005)


@pytest.mark.parametrize("yaw", [0.0, 1.2])
def test_the_spin_is_there_right_after_the_release(yaw):
    core = make_core(vary("nominal_plain", spread={"grasp": 0.0}), 1)
    spin = np.array([[2.0, -3.0, 1.0]])
    with_objects(core, yaw=np.array([yaw]), spin=spin)
    states = states_after_release(recorded(core), 1)
    np.testing.assert_allclose(states[0, 7:], spin[0], atol=0.05)


def test_without_spin_nothing_turns():
    core = make_core("ideal", 1)
    states = states_after_release(recorded(core), 50)
    assert np.abs(states[:, 7:]).max() < 0.02


def lonely(**changes):
    """The nominal cell at m = 1 with no delay and no spread, throwing one sphere that air hardly slows down."""
    ball = item("ball", mass=0.006, drag=1e-6, size=(0.07, 0.07, 0.07))
    base = {"items": ["ball"], "extra_items": [ball], "suction": NO_DELAY, "spread": NO_SPREAD}
    return vary("nominal_plain", **{**base, **changes})


def test_a_late_release_carries_the_object_on_at_release_velocity():
    """The hand keeps its velocity in the window, so the flight starts delay x velocity farther on."""
    count, delay = 24, 0.012
    late = {**NO_DELAY, "valve": delay}
    on_time, delayed = (make_core(lonely(suction=s), count, seed=1) for s in (NO_DELAY, late))
    zero = np.zeros((count, 2))
    context = delayed.context
    np.testing.assert_allclose(context.objects.delay, delay)
    measured = delayed.preview(zero).landing - on_time.preview(zero).landing
    start = context.plan.position - np.array([0.0, 0.0, 1.0]) * context.objects.com_depth[:, None]
    velocity, plane = context.plan.velocity, context.target[:, 2]
    expected = landing_point(start + delay * velocity, velocity, plane) - landing_point(start, velocity, plane)
    assert (np.linalg.norm(expected, axis=1) > 0.9 * delay * np.linalg.norm(velocity[:, :2], axis=1)).all()
    np.testing.assert_allclose(measured, expected[:, :2], atol=0.0025)


def test_jitter_is_left_out_of_a_preview_unless_asked_for():
    core = make_core(vary("nominal_plain", suction={"jitter": 0.004}), 12)
    zero = np.zeros((12, 2))
    without, with_ = core.preview(zero), core.preview(zero, jitter=True)
    jitter, speed = core.context.objects.jitter, core.context.plan.speed
    assert (np.abs(with_.landing_along - without.landing_along) > 0.2 * np.abs(jitter) * speed - 1e-3).all()
    assert (np.sign(with_.landing_along - without.landing_along) == np.sign(jitter))[np.abs(jitter) > 0.002].all()
    np.testing.assert_allclose(core.step(zero).info["landing_error"], with_.landing_error, atol=2e-4)


def test_a_grasp_beside_the_centre_moves_the_landing_one_to_one():
    core, count = make_core(lonely(), 12, seed=1), 12
    zero = np.zeros((count, 2))
    centred = core.preview(zero).landing
    offset = np.array([0.010, -0.015])
    with_objects(core, grasp=np.tile(offset, (count, 1)))
    np.testing.assert_allclose(core.preview(zero).landing - centred, np.tile(offset, (count, 1)), atol=0.002)


def test_a_weak_feed_forward_moves_the_hand_off_its_path():
    stiff, weak = (make_core(lonely(spread={**NO_SPREAD, "feedforward": f}), 8, seed=1) for f in (0.0, 0.3))
    zero = np.zeros((8, 2))
    assert weak.preview(zero).tracking_error.min() > stiff.preview(zero).tracking_error.max()


def recontact_share(window, share=None):
    follow = {"follow_through": {"window": window, "gravity_share": share}, "reserve": 0.0}
    core = make_core(vary("ideal", motion=follow), 60)
    angle = core.context.plan.angle
    info = core.step(np.zeros((60, 2))).info
    return info["recontact"][angle > 0.35].mean(), info["recontact"][angle < 0.20], info["landing_error"]


def test_braking_at_once_hits_the_object_again_in_a_steep_throw():
    """At 48 m/s2 the hand falls faster than the object above asin(g / A) = 12 degrees."""
    steep, flat, error = recontact_share(0.0)
    assert steep > 0.6
    assert not flat.any()
    assert error.max() > 0.1


@pytest.mark.parametrize(("window", "share"), [(0.100, None), (0.0, 0.9)])
def test_a_long_window_or_soft_braking_keeps_the_cup_away(window, share):
    steep, flat, error = recontact_share(window, share)
    assert steep == 0.0
    assert not flat.any()
    assert error.max() < 0.01


def test_an_engine_warning_is_an_error_and_not_a_number(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the engine writes its log into the working directory
    core = make_core("nominal_plain", 2)
    context = core.context
    objects = context.objects.replace(spin=np.array([[0.0, 0.0, 0.0], [1e40, 0.0, 0.0]]))
    core.cell.context = context.replace(objects=objects)
    with pytest.raises(PhysicsError, match="MuJoCo warned in simulation 1"):
        core.preview(np.zeros((2, 2)))
    core.cell.context = context
    assert np.isfinite(core.preview(np.zeros((2, 2))).landing_error).all()


def test_a_deliberate_miss_misses_by_what_the_action_says():
    core = make_core("ideal", 40)
    info = core.step(np.ones((40, 2))).info
    whole = ~info["residual_clipped"]
    assert whole.mean() > 0.3
    np.testing.assert_allclose(info["landing_along"][whole], 0.20, atol=0.01)
    np.testing.assert_allclose(info["landing_across"][whole], 0.06, atol=0.005)
    assert not info["is_success"].any()


def test_falls_are_the_same_without_the_checks_above_the_rim(monkeypatch):
    skipping = make_core("waste", 24).step(np.zeros((24, 2))).info
    monkeypatch.setattr(settling, "FASTEST_FALL", 1e9)  # all checks
    checking = make_core("waste", 24).step(np.zeros((24, 2))).info
    assert all(same_bits(skipping[name], values) for name, values in checking.items())


@pytest.mark.parametrize("fidelity", ["flight", "full"])
def test_a_hand_that_rides_out_of_reach_on_a_fast_belt_stops_there(fidelity):
    """Before, the motors got no number and the energy was none."""
    core = make_core(vary("waste", fidelity=fidelity, belt={"speed": 1.3}, limits={"percent": [90]}), 32)
    for _ in range(2):
        info = core.step(np.zeros((32, 2))).info
        assert np.isfinite(info["energy"]).all()
        assert (info["energy"] > 0.0).all()


def test_a_motion_rests_where_it_leaves_the_workspace_for_good():
    gone, inside = np.nan, np.arange(4.0)
    rows = [inside, [0.0, 1.0, gone, gone], [0.0, gone, 2.0, 3.0], [gone, 1.0, 2.0, gone]]
    motion = JointMotion(*(np.array([rows]) for _ in range(4)))
    rested = motion.within_reach()
    np.testing.assert_array_equal(rested.position[0], [inside, [0.0, 1.0, 1.0, 1.0], *rows[2:]])
    np.testing.assert_array_equal(rested.torque[0], rested.position[0])
    np.testing.assert_array_equal(rested.velocity[0], [inside, [0.0, 1.0, 0.0, 0.0], *rows[2:]])
    np.testing.assert_array_equal(rested.acceleration[0], rested.velocity[0])


def test_a_throw_whose_contacts_gain_speed_without_end_is_simulated_again(monkeypatch):
    """In steps of 2 ms a bouncy object shakes on the belt until the engine warns; the other throws are as before."""
    level = vary("waste", timestep=0.002, spread={"restitution": 1.0})
    with monkeypatch.context() as patch:
        patch.setattr(plant, "passive_restitution", lambda step: 1.0)
        with pytest.raises(PhysicsError, match="MuJoCo warned in simulation 8: ") as caught:
            make_core(level, 16, seed=128).step(np.zeros((16, 2)))
        assert set(caught.value.simulations) == {8}
        assert pickle.loads(pickle.dumps(caught.value)).simulations == caught.value.simulations
    together = make_core(level, 16, seed=128).step(np.zeros((16, 2))).info
    for row in (7, 8):
        alone = make_core(level, 1, seed=128 + row).step(np.zeros((1, 2))).info
        assert same_bits({name: values[row : row + 1] for name, values in together.items()}, alone)
