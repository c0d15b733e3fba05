"""The network that learns in context: what it learns from, and that numpy carries out what torch has trained."""

from itertools import islice

import numpy as np
import pytest
import torch

from agents.controllers import in_context
from agents.controllers.in_context import (
    BLURRED,
    LEVELS,
    PICKS,
    SHIFTS,
    SHORT,
    STRONGEST,
    UNSEEN,
    InContext,
    shuffle_shifts,
    simulate_shifts,
)
from agents.controllers.recurrent import UNIT, Recurrent, _layers, train
from agents.controllers.trackers import drift_effects
from agents.ground.cli import UsageError
from pnt_gym.cells.conveyor.config import ConveyorConfig
from tests.agents.controllers.test_trackers import CAMERA, everyone, network, throws

SIZE = 6


def parts() -> tuple[torch.nn.GRUCell, torch.nn.Linear, torch.nn.Linear]:
    """A unit, a head and an answer that does not begin at nothing."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        unit, head, answer = _layers(torch, 26, SIZE)
        torch.nn.init.normal_(answer.weight)
        torch.nn.init.normal_(answer.bias)
    return unit, head, answer


def test_numpy_carries_out_what_torch_has_trained() -> None:
    unit, head, answer = parts()
    ours, random = Recurrent.from_torch(unit, head, answer), np.random.default_rng(1)
    memory = np.zeros((7, SIZE))
    theirs = torch.zeros(7, SIZE)
    for pick in range(9):
        thrown, z = throws(7, pick), random.normal(0.0, 0.03, (7, 2))
        z[0] = 0.5  # far off is just far off
        seen = torch.as_tensor(thrown, dtype=torch.float32)
        with torch.no_grad():
            lesson = torch.as_tensor(np.clip(z / UNIT, -6.0, 6.0), dtype=torch.float32)
            theirs = unit(torch.cat([seen, lesson], dim=1), theirs)
            hidden = torch.nn.functional.silu(head(torch.cat([theirs, seen], dim=1)))
            expected = UNIT * answer(hidden).numpy()
        memory = ours.update(memory, thrown, z)
        np.testing.assert_allclose(memory, theirs.numpy(), atol=2e-6)
        np.testing.assert_allclose(ours.predict(memory, thrown), expected, atol=2e-7)
    assert np.abs(expected).max() > 1e-3
    assert ours.size == SIZE


def test_a_state_that_holds_no_network_is_refused() -> None:
    tracker = InContext(CAMERA, False)
    with pytest.raises(UsageError, match="holds no network") as caught:
        tracker.restore({"weight_0": np.zeros((2, 2))})
    assert "\n" not in str(caught.value)
    tracker.restore(network())
    assert tracker.state()
    tracker.restore({})
    assert not tracker.state()


# What it learns from.


def test_batches_are_shifts_of_the_throws_that_were_made() -> None:
    made, z = throws(40), np.random.default_rng(1).normal(0.0, 0.01, (40, 2))
    batches = list(simulate_shifts(made, z, CAMERA, 3, seed=0))
    assert len(batches) == 3
    rows = {row.tobytes() for row in made}
    for lessons in batches:
        assert lessons.features.shape == (SHIFTS, PICKS, 26)
        assert {row.tobytes() for row in lessons.features.reshape(-1, 26)} == rows
        assert not lessons.z[~lessons.has_landing].any()
        assert np.isfinite(lessons.true).all()
    again = list(simulate_shifts(made, z, CAMERA, 3, seed=0))
    other = list(simulate_shifts(made, z, CAMERA, 1, seed=1))
    assert all(np.array_equal(a.z, b.z) for a, b in zip(batches, again, strict=True))
    assert not np.array_equal(batches[0].z, other[0].z)


def test_the_drifts_are_those_of_the_levels_and_half_as_strong_again() -> None:
    """Of one throw that is foreseen exactly, all that is off is the drift: constant, in steps, or wandering."""
    made = throws(1)
    lessons = list(simulate_shifts(made, np.zeros((1, 2)), CAMERA, 12, seed=2))
    off = np.concatenate([one.true for one in lessons])
    values = np.array([len(np.unique(shift[:, 1].round(12))) for shift in off])
    kinds = {"day": values == 1, "steps": values == 2, "drift_mix": values > 2}
    assert set(kinds) == set(LEVELS)
    for name, rows in kinds.items():
        assert rows.mean() == pytest.approx(1 / 3, abs=0.07), name
    effect = np.abs(drift_effects(made, CAMERA)[0])
    for name, rows in kinds.items():
        drift = ConveyorConfig.load(name).drift
        most = effect @ [drift.delay.most, drift.camera.most, drift.camera.most, drift.encoder.most]
        assert (np.abs(off[rows]).max(axis=(0, 1)) <= STRONGEST * most).all()
    steps = np.abs(off[kinds["steps"]][..., 1]).max()
    camera = ConveyorConfig.load("steps").drift.camera.step * effect[1, 1:3].sum()
    assert 0.7 * STRONGEST * camera < steps <= STRONGEST * camera


def test_what_is_seen_of_them_is_missing_and_blurred_as_documented() -> None:
    made, z = throws(40), np.zeros((40, 2))
    lessons = list(simulate_shifts(made, z, CAMERA, 8, seed=3))
    known, off = (np.concatenate([getattr(one, name) for one in lessons]) for name in ("has_landing", "true"))
    blur = np.concatenate([one.z for one in lessons]) - off
    missing = 1.0 - known.mean(axis=1)
    assert missing.mean() == pytest.approx(UNSEEN / 2, abs=0.02)
    assert missing.std() > 0.06  # another share in every shift
    spread = np.array([one[here].std() for one, here in zip(blur, known, strict=True)])
    assert (spread == 0.0).mean() == pytest.approx(0.5, abs=0.08)
    assert spread.max() == pytest.approx(BLURRED, rel=0.25)
    assert spread[spread > 0.0].mean() == pytest.approx(BLURRED / 2, rel=0.2)


def test_what_the_static_policy_leaves_of_a_throw_stays_with_it() -> None:
    made, z = throws(30), np.random.default_rng(1).normal(0.0, 0.01, (30, 2))
    plain, left = (next(simulate_shifts(made, one, CAMERA, 1, seed=4)) for one in (np.zeros((30, 2)), z))
    place = {row.tobytes(): k for k, row in enumerate(made)}
    drawn = np.array([place[row.tobytes()] for row in left.features.reshape(-1, 26)]).reshape(SHIFTS, PICKS)
    np.testing.assert_allclose(left.true - plain.true, z[drawn], atol=1e-15)


# What comes of it.


def missed(tracker: InContext, lessons: in_context.TrainingShifts) -> float:
    """Mean error [m] of what a tracker foresees through shifts, after their first throws."""
    tracker.begin(everyone(len(lessons.z)))
    errors = []
    for pick in range(lessons.z.shape[1]):
        errors.append(np.abs(tracker.effect(lessons.features[:, pick]) - lessons.true[:, pick]).mean())
        tracker.learn(lessons.features[:, pick], lessons.z[:, pick], lessons.has_landing[:, pick])
    return float(np.mean(errors[10:]))


def test_a_little_study_lowers_the_loss(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(in_context, "SHIFTS", 16)
    monkeypatch.setattr(in_context, "PICKS", 20)
    made, z = throws(200), np.random.default_rng(1).normal(0.0, 0.004, (200, 2))
    (fresh,) = simulate_shifts(made, z, CAMERA, 1, seed=99)
    tracker = InContext(CAMERA, False, size=16, batches=80)
    before = missed(tracker, fresh)
    tracker.study(made, z, np.zeros(len(made), dtype=np.int64), seed=0)
    assert missed(tracker, fresh) < 0.75 * before
    other = InContext(CAMERA, False, size=16)
    other.restore(tracker.state())
    for one in (tracker, other):
        one.begin(everyone(3))
    assert tracker.effect(made[:3]).any()
    np.testing.assert_array_equal(other.effect(made[:3]), tracker.effect(made[:3]))


def test_a_seed_names_the_network() -> None:
    def one(seed: int) -> dict[str, np.ndarray]:
        lessons = islice(simulate_shifts(throws(20), np.zeros((20, 2)), CAMERA, 2, seed=0), 2)
        return dict(train(lessons, 2, 26, seed, 4).state())

    before = torch.get_rng_state()
    first, again, other = one(0), one(0), one(1)
    assert torch.equal(torch.get_rng_state(), before)
    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert not np.array_equal(first["head_weight"], other["head_weight"])


def test_where_cells_differ_a_training_shift_is_of_one_shift_of_the_practice() -> None:
    counts = [SHORT, SHORT + 9, SHORT - 1]
    shift = np.random.default_rng(2).permutation(np.repeat([4, 7, 1], counts))
    made = throws(sum(counts))
    z = np.stack([0.001 * shift, np.arange(len(shift)) * 1e-6], axis=1)  # the landing tells its shift and its throw
    for lessons in shuffle_shifts(made, z, shift, 2, seed=0):
        assert lessons.true.shape == (SHIFTS, SHORT, 2)
        assert all(len(np.unique(row[:, 0])) == 1 for row in lessons.true)
        assert all(len(np.unique(row[:, 1])) == SHORT for row in lessons.true)
        assert set(np.unique(lessons.true[..., 0])) == {0.004, 0.007}  # the third one is too short
        assert not lessons.z[~lessons.has_landing].any()
    with pytest.raises(UsageError, match=f"no shift of the practice has {SHORT} landings"):
        next(shuffle_shifts(made[:9], z[:9], shift[:9], 1, seed=0))


def test_a_network_learns_what_cells_have_in_common() -> None:
    random = np.random.default_rng(3)
    shift = np.repeat(np.arange(80), SHORT)
    made, offsets = throws(len(shift)), random.normal(0.0, 0.03, (80, 2))
    z = offsets[shift] + random.normal(0.0, 0.003, (len(shift), 2))
    tracker = InContext(CAMERA, True, size=16, batches=150)
    tracker.study(made, z, shift, seed=0)
    rows = np.full(20, True)
    tracker.begin(rows)
    new, other = random.normal(0.0, 0.03, (20, 2)), throws(20)
    for _ in range(6):
        tracker.learn(other, new, rows)
    assert np.abs(tracker.effect(other) - new).mean() < 0.4 * np.abs(new).mean()
