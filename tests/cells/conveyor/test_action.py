"""An action corrects a plan: zero is the plan, one is the documented shift, and an infeasible one is shortened."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pnt_gym.cells.base.action import clip_actions
from pnt_gym.cells.conveyor.action import MODES
from pnt_gym.errors import ActionError
from pnt_gym.planning.motion.ballistics import landing_point
from tests.tools.throws import is_feasible, make_core, same_bits, vary

COUNT = 120
LEVELS = ("ideal", "nominal", "waste")
SIZE = {name: len(mode.numbers) for name, mode in MODES.items()}


@pytest.fixture(scope="module")
def cores():
    return {(level, mode): make_core(level, COUNT, mode=mode, seed=3) for level in LEVELS for mode in MODES}


def landing(core, release):
    return landing_point(release.position, release.velocity, core.context.target[:, 2])[:, :2]


def in_throw_frame(core, vector):
    return np.stack(core.context.to_throw_frame(vector), axis=1)


@pytest.mark.parametrize("level", LEVELS)
def test_zero_re_plans_the_nominal_throw_bit_for_bit_as_a_virtual_goal(cores, level):
    core = cores[level, "virtual_goal"]
    release, clipped = core.plan(np.zeros((COUNT, 2)))
    for name in ("position", "velocity", "speed", "angle", "distance", "time", "flight_time"):
        assert same_bits(getattr(release, name), getattr(core.context.plan, name)), name
    assert not clipped.any()


@pytest.mark.parametrize("mode", ["release_point", "release_xyz"])
@pytest.mark.parametrize("level", LEVELS)
def test_zero_is_the_nominal_throw_to_rounding_in_the_other_modes(cores, level, mode):
    """These two solve for the release another way, so the last bits may differ: a nanometre at most."""
    core = cores[level, mode]
    release, clipped = core.plan(np.zeros((COUNT, SIZE[mode])))
    plan = core.context.plan
    np.testing.assert_allclose(release.position, plan.position, atol=1e-9)
    np.testing.assert_allclose(release.velocity, plan.velocity, atol=1e-8)
    np.testing.assert_allclose(release.flight_time, plan.flight_time, atol=1e-8)
    assert not clipped.any()


@pytest.mark.parametrize("mode", ["release_point", "virtual_goal"])
def test_an_action_moves_the_drag_free_landing_by_its_scale(cores, mode):
    core = cores["waste", mode]
    action = np.random.default_rng(0).uniform(-1, 1, (COUNT, 2))
    release, clipped = core.plan(action)
    shift = in_throw_frame(core, landing(core, release) - core.context.target[:, :2])
    whole = ~clipped
    assert 0.3 < whole.mean() < 1.0
    np.testing.assert_allclose(shift[whole], (action * [0.20, 0.06])[whole], atol=1e-7)


def test_the_scale_is_the_configs():
    core = make_core(vary("waste", action={"along": 0.04, "across": 0.10}), 30)
    action = np.tile([0.5, -1.0], (30, 1))
    release, clipped = core.plan(action)
    shift = in_throw_frame(core, landing(core, release) - core.context.target[:, :2])
    np.testing.assert_allclose(shift[~clipped], np.tile([0.02, -0.10], ((~clipped).sum(), 1)), atol=1e-7)
    assert (~clipped).sum() > 15


def test_a_shift_keeps_the_planned_elevation_unless_the_ceiling_forbids_it(cores):
    core = cores["waste", "release_point"]
    action = np.random.default_rng(1).uniform(-1, 1, (COUNT, 2))
    release, _ = core.plan(action)
    top = core.context.ceiling + core.config.motion.ceiling_slack
    kept = np.abs(release.angle - core.context.plan.angle) < 1e-12
    assert kept.mean() > 0.8
    assert (release.angle[~kept] < core.context.plan.angle[~kept]).all()
    # Lowered only as far as needed: such a release touches the ceiling and its slack.
    np.testing.assert_allclose(release.position[~kept, 2], top[~kept], atol=2e-3)


def test_raw_metres_move_the_release_point_by_metres(cores):
    core = cores["waste", "release_xyz"]
    action = np.random.default_rng(2).uniform(-0.3, 0.3, (COUNT, 3))
    release, clipped = core.plan(action)
    moved = release.position - core.context.plan.position
    expected = action * [0.12, 0.02, 0.015]
    whole = ~clipped
    assert whole.mean() > 0.8
    np.testing.assert_allclose(in_throw_frame(core, moved)[whole], expected[whole, :2], atol=1e-12)
    np.testing.assert_allclose(moved[whole, 2], expected[whole, 2], atol=1e-12)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("level", ["nominal", "waste"])
def test_every_plan_is_feasible_and_stays_under_the_ceiling_and_its_slack(cores, level, mode):
    core = cores[level, mode]
    context, config = core.context, core.config
    rng = np.random.default_rng(4)
    for action in (*np.broadcast_to([-1.0, 1.0], (SIZE[mode], 2)).T, None):
        actions = rng.uniform(-1, 1, (COUNT, SIZE[mode])) if action is None else np.tile(action, (COUNT, 1))
        release, _ = core.plan(actions)
        assert release.feasible.all()
        assert np.isfinite(release.position).all()
        assert is_feasible(core, release).all()
        assert (release.position[:, 2] <= context.ceiling + config.motion.ceiling_slack + 1e-6).all()
        # Independent of the plan check: the release, and the way covered in the window, lie in the ellipse.
        window = release.position + config.motion.follow_through.window * release.velocity
        for point in (release.position, window):
            assert ((point[:, 0] / 0.45) ** 2 + (point[:, 1] / 0.80) ** 2 <= 1.0 + 1e-12).all()


def test_an_infeasible_residual_is_shortened_as_little_as_possible_and_reported(cores):
    core = cores["waste", "release_point"]
    action = np.ones((COUNT, 2))
    release, clipped = core.plan(action)
    assert 0.05 < clipped.mean() < 0.95
    shift = in_throw_frame(core, landing(core, release) - core.context.target[:, :2])[clipped]
    share = shift / [0.20, 0.06]
    np.testing.assert_allclose(share[:, 0], share[:, 1], atol=1e-6)  # shortened, not turned
    assert ((share > 0.0) & (share < 1.0)).all()

    def feasible(part):
        scaled = np.ones((COUNT, 2))
        scaled[clipped] = part
        mode = MODES["release_point"]
        wanted = mode.plan(core.cell.planner, core.context, scaled * mode.scale(core.config))
        np.testing.assert_array_equal(wanted.feasible, is_feasible(core, wanted))
        return wanted.feasible[clipped]

    assert feasible(share[:, :1] - 1e-6).all()
    assert not feasible(share[:, :1] + 2.0 / 4096).any()
    np.testing.assert_array_equal(core.step(action).info["residual_clipped"], clipped)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_none_is_refused_with_its_cell(mode, bad):
    action = np.zeros((4, SIZE[mode]))
    action[2, -1] = bad
    with pytest.raises(ActionError, match=r"action of cell 2 is .* must have finite numbers; .* are clipped") as caught:
        clip_actions(action, 4, SIZE[mode], mode)
    assert isinstance(caught.value, ValueError)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("shape", [(), (2,), (3, 2), (4, 3), (4, 2, 1), (0, 2)])
def test_a_wrong_shape_is_refused_with_both_shapes(shape):
    with pytest.raises(ActionError, match=r"action has shape .* needs \(4, 2\)"):
        clip_actions(np.zeros(shape), 4, 2, "release_point")


@given(st.lists(st.floats(-1e6, 1e6), min_size=6, max_size=6))
@settings(max_examples=60, deadline=None)
def test_values_outside_are_clipped_and_inside_kept(values):
    actions = np.array(values).reshape(3, 2)
    checked = clip_actions(actions, 3, 2, "virtual_goal")
    assert checked.dtype == np.float64
    np.testing.assert_array_equal(checked, np.minimum(np.maximum(actions, -1.0), 1.0))


def test_lists_and_float32_are_taken():
    np.testing.assert_array_equal(clip_actions([[0.5, -2.0]], 1, 2, "release_point"), [[0.5, -1.0]])
    assert clip_actions(np.zeros((1, 3), dtype=np.float32), 1, 3, "release_xyz").dtype == np.float64
