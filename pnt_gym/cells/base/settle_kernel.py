"""Compiled judgement of falling objects: which are clear of belt and bins, and which stay in or out of a bin for good.

Walls are planes along the axes, so the half extents of a turned body along the axes say exactly whether the body
crosses a plane.

An object stays in a bin, or outside, if it sinks and no rebound can lift its centre of mass over the rim. A single blow
from below on a body that falls with a vertical speed w changes that speed by (1 + e) k (w + r o), with the rebound e,
the share k = 1 / (1 + m r^2 / I) of the mass that the point of contact feels, and the point's speed r o by rotation.
Over all arms r the body leaves with at most (1 + e) (w + V) / 2 - w, where V is the speed of which all kinetic energy
would be translation. V counts horizontal speed too, because friction can turn it into rotation. So a body that meets
the lowest point that can lift it with kinetic energy m V^2 / 2 rises from there by at most ((1 + e) (w + V) / 2 - w)^2
/ (2 g), where e is the largest rebound of the contact in the engine's steps, see `fill_rebounds`.

Later blows have less energy. That a body which is struck several times in a row, by walls and bottom, keeps to this
bound as well is not proven: the study `margins` compares a hundred thousand throws with the engine, and a test a few
hundred.
"""

from __future__ import annotations

import math

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.airborne import Airborne, BinShape, Ground, Solid, Vicinity
from pnt_gym.cells.base.freefall import step_free
from pnt_gym.cells.base.items import CYLINDER, ELLIPSOID
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.rows import Floats1, Floats2, Ints1, Rows

FALLING, STAYS, OVER = 0, 1, 2
"""Verdicts: unknown; the object stays in its bin or outside; it has no energy to reach a rim, or its time is over."""
GAP = 0.001
"""Distance from a wall below which a contact is possible, beside the way of one step [m].

The engine looks ahead by a step, too. Gravity and air change that way by less than 0.04 mm in steps of 2 ms."""
TOUCH = 0.002
"""Height of an object's highest point under the rim above which the rim may strike the object [m]: contacts are soft.

A contact is 1.1 mm deep for each m/s of its impact, see `bodies.contact_solref`."""
MARGIN = 0.005
"""Distance from the rim within which no rebound may lift an object that counts as staying [m]; blows in a row, and
springs of contacts, beside the bound."""
PHASES = 40
"""Number of moments within a step at which impacts begin; the strongest rebound counts."""
IMPACT_TIME = 0.02
"""Time that an object needs at the bottom of its bin to lose the energy with which it came [s]; several contacts."""


@kernel_part
def _half_extent(solid: Solid, x: float, y: float, z: float) -> float:
    """Half extent [m] of a turned body along a direction (x, y, z) in the body's axes."""
    a, b, c = solid.half[0], solid.half[1], solid.half[2]
    if solid.shape == ELLIPSOID:
        return math.sqrt((a * x) ** 2 + (b * y) ** 2 + (c * z) ** 2)
    if solid.shape == CYLINDER:
        return a * abs(x) + b * math.sqrt(max(1.0 - x * x, 0.0))
    return a * abs(x) + b * abs(y) + c * abs(z)


