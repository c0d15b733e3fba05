"""A fully convolutional network: the expected worth of a try at every pixel of a picture, from the pixels themselves.

The network is fitted to patches around the places of tries, with turned and mirrored copies, and computes whole
pictures in one pass. Torch fits it; NumPy computes it.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.reading import arrays_of

from ..ground.cli import UsageError
from ..ground.fitting import fit_from
from ..policies.networks import Convolution, activate, convolutions_of, join_squares, sigmoid, split_squares
from .features import NAMES, PlaceFeatures, place_features
from .maps import best_places, blur_maps
from .practice import Practice
from .scenes import Scenes

CHANNELS: Final = 24
PATCH: Final = 20
"""Side of a patch in pixels; the network sees 8 pixels to each side."""
BATCH: Final = 128
EPOCHS: Final = 25
"""Passes over the tries of a fit to pixels; with 60 the worth of held-out tries grew by 0.1 % (one seed)."""
SQUARE: Final = 2
"""Side of the squares of pixels that the first convolution sees as one."""
CHUNK: Final = 64
"""Pictures that are computed at once, to bound the memory."""
ARRAY: Final = re.compile(r"(?:weight|bias)_\d")
"""Pattern of the names of the arrays in a file."""
_SCALE: Final = np.array([50.0, 255.0, 255.0, 255.0, 255.0])
"""Units of the picture's channels: 50 mm, 1, full colours."""


def input_maps(images: NDArray[np.uint8], radius: Floats, features: PlaceFeatures | None = None) -> NDArray[np.float32]:
    """Inputs (N, C, 48, 48) of the network: pictures, the cup's radius, and features of places if they are given."""
    maps = np.empty((len(images), 6 + (0 if features is None else len(NAMES)), 48, 48), dtype=np.float32)
    maps[:, :5] = images / _SCALE[:, None, None]
    maps[:, 5] = radius[:, None, None] / 0.018
    if features is not None:
        maps[:, 6:] = 0.0
        row, column = features.pixel.T
        maps[features.picture, 6:, row, column] = features.values
    return maps


