"""Objects in pictures, and features of depth and colour around places. Compiled; see `pnt_gym.compiled`.

Depths are in mm and colours in shares here, so that features are of the order of 1.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.grasp.image_kernel import BLUE, GREEN, HEIGHT, PIXEL, PIXELS, RED, VALID
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Bytes4, Floats1, Floats2, Ints2

ON = 4.0
"""Height above which a pixel shows an object and not the belt; lids lie only 9 mm above the belt [mm]."""
AROUND = 0.009
"""Width of the ring around a lip that features look at [m]."""
LIP_SHARE = 0.8
"""Share of the lip's radius to which the object must reach around a place."""
INNER, OUTER = 0, 1
P_VALID, P_HEIGHT, P_ON, P_GRAY, P_WARM = range(5)
"""Planes of a picture: whether the depth is valid, height [mm], whether not the belt, brightness, warmth."""
# Sums over the pixels of a disc: valid ones and their x, y, height and products; all ones, those on the belt, colours.
(N, X, Y, Z, XX, XY, YY, XZ, YZ, ZZ, ALL, BELT, G, GG, W, WW) = range(16)
SUMS = 16
# Features of a place; of the inner disc under the lip, and of the outer disc with the ring around the lip.
(
    VALID_IN, VALID_OUT, ROUGH_IN, ROUGH_OUT, SLOPE_IN, SLOPE_OUT, BELT_IN, BELT_OUT, BULGE, BELOW_TOP, LEVEL,
    GRAY_IN, WARM_IN, GRAY_TEXTURE, WARM_TEXTURE, GRAY_STEP, WARM_STEP, DISTANCE, AXIS_DISTANCE,
    OBJECT_GRAY, OBJECT_WARM, OBJECT_VALID, OBJECT_AREA, OBJECT_TOP, OBJECT_LENGTH, CUP,
) = range(26)  # fmt: skip
FEATURES = 26
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
def _write(image: Any, smooth: Floats, planes: Floats) -> None:
    """Write the planes of a picture: what loops over discs read many times."""
    for row in range(PIXELS):
        for column in range(PIXELS):
            red, green, blue = (
                float(image[RED, row, column]),
                float(image[GREEN, row, column]),
                float(image[BLUE, row, column]),
            )
            planes[row, column, P_VALID] = 1.0 if image[VALID, row, column] > 0 else 0.0
            planes[row, column, P_HEIGHT] = image[HEIGHT, row, column]
            planes[row, column, P_ON] = 1.0 if smooth[row, column] > ON else 0.0
            planes[row, column, P_GRAY] = (red + green + blue) / 765.0
            planes[row, column, P_WARM] = (red - blue) / 255.0


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
def _describe(planes: Floats, smooth: Floats, valid: Floats, part: Ints, label: int, whole: Floats) -> int:
    """Write an object's pixels, middle, axis, length, colours, valid share and top; return the number of pixels."""
    whole[:] = 0.0
    count, x, y, xx, xy, yy, top = 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    half = (PIXELS - 1) / 2.0
    for row in range(PIXELS):
        for column in range(PIXELS):
            if part[row, column] == label:
                p, q = (column - half) * PIXEL, (half - row) * PIXEL
                count, x, y = count + 1, x + p, y + q
                xx, xy, yy = xx + p * p, xy + p * q, yy + q * q
                whole[5] += planes[row, column, P_GRAY]
                whole[6] += planes[row, column, P_WARM]
                whole[7] += valid[row, column]
                top += smooth[row, column]
    if count == 0:
        return 0
    x, y = x / count, y / count
    xx, xy, yy = xx / count - x * x, xy / count - x * y, yy / count - y * y
    angle = 0.5 * math.atan2(2.0 * xy, xx - yy)
    whole[0], whole[1], whole[2], whole[3] = x, y, math.cos(angle), math.sin(angle)
    whole[4] = math.sqrt(max((xx + yy) / 2.0 + math.hypot((xx - yy) / 2.0, xy), 0.0))
    whole[5], whole[6], whole[7], whole[8] = whole[5] / count, whole[6] / count, whole[7] / count, top / count
    return count


