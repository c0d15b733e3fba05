import numpy as np
import pytest

from papers.leveziel.motion import Profile, circle, line
from pnt_gym.engine import mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.robots.gripper import MOTOR_SPEED, JointLimits, PoseError, forward_kinematics
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD, Build, Claws, MotorServo
from pnt_gym.robots.gripper.geometry import PROTOTYPE
from pnt_gym.robots.gripper.model import PAD_BIT, add_gripper, set_options
from pnt_gym.robots.gripper.references import closed_pose, motor_references

STEP = 0.001
LIMITS = JointLimits(acceleration=150.0)
SMOOTH = Profile("s-curve", 0.5)
SLIDES = ("platform_x", "platform_y", "platform_z")


def built(step=STEP, dress=None, build=PROTOTYPE_BUILD, dimensions=PROTOTYPE):
    spec = mujoco.MjSpec()
    set_options(spec, step)
    add_gripper(spec, dimensions, build)
    if dress is not None:
        dress(spec)
    return spec.compile()


MODEL = built()


def loop_gap(data):
    """Largest distance between a forearm's end and its joint on the platform."""
    return max(np.linalg.norm(data.site(f"rod_{i}_end").xpos - data.site(f"attach_{i}").xpos) for i in range(4))


def pose_of(data):
    return np.array([data.joint(name).qpos[0] for name in (*SLIDES, "half_right")])


def followed(model, poses, step=STEP, robot=(PROTOTYPE, PROTOTYPE_BUILD)):
    """Run the motors along poses (S, 4); gap, theta's error, position's error, torque and speed at every step."""
    data = mujoco.MjData(model)
    data.qpos[: model.nq] = closed_pose(poses[0], robot[0])
    rows = []
    for k, control in enumerate(motor_references(poses, step, *robot).controls()[:-1]):
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        error = pose_of(data) - poses[k + 1]
        speed = max(abs(data.joint(f"arm_{i}").qvel[0]) for i in range(4))
        rows.append((loop_gap(data), abs(error[3]), np.linalg.norm(error[:3]), abs(data.actuator_force).max(), speed))
    assert not data.warning.number.any()
    return np.array(rows)


def driven(model, poses, push=0.0):
    """The data after the motors have been run along poses (S, 4), with a torque on the right half [N m]."""
    data = mujoco.MjData(model)
    data.qpos[:] = closed_pose(poses[0])
    data.joint("half_right").qfrc_applied[0] = push
    for control in motor_references(poses, STEP).controls():
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
    return data


def sampled(motion, step=STEP, rest=0.03):
    time = np.arange(0.0, motion.duration + rest, step)
    return np.stack([np.interp(time, motion.time, column) for column in motion.pose.T], axis=-1)


@pytest.mark.parametrize("theta", [-30.0, -45.0, -55.0])
@pytest.mark.parametrize(
    ("start", "end"),
    [
        ((0.0, 0.0, -0.25), (0.0, 0.0, -0.20)),
        ((0.0, -0.035, -0.20), (0.0, 0.035, -0.20)),
        ((-0.05, -0.03, -0.24), (0.06, 0.02, -0.195)),
    ],
)
def test_cartesian_moves_at_the_prototypes_speed_keep_the_loops_closed_and_theta(theta, start, end):
    angle = np.deg2rad(theta)
    motion = line([*start, angle], [*end, angle], limits=LIMITS, profile=SMOOTH)
    gap, turned, away, torque, speed = followed(MODEL, sampled(motion)).max(axis=0)
    assert gap <= 0.05e-3
    assert turned <= np.deg2rad(0.2)
    assert away <= 0.2e-3
    assert torque <= 3.0
    assert 0.7 * MOTOR_SPEED < speed <= 1.01 * MOTOR_SPEED


def test_a_circle_keeps_the_loops_closed_and_theta():
    motion = circle((0.0, 0.0, -0.22), np.deg2rad(-50.0), limits=JointLimits(speed=5.5, acceleration=150.0))
    gap, turned, *_ = followed(MODEL, sampled(motion)).max(axis=0)
    assert gap <= 0.05e-3
    assert turned <= np.deg2rad(0.2)


def test_an_industrial_size_robot_moves_at_three_metres_per_second():
    scale, servo = 4.1, MotorServo(60.0, no_load_speed=20.0, speed=15.0, armature=0.05, kp=4000.0, kv=30.0)
    large, build = PROTOTYPE.with_scale(scale), PROTOTYPE_BUILD.with_scale(scale, servo)
    model = built(build=build, dimensions=large)
    limits = JointLimits(speed=servo.speed, acceleration=80.0)
    angle = np.deg2rad(-50.0)
    motion = line([-0.25, -0.1, -0.95, angle], [0.25, 0.1, -0.8, angle], large, limits=limits, profile=SMOOTH)
    poses = sampled(motion)
    gap, turned, away, torque, _ = followed(model, poses, robot=(large, build)).max(axis=0)
    assert np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1).max() / STEP > 3.0
    assert gap <= 0.05e-3 * scale
    assert turned <= np.deg2rad(0.2)
    assert away <= 1e-3
    assert torque < servo.stall_torque


