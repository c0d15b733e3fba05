"""A cell that drifts through its shift: bit for bit the usual one without drift, and nobody sees how it is off."""

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base.bodies import turn_back
from pnt_gym.cells.conveyor.context import HiddenDrift
from pnt_gym.cells.conveyor.objects.drawing import time_constant
from pnt_gym.cells.conveyor.objects.kernel import peel_impulse
from pnt_gym.cells.conveyor.observation import DRIFT, HIDDEN, decode
from pnt_gym.cells.conveyor.shift import DriftSchedule, apply_drift
from pnt_gym.errors import ConfigError
from tests.tools.drifting import ALL, QUICK, actions, cells
from tests.tools.throws import CONVEYOR, make_core, parts_of, same_bits, vary


def same_info(mine, other):
    """Whether an info has all that another one has, to the last bit."""
    for key, value in other.items():
        if isinstance(value, dict):
            same_info(mine[key], value)
        elif value.dtype == object:
            for one, two in zip(mine[key], value, strict=True):
                assert (one is None) == (two is None)
                assert two is None or same_bits(one[: len(two)], two), key
        else:
            assert same_bits(mine[key], value), key


@pytest.mark.parametrize("level", ["waste", "nominal"])
def test_a_cell_without_drift_is_that_of_the_conveyor_to_the_last_bit(level):
    config = vary(level, picks_per_shift=3)
    told, plain = (gym.make_vec(env_id, num_envs=4, level=config) for env_id in ("PnTAdapt-v0", "PnTConveyor-v0"))
    (one, first), (two, second) = told.reset(seed=3), plain.reset(seed=3)
    assert same_bits(one[:, :26], two)
    same_info(first, second)
    ends = 0
    for action in actions(4, 8):
        (one, *mine, info), (two, *other, seen) = told.step(action), plain.step(action)
        assert same_bits(one[:, :26], two)
        for a, b in zip(mine, other, strict=True):
            assert same_bits(a, b)
        same_info(info, seen)
        where = info.get("final_info", info), seen.get("final_info", seen)
        assert {key for key in where[0] if not key.startswith("_")} - {*where[1]} == {
            "seen_along", "seen_across", "pick_in_shift",
        }  # fmt: skip
        ends += int(mine[2].sum())
    assert ends == 8


@pytest.mark.parametrize("env_id", [env_id for env_id in CONVEYOR if env_id != "PnTAdapt-v0"])
@pytest.mark.parametrize("kind", ["delay", "camera", "encoder", "draught"])
def test_a_level_that_drifts_is_refused_where_nothing_tells_of_it(env_id, kind):
    for make in (gym.make, lambda *args, **kwargs: gym.make_vec(*args, num_envs=2, **kwargs)):
        with pytest.raises(ConfigError) as caught:
            make(env_id, level={"base": "waste", "drift": {kind: {"walk": 0.001}}})
        assert str(caught.value) == (
            "level 'custom' drifts, and the observations of this environment do not show drift; use PnTAdapt-v0, or "
            "set the parts of its section `drift` to 0"
        )


@pytest.mark.parametrize("picks", [1, 100_001, 10**15])
def test_a_shift_needs_a_throw_that_follows_and_is_drawn_whole(picks):
    with pytest.raises(ConfigError) as caught:
        gym.make("PnTAdapt-v0", level={"base": "waste", "picks_per_shift": picks})
    assert str(caught.value) == (f"picks_per_shift is {picks}; where a camera sees landings it must be 2 to 100000")
    assert gym.make("PnTConveyor-v0", level={"base": "waste", "picks_per_shift": picks}).reset(seed=0)


def shifts(seeds, **changes):
    config = vary("waste", **changes)
    return DriftSchedule.draw([np.random.default_rng(seed) for seed in seeds], config)


def columns(shift):
    named = {name: getattr(shift.drift, name) for name in HiddenDrift.fields}
    return named | {name: getattr(shift, name) for name in ("noise", "chance", "at")}


