"""The thrower's scene: what may touch what, and parts that wait for their turn."""

import mujoco
import numpy as np
import pytest

from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.plant import PARKING_DISTANCE, OneJointPlant
from pnt_gym.cells.one_joint.scene import build_scene, contact_columns
from pnt_gym.cells.one_joint.tasks import Job
from pnt_gym.robots.one_joint.visuals import FLOOR


def scene(**changes):
    config = OneJointConfig.load("ideal", **changes)
    job = Job.of(config)
    return build_scene(config, job.parts, job.pallets)


def can_meet(model, one, other):
    """Whether any geoms of two bodies are allowed to collide."""
    a, b = ([g for g in range(model.ngeom) if model.geom_bodyid[g] == model.body(name).id] for name in (one, other))
    return any(
        model.geom_contype[i] & model.geom_conaffinity[j] or model.geom_contype[j] & model.geom_conaffinity[i]
        for i in a
        for j in b
    )


def test_parts_meet_pallets_and_each_other_and_the_arm_only_where_they_lie_on_it():
    model = scene(task="assembly").model
    assert can_meet(model, "aitch", "tee")
    assert can_meet(model, "aitch", "stand")
    assert not can_meet(model, "aitch", "arm")
    model = scene(release="contact", task="sort").model
    for name in ("arm", "stopper_inner", "stopper_outer", "pallet_1"):
        assert can_meet(model, "block", name), name
    assert not can_meet(model, "arm", "pallet_1")


@pytest.mark.parametrize("mismatch", [0.0, 0.5, 1.0])
def test_the_air_has_the_density_of_the_mismatch(mismatch):
    assert scene(mismatch=mismatch).model.opt.density == pytest.approx(1.2 * mismatch)


def test_the_air_only_drags():
    fluid = scene().model.geom_fluid
    assert fluid[:, 1].any()
    assert not fluid[:, 4:].any()  # no lift, no added mass


def test_contacts_have_columns_of_their_own():
    built = scene(task="sort")
    found, distance = contact_columns(built, 0)
    assert (found.size, distance.size) == (3, 3)
    built = scene(task="assembly")
    columns = np.concatenate([np.concatenate(contact_columns(built, part)) for part in (0, 1)])
    assert sorted(columns.tolist()) == list(range(1, int(built.model.nsensordata)))


def test_a_part_that_waits_floats_where_it_is_and_one_that_lies_has_weight():
    config = OneJointConfig.load("ideal", task="assembly")
    plant = OneJointPlant(config, 2)
    lying = np.full((2, 2, 3), np.nan)
    lying[1, 0] = 0.5, 0.3, 0.1
    plant.write(np.zeros(2), np.array([0, 1]), np.full(2, 0.25), lying)
    places = []
    for row in (0, 1):
        model, data = plant.current_state(row)
        start = data.qpos.copy()
        for _ in range(100):
            mujoco.mj_step(model, data)
        places.append((start, data.qpos.copy()))
    tee, aitch = plant.scene.first_qpos[1], plant.scene.first_qpos[0]
    assert places[0][0][tee] == PARKING_DISTANCE + 1.0
    np.testing.assert_allclose(places[0][1][tee : tee + 3], places[0][0][tee : tee + 3], atol=1e-12)
    np.testing.assert_allclose(places[1][0][aitch : aitch + 3], [0.5, 0.3, 0.1])
    assert places[1][1][aitch + 1] == pytest.approx(0.3 - 0.5 * 9.81 * 0.1**2, abs=0.001)


def test_the_stoppers_stand_at_both_ends_of_the_part_wherever_it_lies():
    config = OneJointConfig.load("ideal", release="contact")
    plant = OneJointPlant(config, 2)
    radius = np.array([0.20, 0.27])
    plant.write(np.zeros(2), np.zeros(2, dtype=np.int64), radius, np.full((2, 1, 3), np.nan))
    for row in (0, 1):
        _, data = plant.current_state(row)
        inner, outer = (data.geom(name).xpos[0] for name in ("stopper_inner", "stopper_outer"))
        assert outer - radius[row] == pytest.approx(0.030 + 0.002, abs=1e-4)
        assert radius[row] - inner == pytest.approx(0.030 + 0.002, abs=1e-4)


@pytest.mark.parametrize("task", ["throw", "sort", "assembly"])
def test_a_picture_shows_arm_part_and_pallets(task, opengl):
    """The same frame without them differs where they are."""
    config = OneJointConfig.load("ideal", task=task)
    plant = OneJointPlant(config, 1)
    lying = np.full((1, len(plant.scene.parts), 3), np.nan)
    plant.write(np.zeros(1), np.zeros(1, dtype=np.int64), np.full(1, 0.27), lying)
    model, data = plant.current_state(0)
    names = ("arm", plant.scene.parts[0].name, *(pallet.name for pallet in plant.scene.pallets))
    renderer = mujoco.Renderer(model, 180, 320)
    try:
        frames = [frame(renderer, model, data, name) for name in (None, *names)]
    finally:
        renderer.close()
    for name, without in zip(names, frames[1:], strict=True):
        assert (np.abs(frames[0].astype(int) - without).max(axis=2) > 20).sum() > 10, name


def frame(renderer, model, data, hidden):
    """A picture with the geoms of one body made invisible."""
    before = model.geom_rgba.copy()
    if hidden is not None:
        model.geom_rgba[model.geom_bodyid == model.body(hidden).id, 3] = 0.0
    view = mujoco.MjvCamera()
    view.lookat[:], view.distance, view.azimuth, view.elevation = [0.0, 0.0, 0.1], 1.6, 95.0, -8.0
    renderer.update_scene(data, view)
    picture = renderer.render().copy()
    model.geom_rgba[:] = before
    return picture


def test_a_part_that_misses_comes_to_lie_on_the_floor():
    config = OneJointConfig.load("ideal", task="sort")
    plant = OneJointPlant(config, 1)
    model, data = plant.current_state(0)
    first = int(plant.scene.first_qpos[0])
    data.qpos[first : first + 3] = -0.6, -0.5, 0.0
    data.eq_active[:] = 0
    model.body_gravcomp[plant.scene.bodies] = 0.0
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert data.qpos[first + 1] == pytest.approx(FLOOR + 0.015, abs=0.001)
    assert np.abs(data.qvel[first : first + 3]).max() < 0.01
