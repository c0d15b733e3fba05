"""Pictures: shapes as the engine sees them, noise as the gloss says, one picture alone and in a batch."""

import mujoco
import numpy as np
import pytest
from mujoco.batch import Batch

from pnt_gym.arrays import take
from pnt_gym.cells.base.items import SHAPES, Item
from pnt_gym.cells.grasp.images import draw_images, pixel_places
from pnt_gym.cells.grasp.surfaces import IMAGE, draw_surfaces, object_keys
from tests.tools.surfaces import SEEN, UNSEEN, draw_objects, height_and_leak
from tests.tools.throws import same_bits


@pytest.fixture(scope="module")
def waste():
    objects, table = draw_objects((*SEEN, *UNSEEN), 120, seed=2)
    return take(objects, np.arange(120).reshape(60, 2)), table


@pytest.fixture(scope="module")
def middles():
    """Two objects in each picture, one near its middle."""
    rng = np.random.default_rng(0)
    return np.stack([rng.normal(0.0, 0.004, (60, 2)), rng.uniform(-0.12, 0.12, (60, 2))], axis=1)


def seen_by_engine(objects, row, middles):
    """Heights (48, 48) of the bodies in a picture by rays of the engine, which come from above."""
    geoms = []
    for k in range(objects.shape.shape[1]):
        size, yaw = objects.size[row, k], objects.yaw[row, k]
        half, (x, y) = size / 2.0, middles[row, k]
        kind, turn = SHAPES[objects.shape[row, k]], np.degrees(yaw)
        numbers, euler = f"{half[0]} {half[1]} {half[2]}", f"0 0 {turn}"
        if kind == "cylinder":
            numbers, euler = f"{half[2]} {half[0]}", f"0 90 {turn}"
        geoms.append(f'<geom type="{kind}" size="{numbers}" pos="{x} {y} {half[2]}" euler="{euler}"/>')
    text = f'<mujoco><compiler eulerseq="XYZ"/><worldbody>{"".join(geoms)}</worldbody></mujoco>'
    batch = Batch(mujoco.MjModel.from_xml_string(text), nsim=1, nthread=1)
    places = pixel_places().reshape(-1, 2)
    above = np.column_stack([places, np.ones(len(places))])
    distance, _ = batch.ray(above, np.array([0.0, 0.0, -1.0]))
    return np.where(distance[0] < 0.0, 0.0, 1.0 - distance[0]).reshape(48, 48)


def test_bodies_are_as_the_engine_sees_them(waste, middles):
    """Without zones and reliefs; also where two objects overlap."""
    objects, table = waste
    bare = table._replace(items=table.items.copy())
    bare.items["is_real"] = False
    heights = draw_images(bare, objects, middles)[:, 0]
    for row in range(20):
        assert_rounded(heights[row], seen_by_engine(objects, row, middles), 1e-6)
    assert len(np.unique(objects.shape[:20])) == 3
    assert 0.1 < (heights > 0).mean() < 0.6


def assert_rounded(millimetres, heights, error):
    """Numbers are heights [m] in millimetres, to the nearest whole number.

    An error of the heights above `error` [m] shows: thousands of heights have any part of a millimetre.
    """
    assert np.abs(millimetres - 1e3 * heights).max() <= 0.5 + 1e3 * error


def test_a_picture_is_one_alone_and_in_a_batch(waste, middles):
    objects, table = waste
    keys = object_keys(take(objects, (slice(None), 0)), IMAGE)
    images = draw_images(table, objects, middles, keys)
    assert images.shape == (60, 5, 48, 48)
    assert images.dtype == np.uint8
    single = draw_images(table, take(objects, np.array([7])), middles[7:8], keys[7:8])
    assert same_bits(single[0], images[7])
    assert not same_bits(draw_images(table, objects, middles, keys + np.uint64(1)), images)
    assert len({image.tobytes() for image in images}) == 60


def test_a_clean_picture_has_the_heights_of_a_formula_in_millimetres(waste, middles):
    objects, table = waste
    images, surfaces = draw_images(table, objects, middles), draw_surfaces(table, objects)
    for row in range(60):
        heights = np.zeros((48, 48))
        for k, (x, y) in enumerate(middles[row]):
            cos, sin = np.cos(objects.yaw[row, k]), np.sin(objects.yaw[row, k])
            p, q = (pixel_places() - (x, y)).transpose(2, 0, 1)
            along, across = cos * p + sin * q, cos * q - sin * p
            heights = np.maximum(heights, height_and_leak(objects, surfaces, (row, k), along, across)[0])
        assert_rounded(images[row, 0], heights, 1e-10)
    assert (images[:, 1] == 255).all()


def test_an_absent_neighbour_leaves_the_belt(waste, middles):
    objects, table = waste
    alone = middles.copy()
    alone[:, 1] = np.nan
    pair, single = draw_images(table, objects, middles), draw_images(table, objects, alone)
    assert same_bits(single, draw_images(table, take(objects, (slice(None), slice(0, 1))), middles[:, :1]))
    assert (pair[:, 0] >= single[:, 0]).all()
    assert (pair[:, 0] > single[:, 0]).any()


def plate(gloss):
    item = Item(
        name="plate", shape="box", size=(0.9, 0.9, 0.1), mass=0.01, drag=1.0, seal_force=10.0, friction=0.5,
        rolling_friction=0.001, restitution=0.2, source="test", look=(0.5, 0.4, gloss, 0.1),
    )  # fmt: skip
    objects, table = draw_objects([item], 40)
    return draw_images(table, take(objects, np.arange(40)[:, None]), np.zeros((40, 1, 2)), object_keys(objects, IMAGE))


@pytest.mark.parametrize("gloss", [0.0, 0.5, 1.0])
def test_gloss_makes_depths_noisy_and_loses_them(gloss):
    depth, valid, *colours = plate(gloss).transpose(1, 0, 2, 3).astype(np.float64)
    lost = valid == 0.0
    assert lost.mean() == pytest.approx(0.02 + 0.3 * gloss, abs=0.01)
    assert (depth[lost] == 0.0).all()
    means = np.array([one[~hidden].mean() for one, hidden in zip(depth, lost, strict=True)])
    spread = np.mean([one[~hidden].std() for one, hidden in zip(depth, lost, strict=True)])
    assert spread == pytest.approx(np.hypot(1.0 + 3.0 * gloss, 12.0**-0.5), rel=0.03)
    assert (np.abs(means - 100.0) < 20.0).all()
    red, green, blue = (one.mean() for one in colours)
    assert red > green > blue
    noise = np.mean([(one - one.mean()).std() for one in colours[0]])
    assert 3.0 < noise < 20.0


def test_places_of_pixels_go_along_the_belt_and_from_far_to_near():
    places = pixel_places()
    assert places.shape == (48, 48, 2)
    np.testing.assert_allclose(places[0, 1] - places[0, 0], [0.005, 0.0])
    np.testing.assert_allclose(places[1, 0] - places[0, 0], [0.0, -0.005])
    np.testing.assert_allclose(places.mean(axis=(0, 1)), 0.0, atol=1e-12)
