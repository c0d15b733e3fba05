"""A figure of places to grasp: pictures of objects, true and expected worths of places, and which places are chosen."""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.grasp.config import PIXEL, PIXELS

from ..grasping import rules
from ..grasping.features import place_features
from ..grasping.network import PlaceNetwork
from ..grasping.practice import network_places, worth_maps
from ..grasping.rules import mean_scores, surface_places
from ..grasping.scenes import Scenes
from ..ground.drawings import WIDTH, Figure, subplots
from ..ground.places import GRASPING

LEVEL, OBJECTS, SEED = "grasp", 400, 77_000_000
"""Level, number and seed of the objects from which the examples are taken; no try was made on these objects."""
GOOD, BAD = 0.8, 0.3
"""True worths above and below which a place counts as good and as bad."""
MARKS: Final = {"rule": ("x", "#1f77b4"), "network": ("+", "#d62728"), "truth": ("o", "#ffffff")}
"""Markers and colours of the places that are chosen."""


@final
class Examples(NamedTuple):
    """Objects, what is expected of their places, and the chosen places."""

    scenes: Scenes
    truth: Floats
    """True expected worths (N, 48, 48)."""
    maps: dict[str, Floats]
    """Scores (N, 48, 48) by name, NaN or 0 beside the objects."""
    places: dict[str, Floats]
    """Chosen places (N, 2) by name [m]."""

    def worth(self, name: str) -> Floats:
        """True expected worths of the chosen places (N,)."""
        column, row = pixels(self.places[name]).T
        return self.truth[np.arange(len(row)), row, column]


def examples() -> Examples:
    """The objects and what rule, network and true surface make of them."""
    scenes = Scenes.draw(LEVEL, OBJECTS, SEED)
    features, network = place_features(scenes.images, scenes.radius), PlaceNetwork.load(GRASPING / "local_mlp.npz")
    maps = {"rule": features.maps(mean_scores(features)), "network": worth_maps(features, network)}
    places = {
        "rule": rules.places(features),
        "network": network_places(features, network),
        "truth": surface_places(scenes),
    }
    truth = np.concatenate([rules.maps(part) for part in scenes.parts(100)])
    return Examples(scenes, truth, maps, places)


def objects(seen: Examples) -> list[tuple[str, int]]:
    """Three objects of different kinds, the first ones of their sorts, with what they show."""
    rule, network = seen.worth("rule"), seen.worth("network")
    middle, best = seen.truth[:, PIXELS // 2, PIXELS // 2], seen.worth("truth")
    sorts: dict[str, Bools] = {
        "both choose well, the middle is bad": (middle < BAD) & (rule > GOOD) & (network > GOOD),
        "the rule fails": (rule < BAD) & (network > GOOD),
        "the network fails": (network < BAD) & (best > GOOD),
    }
    rows: list[tuple[str, int]] = []
    kinds = seen.scenes.objects.kind
    for text, fits in sorts.items():
        others = fits & ~np.isin(kinds, [kinds[row] for _, row in rows])
        if others.any():
            rows.append((text, int(np.argmax(others))))
    return rows


def pixels(places: Floats) -> Ints:
    """Columns and rows (N, 2) of the pixels at places (N, 2) [m]."""
    return np.rint(places * [1.0, -1.0] / PIXEL + (PIXELS - 1) / 2.0).astype(np.int64)


def figure() -> Figure:
    """The figure: a row for each object with picture, true worths, the rule's scores and the network's worths."""
    seen = examples()
    rows = objects(seen)
    figure, axes = subplots(len(rows), 4, (WIDTH, 2.0 * len(rows)))
    for k, (text, row) in enumerate(rows):
        name = seen.scenes.config.items[seen.scenes.objects.kind[row]]
        colours = np.moveaxis(seen.scenes.images[row, 2:], 0, -1)
        shown = {
            f"{name}: {text}": colours,
            "true worth": seen.truth[row],
            "score of the rule": seen.maps["rule"][row],
            "worth by the network": seen.maps["network"][row],
        }
        on_object = np.isfinite(seen.maps["rule"][row])
        for panel, (title, values) in zip(axes[4 * k : 4 * k + 4], shown.items(), strict=True):
            is_picture = values.ndim == 3
            panel.imshow(values if is_picture else np.where(on_object, values, np.nan), interpolation="none")
            panel.set_title(title if not is_picture else f"{name}\n{text}", fontsize=8)
            panel.set_axis_off()
            for rule, (marker, colour) in MARKS.items():
                x, y = pixels(seen.places[rule][row : row + 1])[0]
                fill = "none" if marker == "o" else colour
                panel.scatter(
                    [x], [y], marker=marker, s=45, facecolors=fill, edgecolors=colour if marker == "o" else None
                )
    return figure
