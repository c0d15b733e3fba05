"""Features of places: those of a formula in NumPy, on the object at hand."""

import numpy as np
import pytest

from agents.grasping.features import NAMES, place_features
from agents.grasping.scenes import Scenes
from pnt_gym.cells.grasp.images import pixel_places
from tests.tools.throws import same_bits


@pytest.fixture(scope="module")
def scenes():
    return Scenes.draw("grasp", 300, seed=6)


@pytest.fixture(scope="module")
def features(scenes):
    return place_features(scenes.images, scenes.radius)


def test_places_lie_on_the_objects_of_their_pictures(scenes, features):
    assert same_bits(np.unique(features.picture), np.arange(300))
    assert (np.diff(features.picture) >= 0).all()
    heights = scenes.images[features.picture, 0, features.pixel[:, 0], features.pixel[:, 1]]
    valid = scenes.images[features.picture, 1, features.pixel[:, 0], features.pixel[:, 1]] > 0
    assert (heights[valid] > 4).mean() > 0.98
    assert np.isfinite(features.values).all()
    assert features.values.shape == (len(features.picture), len(NAMES))


def test_features_of_a_picture_are_those_alone_and_in_a_batch(scenes, features):
    single = place_features(scenes.images[280:281], scenes.radius[280:281])
    assert same_bits(single.values, features.values[features.picture == 280])
    assert (single.picture == 0).all()


def disc_of(scenes, features, row, width):
    """Rows and columns of the pixels within a distance of a place."""
    radius = scenes.radius[features.picture[row]] + width
    return np.nonzero(np.hypot(*np.moveaxis(pixel_places() - features.places()[row], -1, 0)) <= radius + 1e-12)


def test_roughness_and_slope_are_those_of_the_plane_through_valid_depths(scenes, features):
    for row in range(0, len(features.picture), 977):
        image = scenes.images[features.picture[row]]
        for ending, width in (("in", 0.0), ("out", 0.009)):
            pixels = disc_of(scenes, features, row, width)
            valid = image[1][pixels] > 0
            assert features.column(f"valid_{ending}")[row] == pytest.approx(valid.mean())
            if valid.sum() < 6:
                continue
            x, y = 1e3 * pixel_places()[pixels][valid].T
            basis = np.column_stack([np.ones_like(x), x, y])
            height = image[0][pixels][valid].astype(np.float64)
            plane, *_ = np.linalg.lstsq(basis, height, rcond=None)
            rough = 0.5 * np.log(np.mean((height - basis @ plane) ** 2) + 0.25)
            assert features.column(f"rough_{ending}")[row] == pytest.approx(rough, abs=1e-4)
            assert features.column(f"slope_{ending}")[row] == pytest.approx(np.hypot(*plane[1:]), abs=1e-4)


def test_colours_are_those_under_the_lip(scenes, features):
    compared = 0
    for row in range(0, len(features.picture), 977):
        pixels = disc_of(scenes, features, row, 0.0)
        if features.column("belt_in")[row] == 0.0:
            red, green, blue = (scenes.images[features.picture[row], 2 + k][pixels] / 255.0 for k in range(3))
            gray, warm = (red + green + blue) / 3.0, red - blue
            assert features.column("gray_in")[row] == pytest.approx(gray.mean())
            assert features.column("warm_in")[row] == pytest.approx(warm.mean())
            assert features.column("gray_texture")[row] == pytest.approx(10.0 * gray.std(), abs=1e-6)
            assert features.column("warm_texture")[row] == pytest.approx(10.0 * warm.std(), abs=1e-6)
            compared += 1
    assert compared > 20


def test_a_neighbour_counts_only_if_all_objects_do():
    images = np.zeros((1, 5, 48, 48), dtype=np.uint8)
    images[:, 1] = 255
    images[0, 0, 18:30, 18:30] = 40  # at hand
    images[0, 0, 4:14, 34:46] = 30  # its neighbour
    radius = np.array([0.0125])
    near, every = place_features(images, radius), place_features(images, radius, of_all=True)
    assert near.pixel.min() >= 18
    assert near.pixel.max() <= 29
    assert len(every.picture) > len(near.picture)
    assert every.pixel[:, 0].min() < 14


def test_a_picture_without_an_object_has_no_place():
    images = np.zeros((3, 5, 48, 48), dtype=np.uint8)
    images[:, 1] = 255
    images[1, 0, 20:28, 20:28] = 40
    features = place_features(images, np.full(3, 0.0125))
    assert set(features.picture) == {1}
    places = features.best(-features.column("distance"))
    np.testing.assert_allclose(places[[0, 2]], 0.0)
    assert np.isnan(features.maps(features.column("distance"))[0]).all()


def test_the_best_place_is_that_of_the_highest_score(features):
    score = np.random.default_rng(0).random(len(features.picture))
    maps = features.maps(score, -1.0)
    expected = pixel_places().reshape(-1, 2)[maps.reshape(300, -1).argmax(axis=1)]
    assert same_bits(features.best(score), expected)


def test_places_apart_from_one_are_those_outside_of_the_radius(features):
    places, radius = np.full((300, 2), np.nan), np.full(300, 0.02)
    places[:100] = features.best(features.column("valid_in"))[:100]
    radius[:50] = 1.0  # beyond all places of a picture, so all remain
    apart = features.apart_from(places, radius)
    for picture in range(0, 300, 10):
        before, after = (one.places()[one.picture == picture] for one in (features, apart))
        away = np.hypot(*(before - places[picture]).T)
        expected = before[away >= 0.02] if 50 <= picture < 100 else before
        assert same_bits(after, expected)
