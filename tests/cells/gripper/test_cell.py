from dataclasses import replace

import numpy as np
import pytest

from pnt_gym.cells.gripper.hidden import expected_hidden
from pnt_gym.engine import mujoco
from tests.tools.gripper import fields_equal, made, oracle, planned, shortened
from tests.tools.nightly import with_nightly


def test_in_the_planners_own_world_throws_land_on_target():
    cell = made("ideal", 24)
    outcome = cell.throw(cell.context.plans)
    assert outcome.landing_error.max() < 0.006
    assert outcome.is_success.all()
    assert outcome.picked.all()
    assert not outcome.recontact.any()
    assert np.abs(outcome.release_delay).max() < 0.003


def test_every_kind_lets_go_at_its_own_moment():
    cell = made("nominal", 48)
    kind = cell.context.kind.copy()
    outcome = cell.throw(cell.context.plans)
    delays = [outcome.release_delay[kind == k].mean() for k in range(3)]
    np.testing.assert_allclose(delays, [item.opening_delay for item in cell.config.item_list()], atol=0.004)
    # The block is still held when the robot brakes, and falls short.
    assert outcome.is_success[kind != 2].all()
    assert outcome.is_success[kind == 2].mean() < 0.6
    assert outcome.landing_along[kind == 2].mean() < -0.015


def test_a_longer_follow_through_forgives_a_late_opening_and_costs_time():
    hasty, patient = made("nominal", 30), made("patient", 30)
    block = hasty.context.kind == 2
    quick, slow = hasty.throw(hasty.context.plans), patient.throw(patient.context.plans)
    assert slow.is_success.all()
    # At constant velocity a late object goes on along the line, and lands further.
    assert slow.landing_along[block].mean() > 0.010
    assert slow.cycle_time.mean() > quick.cycle_time.mean() + 0.02


@pytest.mark.parametrize("level", with_nightly(("nominal", "late", "patient", "drop"), ["late"]))
def test_an_oracle_succeeds(level):
    cell = made(level, 24)
    outcome = cell.throw(oracle(cell)[0])
    assert outcome.is_success.mean() >= 0.97
    assert outcome.picked.all()


def test_late_blocks_miss_without_a_correction():
    cell = made("late", 32)
    block = cell.context.kind == 2
    outcome = cell.throw(cell.context.plans)
    assert not outcome.is_success[block].any()


def test_a_deliberate_miss_fails():
    cell = made("nominal", 12)
    plans = planned(cell, np.tile([-0.030, 0.0, -0.040], (12, 1)))
    assert plans.feasible.all()
    outcome = cell.preview(plans)
    assert not outcome.is_success.any()
    assert (outcome.landing_along < -0.02).all()


def test_opening_later_lands_further_and_the_release_point_moves_the_landing_with_it():
    cell = made("ideal", 9)
    plain = cell.preview(cell.context.plans)
    later = cell.preview(planned(cell, np.tile([0.0, 0.0, 0.010], (9, 1))))
    speed = np.hypot(*cell.context.plans.velocity[:, :2].T)
    rise, flight = cell.context.plans.velocity[:, 2], cell.context.plans.flight_time
    # The release point moves on by v dt, and up, which lengthens the flight.
    longer = rise * 0.010 / (9.81 * flight - rise)
    np.testing.assert_allclose(later.landing_along - plain.landing_along, speed * (0.010 + longer), atol=0.002)
    moved = cell.preview(planned(cell, np.tile([-0.010, 0.008, 0.0], (9, 1))))
    np.testing.assert_allclose(moved.landing_along - plain.landing_along, -0.010, atol=0.001)
    np.testing.assert_allclose(moved.landing_across - plain.landing_across, 0.008, atol=0.001)


def test_a_drop_at_rest_falls_straight():
    cell = made("drop", 12, mismatch=0.0)
    outcome = cell.throw(cell.context.plans)
    assert outcome.is_success.all()
    assert outcome.landing_error.max() < 0.003


def test_a_preview_changes_nothing_and_tells_what_a_throw_will_do():
    cell = made("nominal", 6)
    first, again = (cell.preview(cell.context.plans, jitter=True) for _ in range(2))
    assert fields_equal(first, again)
    assert fields_equal(first, cell.throw(cell.context.plans))


def test_a_preview_without_jitter_has_average_objects():
    cell = made("nominal", 6)
    before = cell.preview(cell.context.plans)
    cell.context = replace(cell.context, hidden=expected_hidden(cell.context.kind, cell.config))
    assert fields_equal(before, cell.preview(cell.context.plans, jitter=True))


def test_infeasible_corrections_are_shortened_or_refused():
    cell = made("nominal", 5)
    far = np.tile([0.08, 0.0, 0.0], (5, 1))
    with pytest.raises(ValueError, match="not feasible"):
        cell.preview(planned(cell, far))
    plans, clipped = shortened(cell, far)
    assert clipped.all()
    assert plans.feasible.all()
    assert (plans.release[:, 0] < planned(cell, far).release[:, 0]).all()
    assert np.isfinite(cell.throw(plans).landing).all()


def test_the_mismatch_dial_switches_the_hidden_values_off():
    hidden = made("ideal", 20).context.hidden
    for name in ("offset", "yaw", "delay"):
        assert not getattr(hidden, name).any()
    cell = made("nominal", 200)
    assert cell.context.hidden.delay.std() > 0.005
    sizes = np.array([item.size for item in cell.config.item_list()])[cell.context.kind]
    assert 0.01 < np.std(cell.context.hidden.size / sizes) < 0.05
    error = cell.context.measured - cell.context.hidden.size
    assert 0.5 < error.std() / cell.config.errors.camera < 1.5


def test_a_recording_plays_the_throw_again():
    cell = made("nominal", 3)
    cell.plant.record_row = 1
    outcome = cell.throw(cell.context.plans)
    recording = cell.plant.recording
    places = [data.body("object").xpos.copy() for data, _ in recording.play(0.001)]
    np.testing.assert_array_equal(places[-1], outcome.final[1])
    assert len(places) == len(recording.control)


def test_picture_poses_stand_ready_above_the_object():
    cell = made("nominal", 2)
    model, data = cell.pose(1)
    hand, thing = data.site("grip").xpos, data.body("object").xpos
    assert np.hypot(*(hand - thing)[:2]) < 0.010
    assert data.ncon == 0
    assert model.geom_size[cell.plant.scene.object_geom].max() < 0.03


def test_the_object_weighs_and_measures_what_was_drawn():
    cell = made("nominal", 8)
    context = cell.context
    cell.pose(0)
    for row in range(8):
        model, data = cell.plant.current_state(row)
        assert model.body_mass[cell.plant.scene.object_body] == context.hidden.mass[row]
        lowest = min(_corners(model, data, cell.plant.scene.object_geom)[:, 2])
        assert lowest == pytest.approx(cell.config.table.height, abs=2e-4)


def _corners(model, data, geom):
    """Points of a geom's bounding box in the world; a lying cylinder touches the table with one face of it."""
    half = model.geom_aabb[geom].reshape(2, 3)[1]
    signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    assert int(model.geom_type[geom]) in (int(mujoco.mjtGeom.mjGEOM_BOX), int(mujoco.mjtGeom.mjGEOM_CYLINDER))
    return data.geom_xpos[geom] + (signs * half) @ data.geom_xmat[geom].reshape(3, 3).T
