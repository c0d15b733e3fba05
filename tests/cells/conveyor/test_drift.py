"""The sections `drift` and `feedback` of a level: what they refuse, and what the values that they draw are like."""

from itertools import product

import numpy as np
import pytest

from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.drift import CameraOffset, Draught, Drift, Encoder, Valve
from pnt_gym.errors import ConfigError

KINDS = {"delay": Valve, "camera": CameraOffset, "encoder": Encoder, "draught": Draught}
BOUNDS = {"delay": ("s", 0.03), "camera": ("m", 0.05), "encoder": ("of the speed", 0.05), "draught": ("m/s", 3.0)}
PARTS = ("even", "normal", "step", "walk", "ramp")
SHIFTS, PICKS, EVERY = 4000, 50, 20


def paths(wander, shifts=SHIFTS, picks=PICKS, every=EVERY):
    """Many shifts (shifts, picks)."""
    random = np.random.default_rng(5)
    return np.array([wander.path(random, picks, every) for _ in range(shifts)])


def centred(values):
    """Whether columns have no mean that their spread does not explain."""
    error = values.std(axis=0) / np.sqrt(len(values))
    return (np.abs(values.mean(axis=0)) <= 4.5 * error + 1e-12).all()


@pytest.mark.parametrize("value", [-1e-9, 10.0, np.inf, -np.inf, np.nan])
@pytest.mark.parametrize(("kind", "part"), [*product(KINDS, [*PARTS, "most"]), ("delay", "film")])
def test_a_part_without_bounds_is_refused_with_its_value_and_the_range(kind, part, value):
    with pytest.raises(ConfigError) as caught:
        ConveyorConfig.load({"base": "waste", "drift": {kind: {part: value}}})
    unit, bound = BOUNDS[kind]
    assert str(caught.value) == (f"config: drift.{kind}.{part} is {value:g} {unit}; it must be 0 to {bound:g} {unit}")


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_on_its_bound_is_taken(kind, part):
    drift = ConveyorConfig.load({"drift": {kind: {part: BOUNDS[kind][1], "most": BOUNDS[kind][1]}}}).drift
    assert getattr(getattr(drift, kind), part) == BOUNDS[kind][1]
    assert drift.moves


@pytest.mark.parametrize(
    ("sections", "said"),
    [
        ({"drift": {"steps_every": 2.5}}, "drift.steps_every is 2.5"),
        ({"drift": {"camera": {"film": 0.01}}}, "unknown key 'drift.camera.film'"),
        ({"drift": {"delay": {"even": True}}}, "drift.delay.even is True"),
    ],
    ids=str,
)
def test_a_wrong_section_is_one_sentence(sections, said):
    with pytest.raises(ConfigError) as caught:
        ConveyorConfig.load({"base": "waste", **sections})
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200


def test_nothing_drifts_by_default():
    assert not Drift().moves
    assert not any(ConveyorConfig.load(name).drift.moves for name in ("nominal", "waste", "unseen", "tight", "ideal"))
    for kind in KINDS.values():
        assert not kind().moves
        assert not paths(kind(), shifts=50).any()


@pytest.mark.parametrize(("kind", "part"), [*product(KINDS, PARTS), ("delay", "film")])
def test_each_part_makes_it_move_unless_it_is_held(kind, part):
    assert Drift(**{kind: KINDS[kind](**{part: 0.001})}).moves
    held = KINDS[kind](**{part: 0.001, "most": 0.0})
    assert not held.moves
    assert not paths(held, shifts=20).any()


@pytest.mark.parametrize("name", ["day", "steps", "drift_mix"])
def test_the_shipped_levels_drift_and_their_far_forms_twice_as_much(name):
    """And in nothing else do they differ from `waste`."""
    waste, near, far = (ConveyorConfig.load(level) for level in ("waste", name, f"{name}_far"))
    for level in (near, far):
        assert level.drift.moves
        assert level.model_copy(update={"name": "waste", "drift": waste.drift}) == waste
    for kind in KINDS:
        one, two = (getattr(level.drift, kind).model_dump() for level in (near, far))
        for part in {*one} - {"most", "cleaned"}:
            assert two[part] == pytest.approx(2.0 * one[part])
        assert two["most"] >= one["most"]


@pytest.mark.parametrize("kind", KINDS.values())
@pytest.mark.parametrize("picks", [1, 2, 50])
def test_as_many_numbers_are_drawn_whatever_the_level_says(kind, picks):
    following = set()
    settings = [{}, {"most": 0.0}, *({part: 0.001} for part in PARTS), dict.fromkeys(PARTS, 0.01)]
    for setting in settings + ([{"film": 0.01}] if kind is Valve else []):
        random = np.random.default_rng(3)
        assert kind(**setting).path(random, picks, EVERY).shape == (picks,)
        following.add(random.random())
    assert len(following) == 1


