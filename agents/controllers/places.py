"""Places of the cup by a rule on the pictures, by a network, or by an oracle, as controllers use them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeAlias, final

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.observation import TABLE

from ..grasping.fcn import PlaceMaps, input_maps
from ..grasping.features import PlaceFeatures, place_features
from ..grasping.network import PlaceNetwork
from ..grasping.practice import network_places
from ..grasping.rules import COLOURED, TUNED, centroid_places, flattest_places, oracle_places, rule_places
from ..grasping.scenes import Scenes
from ..ground.cli import UsageError
from ..ground.places import GRASPING, at
from .protocol import Observation

Choice: TypeAlias = Callable[[PlaceFeatures], Floats]
"""Function from the features of places in N pictures to places of cups, from the pictures' middles (N, 2) [m]."""
RULES: Final[dict[str, Choice]] = {
    "centroid": centroid_places,
    "naive": flattest_places,
    "depth": lambda features: rule_places(features, TUNED),
    "colour": lambda features: rule_places(features, COLOURED),
}
"""Rules on pictures by name."""


@final
class PicturePlaces:
    """Places that a rule or a network chooses in pictures.

    Args:
        core: the cells.
        choice: chooses the places.
    """

    def __init__(self, core: GraspCore, choice: Choice) -> None:
        self._choice, self._of_all = choice, core.config.grasp.objects > 1

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Places of the cups for some rows (K, 2) [m]."""
        assert observation.image is not None  # of this environment
        radius = TABLE.decode(observation.features)["cup_radius"][rows]
        return self._choice(place_features(observation.image[rows], radius, of_all=self._of_all))


@final
class PixelPlaces:
    """Places that a fully convolutional network chooses in pictures.

    Args:
        core: the cells.
        file: arrays of the network, as `agents.grasping --sees pixels` writes them; by default those that ship.

    Raises:
        UsageError: there is no such file, or the file holds no such network.
    """

    def __init__(self, core: GraspCore, file: str | Path = GRASPING / "fcn.npz") -> None:
        self._network, self._of_all = PlaceMaps.load(at(file)), core.config.grasp.objects > 1

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Places of the cups for some rows (K, 2) [m]."""
        assert observation.image is not None  # of this environment
        images, radius = observation.image[rows], TABLE.decode(observation.features)["cup_radius"][rows]
        features = place_features(images, radius, of_all=self._of_all)
        return self._network.places(input_maps(images, radius), features)


@final
class OraclePlaces:
    """The places with the highest expected worth, by the true surfaces.

    Args:
        core: the cells.

    Raises:
        UsageError: the level has groups of objects, or no surfaces.
    """

    def __init__(self, core: GraspCore) -> None:
        if core.config.grasp.objects > 1 or core.config.surface is None:
            raise UsageError("controller 'oracle_grasp' knows single objects with surfaces; choose another one here")
        self._core = core

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """Places of the cups for some rows (K, 2) [m]."""
        return oracle_places(Scenes.of_picks(self._core.config, take(self._core.picks, rows)))


def flattest(core: GraspCore, rule: str = "depth") -> PicturePlaces:
    """Places that are flat under the cup.

    Args:
        core: the cells.
        rule: "depth" for the rule tuned from tries, "colour" for that with colours, "naive" for the least roughness.

    Raises:
        UsageError: there is no such rule.
    """
    if rule not in RULES:
        raise UsageError(f"rule is {rule!r}; it must be one of {', '.join(RULES)}")
    return PicturePlaces(core, RULES[rule])


def local_mlp(core: GraspCore, file: str | Path = GRASPING / "local_mlp.npz") -> PicturePlaces:
    """Places of a network that learned from tries.

    Args:
        core: the cells.
        file: arrays of the network, as `agents.grasping` writes them; by default those that ship.

    Raises:
        UsageError: there is no such file, or the file holds no network.
    """
    network = PlaceNetwork.load(at(file))
    return PicturePlaces(core, lambda features: network_places(features, network))
