"""What the agent sees: bounded, decodable, and free of everything that a real cell could not measure."""

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.observation import FEATURES, TABLE, decode
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.errors import PntGymError
from tests.tools.throws import make_core, planned, same_bits, with_part

COUNT = 200


def drawn(config, count=COUNT, seed=0) -> Objects:
    return take(PickPlanner(config).draw([np.random.default_rng(seed)], np.arange(1), count), 0)


def seen(config, objects: Objects):
    """Observations of throwable objects, and which they are."""
    context, good = planned(config, objects, np.linspace(*config.belt.pick_x, len(objects.mass)))
    return TABLE.encode(take(context, np.flatnonzero(good))), good


@pytest.fixture(scope="module", params=["nominal_plain", "waste_plain"])
def core(request):
    return make_core(request.param, COUNT)


def test_bounds_type_and_size(core):
    observation = core.observe()
    assert observation.shape == (COUNT, len(FEATURES)) == (COUNT, 26)
    assert observation.dtype == np.float32
    assert np.abs(observation).max() <= CLIP
    assert all(core.observation_space.contains(row) for row in observation)


def test_few_values_are_clipped_and_every_feature_that_may_vary_does():
    observation = make_core("waste", 500).observe()
    assert np.mean(np.abs(observation) == CLIP) < 0.01
    constant = {f.name for f, column in zip(FEATURES, observation.T, strict=True) if np.ptp(column) == 0.0}
    assert constant == {"belt_speed"}
    assert np.abs(observation).mean() < 2.0


def test_decode_inverts_observe_where_nothing_is_clipped(core):
    context, observation = core.context, core.observe()
    values = decode(observation)
    inside = np.abs(observation) < CLIP
    measured, plan = context.objects.measured, context.plan
    scale = {f.name: f.scale for f in FEATURES}
    index = {f.name: i for i, f in enumerate(FEATURES)}
    expected = {
        "pick_x": context.pick[:, 0],
        "pick_y": context.pick[:, 1],
        "target_x": context.target[:, 0],
        "target_y": context.target[:, 1],
        "distance": np.hypot(*(context.target - context.pick)[:, :2].T),
        "opening": context.opening.min(axis=1),
        "belt_speed": np.full(COUNT, core.config.belt.speed),
        "release_speed": np.linalg.norm(plan.velocity, axis=1),
        "elevation": np.arcsin(plan.velocity[:, 2] / np.linalg.norm(plan.velocity, axis=1)),
        "release_distance": np.linalg.norm(plan.position - context.pick, axis=1),
        "flight_time": plan.flight_time,
        "length": measured.size[:, 0],
        "width": measured.size[:, 1],
        "height": measured.size[:, 2],
        "is_ellipsoid": measured.shape == 0,
        "is_cylinder": measured.shape == 1,
        "is_box": measured.shape == 2,
        "ln_mass": np.log(measured.mass),
        "ln_seal": np.log(measured.seal),
        "ln_grip_ratio": np.log(measured.seal / measured.mass / 9.81),
        "plan_area_per_mass": measured.size[:, 0] * measured.size[:, 1] / measured.mass,
    }
    for name, value in expected.items():
        rows = inside[:, index[name]]
        assert rows.sum() > 0.9 * COUNT, name
        np.testing.assert_allclose(values[name][rows], value[rows], atol=2e-6 * scale[name] * CLIP, err_msg=name)


def test_yaw_and_grasp_are_seen_in_the_frame_of_the_throw(core):
    context, values = core.context, decode(core.observe())
    heading = np.arctan2(*(context.target - context.pick)[:, 1::-1].T)
    relative = context.objects.measured.yaw - heading
    np.testing.assert_allclose(values["cos_2yaw"], np.cos(2 * relative), atol=2e-6)
    np.testing.assert_allclose(values["sin_2yaw"], np.sin(2 * relative), atol=2e-6)
    grasp = context.measured_grasp
    along = grasp[:, 0] * np.cos(heading) + grasp[:, 1] * np.sin(heading)
    across = grasp[:, 1] * np.cos(heading) - grasp[:, 0] * np.sin(heading)
    inside = (np.abs(along) < 0.049) & (np.abs(across) < 0.049)
    np.testing.assert_allclose(values["grasp_along"][inside], along[inside], atol=2e-8)
    np.testing.assert_allclose(values["grasp_across"][inside], across[inside], atol=2e-8)


