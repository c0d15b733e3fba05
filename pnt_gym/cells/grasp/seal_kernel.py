"""Seals of suction cups at places on surfaces. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.grasp.rows import Surfaces
from pnt_gym.cells.grasp.surface_kernel import surface_point
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Floats1, Floats2, Floats3

POINTS = 16
"""Points of the lip, and of a circle inside the lip."""
_ANGLES = 2.0 * np.pi / POINTS * np.arange(POINTS)
COSINES, SINES = tuple(np.cos(_ANGLES).tolist()), tuple(np.sin(_ANGLES).tolist())
"""Of the angles of the lip's points."""
INNER, MIDDLE = 0.6, 3.0
"""Radius of that circle over the lip's radius, and weight of the middle against a point; assumed."""
FOLLOWS = 0.2
"""Gap that the lip bridges, over the lip's radius; assumed."""
SLOPE = math.tan(math.radians(20.0))
"""Steepest plane to which the bellows tilt; assumed."""
OFF = 0.010
"""Gap where the lip is beside the object [m]."""
GAP_LEAK = 8.0e6
"""Leak of a gap over the square of the gap [1/m2]; assumed."""
LEAST_LEAK = 1e-3
VACUUM = 0.6e5
"""Vacuum of the ejector against a tight surface [Pa], that of the catalogue's forces."""


@kernel_part
def _mean_gap(heights: Floats, radius: float) -> float:
    """Mean squared gap [m2] under a lip over heights (POINTS,) [m], -1 beside the object."""
    count, mean, along, across = 0, 0.0, 0.0, 0.0
    for k in range(POINTS):
        if heights[k] >= 0.0:
            count, mean = count + 1, mean + heights[k]
    if count == 0:
        return OFF * OFF
    mean /= count
    # Least squares on a circle: the slope is the first Fourier coefficient.
    for k in range(POINTS):
        if heights[k] >= 0.0:
            along += 2.0 * (heights[k] - mean) * COSINES[k] / (POINTS * radius)
            across += 2.0 * (heights[k] - mean) * SINES[k] / (POINTS * radius)
    steepness = math.sqrt(along * along + across * across)
    share = SLOPE / steepness if steepness > SLOPE else 1.0
    along, across = share * along * radius, share * across * radius
    highest, total = -1.0, 0.0
    for k in range(POINTS):
        if heights[k] >= 0.0:
            highest = max(highest, heights[k] - along * COSINES[k] - across * SINES[k])
    for k in range(POINTS):
        gap = OFF
        if heights[k] >= 0.0:
            gap = highest - (heights[k] - along * COSINES[k] - across * SINES[k]) - FOLLOWS * radius
            gap = min(max(gap, 0.0), OFF)
        total += gap * gap
    return total / POINTS


@kernel
def seal_at(surfaces: Surfaces, seal: Floats1, radius: Floats1, places: Floats3, force: Floats2, leak: Floats2) -> None:
    """Write the forces of cups and the leaks under them at places on N objects.

    Args:
        surfaces: the objects.
        seal: forces of the cups on a tight item (N,) [N].
        radius: radii of the cups (N,) [m].
        places: axes of the cups from the outlines' middles, world axes (N, P, 2) [m].
        force: written (N, P) [N].
        leak: written (N, P).
    """
    heights = np.empty(POINTS)
    for row in range(len(radius)):
        body, r = surfaces.bodies[row], radius[row]
        cos, sin = math.cos(body.yaw), math.sin(body.yaw)
        most = VACUUM * (math.pi * r * r)
        for k in range(places.shape[1]):
            x, y = places[row, k, 0], places[row, k, 1]
            along, across = cos * x + sin * y, cos * y - sin * x
            _, inner, _ = surface_point(surfaces, row, along, across)
            total = MIDDLE * inner
            for point in range(POINTS):
                p, q = r * COSINES[point], r * SINES[point]
                heights[point], outer, _ = surface_point(surfaces, row, along + p, across + q)
                _, inner, _ = surface_point(surfaces, row, along + INNER * p, across + INNER * q)
                total += outer + inner
            if body.count < 0:  # the shape itself does not leak
                for point in range(POINTS):
                    heights[point] = min(heights[point], 0.0)
            gap = _mean_gap(heights, r)
            leak[row, k] = max(total / (2.0 * POINTS + MIDDLE) + GAP_LEAK * gap, LEAST_LEAK)
            force[row, k] = min(seal[row] / leak[row, k], most)
