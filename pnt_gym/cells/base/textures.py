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


def _plain(colour: Rgb) -> Floats:
    return np.tile(np.array(colour), (SIDE, SIDE, 1))


def _painted(ground: Floats, mask: NDArray[np.bool_], colour: Rgb) -> Floats:
    """The ground with a colour where the mask is True."""
    return np.where(mask[..., None], np.array(colour), ground)


def _shaded(ground: Floats, shade: Floats) -> Texture:
    """A texture from colours of 0 to 1, each multiplied by a shade (SIDE, SIDE)."""
    return np.asarray(np.clip(255.0 * ground * shade[..., None], 0.0, 255.0).astype(np.uint8))


def _belt() -> Texture:
    """Dark rubber with scuffs and a seam across; the belt runs along the columns."""
    ground = _painted(_plain((0.165, 0.185, 0.215)), np.abs(_U - 0.5) < 0.016, (0.30, 0.33, 0.37))
    return _shaded(ground, 1.0 + 0.20 * _noise(8, 1))


def _floor() -> Texture:
    """Sealed concrete: pale, a little cloudy, with joints around each square."""
    joints = (np.minimum(_U, 1.0 - _U) < 0.004) | (np.minimum(_V, 1.0 - _V) < 0.004)
    ground = _painted(_plain((0.70, 0.72, 0.745)), joints, (0.60, 0.62, 0.65))
    return _shaded(ground, 1.0 + 0.03 * _noise(4, 3))


def _wood() -> Texture:
    """Planed wood with its grain along the columns."""
    rings = np.sin(2.0 * np.pi * (9.0 * _V + 0.8 * _noise(3, 5)))
    return _shaded(
        _plain((0.78, 0.60, 0.40)), 1.0 + 0.10 * rings + 0.06 * np.sin(2.0 * np.pi * 70.0 * _V) * _noise(8, 6)
    )


def _board() -> Texture:
    """A dark board with one square line around the edge, ten of which make a metre."""
    line = (np.minimum(_U, 1.0 - _U) < 0.012) | (np.minimum(_V, 1.0 - _V) < 0.012)
    return _shaded(_painted(_plain((0.20, 0.26, 0.33)), line, (0.33, 0.41, 0.50)), np.ones((SIDE, SIDE)))


def _can() -> Texture:
    """A printed drink can: metal ends, red print, a white wave and a ring."""
    wave = np.abs(_V - 0.52 - 0.10 * np.sin(4.0 * np.pi * _U)) < 0.07
    ground = _painted(_plain((0.80, 0.07, 0.10)), wave, (0.96, 0.96, 0.95))
    ground = _painted(ground, np.abs(_V - 0.30) < 0.015, (0.98, 0.78, 0.20))
    return _shaded(_painted(ground, (_V < 0.16) | (_V > 0.84), (0.80, 0.82, 0.85)), np.ones((SIDE, SIDE)))


def _bottle() -> Texture:
    """A clear blue bottle with a white label that has a band and dots, and a dark blue cap."""
    ribs = 1.0 + 0.10 * np.sin(2.0 * np.pi * 24.0 * _V)
    ground = _plain((0.55, 0.78, 0.90)) * ribs[..., None]
    ground = _painted(ground, (_V > 0.30) & (_V < 0.56), (0.96, 0.97, 0.98))
    ground = _painted(ground, (_V > 0.47) & (_V < 0.54), (0.08, 0.36, 0.72))
    dots = (np.hypot((4.0 * _U) % 1.0 - 0.5, 4.0 * (_V - 0.39) * 2.2) < 0.28) & (_V < 0.46)
    ground = _painted(ground, dots, (0.10, 0.60, 0.86))
    return _shaded(_painted(ground, _V > 0.86, (0.06, 0.25, 0.60)), np.ones((SIDE, SIDE)))


def _cup() -> Texture:
    """A white cup of yoghurt with a band of fruit and a foil."""
    fruit = np.hypot((3.0 * _U) % 1.0 - 0.5, 2.6 * (_V - 0.52)) < 0.30
    ground = _painted(_plain((0.96, 0.95, 0.93)), fruit, (0.86, 0.20, 0.42))
    ground = _painted(ground, np.abs(_V - 0.30) < 0.03, (0.35, 0.62, 0.30))
    return _shaded(_painted(ground, _V > 0.80, (0.86, 0.87, 0.90)), np.ones((SIDE, SIDE)))


def _tin() -> Texture:
    """A steel tin with beads and a paper label."""
    beads = 1.0 + 0.12 * np.sin(2.0 * np.pi * 16.0 * _V)
    label = (_V > 0.30) & (_V < 0.70)
    ground = _painted(_plain((0.74, 0.75, 0.77)), label, (0.16, 0.45, 0.25))
    ground = _painted(ground, label & (np.abs(_V - 0.5) < 0.05), (0.97, 0.86, 0.38))
    ground = _painted(ground, np.hypot((2.0 * _U) % 1.0 - 0.5, 2.0 * (_V - 0.5)) < 0.22, (0.85, 0.16, 0.10))
    return _shaded(ground, np.where(label, 1.0, beads))


