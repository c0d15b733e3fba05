"""Random numbers from keys instead of a generator: a row's numbers depend on the row's key alone. Compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Floats1, Keys1, Keys2

# Integers of another type would turn a sum of them into a float.
GOLDEN = np.uint64(0x9E3779B97F4A7C15)
FIRST, SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
S11, S16, S27, S30, S31, S32, S48 = (np.uint64(shift) for shift in (11, 16, 27, 30, 31, 32, 48))
LOW_16 = np.uint64(0xFFFF)
UNIT = 2.0**-53
IRWIN_HALL = math.sqrt(3.0) / 65536.0
"""Factor of the centred sum of four 16-bit numbers that makes its standard deviation 1."""


@kernel_part
def mix(key: Any) -> Any:
    """The output function of splitmix64 (Steele, Lea and Flood 2014): each bit of the key changes half of the bits."""
    key = (key ^ (key >> S30)) * FIRST
    key = (key ^ (key >> S27)) * SECOND
    return key ^ (key >> S31)


@kernel_part
def uniform(key: Any, number: int) -> float:
    """A number's uniform draw in [0, 1) of a key."""
    return (mix(key + np.uint64(number + 1) * GOLDEN) >> S11) * UNIT


@kernel_part
def rough_normal(bits: Any) -> float:
    """A nearly normal number from 64 random bits: the sum of four uniform ones, at most 3.5 from 0."""
    total = np.int64(bits & LOW_16) + np.int64((bits >> S16) & LOW_16) + np.int64((bits >> S32) & LOW_16)
    return (total + np.int64(bits >> S48) - 131070) * IRWIN_HALL


@kernel
def hash_rows(bits: Keys2, purpose: np.uint64, keys: Keys1) -> None:
    """Write the keys (N,) of rows of bits (N, C), for one of several purposes."""
    for row in range(len(bits)):
        key = mix(purpose * GOLDEN)
        for column in range(bits.shape[1]):
            key = mix((key ^ bits[row, column]) + GOLDEN)
        keys[row] = key


@kernel
def normal_draw(keys: Keys1, normals: Floats1) -> None:
    """Write a standard normal draw of each key (N,), by Box and Muller's formula."""
    for row in range(len(keys)):
        radius = math.sqrt(-2.0 * math.log(1.0 - uniform(keys[row], 0)))
        normals[row] = radius * math.cos(2.0 * math.pi * uniform(keys[row], 1))
