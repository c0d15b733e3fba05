"""The parts against integration over their boxes, and how they lie, slide and bounce in the engine."""

import numpy as np
import pytest

from pnt_gym.cells.one_joint.parts import AITCH, BLOCK, TEE, WOOD_FRICTION, Part, add_part, block
from pnt_gym.engine import mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.planning.one_joint.parameters import Arm, Block
from pnt_gym.robots.one_joint.model import add_plane_joints
from pnt_gym.robots.specification import set_options

EVERY = pytest.mark.parametrize("part", (BLOCK, TEE, AITCH), ids=lambda part: part.name)


def filled(part, spacing=1e-4):
    """Points u, v of a fine grid inside any of the part's boxes, (K, 2)."""
    axis = np.arange(-0.04, 0.04, spacing) + spacing / 2
    u, v = np.meshgrid(axis, axis)
    inside = np.zeros(u.shape, dtype=bool)
    for cu, cv, half_u, half_v, angle in part.boxes:
        along = (u - cu) * np.cos(angle) + (v - cv) * np.sin(angle)
        across = (v - cv) * np.cos(angle) - (u - cu) * np.sin(angle)
        inside |= (np.abs(along) < half_u) & (np.abs(across) < half_v)
    return np.stack([u[inside], v[inside]], axis=-1), spacing**2


@EVERY
def test_boxes_fill_the_outline_and_mass_and_inertia_are_theirs(part):
    points, cell = filled(part)
    assert len(points) * cell == pytest.approx(part.area, rel=5e-3)
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=5e-5)
    mass = part.density * part.depth * cell * len(points)
    assert mass == pytest.approx(part.mass, rel=5e-3)
    u2, v2 = (points**2).mean(axis=0)
    flat = part.depth**2 / 12
    assert part.inertia == pytest.approx(mass * (u2 + v2), rel=1e-2)
    np.testing.assert_allclose(part.inertias, mass * np.array([v2 + flat, u2 + v2, u2 + flat]), rtol=1e-2)
    assert points[:, 1].min() == pytest.approx(-part.half_height, abs=2e-4)
    assert np.hypot(*points.T).max() == pytest.approx(part.reach, abs=2e-4)


def test_the_block_is_the_planners_block():
    assert (BLOCK.mass, BLOCK.inertia) == pytest.approx((Block().mass, Block().inertia), rel=1e-12)
    assert block(BLOCK) == Block(mass=BLOCK.mass)


@EVERY
def test_the_planner_sees_mass_and_support_and_nearly_the_inertia(part):
    seen = block(part)
    assert part.support == pytest.approx((seen.half_length, seen.half_length), rel=1e-12)
    assert (seen.mass, seen.half_height) == (part.mass, part.half_height)
    assert seen.inertia == pytest.approx(part.inertia, rel=0.16)
    # What the difference does to the bounds of the dynamic grasp at the largest radius (Eq. 2).
    radius = Arm().largest_radius(seen)
    coefficient = part.inertia - part.mass * (part.half_length * radius - part.half_height**2)
    assert abs(seen.inertia - part.inertia) < 0.011 * abs(coefficient)


@EVERY
def test_the_engine_gets_mass_and_inertia(part):
    model = resting_model(part, tilt=0.0)
    body = model.body(part.name)
    assert float(body.mass[0]) == pytest.approx(part.mass, rel=1e-12)
    full = np.empty(9)
    mujoco.mju_quat2Mat(full, body.iquat)
    turn = full.reshape(3, 3)
    tensor = turn @ np.diag(body.inertia) @ turn.T
    np.testing.assert_allclose(tensor, np.diag(part.inertias), rtol=1e-9, atol=1e-15)


def resting_model(part, tilt):
    """A part just above a plane through the origin that is tilted anticlockwise."""
    spec = mujoco.MjSpec()
    set_options(spec, 0.0005, density=0.0, viscosity=0.0)
    add_part_on_plane(spec, part, tilt)
    return spec.compile()


def add_part_on_plane(spec, part, tilt):
    normal = np.array([-np.sin(tilt), 0.0, np.cos(tilt)])
    plank = spec.worldbody.add_body(name="plank")
    plank_part = Part("plank", ((-1, -0.01), (1, -0.01), (1, 0.01), (-1, 0.01)), ((0.0, 0.0, 1.0, 0.01, 0.0),))
    add_part(plank, plank_part)
    plank.pos, plank.quat = -0.01 * normal, [np.cos(tilt / 2), 0, -np.sin(tilt / 2), 0]
    body = spec.worldbody.add_body(name=part.name)
    add_plane_joints(body, part.name)
    add_part(body, part)


def run(part, start, seconds, tilt=0.0):
    """Pose and velocity (3,) after a time, and the vertical speed after every step."""
    model = resting_model(part, tilt)
    data = mujoco.MjData(model)
    data.qpos[:] = start
    speeds = []
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        speeds.append(data.qvel[1])
    assert not data.warning.number.any()
    return data.qpos.copy(), data.qvel.copy(), np.array(speeds)


@EVERY
def test_a_part_lies_on_its_underside(part):
    pose, velocity, _ = run(part, (0.0, part.half_height + 1e-4, 0.0), 0.5)
    np.testing.assert_allclose(pose, [0.0, part.half_height, 0.0], atol=1e-4)
    np.testing.assert_allclose(velocity, 0.0, atol=1e-3)


@pytest.mark.parametrize(("excess", "moves"), [(-0.05, False), (0.05, True)])
def test_wood_slides_on_wood_where_its_friction_says(excess, moves):
    tilt = np.arctan(WOOD_FRICTION + excess)
    start = BLOCK.half_height * np.array([-np.sin(tilt), np.cos(tilt)])
    pose, _, _ = run(BLOCK, (*start, tilt), 0.5, tilt)
    # Of a body that slides down with what friction leaves of gravity.
    slid = 0.5 * 9.81 * (np.sin(tilt) - WOOD_FRICTION * np.cos(tilt)) * 0.5**2
    assert np.hypot(*(pose[:2] - start)) == pytest.approx(max(slid, 0.0), rel=0.1, abs=1e-3)
    assert (slid > 0.0) == moves


@pytest.mark.parametrize("height", [0.02, 0.20])
def test_wood_rebounds_with_about_a_tenth_of_the_speed(height):
    *_, speeds = run(BLOCK, (0.0, BLOCK.half_height + height, 0.0), 0.4)
    assert -speeds.min() == pytest.approx(np.sqrt(2 * 9.81 * height), rel=0.01)
    assert 0.08 < speeds[speeds.argmin() :].max() / -speeds.min() < 0.12


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"depth": 0.0}, "depth"),
        ({"density": np.nan}, "density"),
        ({"outline": ((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1))}, "centroid"),
        ({"outline": TEE.outline[::-1]}, "anticlockwise"),
        ({"outline": ((0.0, 0.0), (0.1, 0.0), (-0.1, 0.0))}, "anticlockwise"),
    ],
)
def test_an_impossible_part_is_refused(change, words):
    values = {"name": "odd", "outline": TEE.outline, "boxes": TEE.boxes} | change
    with pytest.raises(ConfigError, match=words):
        Part(**values)