def _drink() -> Texture:
    """A drink carton seen from above: white and blue, a wave, a cap's ring and the folded end."""
    wave = 0.46 + 0.12 * np.sin(2.0 * np.pi * (_U + 0.1)) < _V
    ground = _painted(_plain((0.97, 0.97, 0.96)), wave, (0.10, 0.47, 0.76))
    ground = _painted(ground, np.abs(_V - 0.42 - 0.12 * np.sin(2.0 * np.pi * (_U + 0.1))) < 0.03, (0.48, 0.76, 0.28))
    ring = np.hypot(_U - 0.82, 0.7 * (_V - 0.25)) < 0.06
    return _shaded(_painted(ground, ring | (_U < 0.03), (0.86, 0.20, 0.16)), np.ones((SIDE, SIDE)))


def _carton() -> Texture:
    """Brown board with a strip of tape, a printed mark and an arrow."""
    ground = _plain((0.74, 0.57, 0.38)) * (1.0 + 0.06 * _noise(60, 7))[..., None]
    ground = _painted(ground, np.abs(_V - 0.5) < 0.09, (0.86, 0.74, 0.53))
    mark = (np.abs(_U - 0.78) < 0.12) & (np.abs(_V - 0.22) < 0.10)
    ground = _painted(ground, mark & (np.abs((12.0 * _U) % 1.0 - 0.5) < 0.28), (0.20, 0.16, 0.13))
    arrow = (np.abs(_U - 0.20) < 0.015 + 0.20 * np.clip(_V - 0.70, 0.0, 0.12)) & (_V > 0.70) & (_V < 0.92)
    return _shaded(_painted(ground, arrow, (0.62, 0.14, 0.10)), 1.0 + 0.03 * np.sin(2.0 * np.pi * 40.0 * _U))


def _tray() -> Texture:
    """A bright tray of plastic with a rest of its film."""
    ground = _painted(_plain((0.08, 0.62, 0.64)), (_U > 0.62) & (_noise(6, 14) > -0.1), (0.80, 0.88, 0.90))
    return _shaded(ground, 1.0 + 0.08 * _noise(20, 8))


def _paper() -> Texture:
    """White paper with ruled lines and soft folds."""
    ground = _painted(_plain((0.95, 0.94, 0.91)), np.abs((14.0 * _V) % 1.0 - 0.5) > 0.45, (0.62, 0.72, 0.86))
    return _shaded(ground, 1.0 + 0.10 * _noise(24, 9))


def _foil() -> Texture:
    """Crumpled aluminium."""
    return _shaded(_plain((0.80, 0.81, 0.83)), 1.0 + 0.28 * _noise(40, 10))


def _lid() -> Texture:
    """A lid with red and white squares and a gold rim."""
    squares = ((12.0 * _U) % 2.0 < 1.0).astype(np.float64) + ((12.0 * _V) % 2.0 < 1.0)
    ground = _plain((0.97, 0.95, 0.92)) * (1.0 - squares[..., None] * np.array([0.06, 0.42, 0.42]))
    return _shaded(_painted(ground, np.hypot(_U - 0.5, _V - 0.5) > 0.43, (0.84, 0.67, 0.27)), np.ones((SIDE, SIDE)))


def _film() -> Texture:
    """Wrinkled film, milky, with printed stripes."""
    ground = _painted(_plain((0.86, 0.90, 0.93)), np.abs((3.0 * _U) % 1.0 - 0.5) < 0.12, (0.35, 0.70, 0.62))
    return _shaded(ground, 1.0 + 0.14 * _noise(14, 11))


def _cork() -> Texture:
    """Cork with dark pores."""
    ground = _painted(_plain((0.78, 0.58, 0.38)), _noise(60, 12) > 0.42, (0.45, 0.29, 0.17))
    return _shaded(ground, 1.0 + 0.10 * _noise(20, 13))


def _plastic() -> Texture:
    """A bright plastic pack with a label."""
    label = (np.abs(_U - 0.45) < 0.28) & (np.abs(_V - 0.5) < 0.34)
    ground = _painted(_plain((0.12, 0.60, 0.62)), label, (0.97, 0.96, 0.90))
    ground = _painted(ground, label & (np.abs(_V - 0.36) < 0.06), (0.90, 0.38, 0.10))
    return _shaded(_painted(ground, _U > 0.88, (0.95, 0.78, 0.16)), np.ones((SIDE, SIDE)))


TEXTURES: Final[Mapping[str, Callable[[], Texture]]] = MappingProxyType({
    "belt": _belt, "floor": _floor, "wood": _wood, "board": _board, "can": _can, "bottle": _bottle, "cup": _cup,
    "tin": _tin, "drink": _drink, "carton": _carton, "tray": _tray, "paper": _paper, "foil": _foil, "lid": _lid,
    "film": _film, "cork": _cork, "plastic": _plastic,
})  # fmt: skip
"""Drawings of the textures by name."""