def test_the_area_facing_the_throw_is_that_of_the_turned_box(core):
    context, values = core.context, decode(core.observe())
    measured = context.objects.measured
    relative = measured.yaw - np.arctan2(*(context.target - context.pick)[:, [1, 0]].T)
    corners = np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]]) / 2
    places = corners[None] * measured.size[:, None, :2]
    across = places[..., 0] * np.sin(relative)[:, None] + places[..., 1] * np.cos(relative)[:, None]
    width = across.max(axis=1) - across.min(axis=1)
    area = width * measured.size[:, 2] / measured.mass
    inside = np.abs(area - 0.35) < 0.20 * CLIP
    np.testing.assert_allclose(values["frontal_area_per_mass"][inside], area[inside], atol=2e-6)


def test_clipped_values_decode_to_the_border():
    high = decode(np.full(len(FEATURES), CLIP, dtype=np.float32))
    for f in FEATURES:
        assert high[f.name] == pytest.approx(f.centre + CLIP * f.scale)


# No hidden value leaks. Objects are changed where sensors do not look, and planned and observed anew.


def other(values, seed=1):
    """Values of the same size that share nothing with the given ones."""
    return values * np.random.default_rng(seed).uniform(1.5, 3.0, values.shape) + 1e-4


def changed(o: Objects, name: str) -> Objects:
    """Objects with another hidden value and the same measured one."""
    if name == "size":  # the height is felt by the cup: it is measured
        return o.replace(size=o.size * np.array([1.3, 0.8, 1.0]))
    if name == "grasp":
        moved = o.replace(grasp=o.grasp + 0.004)
        return with_part(moved, "measured.grasp_noise", o.measured.grasp_noise - 0.004)
    return o.replace(**{name: other(getattr(o, name))})


HIDDEN = (
    "mass", "size", "drag", "com_depth", "seal", "delay", "jitter", "friction", "rolling_friction", "restitution",
    "yaw", "grasp", "spin", "blow_off",
)  # fmt: skip


@pytest.mark.parametrize("level", ["nominal", "waste", "unseen", "tight"])
@pytest.mark.parametrize("name", HIDDEN)
def test_a_hidden_value_leaves_the_observation_as_it_is(level, name):
    config = ConveyorConfig.load(level)
    objects = drawn(config)
    before, good = seen(config, objects)
    after, still = seen(config, changed(objects, name))
    assert same_bits(good, still)
    assert good.sum() > COUNT / 4
    if name == "grasp":  # measured = true + noise: the sum is the same up to rounding
        np.testing.assert_allclose(after, before, atol=1e-6)
    else:
        assert same_bits(before, after)


def test_the_belt_speed_error_is_seen_through_the_measured_grasp_only():
    config = ConveyorConfig.load("nominal")
    objects = drawn(config)
    before, _ = seen(config, objects)
    after, _ = seen(config, objects.replace(belt_error=objects.belt_error + 0.01))
    columns = [i for i, f in enumerate(FEATURES) if not f.name.startswith("grasp")]
    assert same_bits(before[:, columns], after[:, columns])
    assert not same_bits(before, after)


def test_measured_values_do_reach_the_observation():
    """The other half of the leak test: it would also pass on an observation of zeros."""
    config = ConveyorConfig.load("waste")
    objects = drawn(config)
    before, _ = seen(config, objects)
    for name in ("mass", "seal", "yaw", "grasp_noise", "size"):
        values = getattr(objects.measured, name) * 1.1
        after, _ = seen(config, with_part(objects, f"measured.{name}", values))
        assert not same_bits(before, after), name


@pytest.mark.parametrize("wrong", ["x", 0.0, np.zeros(3), [[0.0], [0.0, 1.0]]], ids=str)
def test_what_is_no_observation_is_not_decoded(wrong):
    with pytest.raises(PntGymError, match="observation must"):
        decode(wrong)
