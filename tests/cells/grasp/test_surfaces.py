"""Surfaces and seals: what the kernels compute, and how often cups hold on the kinds of the catalogue."""

import pickle

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.base.items import Item
from pnt_gym.cells.conveyor.context import belt_shift
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.grasp.config import GraspConfig, Surface
from pnt_gym.cells.grasp.surfaces import (
    IMAGE,
    SURFACE,
    TRY,
    draw_surfaces,
    later_keys,
    normal_draw,
    object_keys,
    outline_errors,
    seal_at,
    seal_holds,
    surface_table,
)
from tests.tools.surfaces import SEEN, UNSEEN, draw_objects, height_and_leak, to_world
from tests.tools.throws import same_bits

ANGLES = 2.0 * np.pi / 16 * np.arange(16)
RING = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=-1)


@pytest.fixture(scope="module")
def waste():
    objects, table = draw_objects((*SEEN, *UNSEEN, "cork"), 400, seed=3)
    return objects, table, draw_surfaces(table, objects)


def columns_of(surfaces):
    """The columns of surfaces by name."""
    return {f"{kind} {name}": rows[name] for kind, rows in surfaces._asdict().items() for name in rows.dtype.names}


@pytest.fixture(scope="module")
def places(waste):
    """Places (N, P, 2), some of them beside the object."""
    size = waste[0].size[:, None, :2]
    return 0.6 * size * np.random.default_rng(1).uniform(-1.0, 1.0, (len(size), 30, 2))


def mixed(number):
    """The output function of splitmix64, in Python's integers."""
    mask = 2**64 - 1
    number = (number ^ (number >> 30)) * 0xBF58476D1CE4E5B9 & mask
    number = (number ^ (number >> 27)) * 0x94D049BB133111EB & mask
    return number ^ (number >> 31)


def test_keys_are_hashes_of_the_draws(waste):
    objects, golden, mask = waste[0], 0x9E3779B97F4A7C15, 2**64 - 1
    key = mixed(TRY * golden & mask)
    for bits in np.ascontiguousarray(objects.draws.place[7]).view(np.uint64).tolist():
        key = mixed((key ^ bits) + golden & mask)
    assert int(object_keys(objects, TRY)[7]) == key
    keys = [object_keys(objects, purpose) for purpose in (SURFACE, IMAGE, TRY)]
    assert len(np.unique(keys)) == 3 * len(objects.kind)


def test_draws_of_keys_are_standard_normal(waste):
    keys = later_keys(object_keys(waste[0], TRY)[:, None], np.arange(100))
    normals = normal_draw(keys)
    assert normals.shape == (400, 100)
    assert len(np.unique(keys)) == keys.size
    assert abs(normals.mean()) < 0.02
    assert abs(normals.std() - 1.0) < 0.02
    assert abs(np.corrcoef(normals[:, 0], normals[:, 1])[0, 1]) < 0.15
    assert 1e-4 < (np.abs(normals) > 3.0).mean() < 6e-3


def test_an_object_has_one_surface_alone_and_in_a_batch(waste, places):
    objects, table, surfaces = waste
    single = take(objects, np.array([5]))
    for name, values in columns_of(draw_surfaces(table, single)).items():
        assert same_bits(values[0], columns_of(surfaces)[name][5]), name
    seals = seal_at(surfaces, objects, places)
    again = seal_at(take(surfaces, np.array([5])), pickle.loads(pickle.dumps(single)), places[5:6])
    assert same_bits(seals.force[5], again.force[0])
    assert same_bits(seals.leak[5], again.leak[0])
    folded = take(objects, np.arange(400).reshape(20, 20))
    for name, values in columns_of(draw_surfaces(table, folded)).items():
        assert same_bits(values.reshape(400, *values.shape[2:]), columns_of(surfaces)[name]), name


def test_a_seal_is_conductance_and_gap_under_the_lip(waste, places):
    """At every place of every object, by heights and leaks of a formula in NumPy."""
    objects, _, surfaces = waste
    seals, radius, shares = (
        seal_at(surfaces, objects, to_world(objects, *places.transpose(2, 0, 1))),
        objects.cup_radius,
        [],
    )
    for row in range(len(places)):
        lip = radius[row] * np.concatenate([RING, 0.6 * RING, np.zeros((1, 2))])
        height, leak = height_and_leak(objects, surfaces, row, *(places[row][:, None] + lip).transpose(2, 0, 1))
        conductance = (leak[:, :32].sum(axis=1) + 3.0 * leak[:, 32]) / 35.0
        rim = height[:, :16] if surfaces.bodies["count"][row] >= 0 else np.minimum(height[:, :16], 0.0)
        gaps = np.array([mean_gap(one, radius[row]) for one in rim])
        expected = conductance + 8.0 * 1e6 * gaps
        np.testing.assert_allclose(seals.leak[row], expected, rtol=1e-9)
        force = np.minimum(objects.seal[row] / expected, 0.6e5 * np.pi * radius[row] ** 2)
        np.testing.assert_allclose(seals.force[row], force, rtol=1e-9)
        shares.append([(height[:, 32] < 0.0).mean(), (leak != 1.0).mean(), (gaps > 0.0).mean()])
    beside, leaks, gapes = np.mean(shares, axis=0)
    assert 0.2 < beside < 0.5
    assert leaks > 0.1
    assert 0.2 < gapes < 0.9


