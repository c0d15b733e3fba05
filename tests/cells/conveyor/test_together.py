"""Shipped levels, which are honest in all sections at once: grip, cup, pick, belt, order and bins go together."""

from itertools import cycle, product

import numpy as np
import pytest

from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core

COUNT, STEPS = 8, 3
LEVELS = {
    **{name: {"base": name} for name in ("nominal", "waste", "fast", "light")},
    "blown": {"base": "waste", "cup": {"blow_off": 0.1}, "spread": {"blow_off": 0.3}},
}
"""Shipped levels as they are, and one whose cups blow objects off as well."""
PICKS = ("belt", "independent")
EVERY = pytest.mark.parametrize(
    ("level", "picks"), with_nightly(product(LEVELS, PICKS), [*zip(LEVELS, cycle(PICKS), strict=False)])
)
"""All levels with picks of both kinds; daily with the one or the other."""
SIMULATED = [*product(("full", "flight"), PICKS)]
PLANNERS = ("free_direction", "horizontal", "pick_and_place", "ellipse")
ALONE = [*(("blown", {"fidelity": fidelity}, picks) for fidelity, picks in SIMULATED),
         *(("waste", {"planner": planner}, "belt") for planner in PLANNERS)]  # fmt: skip
"""Everything at once, and every way to a bin but the straight one, which is the first's."""


def core_of(level, picks="belt", rows=range(COUNT), threads=1, **changes):
    changed = {**LEVELS.get(level, {"base": level}), **changes}
    return make_core(changed, len(rows), picks=picks, seed=rows.start, threads=threads)


def steps(core, count=STEPS, first=0):
    """Steps with the actions of as many rows as there are, from a first row on."""
    action = np.random.default_rng(0).uniform(-0.3, 0.3, (count, COUNT, 2))
    return [core.step(one[first : first + core.count]) for one in action]


def same(one, other, rows=slice(None)):
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.observation[rows], b.observation)
        np.testing.assert_array_equal(a.reward[rows], b.reward)
        for name, values in b.info.items():
            np.testing.assert_array_equal(a.info[name][rows], values, err_msg=name)


@pytest.mark.parametrize(("level", "changes", "picks"), with_nightly(ALONE, [ALONE[0], ALONE[2], ALONE[-2]]), ids=str)
def test_a_row_is_the_same_alone_in_a_batch_and_with_other_threads(level, changes, picks):
    count = STEPS if level == "blown" else 2
    batch = steps(core_of(level, picks, **changes), count)
    same(batch, steps(core_of(level, picks, threads=2, **changes), count))
    alone = core_of(level, picks, rows=range(5, 6), **changes)
    same(batch, steps(alone, count, first=5), slice(5, 6))


@EVERY
def test_what_is_lost_is_lost_once_and_numbers_are_numbers(level, picks):
    core = core_of(level, picks)
    for step in steps(core):
        info = step.info
        assert np.isfinite(step.observation).all()
        assert np.isfinite(step.reward).all()
        assert not (info["dropped"] & ~info["picked"]).any()
        assert not (info["is_success"] & (info["dropped"] | ~info["picked"])).any()
        np.testing.assert_array_equal(np.isfinite(info["landing_error"]), info["picked"])
        assert (info["ended_in"][~info["picked"]] == -1).all()
        assert (info["sorted"] <= info["is_success"]).all()
        assert (info["energy"] > 0.0).all()


@EVERY
def test_the_planners_own_world_holds_everything(level, picks):
    for step in steps(core_of(level, picks, mismatch=0.0), 3):
        info = step.info
        assert info["picked"].all()
        assert not info["dropped"].any()
        assert not info["slip"].any()


@pytest.mark.parametrize("level", with_nightly(("nominal", "waste", "unseen"), ["waste"]))
def test_some_picks_fail_and_a_few_objects_are_lost(level):
    core = core_of(level, rows=range(300), fidelity="flight")
    steps = [core.step(np.zeros((300, 2))).info for _ in range(3)]
    picked, dropped = (np.concatenate([info[name] for info in steps]) for name in ("picked", "dropped"))
    assert 0.70 < picked.mean() < 0.90
    assert 0.002 < dropped[picked].mean() < 0.06
