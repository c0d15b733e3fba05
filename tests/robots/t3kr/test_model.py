"""The MuJoCo model: what is in it, that its loops close, and that it can hold still."""

import mujoco
import numpy as np
import pytest

from pnt_gym.robots.joints import qpos_columns
from pnt_gym.robots.specification import set_options
from pnt_gym.robots.t3kr.geometry import T3KR, T3krGeometry
from pnt_gym.robots.t3kr.kinematics import closed_pose, inverse_kinematics
from pnt_gym.robots.t3kr.model import add_t3kr
from tests.tools.t3kr import WORKSPACE, control_columns, motor_torque

SIZES = {"four": {"nq": 15, "nv": 15, "neq": 4}, "eight": {"nq": 27, "nv": 26, "neq": 8}}


def build(rods="four", geometry=T3KR, before=0, timestep=0.001):
    """A model with the robot, after `before` free bodies that shift every index."""
    spec = mujoco.MjSpec()
    for k in range(before):
        body = spec.worldbody.add_body(name=f"free_{k}", pos=[3.0 + k, 0, 0])
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.02, 0, 0])
    handles = add_t3kr(spec, geometry, rods)
    set_options(spec, timestep)
    return spec.compile(), handles


def points(count=200):
    cloud = np.random.default_rng(1).uniform([-0.45, -0.8, -0.95], [0.45, 0.8, 0.0], (3 * count, 3))
    return cloud[WORKSPACE.contains(cloud)][:count]


@pytest.mark.parametrize("rods", ["four", "eight"])
@pytest.mark.parametrize("before", [0, 2])
def test_closed_pose_closes_every_loop(rods, before):
    model, handles = build(rods, before=before)
    data = mujoco.MjData(model)
    cloud, columns = points(), qpos_columns(model, handles)
    for tcp, pose in zip(cloud, closed_pose(cloud, handles.rods_per_arm, handles.geometry), strict=True):
        data.qpos[columns] = pose
        mujoco.mj_kinematics(model, data)
        ends = data.site_xpos[model.eq_obj1id] - data.site_xpos[model.eq_obj2id]
        assert np.abs(ends).max() < 1e-9
        np.testing.assert_allclose(data.site(handles.tcp).xpos, tcp, atol=1e-12)
        np.testing.assert_allclose(data.body(handles.platform).xpos, tcp, atol=1e-12)


@pytest.mark.parametrize("rods", ["four", "eight"])
def test_contents_are_named_in_model_order(rods):
    model, handles = build(rods, before=1)
    assert (model.nq - 7, model.nv - 6, model.neq) == tuple(SIZES[rods].values())
    assert model.nu == 12
    assert [model.joint(k).name for k in range(1, model.njnt)] == list(handles.joints)
    assert [model.equality(k).name for k in range(model.neq)] == list(handles.equalities)
    assert [model.actuator(k).name for k in range(4)] == list(handles.actuators)
    assert list(control_columns(model, handles)) == list(range(12))
    assert list(qpos_columns(model, handles)) == list(range(7, model.nq))


def test_controls_are_found_behind_other_actuators():
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="other")
    body.add_joint(name="other")
    body.add_geom(size=[0.1, 0, 0])
    spec.add_actuator(name="other", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="other")
    handles = add_t3kr(spec)
    model = spec.compile()
    assert list(control_columns(model, handles)) == list(range(1, 13))


@pytest.mark.parametrize("rods", ["four", "eight"])
def test_masses_are_the_geometry_s_and_nothing_else(rods):
    model, _ = build(rods)
    total = 4 * T3KR.arm_mass + 8 * T3KR.rod_mass + T3KR.platform_mass
    assert model.body_mass.sum() == pytest.approx(total, rel=1e-12)
    assert model.body("platform").mass[0] == pytest.approx(T3KR.platform_mass)


def test_the_robot_touches_nothing():
    model, _ = build()
    assert not model.geom_contype.any()
    assert not model.geom_conaffinity.any()
    assert set(model.geom_group) == {1, 2}


@pytest.mark.parametrize("rods", ["four", "eight"])
def test_holds_still_where_it_starts(rods):
    model, handles = build(rods)
    data = mujoco.MjData(model)
    tcp = np.array([0.2, -0.4, -0.7])
    torque = motor_torque(tcp, np.zeros(3), np.zeros(3))
    data.qpos[qpos_columns(model, handles)] = closed_pose(tcp, handles.rods_per_arm, handles.geometry)
    controls = np.stack([inverse_kinematics(tcp), np.zeros(4), torque], axis=-1).ravel()
    data.ctrl[control_columns(model, handles)] = controls
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert not data.warning.number.any()
    np.testing.assert_allclose(data.body("platform").xpos, tcp, atol=2e-5)
    np.testing.assert_allclose(data.actuator_force, torque, atol=0.05)


def test_motors_stop_at_their_limit():
    model, handles = build()
    data = mujoco.MjData(model)
    data.qpos[qpos_columns(model, handles)] = closed_pose([0.0, 0.0, -0.6], handles.rods_per_arm, handles.geometry)
    data.ctrl[control_columns(model, handles)] = np.tile([3.0, 0.0, 0.0], 4)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.actuator_force, 530.0)


def test_options():
    option = build(timestep=0.0004)[0].opt
    assert (option.timestep, option.tolerance) == (0.0004, 1e-10)
    assert (option.iterations, option.impratio) == (50, 10.0)
    assert (option.density, option.viscosity) == (1.2, 1.8e-5)
    np.testing.assert_array_equal(option.gravity, [0, 0, -9.81])
    assert int(option.integrator) == int(mujoco.mjtIntegrator.mjINT_EULER)
    assert int(option.jacobian) == int(mujoco.mjtJacobian.mjJAC_DENSE)
    assert int(option.cone) == int(mujoco.mjtCone.mjCONE_ELLIPTIC)
    assert int(option.enableflags) & int(mujoco.mjtEnableBit.mjENBL_SPECULATIVE)
    assert int(option.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)


@pytest.mark.parametrize("timestep", [0.0, -0.001, 0.0021, np.nan])
def test_a_timestep_the_chain_cannot_take_is_refused(timestep):
    with pytest.raises(ValueError, match="timestep"):
        set_options(mujoco.MjSpec(), timestep)


@pytest.mark.parametrize("air", [{"density": -1.0}, {"viscosity": np.nan}])
def test_impossible_air_is_refused(air):
    with pytest.raises(ValueError, match="density and viscosity"):
        set_options(mujoco.MjSpec(), 0.001, **air)


def test_unknown_number_of_rods_is_refused():
    with pytest.raises(ValueError, match='"four" or "eight"'):
        add_t3kr(mujoco.MjSpec(), rods="six")


def test_another_geometry_closes_too():
    geometry = T3krGeometry(arm_length=0.85, attach_radius=0.14, rod_spacing=0.08, attach_azimuth=0.9)
    model, handles = build("eight", geometry)
    data = mujoco.MjData(model)
    data.qpos[qpos_columns(model, handles)] = closed_pose([0.1, 0.3, -0.5], handles.rods_per_arm, handles.geometry)
    mujoco.mj_kinematics(model, data)
    assert np.abs(data.site_xpos[model.eq_obj1id] - data.site_xpos[model.eq_obj2id]).max() < 1e-9
