"""What the camera sees of an object, and where a controller grasps, beside the pictures of the throw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.canvas import FPS, Frame
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.images import pixel_places
from pnt_gym.cells.grasp.observation import TABLE

from ..controllers.grasps import Mapped
from ..controllers.protocol import Actions, Controller, Observation

HIGHEST: Final = 0.08
"""Height above the belt that is drawn white in a picture of depths, if no point is higher [m]."""
SCALE: Final = np.array([[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]], dtype=np.float64)
"""Colours of a map from its lowest to its highest score: five of matplotlib's viridis."""
CHOSEN: Final = (255, 40, 40)
FAILED: Final = (255, 255, 255)


@final
@dataclass(frozen=True)
class SeenGrasp:
    """A try to grasp an object as a controller saw the object."""

    image: NDArray[np.uint8]
    """Picture (5, 48, 48)."""
    scores: Floats | None
    """Scores of places (48, 48), NaN or 0 beside the object; None of a controller without a map."""
    place: Floats
    """Chosen place of the cup from the picture's middle (2,) [m]."""
    failed: Floats | None
    """Place that failed before (2,) [m]; None for a first try."""
    radius: float
    """Radius of the cup [m]."""

    def panels(self, side: int) -> list[Frame]:
        """Colours, depths and, if there are any, scores, each as a square of `side` pixels with the cup's place."""
        depth = self.image[0].astype(np.float64) / max(1e3 * HIGHEST, float(self.image[0].max()))
        gray = np.repeat((255.0 * depth)[..., None], 3, axis=-1)
        gray[self.image[1] == 0] = (70.0, 0.0, 0.0)  # pixels without a depth
        pictures = [np.moveaxis(self.image[2:], 0, -1), gray]
        if self.scores is not None:
            pictures.append(colour_map(self.scores))
        return [self._marked(picture, side) for picture in pictures]

    def _marked(self, picture: NDArray[Any], side: int) -> Frame:
        """A picture (48, 48, 3) enlarged to a square, with rings where the cup is, and where the cup failed before."""
        index = np.arange(side) * len(picture) // side
        frame = picture[index][:, index].astype(np.uint8)
        grid = pixel_places()
        x, y = (
            np.interp(np.arange(side) / side * 48 - 0.5, np.arange(48), line) for line in (grid[0, :, 0], grid[:, 0, 1])
        )
        for place, colour in ((self.failed, FAILED), (self.place, CHOSEN)):
            if place is not None:
                away = np.hypot(x[None, :] - place[0], y[:, None] - place[1])
                frame[(np.abs(away - self.radius) < 0.0015) | (away < 0.0025)] = colour
        return frame


def colour_map(scores: Floats) -> NDArray[np.float64]:
    """Scores (48, 48) as colours (48, 48, 3), from the lowest tenth to the highest; black beside the object."""
    is_there = np.isfinite(scores) & (scores != 0.0)
    if not is_there.any():
        return np.zeros((*scores.shape, 3))
    low, high = np.percentile(scores[is_there], 10.0), scores[is_there].max()
    share = np.clip((np.where(is_there, scores, low) - low) / max(high - low, 1e-9), 0.0, 1.0)
    stops = np.linspace(0.0, 1.0, len(SCALE))
    colours = np.stack([np.interp(share, stops, column) for column in SCALE.T], axis=-1)
    return np.where(is_there[..., None], colours, 0.0)


@final
class SeenController(Controller):
    """A controller whose last grasp of row 0 is kept, with what it saw.

    Args:
        controller: acts.
        core: the cells.
    """

    def __init__(self, controller: Controller, core: GraspCore) -> None:
        self.name, self._controller, self._core = controller.name, controller, core
        self.grasp: SeenGrasp | None = None

    def reset(self, seed: int) -> None:
        """Reset the controller."""
        self._controller.reset(seed)

    def act(self, observation: Observation) -> Actions:
        """Actions of the controller."""
        actions = self._controller.act(observation)
        values, rules = TABLE.decode(observation.features[0]), self._core.config.grasp
        if observation.image is not None and values["holds"] < 0.5:
            row: Ints = np.zeros(1, dtype=np.int64)
            scores = self._controller.maps(observation, row) if isinstance(self._controller, Mapped) else None
            is_first = np.rint(values["tries_left"]) >= rules.tries
            self.grasp = SeenGrasp(
                observation.image[0].copy(),
                None if scores is None else scores[0],
                rules.reach * actions[0, :2].astype(np.float64),
                None if is_first else np.array([values["failed_x"], values["failed_y"]], dtype=np.float64),
                float(values["cup_radius"]),
            )
        return actions


@final
class SeenView:
    """The view of a cell that grasps, with the last grasp at the right of each frame.

    Args:
        view: pictures of the cell.
        seen: keeps the grasps.
    """

    def __init__(self, view: ThrowView, seen: SeenController) -> None:
        self._view, self._seen = view, seen

    def last_throw(self, fps: int = FPS) -> list[Frame]:
        """Frames of the last throw at true rate."""
        return [self._join(frame) for frame in self._view.last_throw(fps)]

    def at(self, moment: float, fps: int = FPS) -> Frame:
        """Frame at a moment [s] of the last throw."""
        return self._join(self._view.at(moment, fps))

    def close(self) -> None:
        """Free all resources of rendering; safe to call twice."""
        self._view.close()

    def _join(self, frame: Frame) -> Frame:
        """A frame with the panels one below the other at its right."""
        side, grasp = len(frame) // 3 // 2 * 2, self._seen.grasp
        column = np.zeros((len(frame), side, 3), dtype=np.uint8)
        for k, panel in enumerate([] if grasp is None else grasp.panels(side)):
            column[k * side : (k + 1) * side] = panel
        return np.concatenate([frame, column], axis=1)