def test_a_shift_is_a_function_of_its_rows_generator_which_stays_where_it_is():
    generators = [np.random.default_rng(seed) for seed in range(5)]
    together = columns(DriftSchedule.draw(generators, vary("waste", drift=ALL)))
    assert [g.random() for g in generators] == [np.random.default_rng(seed).random() for seed in range(5)]
    for row in range(5):
        for name, values in columns(shifts([row], drift=ALL)).items():
            assert same_bits(values[0], together[name][row]), name
    for name in ("delay", "camera", "encoder", "draught", "noise", "chance"):
        assert len({row.tobytes() for row in together[name]}) == 5, name


def test_drift_scales_with_the_mismatch_and_is_nothing_in_the_planners_own_world():
    full, half, none = (columns(shifts(range(20), drift=ALL, mismatch=m)) for m in (1.0, 0.5, 0.0))
    for name in ("delay", "camera", "encoder", "draught"):
        assert np.abs(full[name]).max() > 0.0
        np.testing.assert_array_equal(half[name], 0.5 * full[name])
        assert not none[name].any()
    for name in ("noise", "chance"):  # what is seen of it is no unmodelled effect
        assert same_bits(full[name], none[name])


def test_what_drifts_and_what_is_seen_are_drawn_apart():
    """Another drift, or a camera that errs, changes no other number of the shift."""
    drift, still = columns(shifts(range(3), drift=ALL)), columns(shifts(range(3)))
    only = columns(shifts(range(3), drift={"encoder": ALL["encoder"]}))
    for name in ("noise", "chance", "at"):
        assert same_bits(drift[name], still[name])
    assert same_bits(drift["encoder"], only["encoder"])


def test_the_axes_of_camera_and_draught_differ():
    drawn = shifts(range(600), drift=ALL, picks_per_shift=2)
    for values in (drawn.drift.camera[:, 0], drawn.drift.draught[:, 0]):
        assert abs(np.corrcoef(values.T)[0, 1]) < 0.13


def test_behind_its_end_a_shift_stays_as_it_was():
    shift = shifts([1, 2], drift=ALL, picks_per_shift=3)
    for _ in range(5):
        shift = shift.advance(np.ones(2, dtype=np.bool_))
    np.testing.assert_array_equal(shift.now().delay, shift.drift.delay[:, -1])
    np.testing.assert_array_equal(shift.now().camera, shift.drift.camera[:, -1])


def test_every_pick_has_the_drift_of_its_place_in_the_shift():
    core = cells(3, drift=ALL, picks_per_shift=4, **QUICK)
    generators = [np.random.default_rng(seed) for seed in range(3)]
    for _ in range(2):
        told = []
        for action in actions(3, 4):
            told.append(core.context.drift)
            core.step(action)
        assert len({now.delay.tobytes() for now in told}) == 4
        assert len({now.camera.tobytes() for now in told}) == 4  # a walk
        assert len({now.draught.tobytes() for now in told}) == 1  # constant
        core.reset(np.arange(3), generators, seeded=True)


def drifts(env):
    """How the coming picks are off, as bytes of each row."""
    return [row.tobytes() for row in env.unwrapped.core.context.drift.rows]


def test_shifts_differ_by_seed_and_follow_from_it():
    env, other = (gym.make_vec("PnTAdapt-v0", num_envs=3, level={"base": "drift_mix", **QUICK}) for _ in range(2))
    env.reset(seed=1)
    first = drifts(env)
    assert len({*first}) == 3
    other.reset(seed=99)
    for action in actions(3, 2):
        other.step(action)
    other.reset(seed=1)
    assert drifts(other) == first
    env.reset(seed=2)
    assert drifts(env)[:2] == first[1:]  # row i of seed s is row 0 of seed s + i
    assert drifts(env)[2] not in first
    for action in actions(3, 1):
        env.step(action)
    env.reset()
    assert not {*drifts(env)} & {*first}


@pytest.fixture(scope="module")
def pair():
    """The same first picks in cells without and with drift."""
    still, moving = cells(40, seed=11, **QUICK), cells(40, seed=11, drift=ALL, **QUICK)
    return still, moving


def test_the_first_throw_has_the_same_object_and_looks_the_same(pair):
    still, moving = pair
    assert same_bits(still.observe(), moving.observe())
    one, two = still.context, moving.context
    other = parts_of(two.objects)
    for name, values in parts_of(one.objects).items():
        assert same_bits(values, other[name]) == (name not in ("delay", "spin")), name
    for name in ("measured_grasp", "pick", "target", "bin", "opening", "depth", "visible_grasp"):
        assert same_bits(getattr(one, name), getattr(two, name)), name
    assert same_bits(one.plan.velocity, two.plan.velocity)


