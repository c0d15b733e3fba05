"""Pictures of objects from above. Compiled; see `pnt_gym.compiled`.

A picture has rows from the far side (larger y) to the near side of the belt, and columns along the belt (x).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.grasp.config import CHANNELS, PIXEL, PIXELS
from pnt_gym.cells.grasp.random_kernel import GOLDEN, LOW_16, S16, S32, S48, mix, rough_normal
from pnt_gym.cells.grasp.rows import Surfaces
from pnt_gym.cells.grasp.surface_kernel import surface_point
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Bytes4, Floats3, Keys1

BELT_GRAY, BELT_TEXTURE = 0.12, 0.05
"""Look of the belt: dark and matte; assumed."""
DEPTH_NOISE, DEPTH_GLOSS = 1.0, 3.0
"""Noise of a depth [mm] on a matte surface, and what full gloss adds; assumed."""
LOST, LOST_GLOSS = 0.02, 0.30
"""Share of pixels without a depth on a matte surface, and what full gloss adds; assumed."""
WARMTH = 0.5
"""Change of red and of blue by warmth."""
LIGHT_X, LIGHT_Y, LIGHT_Z = 0.36, 0.28, 0.89
"""Direction to the lamp."""
AMBIENT, SHINE = 0.55, 0.35
"""Share of the light that comes from all sides, and brightness of a mirror that shines into the camera."""
UNIT_16 = 1.0 / 65536.0
HEIGHT, VALID, RED, GREEN, BLUE = range(5)
# Columns of a pixel: brightness, warmth, gloss, texture.


@kernel_part
def _byte(value: float) -> Any:
    """A share 0 to 1 as a byte."""
    return np.uint8(min(max(value, 0.0), 1.0) * 255.0 + 0.5)


@kernel_part
def _draw(surfaces: Surfaces, k: int, x: float, y: float, height: Floats, look: Floats) -> None:
    """Write the heights of object k with its middle at x, y above what is there, and its look (PIXELS, PIXELS, 4)."""
    body, zones = surfaces.bodies[k], surfaces.zones[k]
    size, cos, sin = body.size, math.cos(body.yaw), math.sin(body.yaw)
    wide = (abs(cos) * size[0] + abs(sin) * size[1]) / 2.0
    tall = (abs(sin) * size[0] + abs(cos) * size[1]) / 2.0
    # Rows run against y: the first row has the largest y.
    half = (PIXELS - 1) / 2.0
    first, last = max(int(half + (x - wide) / PIXEL), 0), min(int(half + (x + wide) / PIXEL) + 1, PIXELS - 1)
    top, bottom = max(int(half - (y + tall) / PIXEL), 0), min(int(half - (y - tall) / PIXEL) + 1, PIXELS - 1)
    for row in range(top, bottom + 1):
        q = (half - row) * PIXEL - y
        for column in range(first, last + 1):
            p = (column - half) * PIXEL - x
            above, _, zone = surface_point(surfaces, k, cos * p + sin * q, cos * q - sin * p)
            if above > height[row, column]:
                height[row, column] = above
                for part in range(4):
                    look[row, column, part] = zones[zone].look[part] if zone >= 0 else body.look[part]


@kernel_part
def _paint_pixel(image: Any, row: int, column: int, height: Floats, look: Floats, is_noisy: bool, key: Any) -> None:
    """Paint a pixel of a picture (5, PIXELS, PIXELS)."""
    gray, warm, gloss, texture = look[0], look[1], look[2], look[3]
    depth, valid, red, green, blue = 1e3 * height[row, column], True, 0.0, 0.0, 0.0
    if is_noisy:
        bits = mix(key + np.uint64(2 * (row * PIXELS + column) + 1) * GOLDEN)
        depth += (DEPTH_NOISE + DEPTH_GLOSS * gloss) * rough_normal(bits)
        bits = mix(key + np.uint64(2 * (row * PIXELS + column) + 2) * GOLDEN)
        valid = np.int64(bits & LOW_16) * UNIT_16 >= LOST + LOST_GLOSS * gloss
        red = texture * (2.0 * UNIT_16 * np.int64((bits >> S16) & LOW_16) - 1.0)
        green = texture * (2.0 * UNIT_16 * np.int64((bits >> S32) & LOW_16) - 1.0)
        blue = texture * (2.0 * UNIT_16 * np.int64(bits >> S48) - 1.0)
    # Diffuse light on a pixel, and what a glossy surface throws into the camera.
    right, down = min(column + 1, PIXELS - 1), min(row + 1, PIXELS - 1)
    along = (height[row, right] - height[row, column]) / PIXEL
    across = (height[row, column] - height[down, column]) / PIXEL
    scale = 1.0 / math.sqrt(1.0 + along * along + across * across)
    toward = max((LIGHT_Z - along * LIGHT_X - across * LIGHT_Y) * scale, 0.0)
    # The camera looks straight down: the mirror direction of the lamp is (2 n_z n - z).
    mirror = max(2.0 * scale * toward - LIGHT_Z, 0.0)
    diffuse, mirror = AMBIENT + (1.0 - AMBIENT) * toward, SHINE * gloss * mirror**8
    image[HEIGHT, row, column] = np.uint8(min(max(depth, 0.0), 255.0) + 0.5) if valid and depth < 255.0 else np.uint8(0)
    image[VALID, row, column] = np.uint8(255) if valid else np.uint8(0)
    image[RED, row, column] = _byte((gray * (1.0 + WARMTH * warm) + red) * diffuse + mirror)
    image[GREEN, row, column] = _byte((gray + green) * diffuse + mirror)
    image[BLUE, row, column] = _byte((gray * (1.0 - WARMTH * warm) + blue) * diffuse + mirror)


@kernel
def draw_images(surfaces: Surfaces, middles: Floats3, keys: Keys1, is_noisy: bool) -> Bytes4:
    """N pictures of M objects each (N, 5, PIXELS, PIXELS).

    Args:
        surfaces: the objects, picture after picture (N * M rows).
        middles: middles of the outlines from the middle of the picture (N, M, 2) [m]; NaN for an absent object.
        keys: keys of the noise (N,).
        is_noisy: whether depths are noisy or lost, and colours noisy.
    """
    count, objects, _ = middles.shape
    images = np.empty((count, CHANNELS, PIXELS, PIXELS), np.uint8)
    height, look = np.empty((PIXELS, PIXELS)), np.empty((PIXELS, PIXELS, 4))
    for n in range(count):
        height[:], look[:] = 0.0, 0.0
        look[:, :, 0], look[:, :, 3] = BELT_GRAY, BELT_TEXTURE
        for k in range(objects):
            x, y = middles[n, k, 0], middles[n, k, 1]
            if not math.isnan(x):
                _draw(surfaces, n * objects + k, x, y, height, look)
        for row in range(PIXELS):
            for column in range(PIXELS):
                _paint_pixel(images[n], row, column, height, look[row, column], is_noisy, keys[n])
    return images
