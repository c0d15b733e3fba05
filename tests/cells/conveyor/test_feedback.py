"""The camera over the bins: what it tells of every throw for the next one."""

import numpy as np
import pytest

from pnt_gym.cells.conveyor.context import LastThrow
from pnt_gym.cells.conveyor.observation import FEEDBACK, SHIFT_TABLE, TABLE, decode
from tests.tools.drifting import ALL, QUICK, actions, cells


@pytest.fixture(scope="module")
def shift():
    """Steps of many cells through a shift of six picks: actions, contexts thrown, observations and infos."""
    core, steps = cells(120, drift=ALL, picks_per_shift=6, feedback={"unseen": 0.2}, **QUICK), []
    asked = actions(120, 6)
    asked[2] = 0.0
    for action in asked:
        thrown = core.context
        step = core.step(action)
        steps.append((action, thrown, decode(step.observation), step.info))
    return core, steps


def test_after_a_reset_nothing_is_known():
    core = cells(5, drift=ALL, **QUICK)
    for _ in range(2):
        assert not core.observe()[:, 26:].any()
        core.step(actions(5, 1)[0])
        assert (core.observe()[:, -1] > 0.0).all()
        core.reset(np.arange(5), core.cell.generators, seeded=False)


def test_the_observation_tells_what_the_info_says_was_seen(shift):
    for _, _, seen, info in shift[1]:
        known = np.isfinite(info["seen_along"])
        np.testing.assert_array_equal(known, np.isfinite(info["seen_across"]))
        np.testing.assert_array_equal(seen["last_seen"], known)
        for axis in ("along", "across"):
            told = np.clip(info[f"seen_{axis}"][known], -0.25, 0.25)
            np.testing.assert_allclose(seen[f"last_{axis}"][known], told, atol=2e-8)
            assert not seen[f"last_{axis}"][~known].any()


def test_its_noise_is_the_levels():
    found = []
    for noise, count in ((0.0, 60), (0.01, 150)):
        core = cells(count, feedback={"noise": noise, "unseen": 0.0}, **QUICK)
        infos = [core.step(action).info for action in actions(count, 4)]
        off = [[i[f"seen_{axis}"] - i[f"landing_{axis}"] for i in infos] for axis in ("along", "across")]
        found.append(np.reshape(off, (2, -1)))
    exact, noisy = (off[:, np.isfinite(off[0])] for off in found)
    assert exact.shape[1] > 150
    assert noisy.shape[1] > 400
    assert not exact.any()
    assert noisy.std(axis=1) == pytest.approx(0.01, rel=0.12)
    assert np.abs(noisy.mean(axis=1)).max() < 0.002
    assert abs(np.corrcoef(noisy)[0, 1]) < 0.15


def test_it_misses_its_share_and_what_is_not_there(shift):
    _, steps = shift
    lost = []
    for _, _, _, info in steps:
        seen = np.isfinite(info["seen_along"])
        far = ~(info["landing_error"] <= 0.25)
        assert not seen[~info["picked"] | info["dropped"] | far].any()
        lost.append(~seen[info["picked"] & ~info["dropped"] & ~far])
    assert any((~info["picked"]).any() for *_, info in steps)
    assert any(info["dropped"].any() for *_, info in steps)
    assert np.concatenate(lost).mean() == pytest.approx(0.2, abs=0.06)


@pytest.mark.parametrize(("feedback", "share"), [({"unseen": 1.0}, 0.0), ({"view": 1e-6}, 0.0), ({"view": 0.02}, None)])
def test_a_camera_that_sees_little(feedback, share):
    core = cells(60, feedback=feedback, **QUICK)
    info = core.step(actions(60, 1)[0]).info
    seen = np.isfinite(info["seen_along"])
    if share is None:
        assert 0.0 < seen.mean() < 0.9
        assert info["landing_error"][seen].max() <= 0.02
    else:
        assert seen.mean() == share


def test_the_last_action_is_told_as_it_was_carried_out(shift):
    core, steps = shift
    scale, checked = core.correction.scale, 0
    for k, (action, _, seen, info) in enumerate(steps):
        moved = np.stack([seen["last_shift_along"], seen["last_shift_across"]], axis=1)
        as_asked = ~info["residual_clipped"]
        np.testing.assert_allclose(moved[as_asked], (action * scale)[as_asked], atol=2e-7)
        if k == 2:  # nothing but rounding, and exactly nothing as a rule
            assert np.abs(moved).max() < 1e-14
            assert (moved == 0.0).all(axis=1).mean() > 0.8
        checked += int(as_asked.sum())
    assert checked > 0.8 * 6 * 120


def test_a_shortened_action_is_told_shortened():
    """Along, it is the share that was carried out of what was asked for; across likewise."""
    core = cells(60, **QUICK)
    asked = np.tile(core.correction.scale, (60, 1))
    step = core.step(np.ones((60, 2)))
    seen, clipped = decode(step.observation), step.info["residual_clipped"]
    share = np.stack([seen["last_shift_along"], seen["last_shift_across"]], axis=1) / asked
    assert clipped.any()
    assert (share[clipped] < 1.0).all()
    assert (share[clipped] > -1e-6).all()
    np.testing.assert_allclose(share[clipped, 0], share[clipped, 1], atol=2e-6)


def test_the_last_direction_and_the_share_of_the_shift(shift):
    _, steps = shift
    for k, (_, thrown, seen, info) in enumerate(steps):
        for axis, name in enumerate(("last_direction_x", "last_direction_y")):
            np.testing.assert_allclose(seen[name], thrown.direction[:, axis], atol=1e-7)
        np.testing.assert_allclose(seen["shift_gone"], (k + 1) / 6, atol=1e-7)
        assert (info["pick_in_shift"] == k).all()


def test_frames_are_the_throws_own(shift):
    """Where it was seen against the target, in the world, is where it landed but for the noise."""
    _, steps = shift
    for _, thrown, seen, info in steps:
        known = seen["last_seen"] > 0.5
        place = thrown.from_throw_frame(seen["last_along"], seen["last_across"])[known]
        true = thrown.from_throw_frame(info["landing_along"], info["landing_across"])[known]
        assert np.abs(place - true).max() < 6.0 * 0.005


def test_the_feedback_alone_has_the_names_of_its_table():
    assert len(SHIFT_TABLE) == len(TABLE) + len(FEEDBACK) == 34
    nothing = SHIFT_TABLE.decode(np.zeros((1, 34)))
    assert [*nothing][26:] == [one.name for one in FEEDBACK]
    assert not any(nothing[one.name].any() for one in FEEDBACK)  # zero is nothing known
    assert len(LastThrow.of(3).error) == 3
