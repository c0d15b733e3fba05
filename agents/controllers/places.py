"""Places of the cup by a rule on the pictures, by a network, or by the true surface, as controllers use them."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.observation import TABLE
from pnt_gym.names import unknown_name

from ..grasping import rules
from ..grasping.features import PlaceFeatures, place_features
from ..grasping.network import PlaceNetwork
from ..grasping.practice import network_places, worth_maps
from ..grasping.rules import COLOURED, mean_scores, surface_places
from ..grasping.scenes import Scenes
from ..ground.cli import UsageError
from ..ground.places import GRASPING, at
from .protocol import Observation

AVOID: Final = 1.0
"""Distance of a further try from the place that failed, in radii of the cup."""


@final
class Chooser(NamedTuple):
    """A rule or a network that chooses places in pictures."""

    places: Callable[[PlaceFeatures], Floats]
    """From the features of places in N pictures to places of cups, from the pictures' middles (N, 2) [m]."""
    maps: Callable[[PlaceFeatures], Floats]
    """From these features to the scores by which the choice is made (N, 48, 48); NaN or 0 beside the object."""


RULES: Final[dict[str, Chooser]] = {
    "centroid": Chooser(rules.centroid, lambda seen: seen.maps(-seen.column("distance"))),
    "naive": Chooser(rules.flattest, lambda seen: seen.maps(-seen.column("rough_in"))),
    "depth": Chooser(rules.places, lambda seen: seen.maps(mean_scores(seen))),
    "colour": Chooser(lambda seen: rules.places(seen, COLOURED), lambda seen: seen.maps(mean_scores(seen, COLOURED))),
}
"""Rules on pictures by name."""


@final
class Sight:
    """Describes the places of pictures from which a cup's place is chosen.

    Args:
        core: the cells.
        avoid: distance of a further try from the place that failed last, in radii of the cup; 0 for any place.

    Raises:
        UsageError: `avoid` is negative.
    """

    def __init__(self, core: GraspCore, avoid: float = AVOID) -> None:
        if not 0.0 <= avoid < math.inf:
            raise UsageError(f"avoid is {avoid:g}; it must be 0 or a number of radii")
        self._avoid, self._rules = avoid, core.config.grasp

    def features(self, observation: Observation, rows: Ints) -> PlaceFeatures:
        """Features of the places for some rows."""
        assert observation.image is not None  # of this environment
        values = TABLE.decode(observation.features[rows])
        radius = values["cup_radius"]
        features = place_features(observation.image[rows], radius, of_all=self._rules.objects > 1)
        if self._avoid > 0.0:
            failed = np.stack([values["failed_x"], values["failed_y"]], axis=-1)
            failed[np.rint(values["tries_left"]) >= self._rules.tries] = np.nan
            features = features.apart_from(failed, self._avoid * radius)
        return features


@final
class PicturePlaces:
    """Places that a rule or a network chooses in pictures.

    Args:
        core: the cells.
        choice: chooses the places.
        avoid: see `Sight`.
    """

    def __init__(self, core: GraspCore, choice: Chooser, avoid: float = AVOID) -> None:
        self._choice, self._sight = choice, Sight(core, avoid)

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Places of the cups for some rows (K, 2) [m]."""
        return self._choice.places(self._sight.features(observation, rows))

    def maps(self, observation: Observation, rows: Ints) -> Floats:
        """Scores by which the places for some rows are chosen (K, 48, 48)."""
        return self._choice.maps(self._sight.features(observation, rows))


@final
class TrueSurface:
    """The places with the highest expected worth by the true surfaces, without the errors of the cups.

    Args:
        core: the cells.

    Raises:
        UsageError: the level has groups of objects, or no surfaces.
    """

    def __init__(self, core: GraspCore) -> None:
        if core.config.grasp.objects > 1 or core.config.surface is None:
            raise UsageError("controller 'true_surface' knows single objects with surfaces; choose another one here")
        self._core = core

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Places of the cups for some rows (K, 2) [m]."""
        return surface_places(Scenes.of_picks(self._core.config, take(self._core.picks, rows)))

    def maps(self, observation: Observation, rows: Ints) -> Floats:
        """True expected worths of the places for some rows (K, 48, 48)."""
        return rules.maps(Scenes.of_picks(self._core.config, take(self._core.picks, rows)))


def centroid(core: GraspCore, avoid: float = AVOID) -> PicturePlaces:
    """The places nearest to the middle of what pictures show; arguments as of `PicturePlaces`."""
    return PicturePlaces(core, RULES["centroid"], avoid)


def flattest(core: GraspCore, rule: str = "depth", avoid: float = AVOID) -> PicturePlaces:
    """Places that are flat under the cup.

    Args:
        core: the cells.
        rule: "depth" for the rule tuned from tries, "colour" for that with colours, "naive" for the least roughness.
        avoid: as of `PicturePlaces`.

    Raises:
        UsageError: there is no such rule.
    """
    if rule not in RULES:
        raise UsageError(unknown_name("rule", rule, RULES))
    return PicturePlaces(core, RULES[rule], avoid)


def local_mlp(core: GraspCore, file: str | Path = GRASPING / "local_mlp.npz", avoid: float = AVOID) -> PicturePlaces:
    """Places of a network that learned from tries.

    Args:
        core: the cells.
        file: arrays of the network, as `agents.grasping` writes them; by default those that ship.
        avoid: as of `PicturePlaces`.

    Raises:
        UsageError: there is no such file, or the file holds no network.
    """
    network = PlaceNetwork.load(at(file))
    choice = Chooser(lambda seen: network_places(seen, network), lambda seen: worth_maps(seen, network))
    return PicturePlaces(core, choice, avoid)
