"""Objects in pictures, and features of depth and colour around places. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.grasp.image_kernel import BLUE, GREEN, HEIGHT, PIXEL, PIXELS, RED, VALID
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.rows import Bytes4, Floats1, Ints2, Rows1, Rows2

from .rows import Disc, Pixel, Place, Whole

ON = 4.0
"""Height above which a pixel shows an object and not the belt; lids lie only 9 mm above the belt [mm]."""
AROUND = 0.009
"""Width of the ring around a lip that features look at [m]."""
LIP_SHARE = 0.8
"""Share of the lip's radius to which the object must reach around a place."""
INNER, OUTER = 0, 1
PIXEL_ROW, DISC, WHOLE = Pixel.dtype, Disc.dtype, Whole.dtype
LEAST_VARIANCE = 0.25
"""Smallest variance of heights around a plane, which rounding to millimetres leaves [mm2]."""


@kernel_part
def _blur(image: Any, smooth: Floats, valid: Floats) -> None:
    """Write heights of the pixels that show an object, 0 for the belt [mm], and shares of valid pixels around.

    A pixel shows an object where most of the valid pixels around it are high; the height is the mean of these. A
    pixel without any valid one around shows an object, because only glossy objects lose so many.
    """
    for row in range(PIXELS):
        for column in range(PIXELS):
            total, high, count, size = 0.0, 0, 0, 0
            for i in range(max(row - 1, 0), min(row + 2, PIXELS)):
                for j in range(max(column - 1, 0), min(column + 2, PIXELS)):
                    size += 1
                    if image[VALID, i, j] > 0:
                        count += 1
                        if image[HEIGHT, i, j] > ON:
                            total, high = total + image[HEIGHT, i, j], high + 1
            valid[row, column] = count / size
            smooth[row, column] = total / high if 2 * high > count else (0.0 if count > 0 else ON + 1.0)


@kernel_part
def _fill(smooth: Floats, part: Ints, stack: Ints, row: int, column: int, label: int) -> int:
    """Give a label to the connected pixels of an object, from one of them; return their number."""
    depth, count = 1, 0
    stack[0], part[row, column] = row * PIXELS + column, label
    while depth > 0:
        depth -= 1
        i, j = stack[depth] // PIXELS, stack[depth] % PIXELS
        count += 1
        for turn in range(4):
            p, q = i + (turn == 0) - (turn == 1), j + (turn == 2) - (turn == 3)
            if 0 <= p < PIXELS and 0 <= q < PIXELS and part[p, q] == 0 and smooth[p, q] > ON:
                part[p, q], stack[depth] = label, p * PIXELS + q
                depth += 1
    return count


@kernel_part
def _find(smooth: Floats, part: Ints, stack: Ints) -> int:
    """Label the connected objects of a picture, and return the label of that nearest to the middle, 0 for none."""
    part[:] = 0
    label, nearest, best = 0, 0, 1e9
    half = (PIXELS - 1) / 2.0
    for row in range(PIXELS):
        for column in range(PIXELS):
            if part[row, column] == 0 and smooth[row, column] > ON:
                label += 1
                if _fill(smooth, part, stack, row, column, label) < 4:  # noise
                    label -= 1
                    continue
    for row in range(PIXELS):
        for column in range(PIXELS):
            distance = (row - half) ** 2 + (column - half) ** 2
            if part[row, column] > 0 and distance < best:
                nearest, best = part[row, column], distance
    return nearest


@kernel_part
def _write(image: Any, smooth: Floats, pixels: Rows2[Pixel]) -> None:
    """Write the pixels of a picture."""
    for row in range(PIXELS):
        for column in range(PIXELS):
            red, green, blue = (
                float(image[RED, row, column]),
                float(image[GREEN, row, column]),
                float(image[BLUE, row, column]),
            )
            pixel = pixels[row, column]
            pixel.valid = 1.0 if image[VALID, row, column] > 0 else 0.0
            pixel.height = image[HEIGHT, row, column]
            pixel.on = 1.0 if smooth[row, column] > ON else 0.0
            pixel.gray = (red + green + blue) / 765.0
            pixel.warm = (red - blue) / 255.0


@kernel_part
def _is_inside(part: Ints, label: int, row: int, column: int, reach: int) -> bool:
    """Whether an object reaches as far as a lip in four directions; the rest of the lip is then seldom beside it."""
    return (
        row >= reach
        and column >= reach
        and row + reach < PIXELS
        and column + reach < PIXELS
        and part[row - reach, column] == label
        and part[row + reach, column] == label
        and part[row, column - reach] == label
        and part[row, column + reach] == label
    )


