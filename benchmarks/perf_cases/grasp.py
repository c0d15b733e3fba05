"""Cases of grasping: surfaces, seals, pictures and what is read from pictures, per second of one thread."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from statistics import mean
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.grasping.features import place_features
from agents.grasping.scenes import Scenes
from agents.ground.infos import rows_thrown
from benchmarks.perf_cases.cells import SEED, Cells
from benchmarks.timing import Count, Options, Row, Timing
from pnt_gym.arrays import Floats, take
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.grasp.config import CHANNELS, PIXELS, GraspConfig
from pnt_gym.cells.grasp.images import draw_images
from pnt_gym.cells.grasp.surfaces import IMAGE, draw_surfaces, object_keys, seal_at, surface_table

OBJECTS, PLACES = 1000, 24
STEPS = 12


class NoPictures:
    """Draws nothing in place of pictures: what an environment would do without a camera."""

    def draw(self, objects: Objects, middles: Floats) -> NDArray[np.uint8]:
        """Black pictures (N, 5, 48, 48) of N objects."""
        return np.zeros((len(middles), CHANNELS, PIXELS, PIXELS), dtype=np.uint8)


class Picks(Cells):
    """A vector environment whose picks are counted; a pick takes two steps or more where it begins with a grasp."""

    def __init__(self, env_id: str, level: dict[str, Any], count: int, sees: bool = True) -> None:
        super().__init__(env_id, level, count, threads=2)
        if not sees:
            self.env.core.pictures = NoPictures()
            self.info = self.env.reset(seed=SEED)[1]
        self._picks: list[int] = []

    def step(self) -> None:
        """One step of all cells."""
        super().step()
        self._picks.append(int(rows_thrown(self.info, self.env.num_envs).sum()))

    def per_step(self) -> float:
        """Picks that ended in a step, on average; without the first step, which warms up."""
        return mean(self._picks[1:])


def picks_rows(options: Options) -> Iterator[Row]:
    """Rows of picks per second, that are grasped and then thrown: with pictures, without pictures, and thrown alone."""
    items = GraspConfig.load("grasp").items
    alone = {"base": "waste", "items": items, "limits": {"percent": [60]}}
    for fidelity in ("flight", "full"):
        level = {"base": "grasp", "fidelity": fidelity}
        grasps, blind = (Picks("PnTGrasp-v0", level, options.cells, sees=sees) for sees in (True, False))
        throws = Picks("PnTRelease-v0", {**alone, "fidelity": fidelity}, options.cells)
        seen, thrown = (fidelity, "picks_per_s"), (fidelity, "picks_of_throws_alone_per_s")
        unseen = (fidelity, "picks_without_pictures_per_s")
        yield Timing(seen, grasps.step, "1/s", grasps.per_step, STEPS, mean)
        yield Timing(unseen, blind.step, "1/s", blind.per_step, STEPS, mean)
        yield Timing((fidelity, "over_without_pictures"), unseen, "x", blind.per_step, STEPS, mean, over=seen)
        yield Timing(thrown, throws.step, "1/s", throws.per_step, STEPS, mean)
        yield Timing((fidelity, "over_throws_alone"), thrown, "x", throws.per_step, STEPS, mean, over=seen)


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
    yield Timing(("clean_images_per_s",), partial(draw_images, table, pairs, middles), "1/s", count)
    yield Timing(("images_with_features_per_s",), partial(place_features, scenes.images, scenes.radius), "1/s", count)
    yield from picks_rows(options)
    yield Count(("bytes_of_a_surface",), sum(rows[0].nbytes for rows in scenes.surfaces))
