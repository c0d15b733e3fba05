"""Textures of pictures, drawn by numbers: arrays (height, width, 3) of bytes, the same at every call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats

Texture = NDArray[np.uint8]
SIDE: Final = 256
"""Side of a texture [pixels]."""
Rgb = tuple[float, float, float]

_V, _U = (np.mgrid[0:SIDE, 0:SIDE] + 0.5) / SIDE
"""Place in a texture, 0 to 1: `_V` down the rows, `_U` along the columns."""


def _noise(waves: int, seed: int) -> Floats:
    """Smooth noise (SIDE, SIDE) that tiles, -1 to 1, of at most a number of waves along a side."""
    rng = np.random.default_rng(seed)
    frequency = np.fft.fftfreq(SIDE, 1.0 / SIDE)
    size = np.hypot(*np.meshgrid(frequency, frequency))
    spectrum = np.fft.fft2(rng.standard_normal((SIDE, SIDE))) * ((size > 0.5) & (size <= waves)) / np.maximum(size, 1.0)
    values = np.real(np.fft.ifft2(spectrum))
    return np.asarray(values / np.abs(values).max())


def _texture(ground: Rgb | Floats, *layers: tuple[NDArray[np.bool_], Rgb], shade: Floats | float = 1.0) -> Texture:
    """A ground with colours laid over it one after the other, each where its mask is True, and all of it shaded.

    Args:
        ground: a colour of 0 to 1, or one for each place (SIDE, SIDE, 3).
        layers: masks (SIDE, SIDE) and their colours.
        shade: factor of the colours (SIDE, SIDE).
    """
    colours = np.broadcast_to(np.array(ground), (SIDE, SIDE, 3))
    for mask, colour in layers:
        colours = np.where(mask[..., None], np.array(colour), colours)
    return np.clip(255.0 * colours * np.broadcast_to(shade, (SIDE, SIDE))[..., None], 0.0, 255.0).astype(np.uint8)


TEXTURES: Final[Mapping[str, Callable[[], Texture]]] = MappingProxyType(
    {
        # Dark rubber with scuffs and a seam across; the belt runs along the columns.
        "belt": lambda: _texture(
            (0.165, 0.185, 0.215), (np.abs(_U - 0.5) < 0.016, (0.30, 0.33, 0.37)), shade=1.0 + 0.20 * _noise(8, 1)
        ),
        # Sealed concrete: pale, a little cloudy, with joints around each square.
        "floor": lambda: _texture(
            (0.70, 0.72, 0.745),
            (np.minimum(np.minimum(_U, 1.0 - _U), np.minimum(_V, 1.0 - _V)) < 0.004, (0.60, 0.62, 0.65)),
            shade=1.0 + 0.03 * _noise(4, 3),
        ),
        # Planed wood with its grain along the columns.
        "wood": lambda: _texture(
            (0.78, 0.60, 0.40),
            shade=1.0
            + 0.10 * np.sin(2.0 * np.pi * (9.0 * _V + 0.8 * _noise(3, 5)))
            + 0.06 * np.sin(2.0 * np.pi * 70.0 * _V) * _noise(8, 6),
        ),
        # A dark board with one square line around the edge, ten of which make a metre.
        "board": lambda: _texture(
            (0.20, 0.26, 0.33),
            (np.minimum(np.minimum(_U, 1.0 - _U), np.minimum(_V, 1.0 - _V)) < 0.012, (0.33, 0.41, 0.50)),
        ),
        # A printed drink can: metal ends, red print, a white wave and a ring.
        "can": lambda: _texture(
            (0.80, 0.07, 0.10),
            (np.abs(_V - 0.52 - 0.10 * np.sin(4.0 * np.pi * _U)) < 0.07, (0.96, 0.96, 0.95)),
            (np.abs(_V - 0.30) < 0.015, (0.98, 0.78, 0.20)),
            ((_V < 0.16) | (_V > 0.84), (0.80, 0.82, 0.85)),
        ),
        # A clear blue bottle with ribs, a white label that has a band and dots, and a dark blue cap.
        "bottle": lambda: _texture(
            np.array((0.55, 0.78, 0.90)) * (1.0 + 0.10 * np.sin(2.0 * np.pi * 24.0 * _V))[..., None],
            ((_V > 0.30) & (_V < 0.56), (0.96, 0.97, 0.98)),
            ((_V > 0.47) & (_V < 0.54), (0.08, 0.36, 0.72)),
            ((np.hypot((4.0 * _U) % 1.0 - 0.5, 4.0 * (_V - 0.39) * 2.2) < 0.28) & (_V < 0.46), (0.10, 0.60, 0.86)),
            (_V > 0.86, (0.06, 0.25, 0.60)),
        ),
        # A white cup of yoghurt with a band of fruit and a foil.
        "cup": lambda: _texture(
            (0.96, 0.95, 0.93),
            (np.hypot((3.0 * _U) % 1.0 - 0.5, 2.6 * (_V - 0.52)) < 0.30, (0.86, 0.20, 0.42)),
            (np.abs(_V - 0.30) < 0.03, (0.35, 0.62, 0.30)),
            (_V > 0.80, (0.86, 0.87, 0.90)),
        ),
        # A steel tin with beads, and a paper label with a band and fruit.
        "tin": lambda: _texture(
            (0.74, 0.75, 0.77),
            ((_V > 0.30) & (_V < 0.70), (0.16, 0.45, 0.25)),
            (np.abs(_V - 0.5) < 0.05, (0.97, 0.86, 0.38)),
            (np.hypot((2.0 * _U) % 1.0 - 0.5, 2.0 * (_V - 0.5)) < 0.22, (0.85, 0.16, 0.10)),
            shade=np.where((_V > 0.30) & (_V < 0.70), 1.0, 1.0 + 0.12 * np.sin(2.0 * np.pi * 16.0 * _V)),
        ),
        # A drink carton seen from above: white and blue, a wave, a cap's ring and the folded end.
        "drink": lambda: _texture(
            (0.97, 0.97, 0.96),
            (0.46 + 0.12 * np.sin(2.0 * np.pi * (_U + 0.1)) < _V, (0.10, 0.47, 0.76)),
            (np.abs(_V - 0.42 - 0.12 * np.sin(2.0 * np.pi * (_U + 0.1))) < 0.03, (0.48, 0.76, 0.28)),
            ((np.hypot(_U - 0.82, 0.7 * (_V - 0.25)) < 0.06) | (_U < 0.03), (0.86, 0.20, 0.16)),
        ),
        # Brown board with a strip of tape, a printed mark and an arrow.
        "carton": lambda: _texture(
            np.array((0.74, 0.57, 0.38)) * (1.0 + 0.06 * _noise(60, 7))[..., None],
            (np.abs(_V - 0.5) < 0.09, (0.86, 0.74, 0.53)),
            (
                (np.abs(_U - 0.78) < 0.12) & (np.abs(_V - 0.22) < 0.10) & (np.abs((12.0 * _U) % 1.0 - 0.5) < 0.28),
                (0.20, 0.16, 0.13),
            ),
            (
                (np.abs(_U - 0.20) < 0.015 + 0.20 * np.clip(_V - 0.70, 0.0, 0.12)) & (_V > 0.70) & (_V < 0.92),
                (0.62, 0.14, 0.10),
            ),
            shade=1.0 + 0.03 * np.sin(2.0 * np.pi * 40.0 * _U),
        ),
        # A bright tray of plastic with a rest of its film.
        "tray": lambda: _texture(
            (0.08, 0.62, 0.64),
            ((_U > 0.62) & (_noise(6, 14) > -0.1), (0.80, 0.88, 0.90)),
            shade=1.0 + 0.08 * _noise(20, 8),
        ),
        # White paper with ruled lines and soft folds.
        "paper": lambda: _texture(
            (0.95, 0.94, 0.91),
            (np.abs((14.0 * _V) % 1.0 - 0.5) > 0.45, (0.62, 0.72, 0.86)),
            shade=1.0 + 0.10 * _noise(24, 9),
        ),
        # Crumpled aluminium.
        "foil": lambda: _texture((0.80, 0.81, 0.83), shade=1.0 + 0.28 * _noise(40, 10)),
        # A lid with red and white squares and a gold rim.
        "lid": lambda: _texture(
            np.array((0.97, 0.95, 0.92))
            * (
                1.0
                - np.sum([(12.0 * _U) % 2.0 < 1.0, (12.0 * _V) % 2.0 < 1.0], axis=0)[..., None]
                * np.array([0.06, 0.42, 0.42])
            ),
            (np.hypot(_U - 0.5, _V - 0.5) > 0.43, (0.84, 0.67, 0.27)),
        ),
        # Wrinkled film, milky, with printed stripes.
        "film": lambda: _texture(
            (0.86, 0.90, 0.93),
            (np.abs((3.0 * _U) % 1.0 - 0.5) < 0.12, (0.35, 0.70, 0.62)),
            shade=1.0 + 0.14 * _noise(14, 11),
        ),
        # Cork with dark pores.
        "cork": lambda: _texture(
            (0.78, 0.58, 0.38), (_noise(60, 12) > 0.42, (0.45, 0.29, 0.17)), shade=1.0 + 0.10 * _noise(20, 13)
        ),
        # A bright plastic pack with a label that has a band.
        "plastic": lambda: _texture(
            (0.12, 0.60, 0.62),
            ((np.abs(_U - 0.45) < 0.28) & (np.abs(_V - 0.5) < 0.34), (0.97, 0.96, 0.90)),
            ((np.abs(_U - 0.45) < 0.28) & (np.abs(_V - 0.36) < 0.06), (0.90, 0.38, 0.10)),
            (_U > 0.88, (0.95, 0.78, 0.16)),
        ),
    }
)
"""Drawings of the textures by name."""