@kernel_part
def _describe(pixels: Rows2[Pixel], smooth: Floats, valid: Floats, part: Ints, label: int, whole: Whole) -> None:
    """Write what an object with a label is like."""
    count, x, y, xx, xy, yy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    gray, warm, shown, top = 0.0, 0.0, 0.0, 0.0
    half = (PIXELS - 1) / 2.0
    for row in range(PIXELS):
        for column in range(PIXELS):
            if part[row, column] == label:
                p, q = (column - half) * PIXEL, (half - row) * PIXEL
                count, x, y = count + 1, x + p, y + q
                xx, xy, yy = xx + p * p, xy + p * q, yy + q * q
                gray, warm = gray + pixels[row, column].gray, warm + pixels[row, column].warm
                shown, top = shown + valid[row, column], top + smooth[row, column]
    whole.count = count
    if count == 0:
        return
    x, y = x / count, y / count
    xx, xy, yy = xx / count - x * x, xy / count - x * y, yy / count - y * y
    # Heading of the long axis; the length is the standard deviation along it.
    angle = 0.5 * math.atan2(2.0 * xy, xx - yy)
    whole.x, whole.y, whole.cos, whole.sin = x, y, math.cos(angle), math.sin(angle)
    whole.length = math.sqrt(max((xx + yy) / 2.0 + math.hypot((xx - yy) / 2.0, xy), 0.0))
    whole.gray, whole.warm, whole.valid, whole.top = gray / count, warm / count, shown / count, top / count


@kernel_part
def _sum_ring(pixels: Rows2[Pixel], row: int, column: int, least: float, most: float, s: Disc) -> None:
    """Write the sums over the pixels whose squared distance [m2] is above `least` and at most `most`."""
    # Numbers of their own stay in registers, which makes the loop three times as fast as sums in a row.
    every, shown, gray, gray_2, warm, warm_2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    n, x, y, z, xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    reach = int(math.sqrt(most) / PIXEL)
    for i in range(max(row - reach, 0), min(row + reach + 1, PIXELS)):
        q = (row - i) * PIXEL
        for j in range(max(column - reach, 0), min(column + reach + 1, PIXELS)):
            p = (j - column) * PIXEL
            square = p * p + q * q
            if least < square <= most:
                pixel = pixels[i, j]
                on, valid, g, w = pixel.on, pixel.valid, pixel.gray, pixel.warm
                every, shown = every + 1.0, shown + on
                gray, gray_2, warm, warm_2 = gray + on * g, gray_2 + on * g * g, warm + on * w, warm_2 + on * w * w
                # Centimetres beside heights in millimetres, so that all sums have a similar size.
                a, b, h = 100.0 * valid * p, 100.0 * valid * q, valid * pixel.height
                n, x, y, z = n + valid, x + a, y + b, z + h
                xx, xy, yy = xx + a * a, xy + a * b, yy + b * b
                xz, yz, zz = xz + a * h, yz + b * h, zz + h * h
    s.every, s.belt, s.gray, s.gray_2, s.warm, s.warm_2 = every, every - shown, gray, gray_2, warm, warm_2
    s.n, s.x, s.y, s.z, s.xx, s.xy, s.yy, s.xz, s.yz, s.zz = n, x, y, z, xx, xy, yy, xz, yz, zz


@kernel_part
def _add(disc: Disc, s: Disc) -> None:
    """Add the sums over a disc to those over the ring around it."""
    s.every, s.belt = s.every + disc.every, s.belt + disc.belt
    s.gray, s.gray_2, s.warm, s.warm_2 = (
        s.gray + disc.gray,
        s.gray_2 + disc.gray_2,
        s.warm + disc.warm,
        s.warm_2 + disc.warm_2,
    )
    s.n, s.x, s.y, s.z = s.n + disc.n, s.x + disc.x, s.y + disc.y, s.z + disc.z
    s.xx, s.xy, s.yy = s.xx + disc.xx, s.xy + disc.xy, s.yy + disc.yy
    s.xz, s.yz, s.zz = s.xz + disc.xz, s.yz + disc.yz, s.zz + disc.zz