def test_closing_the_gripper_takes_sixty_milliseconds():
    home, closed = PROTOTYPE.home, PROTOTYPE.home.copy()
    closed[3] = np.deg2rad(-60.0)
    motion = line(home, closed, limits=LIMITS, profile=Profile("trapezoid", 0.5))
    assert motion.duration <= 0.060
    rows = followed(MODEL, sampled(motion, rest=0.010))
    assert rows[-1, 1] <= np.deg2rad(0.2)


def test_closed_poses_close_the_loops_and_agree_with_the_kinematics():
    rng = np.random.default_rng(3)
    data = mujoco.MjData(MODEL)
    for _ in range(50):
        pose = np.append(rng.uniform((-0.06, -0.06, -0.23), (0.06, 0.06, -0.19)), rng.uniform(-1.04, -0.53))
        data.qpos[:] = closed_pose(pose)
        mujoco.mj_kinematics(MODEL, data)
        assert loop_gap(data) < 1e-12
        q = np.array([data.joint(f"arm_{i}").qpos[0] for i in range(4)])
        np.testing.assert_allclose(forward_kinematics(q), pose, atol=1e-10)


def test_the_gear_turns_both_halves_alike_under_a_one_sided_load():
    data = driven(MODEL, np.tile(PROTOTYPE.home, (300, 1)), push=0.3)
    right, left = data.joint("half_right").qpos[0], data.joint("half_left").qpos[0]
    assert right - PROTOTYPE.home_theta > 1e-4  # the servos give
    assert abs(right - left) < np.deg2rad(0.05)


def test_feed_forward_alone_holds_the_robot():
    soft = built(build=PROTOTYPE_BUILD.with_servo(kp=1e-6, kv=1e-6))
    pose = np.array([0.02, -0.03, -0.22, np.deg2rad(-50.0)])
    data = driven(soft, np.tile(pose, (50, 1)))
    # In free fall it would be 12 mm lower by now.
    assert np.linalg.norm(pose_of(data)[:3] - pose[:3]) < 0.5e-3


def test_a_servo_gives_no_more_than_its_stall_torque():
    data = mujoco.MjData(MODEL)
    data.qpos[:] = closed_pose(PROTOTYPE.home)
    controls = motor_references(np.tile(PROTOTYPE.home, (3, 1)), STEP).controls()[0]
    controls[0] += 0.5
    data.ctrl[:] = controls
    mujoco.mj_step(MODEL, data)
    assert data.actuator_force[0] == pytest.approx(3.0)


def test_the_springs_limit_the_grip_on_a_rigid_object():
    claws, squeeze = PROTOTYPE_BUILD.claws, np.deg2rad(6.0)

    def bar(spec):
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=[0, 0, -0.22 - claws.length],
            size=[0.01, claws.width / 2.0, 0.005],
            contype=0,
            conaffinity=PAD_BIT,
        )

    model = built(dress=bar)
    share = np.linspace(0.0, 1.0, 150)
    theta = np.concatenate([claws.theta + 0.1 - share * (0.1 + squeeze), np.full(250, claws.theta - squeeze)])
    poses = np.column_stack([np.tile([0.0, 0.0, -0.22], (400, 1)), theta])
    data = driven(model, poses)
    force, normal = np.zeros(6), {}
    for index, contact in enumerate(data.contact):
        mujoco.mj_contactForce(model, data, index, force)
        pad = next(int(g) for g in contact.geom if model.geom(int(g)).name.startswith("pad"))
        normal[pad] = normal.get(pad, 0.0) + force[0]
    assert len(normal) == 2
    # The servos give by half a degree and the pads sink in.
    bent = data.joint("finger_right").qpos[0]
    assert np.deg2rad(4.5) < bent < squeeze
    np.testing.assert_allclose(list(normal.values()), claws.force(bent), rtol=0.08)


def test_references_ask_for_a_pose_in_reach_and_for_three_poses():
    with pytest.raises(PoseError, match="reach"):
        motor_references(np.tile([0.0, 0.0, -0.9, -0.8], (5, 1)), STEP)
    with pytest.raises(PoseError, match="three poses"):
        motor_references(np.tile(PROTOTYPE.home, (2, 1)), STEP)
    with pytest.raises(PoseError, match="reach"):
        closed_pose([0.5, 0.0, -0.2, -0.8])


@pytest.mark.parametrize("step", [0.0, 0.0015, -0.001])
def test_a_step_that_is_too_long_is_refused(step):
    with pytest.raises(ConfigError, match="timestep"):
        set_options(mujoco.MjSpec(), step)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: MotorServo(kp=0.0), "servo.kp"),
        (lambda: Claws(stiffness=-1.0), "claws.stiffness"),
        (lambda: Claws(theta=0.2), "claws.theta"),
        (lambda: Build(arm_mass=float("nan")), "arm_mass"),
    ],
)
def test_impossible_parts_are_refused(make, name):
    with pytest.raises(ConfigError, match=name):
        make()


def test_the_servo_stops_pushing_at_its_no_load_speed():
    servo = PROTOTYPE_BUILD.servo
    assert servo.damping * servo.no_load_speed == pytest.approx(servo.stall_torque)
    assert servo.no_load_speed > MOTOR_SPEED
