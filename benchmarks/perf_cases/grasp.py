"""Cases of grasping: surfaces, seals, pictures and what is read from pictures, per second of one thread."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from agents.grasping.features import place_features
from agents.grasping.scenes import Scenes
from benchmarks.timing import Count, Options, Row, Timing
from pnt_gym.arrays import take
from pnt_gym.cells.grasp.images import clean_images, draw_images
from pnt_gym.cells.grasp.surfaces import IMAGE, draw_surfaces, object_keys, seal_at, surface_table

OBJECTS, PLACES, SEED = 1000, 24, 0


def grasp(options: Options) -> Iterator[Row]:
    """Surfaces of objects, lips of cups on them, pictures with and without noise, features of places in pictures."""
    count = options.size(OBJECTS)
    scenes = Scenes.draw("grasp", count, SEED)
    table, objects, middles = surface_table(scenes.config.item_list()), scenes.objects, scenes.middle[:, None]
    pairs, keys = take(objects, np.s_[:, None]), object_keys(objects, IMAGE)
    places = np.random.default_rng(SEED).normal(0.0, 0.02, (count, PLACES, 2))
    yield Count(("objects",), count)
    yield Timing(("surfaces_per_s",), partial(draw_surfaces, table, objects), "1/s", count)
    yield Timing(("lips_per_s",), partial(seal_at, scenes.surfaces, objects, places), "1/s", count * PLACES)
    yield Timing(("noisy_images_per_s",), partial(draw_images, table, pairs, middles, keys), "1/s", count)
    yield Timing(("clean_images_per_s",), partial(clean_images, table, pairs, middles), "1/s", count)
    yield Timing(("images_with_features_per_s",), partial(place_features, scenes.images, scenes.radius), "1/s", count)
    columns = (getattr(scenes.surfaces, name) for name in ("count", "com", "body", "zones"))
    yield Count(("bytes_of_a_surface",), sum(column[0].nbytes for column in columns))