@kernel_part
def _box_around(solid: Solid, state: Floats) -> tuple[float, float, float, float, float, float]:
    """Middle and half extents of the box along the world's axes around a body: x, y, z, and then the halves [m]."""
    w, x, y, z = state[3], state[4], state[5], state[6]
    # Third column of the rotation matrix from the body's axes to the world's, times the middle's height in the body.
    up = solid.height
    middle_x = state[0] + up * 2.0 * (x * z + w * y)
    middle_y = state[1] + up * 2.0 * (y * z - w * x)
    middle_z = state[2] + up * (1.0 - 2.0 * (x * x + y * y))
    # Its rows are the world's axes in the body's.
    half_x = _half_extent(solid, 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y))
    half_y = _half_extent(solid, 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x))
    half_z = _half_extent(solid, 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
    return middle_x, middle_y, middle_z, half_x, half_y, half_z


@kernel_part
def _is_beside_belt(ground: Ground, x: float, y: float, half_x: float, half_y: float) -> bool:
    """Whether a box with a middle and half extents along x and y [m] is beside the belt, not over it."""
    beside_x = x + half_x < ground.min_x or x - half_x > ground.max_x
    return beside_x or y + half_y < ground.min_y or y - half_y > ground.max_y


@kernel_part
def _is_clear(solid: Solid, state: Floats, bins: Rows[BinShape], rim: float, ground: Ground, step: float) -> bool:
    """Whether a body cannot touch belt, rims, walls and bottoms in the next step; unknown outside the bins."""
    x, y, z, half_x, half_y, half_z = _box_around(solid, state)
    # The box grows by the way of the body's middle and of its farthest point in a step.
    gap = GAP + step * solid.farthest * math.sqrt(state[10] ** 2 + state[11] ** 2 + state[12] ** 2)
    half_x, half_y = half_x + gap + step * abs(state[7]), half_y + gap + step * abs(state[8])
    low = z - half_z - gap - step * abs(state[9])
    if not (low > ground.belt or _is_beside_belt(ground, x, y, half_x, half_y)):
        return False
    if low > rim:
        return True
    for k in range(bins.shape[0]):
        if abs(x - bins[k].x) + half_x < bins[k].half_x and abs(y - bins[k].y) + half_y < bins[k].half_y:
            return low > rim - bins[k].depth
    return False


@kernel_part
def _stays(
    solid: Solid, state: Floats, bins: Rows[BinShape], rim: float, ground: Ground, energy: float, time: float
) -> bool:
    """Whether a body in a bin lies there for good after a time [s], or a body outside stays outside.

    `energy` is the energy of the body over its weight [m], which is a height. A body that is still falling in its bin
    after that time does not lie there.
    """
    height, sinking = state[2], -state[9]
    if not (sinking >= 0.0 and height < rim):
        return False
    _, _, middle, _, _, half = _box_around(solid, state)
    is_below = middle + half < rim - TOUCH
    surface, is_inside = 0.0, False
    for k in range(bins.shape[0]):
        if abs(state[0] - bins[k].x) <= bins[k].half_x and abs(state[1] - bins[k].y) <= bins[k].half_y:
            is_inside, surface = True, rim - bins[k].depth
    if is_inside:
        # A body that could still rise to the rim sinks at least as fast as one that was dropped at the rim.
        drop = math.sqrt(2.0 * (rim - surface) / GRAVITY) - math.sqrt(2.0 * (rim - height) / GRAVITY)
        if time < drop + IMPACT_TIME:
            return False
    elif is_below:
        # Outside the bins lies the belt, if the body may come down there, or the floor.
        surface = ground.floor
        if height >= ground.belt:
            # A body that sinks is below the belt's surface before it has moved sideways by more than this.
            sideways = math.sqrt(state[7] ** 2 + state[8] ** 2)
            way = solid.farthest + sideways * math.sqrt(2.0 * (height - ground.belt) / GRAVITY)
            surface = ground.floor if _is_beside_belt(ground, state[0], state[1], way, way) else ground.belt
    else:
        return False
    # Below the rim only the surface can lift a body, and highest a body that stands on its end.
    struck = min(height, surface + solid.farthest) if is_below else height
    ahead = 2.0 * GRAVITY * max(energy - struck, 0.0)
    speed, down = math.sqrt(ahead), math.sqrt(min(sinking**2 + 2.0 * GRAVITY * (height - struck), ahead))
    rise = max(0.5 * (1.0 + solid.rebound) * (down + speed) - down, 0.0)
    return struck + rise * rise / (2.0 * GRAVITY) < rim - MARGIN


@kernel
def fill_rebounds(solref: Floats2, step: float, rebounds: Floats1) -> None:
    """Largest rebound speeds over impact speeds of contacts in steps of the engine.

    The contact is a spring and a damper that push and never pull. A step of 1 ms is coarse for it: by the moment within
    a step at which the impact begins, an item of rebound 0.4 leaves with 0.30 to 0.48 of its speed.

    Args:
        solref: time constants [s] and damping ratios (N, 2).
        step: length of a physics step [s].
        rebounds: filled with the rebounds (N,).
    """
    for row in range(rebounds.size):
        damping = 2.0 / solref[row, 0]
        stiffness = 1.0 / (solref[row, 0] * solref[row, 1]) ** 2
        rebounds[row] = 0.0
        for k in range(PHASES):
            height, speed = (k + 1e-3) / PHASES * step, -1.0
            while not (height > 0.0 and speed > 0.0):
                if height <= 0.0:
                    speed += step * max(-stiffness * height - damping * speed, 0.0)
                height += step * speed
            rebounds[row] = max(rebounds[row], speed)


@kernel
def follow(
    state: Floats2, objects: Airborne, vicinity: Vicinity, step: float, energy: Floats1, steps: Ints1, verdict: Ints1
) -> None:
    """Let N objects fly on until they may touch something, and judge which ones stay in or out of a bin, in place.

    Args:
        state: states (N, STATE).
        objects: the objects.
        vicinity: their bodies, and what they may meet.
        step: length of a physics step [s].
        energy: energies over weight at the check before (N,) [m]; overwritten with those of this check. The spring of a
            contact may hold energy for a moment, so an object counts as having the greater of both.
        steps: steps that are left to each throw (N,).
        verdict: `FALLING`, `STAYS` or `OVER` (N,); only objects that are falling are followed.
    """
    for row in range(verdict.size):
        solid, bins, rim = vicinity.solid[row], vicinity.bins[row], vicinity.rim[row]
        ground = vicinity.ground[row]
        while verdict[row] == FALLING:
            # Energy over weight [m].
            squares = state[row, 7] * state[row, 7] + state[row, 8] * state[row, 8] + state[row, 9] * state[row, 9]
            for axis in range(3):
                squares += solid.spin[axis] * (state[row, 10 + axis] * state[row, 10 + axis])
            now = state[row, 2] + squares / (2.0 * GRAVITY)
            largest, energy[row] = max(now, energy[row]), now
            if steps[row] <= 1 or now < rim:
                verdict[row] = OVER
            elif _stays(solid, state[row], bins, rim, ground, largest, steps[row] * step):
                verdict[row] = STAYS
            elif _is_clear(solid, state[row], bins, rim, ground, step):
                step_free(state[row], objects.body[row], objects.wind[row], objects.air, step)
                steps[row] -= 1
            else:
                break