def mean_gap(height, radius):
    """Mean squared gap [m2] under a lip's heights (16,), after a plane of at most 20 degrees."""
    inside = height >= 0.0
    if not inside.any():
        return 0.01**2
    level = np.where(inside, height - height[inside].mean(), 0.0)
    slope = 2.0 / (16 * radius) * RING.T @ level
    slope *= min(1.0, np.tan(np.radians(20.0)) / max(np.hypot(*slope), 1e-12))
    rest = height - radius * RING @ slope
    gap = np.clip(rest[inside].max() - rest - 0.2 * radius, 0.0, 0.01)
    return np.where(inside, gap**2, 0.01**2).mean()


def test_a_cup_seals_anywhere_inside_an_item_without_a_surface():
    objects, table = draw_objects(["plastic_package", "metal_can"], 200)
    surfaces = draw_surfaces(table, objects)
    assert (surfaces.bodies["count"] == -1).all()
    assert (surfaces.com == 0.0).all()
    room = objects.size[:, :2] / 2.0 - objects.cup_radius[:, None]
    grid = np.random.default_rng(0).uniform(-0.999, 0.999, (200, 20, 2)) * room[:, None]
    seals = seal_at(surfaces, objects, to_world(objects, grid[..., 0], grid[..., 1]))
    np.testing.assert_allclose(seals.leak, 1.0)
    most = 0.6e5 * np.pi * objects.cup_radius**2  # of the ejector
    np.testing.assert_allclose(seals.force, np.broadcast_to(np.minimum(objects.seal, most)[:, None], (200, 20)))
    beside = to_world(objects, objects.size[:, :1] / 2.0, np.zeros((200, 1)))
    assert (seal_at(surfaces, objects, beside).leak > 50.0).all()


def test_the_centre_of_mass_lies_towards_either_end(waste):
    objects, _, surfaces = waste
    share = np.array([CATALOGUE[name].com for name in (*SEEN, *UNSEEN, "cork")])[objects.kind]
    along = surfaces.com[:, 0] * np.cos(objects.yaw) + surfaces.com[:, 1] * np.sin(objects.yaw)
    np.testing.assert_allclose(np.abs(along), share * objects.size[:, 0], atol=1e-12)
    assert 0.4 < (along[share > 0.0] > 0.0).mean() < 0.6


def test_a_seal_holds_twice_the_weight_and_moves_the_gauge(waste):
    objects = waste[0]
    draw = np.random.default_rng(0).normal(size=(400, 3))
    force = np.exp(np.random.default_rng(1).uniform(-2.0, 2.0, (400, 3)))
    least = np.maximum(3000.0 * np.pi * objects.cup_radius**2, 2.0 * 9.81 * objects.mass)[:, None]
    held = seal_holds(force, objects, draw, Surface())
    assert same_bits(held, force * np.exp(0.15 * draw) >= least)
    assert same_bits(seal_holds(force[:, 0], objects, draw[:, 0], Surface()), held[:, 0])
    assert 0.2 < held.mean() < 0.8


def held_share(name, count=2500, seed=7):
    """How often a cup sent to the middle of a picture holds, with the errors of camera and belt."""
    config = GraspConfig.load({"base": "grasp", "items": [name]})
    objects, pick = PickPlanner(config).draw_picks([np.random.default_rng(seed)], np.zeros(count, dtype=np.int64))
    middle = objects.grasp + outline_errors(objects, config)
    middle[:, 0] += belt_shift(objects, pick, config.belt)
    surfaces = draw_surfaces(surface_table(config.item_list()), objects)
    force = seal_at(surfaces, objects, -middle[:, None]).force[:, 0]
    return seal_holds(force, objects, normal_draw(object_keys(objects, TRY)), config.surface).mean()


@pytest.mark.parametrize("name", [*SEEN, *UNSEEN])
def test_the_middle_of_a_kind_holds_as_often_as_the_catalogue_says(name):
    assert held_share(name) == pytest.approx(CATALOGUE[name].pick_chance, abs=0.10)


def test_a_zone_lies_where_its_item_says():
    item = Item(
        name="plate", shape="box", size=(0.2, 0.1, 0.03), mass=0.01, drag=1.0, seal_force=10.0, friction=0.5,
        rolling_friction=0.001, restitution=0.2, source="test",
        zones=({"at": (0.5, 0.4), "size": (0.3, 0.4), "spread": 0.1, "chance": 0.5, "leak": 9.0},),
    )  # fmt: skip
    objects, table = draw_objects([item], 4000)
    surfaces = draw_surfaces(table, objects)
    has = surfaces.bodies["count"] == 1
    assert 0.46 < has.mean() < 0.54
    x, y = (2.0 * surfaces.zones["middle"][has, 0, axis] / objects.size[has, axis] for axis in range(2))
    assert 0.45 < (x > 0.0).mean() < 0.55
    assert 0.45 < (y > 0.0).mean() < 0.55
    for share, middle in ((np.abs(x), 0.5), (np.abs(y), 0.4)):
        assert np.abs(share - middle).max() <= 0.1 + 1e-9
        assert share.std() == pytest.approx(0.1 / np.sqrt(3.0), rel=0.1)