@kernel_part
def _sum_ring(planes: Floats, row: int, column: int, least: float, most: float, s: Floats) -> None:
    """Add to the sums (SUMS,) the pixels whose squared distance [m2] is above `least` and at most `most`."""
    # Numbers of their own stay in registers, which makes the loop three times as fast as sums in an array.
    every, shown, gray, gray_2, warm, warm_2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    n, x, y, z, xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    reach = int(math.sqrt(most) / PIXEL)
    for i in range(max(row - reach, 0), min(row + reach + 1, PIXELS)):
        q = (row - i) * PIXEL
        for j in range(max(column - reach, 0), min(column + reach + 1, PIXELS)):
            p = (j - column) * PIXEL
            square = p * p + q * q
            if least < square <= most:
                on, valid, g, w = planes[i, j, P_ON], planes[i, j, P_VALID], planes[i, j, P_GRAY], planes[i, j, P_WARM]
                every, shown = every + 1.0, shown + on
                gray, gray_2, warm, warm_2 = gray + on * g, gray_2 + on * g * g, warm + on * w, warm_2 + on * w * w
                a, b, h = 100.0 * valid * p, 100.0 * valid * q, valid * planes[i, j, P_HEIGHT]
                n, x, y, z = n + valid, x + a, y + b, z + h
                xx, xy, yy = xx + a * a, xy + a * b, yy + b * b
                xz, yz, zz = xz + a * h, yz + b * h, zz + h * h
    s[ALL], s[BELT] = s[ALL] + every, s[BELT] + every - shown
    s[G], s[GG], s[W], s[WW] = s[G] + gray, s[GG] + gray_2, s[W] + warm, s[WW] + warm_2
    s[N], s[X], s[Y], s[Z] = s[N] + n, s[X] + x, s[Y] + y, s[Z] + z
    s[XX], s[XY], s[YY] = s[XX] + xx, s[XY] + xy, s[YY] + yy
    s[XZ], s[YZ], s[ZZ] = s[XZ] + xz, s[YZ] + yz, s[ZZ] + zz


@kernel_part
def _sum_discs(planes: Floats, row: int, column: int, radius: float, sums: Floats) -> None:
    """Write sums over the disc of a radius at a pixel, and over the disc with the ring around."""
    sums[:] = 0.0
    wide = radius + AROUND
    _sum_ring(planes, row, column, -1.0, radius * radius, sums[INNER])
    sums[OUTER] = sums[INNER]
    _sum_ring(planes, row, column, radius * radius, wide * wide, sums[OUTER])


