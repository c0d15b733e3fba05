"""Rows of pictures: pixels, sums over discs of pixels, objects, and the features of places.

Depths are in mm and colours in shares here, so that features are of the order of 1.
"""

from __future__ import annotations

from typing import final

from pnt_gym.rows import Row, field


@final
class Pixel(Row):
    """A pixel of a picture: what loops over discs read many times."""

    valid: float = field("-", "1 where the depth is valid")
    height: float = field("mm", "height above the belt")
    on: float = field("-", "1 where the pixel shows an object and not the belt")
    gray: float = field("-", "brightness")
    warm: float = field("-", "warmth")


@final
class Disc(Row):
    """Sums over the pixels of a disc, valid ones but for the last six; places are from the disc's middle, in 0.01 m."""

    n: float = field("-", "number of valid pixels")
    x: float = field("0.01 m", "places to the right")
    y: float = field("0.01 m", "places upwards")
    z: float = field("mm", "heights")
    xx: float = field("0.0001 m2", "products of places")
    xy: float = field("0.0001 m2", "products of places")
    yy: float = field("0.0001 m2", "products of places")
    xz: float = field("0.01 m mm", "products of places and heights")
    yz: float = field("0.01 m mm", "products of places and heights")
    zz: float = field("mm2", "squares of heights")
    every: float = field("-", "number of all pixels")
    belt: float = field("-", "number of pixels that show the belt")
    gray: float = field("-", "brightness of the object's pixels")
    gray_2: float = field("-", "squares of the brightness")
    warm: float = field("-", "warmth of the object's pixels")
    warm_2: float = field("-", "squares of the warmth")


@final
class Whole(Row):
    """An object in a picture."""

    count: int = field("-", "number of pixels")
    x: float = field("m", "middle, to the right of the picture's")
    y: float = field("m", "middle, above the picture's")
    cos: float = field("-", "cosine of the long axis against the right")
    sin: float = field("-", "sine of the long axis against the right")
    length: float = field("m", "standard deviation of the pixels along the long axis")
    gray: float = field("-", "mean brightness")
    warm: float = field("-", "mean warmth")
    valid: float = field("-", "share of valid depths")
    top: float = field("mm", "mean height")


@final
class Place(Row):
    """Features of a place: `in` under the lip, `out` with a ring of 9 mm around the lip."""

    valid_in: float = field("-", "share of valid depths")
    valid_out: float = field("-", "share of valid depths")
    rough_in: float = field("ln mm", "logarithm of the deviation of the heights from their plane")
    rough_out: float = field("ln mm", "logarithm of the deviation of the heights from their plane")
    slope_in: float = field("-", "slope of that plane")
    slope_out: float = field("-", "slope of that plane")
    belt_in: float = field("-", "share of pixels that show the belt")
    belt_out: float = field("-", "share of pixels that show the belt")
    bulge: float = field("5 mm", "height above the surroundings")
    below_top: float = field("10 mm", "height of the object above the place")
    level: float = field("50 mm", "height above the belt")
    gray_in: float = field("-", "brightness")
    warm_in: float = field("-", "warmth")
    gray_texture: float = field("0.1", "deviation of the brightness")
    warm_texture: float = field("0.1", "deviation of the warmth")
    gray_step: float = field("-", "brightness of the surroundings less that of the place")
    warm_step: float = field("-", "warmth of the surroundings less that of the place")
    distance: float = field("30 mm", "distance from the object's middle")
    axis_distance: float = field("30 mm", "distance from the object's long axis")
    object_gray: float = field("-", "brightness of the object")
    object_warm: float = field("-", "warmth of the object")
    object_valid: float = field("-", "share of valid depths of the object")
    object_area: float = field("100 pixels", "root of the object's area")
    object_top: float = field("50 mm", "height of the object")
    object_length: float = field("30 mm", "length of the object")
    cup: float = field("18 mm", "radius of the cup")