def test_the_true_grasp_is_moved_by_the_camera_and_by_what_the_encoder_adds_up_to(pair):
    still, moving = pair
    context, drift, belt = moving.context, moving.context.drift, moving.config.belt
    moved = drift.camera.copy()
    moved[:, 0] += drift.encoder * (context.pick[:, 0] - belt.camera_x)
    assert np.abs(moved).min() > 0.0
    np.testing.assert_allclose(context.grasp - still.context.grasp, moved, atol=1e-15)
    assert (context.pick[:, 0] > belt.camera_x).all()  # what the encoder adds has been adding up


def test_the_release_is_later_by_the_drift_and_never_before_it_is_commanded(pair):
    still, moving = pair
    drift, delay = moving.context.drift.delay, still.context.objects.delay
    assert (drift > 0.0).any()
    assert (drift < 0.0).any()
    np.testing.assert_array_equal(moving.context.objects.delay, np.maximum(delay + drift, 0.0))
    early = still.context.drift.replace(delay=np.full(40, -1.0))
    assert not apply_drift(still.context, early, still.config).objects.delay.any()


def spun(config, core, offset):
    """Spin at release (N, 3) where objects are off by so much (2,) [m]."""
    return apply_drift(core.context, HiddenDrift.of(core.count, camera=np.array(offset)), config).objects.spin


def test_under_a_rigid_lip_spin_follows_the_offset():
    core = cells(30, "waste_plain", **QUICK)
    spin, config = core.context.objects.spin, core.config
    assert same_bits(spun(config, core, [0.0, 0.0]), spin)
    small, large = (spun(config, core, [0.001 * k, -0.002 * k]) - spin for k in (1, 3))
    assert (np.abs(small).max(axis=1) > 0.0).all()
    np.testing.assert_allclose(large, 3.0 * small, atol=1e-9)


def test_a_lip_that_peels_opens_where_the_object_truly_is():
    core, offset = cells(30, **QUICK), np.array([0.006, -0.010])
    o, spin = core.context.objects, spun(core.config, core, offset)
    tau, found = time_constant(o.seal, o.tau, core.config.suction), turn_back(spin, *o.turn) * o.inertia
    columns = zip(9.81 * o.mass, *(o.grasp + offset).T, o.cup_radius, tau, strict=True)
    impulse = np.array([(*peel_impulse(*row), 0.0) for row in columns])
    np.testing.assert_allclose(found, turn_back(impulse, *o.turn), rtol=1e-9, atol=1e-15)
    assert same_bits(spun(core.config, core, [0.0, 0.0]), o.spin)


@pytest.mark.parametrize(
    "part",
    [
        {"delay": np.full(12, 0.02)}, {"camera": np.full((12, 2), 0.03)}, {"encoder": np.full(12, -0.03)},
        {"draught": np.full((12, 2), 1.0)},
    ],
    ids=lambda part: next(iter(part)),
)  # fmt: skip
def test_no_drift_of_the_coming_pick_leaks_into_what_is_seen_of_it(part):
    core = cells(12, **QUICK)
    core.step(actions(12, 1)[0])
    before, context = core.observe(), core.context
    assert before.shape == (12, 34)
    assert before[:, 26:].any()
    core.cell.context = apply_drift(context, HiddenDrift.of(12, **part), core.config)
    assert same_bits(core.observe(), before)
    assert core.context.drift.rows.tobytes() != context.drift.rows.tobytes()


def test_what_drifts_is_hidden_and_named():
    plain, told = make_core(vary("waste", **QUICK), 2, picks="belt"), cells(2, drift=ALL, **QUICK)
    assert [*plain.hidden()] == [one.name for one in HIDDEN]
    hidden, drift = told.hidden(), told.context.drift
    assert [*hidden] == [one.name for one in (*HIDDEN, *DRIFT)]
    expected = (drift.delay, *drift.camera.T, drift.encoder, *drift.draught.T)
    for one, values in zip(DRIFT, expected, strict=True):
        assert same_bits(hidden[one.name], values)
    assert not {one.name for one in DRIFT} & {*decode(told.observe())}