def test_even_is_constant_and_uniform():
    values = paths(CameraOffset(even=0.01))
    assert (values == values[:, :1]).all()
    assert centred(values[:, :1])
    assert 0.0098 < np.abs(values).max() <= 0.01
    assert values[:, 0].std() == pytest.approx(0.01 / np.sqrt(3), rel=0.03)


def test_normal_is_constant_with_its_deviation():
    values = paths(CameraOffset(normal=0.008))
    assert (values == values[:, :1]).all()
    assert centred(values[:, :1])
    inside = np.abs(values[:, 0]) < 0.008
    assert inside.mean() == pytest.approx(0.683, abs=0.025)
    assert values[:, 0].std() == pytest.approx(0.008, rel=0.04)


def test_a_step_has_another_value_exactly_every_so_many_picks():
    values = paths(Encoder(step=0.01))
    changes = np.diff(values, axis=1) != 0.0
    assert changes[:, EVERY - 1 :: EVERY].all()
    changes[:, EVERY - 1 :: EVERY] = False
    assert not changes.any()
    assert centred(values)
    levels = values[:, ::EVERY]
    assert levels.std(axis=0) == pytest.approx(0.01 / np.sqrt(3), rel=0.05)
    assert np.abs(np.corrcoef(levels.T) - np.eye(levels.shape[1])).max() < 0.07


def test_a_walk_begins_at_nothing_and_spreads_with_the_root_of_the_picks():
    values = paths(Draught(walk=0.02))
    assert not values[:, 0].any()
    assert centred(values[:, 1:])
    steps = np.diff(values, axis=1)
    assert steps.std(axis=0) == pytest.approx(0.02, rel=0.06)
    assert values[:, -1].std() == pytest.approx(0.02 * np.sqrt(PICKS - 1), rel=0.04)
    assert abs(np.corrcoef(steps[:, 10], steps[:, 11])[0, 1]) < 0.06


def test_a_ramp_is_a_line_through_nothing_in_the_middle_of_the_shift():
    values = paths(Valve(ramp=0.01))
    np.testing.assert_allclose(np.diff(values, n=2, axis=1), 0.0, atol=1e-15)
    np.testing.assert_allclose(values[:, 0], -values[:, -1], atol=1e-15)
    assert centred(values)
    assert values[:, -1].std() == pytest.approx(0.01 / np.sqrt(3), rel=0.03)
    assert np.abs(values[:, -1]).max() <= 0.01
    assert not paths(Valve(ramp=0.01), shifts=5, picks=1).any()


def test_a_film_grows_evenly_and_falls_at_a_cleaning():
    cleaned = 20
    values = paths(Valve(film=0.01, cleaned=cleaned))
    steps = np.diff(values, axis=1)
    falls = steps < 0.0
    assert ((falls.sum(axis=1) == 2) | (falls.sum(axis=1) == 3)).all()
    first = falls.argmax(axis=1)
    assert set(first) == set(range(cleaned))  # a shift begins anywhere between two cleanings
    for row in range(200):
        assert np.flatnonzero(falls[row]).tolist() == [*range(first[row], PICKS - 1, cleaned)]
    np.testing.assert_allclose(steps[~falls], 0.01 / (cleaned - 1), atol=1e-15)
    np.testing.assert_allclose(steps[falls], -0.01, atol=1e-15)
    assert centred(values)
    assert (values.min(), values.max()) == pytest.approx((-0.005, 0.005))


def test_the_parts_add_up():
    def drawn(**parts):
        return paths(Valve(most=0.03, **parts), shifts=200)

    parts = {"even": 0.002, "normal": 0.001, "step": 0.002, "walk": 0.0001, "ramp": 0.002, "film": 0.003}
    together = drawn(**parts)
    assert np.abs(together).max() < 0.03
    np.testing.assert_allclose(together, sum(drawn(**{name: size}) for name, size in parts.items()), atol=1e-15)


@pytest.mark.parametrize("kind", KINDS.values())
def test_the_sum_stays_within_its_most(kind):
    most = 0.4 * kind.bound
    film = {"film": 0.5 * kind.bound} if kind is Valve else {}
    wander = kind(**dict.fromkeys(PARTS, 0.5 * kind.bound), **film, most=most)
    values = paths(wander, shifts=500)
    assert np.abs(values).max() == pytest.approx(most)
    assert (np.abs(values) < most).mean() > 0.02
    assert centred(values)