@kernel_part
def _fit(s: Disc) -> tuple[float, float, float]:
    """Mean height [mm], slope and variance of the heights around their plane [mm2], from sums over a disc."""
    n = s.n
    if n < 4.0:
        return (s.z / n if n > 0.0 else 0.0), 0.0, 25.0
    x, y, z = s.x / n, s.y / n, s.z / n
    # Moments about the means; what is added keeps a disc whose pixels lie in one line from a division by zero.
    xx, xy, yy = s.xx / n - x * x + 1e-6, s.xy / n - x * y, s.yy / n - y * y + 1e-6
    xz, yz, zz = s.xz / n - x * z, s.yz / n - y * z, s.zz / n - z * z
    # The plane z = a x + b y by least squares, a and b in millimetres a centimetre.
    determinant = xx * yy - xy * xy
    a, b = (xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant
    return z, math.sqrt(a * a + b * b) / 10.0, max(zz - a * xz - b * yz, 0.0)


@kernel_part
def _write_local(inner: Disc, outer: Disc, whole: Whole, place: Place) -> None:
    """Write the features of a place's surroundings."""
    height, place.slope_in, rough_in = _fit(inner)
    outer_height, place.slope_out, rough_out = _fit(outer)
    place.valid_in, place.valid_out = inner.n / inner.every, outer.n / outer.every
    place.rough_in = 0.5 * math.log(rough_in + LEAST_VARIANCE)
    place.rough_out = 0.5 * math.log(rough_out + LEAST_VARIANCE)
    place.belt_in, place.belt_out = inner.belt / inner.every, outer.belt / outer.every
    place.bulge, place.below_top = (height - outer_height) / 5.0, (whole.top - height) / 10.0
    place.level = height / 50.0
    seen, around = max(inner.every - inner.belt, 1.0), max(outer.every - outer.belt, 1.0)
    gray, warm = inner.gray / seen, inner.warm / seen
    place.gray_in, place.warm_in = gray, warm
    place.gray_texture = 10.0 * math.sqrt(max(inner.gray_2 / seen - gray * gray, 0.0))
    place.warm_texture = 10.0 * math.sqrt(max(inner.warm_2 / seen - warm * warm, 0.0))
    place.gray_step, place.warm_step = outer.gray / around - gray, outer.warm / around - warm


@kernel_part
def _write_object(whole: Whole, radius: float, x: float, y: float, place: Place) -> None:
    """Write the features of a place on its object, and of the object."""
    x, y = x - whole.x, y - whole.y
    place.distance = math.sqrt(x * x + y * y) / 0.03
    place.axis_distance = abs(whole.cos * y - whole.sin * x) / 0.03
    place.object_gray, place.object_warm, place.object_valid = whole.gray, whole.warm, whole.valid
    place.object_area, place.object_top = math.sqrt(float(whole.count)) / 10.0, whole.top / 50.0
    place.object_length, place.cup = whole.length / 0.03, radius / 0.018


@kernel
def write_features(images: Bytes4, radius: Floats1, of_all: bool, places: Ints2, features: Rows1[Place]) -> int:
    """Write the pixels on the objects of N pictures, and the features there.

    Args:
        images: pictures (N, 5, PIXELS, PIXELS).
        radius: radii of the cups (N,) [m].
        of_all: whether all objects of a picture count, or the one nearest to the picture's middle.
        places: written with picture, row and column (T, 3) of the first T rows; a picture without an object gives none.
        features: written (T,).

    Returns:
        The number of rows T.
    """
    pixels, smooth = empty_rows((PIXELS, PIXELS), PIXEL_ROW), np.empty((2, PIXELS, PIXELS))
    part, stack = np.empty((PIXELS, PIXELS), dtype=np.int64), np.empty(PIXELS * PIXELS, dtype=np.int64)
    wholes, discs = empty_rows(1, WHOLE), empty_rows(2, DISC)  # an array keeps its rows, a row alone is not kept
    total, half = 0, (PIXELS - 1) / 2.0
    for n in range(len(images)):
        _blur(images[n], smooth[0], smooth[1])
        _write(images[n], smooth[0], pixels)
        nearest, near, wide = _find(smooth[0], part, stack), radius[n], radius[n] + AROUND
        labels = part.max() if of_all else nearest
        for label in range(1 if of_all else max(nearest, 1), labels + 1):
            _describe(pixels, smooth[0], smooth[1], part, label, wholes[0])
            first, reach = total, int(LIP_SHARE * near / PIXEL)
            while total == first and reach >= 0:  # a narrow object has places where the lip overhangs
                for row in range(PIXELS):
                    for column in range(PIXELS):
                        if part[row, column] == label and _is_inside(part, label, row, column, reach):
                            _sum_ring(pixels, row, column, -1.0, near * near, discs[INNER])
                            _sum_ring(pixels, row, column, near * near, wide * wide, discs[OUTER])
                            _add(discs[INNER], discs[OUTER])
                            _write_local(discs[INNER], discs[OUTER], wholes[0], features[total])
                            x, y = (column - half) * PIXEL, (half - row) * PIXEL
                            _write_object(wholes[0], near, x, y, features[total])
                            places[total, 0], places[total, 1], places[total, 2] = n, row, column
                            total += 1
                reach -= 1
    return total