@kernel_part
def _fit(s: Floats) -> tuple[float, float, float]:
    """Mean height [mm], slope and variance of the heights around their plane [mm2], from sums over a disc."""
    n = s[N]
    if n < 4.0:
        return (s[Z] / n if n > 0.0 else 0.0), 0.0, 25.0
    x, y, z = s[X] / n, s[Y] / n, s[Z] / n
    xx, xy, yy = s[XX] / n - x * x + 1e-6, s[XY] / n - x * y, s[YY] / n - y * y + 1e-6
    xz, yz, zz = s[XZ] / n - x * z, s[YZ] / n - y * z, s[ZZ] / n - z * z
    determinant = xx * yy - xy * xy
    a, b = (xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant
    return z, math.sqrt(a * a + b * b) / 10.0, max(zz - a * xz - b * yz, 0.0)


@kernel_part
def _write_local(sums: Floats, whole: Floats, features: Floats) -> None:
    """Write the features of a place's surroundings."""
    inner, outer = sums[INNER], sums[OUTER]
    height, slope_in, rough_in = _fit(inner)
    outer_height, slope_out, rough_out = _fit(outer)
    features[VALID_IN], features[VALID_OUT] = inner[N] / inner[ALL], outer[N] / outer[ALL]
    features[ROUGH_IN], features[ROUGH_OUT] = (
        0.5 * math.log(rough_in + LEAST_VARIANCE),
        0.5 * math.log(rough_out + LEAST_VARIANCE),
    )
    features[SLOPE_IN], features[SLOPE_OUT] = slope_in, slope_out
    features[BELT_IN], features[BELT_OUT] = inner[BELT] / inner[ALL], outer[BELT] / outer[ALL]
    features[BULGE], features[BELOW_TOP] = (height - outer_height) / 5.0, (whole[8] - height) / 10.0
    features[LEVEL] = height / 50.0
    seen, around = max(inner[ALL] - inner[BELT], 1.0), max(outer[ALL] - outer[BELT], 1.0)
    gray, warm = inner[G] / seen, inner[W] / seen
    features[GRAY_IN], features[WARM_IN] = gray, warm
    features[GRAY_TEXTURE] = 10.0 * math.sqrt(max(inner[GG] / seen - gray * gray, 0.0))
    features[WARM_TEXTURE] = 10.0 * math.sqrt(max(inner[WW] / seen - warm * warm, 0.0))
    features[GRAY_STEP], features[WARM_STEP] = outer[G] / around - gray, outer[W] / around - warm


@kernel_part
def _write_object(whole: Floats, count: int, radius: float, x: float, y: float, features: Floats) -> None:
    """Write the features of a place on its object, and of the object."""
    x, y = x - whole[0], y - whole[1]
    features[DISTANCE] = math.sqrt(x * x + y * y) / 0.03
    features[AXIS_DISTANCE] = abs(whole[2] * y - whole[3] * x) / 0.03
    features[OBJECT_GRAY], features[OBJECT_WARM], features[OBJECT_VALID] = whole[5], whole[6], whole[7]
    features[OBJECT_AREA], features[OBJECT_TOP] = math.sqrt(float(count)) / 10.0, whole[8] / 50.0
    features[OBJECT_LENGTH], features[CUP] = whole[4] / 0.03, radius / 0.018


@kernel
def write_features(images: Bytes4, radius: Floats1, of_all: bool, pixels: Ints2, features: Floats2) -> int:
    """Write the pixels on the objects of N pictures, and the features there.

    Args:
        images: pictures (N, 5, PIXELS, PIXELS).
        radius: radii of the cups (N,) [m].
        of_all: whether all objects of a picture count, or the one nearest to the picture's middle.
        pixels: written with picture, row and column (T, 3) of the first T rows; a picture without an object gives none.
        features: written (T, FEATURES).

    Returns:
        The number of rows T.
    """
    planes, smooth = np.empty((PIXELS, PIXELS, 5)), np.empty((2, PIXELS, PIXELS))
    part, stack = np.empty((PIXELS, PIXELS), dtype=np.int64), np.empty(PIXELS * PIXELS, dtype=np.int64)
    whole, sums = np.empty(9), np.empty((2, SUMS))
    total, half = 0, (PIXELS - 1) / 2.0
    for n in range(len(images)):
        _blur(images[n], smooth[0], smooth[1])
        _write(images[n], smooth[0], planes)
        nearest = _find(smooth[0], part, stack)
        labels = part.max() if of_all else nearest
        for label in range(1 if of_all else max(nearest, 1), labels + 1):
            count = _describe(planes, smooth[0], smooth[1], part, label, whole)
            first, reach = total, int(LIP_SHARE * radius[n] / PIXEL)
            while total == first and reach >= 0:  # a narrow object has places where the lip overhangs
                for row in range(PIXELS):
                    for column in range(PIXELS):
                        if part[row, column] == label and _is_inside(part, label, row, column, reach):
                            _sum_discs(planes, row, column, radius[n], sums)
                            _write_local(sums, whole, features[total])
                            x, y = (column - half) * PIXEL, (half - row) * PIXEL
                            _write_object(whole, count, radius[n], x, y, features[total])
                            pixels[total, 0], pixels[total, 1], pixels[total, 2] = n, row, column
                            total += 1
                reach -= 1
    return total