def cut_patches(maps: NDArray[np.float32], pixel: Ints) -> tuple[NDArray[np.float32], Ints]:
    """Patches (N, C, PATCH, PATCH) around pixels (N, 2), and the pixels in the patches (N, 2).

    Patches begin at even pixels, because the network joins pixels in squares of 2 by 2; beside the picture is nothing.
    """
    begin = (pixel - PATCH // 2) // 2 * 2 + PATCH
    padded = np.pad(maps, [(0, 0), (0, 0), (PATCH, PATCH), (PATCH, PATCH)])
    offsets = np.arange(PATCH)
    rows, columns = begin[:, :1] + offsets, begin[:, 1:] + offsets
    picture = np.arange(len(maps))[:, None, None]
    patches = padded[picture, :, rows[:, :, None], columns[:, None, :]]
    return np.moveaxis(patches, -1, 1), pixel + PATCH - begin


def learn_maps(
    practice: Practice, level: str | GraspConfig, *, with_features: bool, seed: int, epochs: int
) -> PlaceMaps:
    """Fit the network to the tries of a practice on a level, from pixels alone or with the features of places."""
    parts: list[tuple[NDArray[np.float32], Ints]] = []
    begin = 0
    for count, own in practice.rounds:
        scenes = Scenes.draw(level, count, own)
        features = place_features(scenes.images, scenes.radius) if with_features else None
        maps = input_maps(scenes.images, scenes.radius, features)
        parts.append(cut_patches(maps, practice.pixel[begin : begin + count]))
        begin += count
    network = PlaceMaps()
    patches = np.concatenate([patches for patches, _ in parts])
    network.fit(patches, np.concatenate([pixel for _, pixel in parts]), practice.worth, seed, epochs)
    return network


@final
class PlaceMaps:
    """The network; what it was fitted to lies in its parameters."""

    libraries: tuple[str, ...] = ("torch",)
    """Optional libraries by which it fits and computes."""

    def __init__(self) -> None:
        self._layers: tuple[Convolution, ...] = ()

    def fit(self, patches: NDArray[np.float32], pixel: Ints, worth: Floats, seed: int, epochs: int) -> None:
        """Fit to patches and pixels as of `cut_patches` and worths of the tries (N,), each 0 to 1."""
        import torch  # noqa: PLC0415 - a second to import, needed where the network is used only

        with fit_from(seed):
            network = _network(torch, patches.shape[1])
            _train(torch, network, torch.as_tensor(patches), torch.as_tensor(pixel), torch.as_tensor(worth), epochs)
        arrays = [tensor.detach().numpy().copy() for tensor in network.parameters()]
        self._layers = tuple(map(Convolution, arrays[0::2], arrays[1::2]))

    def predict(self, maps: NDArray[np.float32]) -> Floats:
        """Expected worths (N, 48, 48) of inputs (N, C, 48, 48)."""
        return np.concatenate([self._worth(maps[k : k + CHUNK]) for k in range(0, len(maps), CHUNK)])

    def _worth(self, maps: NDArray[np.float32]) -> Floats:
        """Expected worths of a few inputs."""
        value = join_squares(maps.astype(np.float64), SQUARE)
        for layer in self._layers[:-1]:
            value = activate("SiLU", layer(value))
        return sigmoid(split_squares(self._layers[-1](value), SQUARE)[:, 0])

    def places(self, maps: NDArray[np.float32], features: PlaceFeatures) -> Floats:
        """The places on objects with the highest expected worths (N, 2) [m], averaged over the cup's error."""
        return best_places(self.worth_maps(maps, features))

    def worth_maps(self, maps: NDArray[np.float32], features: PlaceFeatures) -> Floats:
        """Expected worths on objects (N, 48, 48), averaged over the cup's error; 0 elsewhere."""
        worth = self.predict(maps)
        row, column = features.pixel.T
        return blur_maps(features.maps(worth[features.picture, row, column], 0.0))

    def save(self, path: Path) -> None:
        """Write the arrays to a file."""
        arrays = {f"{part}_{k}": a for k, layer in enumerate(self._layers) for part, a in layer._asdict().items()}
        with path.open("wb") as file:  # given a name, numpy would append a suffix
            np.savez(file, **arrays)

    @classmethod
    def load(cls, path: Path) -> Self:
        """The network of pictures without features in a file.

        Raises:
            UsageError: the file is missing, damaged, or of something else.
        """
        network = cls()
        try:
            arrays = arrays_of(path, ARRAY)
            network._layers = convolutions_of(arrays, "", 6 * SQUARE**2)
            if len(network._layers[-1].bias) != SQUARE**2:
                raise ValueError("convolutions of another picture")
        except Exception:  # a damaged or foreign file may raise anything
            raise UsageError(f"{str(path)!r} holds no network of pictures that chooses places") from None
        return network


def _network(torch: Any, inputs: int) -> Any:
    """Convolutions of 3 by 3 on squares of 2 by 2 pixels."""
    nn = torch.nn
    layers: list[Any] = [nn.PixelUnshuffle(SQUARE), nn.Conv2d(4 * inputs, CHANNELS, 3, padding=1), nn.SiLU()]
    for _ in range(2):
        layers += [nn.Conv2d(CHANNELS, CHANNELS, 3, padding=1), nn.SiLU()]
    return nn.Sequential(
        *layers, nn.Conv2d(CHANNELS, CHANNELS, 1), nn.SiLU(), nn.Conv2d(CHANNELS, 4, 1), nn.PixelShuffle(SQUARE)
    )


def _train(torch: Any, network: Any, patches: Any, pixel: Any, worth: Any, epochs: int) -> None:
    """Minimise the cross entropy of the worths at the tried pixels, each batch turned and mirrored at random."""
    steps = epochs * len(patches) // BATCH
    optimiser = torch.optim.AdamW(network.parameters(), lr=4e-3, weight_decay=0.02)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 4e-3, total_steps=max(steps, 2))
    loss_of, batch = torch.nn.BCEWithLogitsLoss(), torch.arange(min(BATCH, len(patches)))
    for _ in range(steps):
        rows = torch.randint(len(patches), (len(batch),))
        x, place = patches[rows], pixel[rows]
        turns, mirror = int(torch.randint(4, ())), int(torch.randint(2, ()))
        if mirror:
            x, place = x.flip(3), torch.stack([place[:, 0], PATCH - 1 - place[:, 1]], 1)
        for _ in range(turns):
            x, place = x.rot90(1, (2, 3)), torch.stack([PATCH - 1 - place[:, 1], place[:, 0]], 1)
        value = network(x.contiguous())[batch, 0, place[:, 0], place[:, 1]]
        optimiser.zero_grad()
        loss_of(value, worth[rows].float()).backward()
        optimiser.step()
        schedule.step()
