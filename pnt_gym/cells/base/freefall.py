"""Compiled motion of objects in the air, free or swinging under a hand: MuJoCo's fluid model and its Euler steps.

The forces are those of MuJoCo's manual (computation, fluid forces, ellipsoid model) without added mass times
acceleration, which the engine leaves out too. Velocities are stepped before positions, as in the engine, so a flight
equals the engine's to rounding, and a test compares the two. A swinging object is a rigid body on a pivot: its motion
equals the engine's as far as the engine's constraints are rigid.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.airborne import Airborne, Body, Carrying, Hanging, Pivot
from pnt_gym.cells.base.bodies import turned_back
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import AIR_DENSITY, AIR_VISCOSITY, GRAVITY
from pnt_gym.rows import Floats1, Floats2, Floats3, Ints1

Vector: TypeAlias = tuple[float, float, float]
Attitude: TypeAlias = tuple[float, float, float, float]


@kernel_part
def _vector(numbers: Floats, first: int = 0) -> Vector:
    """Three numbers of an array from one on."""
    return numbers[first], numbers[first + 1], numbers[first + 2]


@kernel_part
def _quaternion(numbers: Floats, first: int = 0) -> Attitude:
    """Four numbers of an array from one on."""
    return numbers[first], numbers[first + 1], numbers[first + 2], numbers[first + 3]


@kernel_part
def _inverse(turn: Attitude) -> Attitude:
    return turn[0], -turn[1], -turn[2], -turn[3]


@kernel_part
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel_part
def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel_part
def _add(a: Vector, scale: float, b: Vector) -> Vector:
    """The vector a + scale b."""
    return a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]


@kernel_part
def _add_cross(c: Vector, a: Vector, b: Vector) -> Vector:
    """The vector c + a x b."""
    return (
        c[0] + a[1] * b[2] - a[2] * b[1],
        c[1] + a[2] * b[0] - a[0] * b[2],
        c[2] + a[0] * b[1] - a[1] * b[0],
    )


@kernel_part
def _rotate(turn: Attitude, v: Vector) -> Vector:
    """A vector turned by a unit quaternion."""
    axis = turn[1], turn[2], turn[3]
    p, q, r = _cross(axis, v)
    twice = 2.0 * p, 2.0 * q, 2.0 * r
    return _add_cross(_add(v, turn[0], twice), axis, twice)


@kernel_part
def _geom_air_force(body: Body, air: float, v: Vector, w: Vector) -> tuple[Vector, Vector]:
    """Air force [N] and torque [N m] on a geom with a velocity and an angular velocity, all in the geom's axes."""
    rx, ry, rz = _vector(body.semi_axes)
    density, viscosity = air * AIR_DENSITY, air * AIR_VISCOSITY
    speed = math.sqrt(_dot(v, v))
    # Added mass and inertia: momentum of the air that moves with the body.
    mass, inertia = body.virtual_mass, body.virtual_inertia
    p = density * mass[0] * v[0], density * mass[1] * v[1], density * mass[2] * v[2]
    spin = density * inertia[0] * w[0], density * inertia[1] * w[1], density * inertia[2] * w[2]
    force, torque = _cross(p, w), _add_cross(_cross(p, v), spin, w)
    # Magnus lift.
    lift = body.magnus * density * (4.0 / 3.0 * math.pi) * rx * ry * rz
    force = _add(force, lift, _cross(w, v))
    # Kutta lift, by the ellipsoid's area across the flow.
    largest, smallest = max(rx, ry, rz), min(rx, ry, rz)
    widest = math.pi * largest * (rx + ry + rz - largest - smallest)
    n = (ry * rz) ** 2 * v[0], (rz * rx) ** 2 * v[1], (rx * ry) ** 2 * v[2]
    along, normal = _dot(n, v), _dot(n, n)
    met = 0.0
    if along > 1e-40:
        met = math.pi * math.sqrt(normal / along)
        share = body.kutta * density * met * along / (speed * normal)
        force = _add(force, share, _cross(_cross(n, v), v))
    # Viscous drag of a sphere of the mean diameter (Stokes), and pressure drag of the area across and along the flow.
    ball = 2.0 / 3.0 * (rx + ry + rz)
    drag = 3.0 * math.pi * viscosity * ball + density * speed * (body.blunt * met + body.slender * (widest - met))
    # Drag against rotation, by the areas' moments.
    ix = 8.0 / 15.0 * math.pi * rx * max(ry, rz) ** 4
    iy = 8.0 / 15.0 * math.pi * ry * max(rz, rx) ** 4
    iz = 8.0 / 15.0 * math.pi * rz * max(rx, ry) ** 4
    top = max(ix, iy, iz)
    t = (
        w[0] * (body.angular * ix + body.slender * (top - ix)),
        w[1] * (body.angular * iy + body.slender * (top - iy)),
        w[2] * (body.angular * iz + body.slender * (top - iz)),
    )
    turn = math.pi * viscosity * ball**3 + density * math.sqrt(_dot(t, t))
    return _add(force, -drag, v), _add(torque, -turn, w)


@kernel_part
def _body_air_force(body: Body, air: float, v: Vector, rate: Vector) -> tuple[Vector, Vector]:
    """Air force [N] and torque [N m] about the centre of mass of an object with velocities, all in the body's axes."""
    turn, up = _quaternion(body.attitude), body.height
    # Velocity of the geom's middle, in the body's axes and then in the geom's.
    middle = _rotate(_inverse(turn), (v[0] + rate[1] * up, v[1] - rate[0] * up, v[2]))
    force, torque = _geom_air_force(body, air, middle, _rotate(_inverse(turn), rate))
    force, torque = _rotate(turn, force), _rotate(turn, torque)
    return force, (torque[0] - up * force[1], torque[1] + up * force[0], torque[2])


@kernel_part
def step_free(state: Floats, body: Body, wind: Floats, air: float, step: float) -> None:
    """Advance the state of a free object in a wind (2,) by one Euler step, in place."""
    turn, rate = _quaternion(state, 3), _vector(state, 10)
    velocity = _rotate(_inverse(turn), (state[7] - wind[0], state[8] - wind[1], state[9]))
    force, torque = _body_air_force(body, air, velocity, rate)
    # Euler's equations about the centre of mass.
    ix, iy, iz = _vector(body.inertia)
    state[10] = rate[0] + step * (torque[0] - rate[1] * rate[2] * (iz - iy)) / ix
    state[11] = rate[1] + step * (torque[1] - rate[2] * rate[0] * (ix - iz)) / iy
    state[12] = rate[2] + step * (torque[2] - rate[0] * rate[1] * (iy - ix)) / iz
    force = _rotate(turn, force)
    state[7] += step * force[0] / body.mass
    state[8] += step * force[1] / body.mass
    state[9] += step * (force[2] / body.mass - GRAVITY)
    for axis in range(3):
        state[axis] += step * state[7 + axis]
    _turn(state, step)


@kernel_part
def _turn(state: Floats, step: float) -> None:
    """Turn an object's attitude by its angular velocity for one step, in place."""
    w, x, y, z = state[3], state[4], state[5], state[6]
    ox, oy, oz = state[10], state[11], state[12]
    rate = math.sqrt(ox * ox + oy * oy + oz * oz)
    if rate > 0.0:
        half = 0.5 * step * rate
        sine, co = math.sin(half) / rate, math.cos(half)
        # The attitude times the quaternion of the turn, whose size rounding changes.
        p, q, r = sine * ox, sine * oy, sine * oz
        state[3], state[4], state[5], state[6] = (
            w * co - x * p - y * q - z * r,
            w * p + x * co + y * r - z * q,
            w * q + y * co + z * p - x * r,
            w * r + z * co + x * q - y * p,
        )
        size = 1.0 / math.sqrt(state[3] ** 2 + state[4] ** 2 + state[5] ** 2 + state[6] ** 2)
        for k in range(3, 7):
            state[k] *= size


@kernel
def fly_down(
    state: Floats2, objects: Airborne, floor: Floats1, step: float, stride: int, records: Floats3, steps: Ints1
) -> None:
    """Simulate N free objects until each is below a height and sinks, in place.

    Args:
        state: states (N, STATE); at the end those just below the objects' heights.
        objects: the objects.
        floor: the heights (N,) [m].
        step: length of a physics step [s].
        stride: steps between two records.
        records: filled with the states every `stride` steps from the first on, and then with the last one
            (N, K, STATE); a flight ends after (K - 1) `stride` steps at the latest.
        steps: filled with the number of steps of each flight (N,).
    """
    for row in range(state.shape[0]):
        object_state, last = state[row], (records.shape[1] - 1) * stride
        count = 0
        while count < last and not (object_state[2] < floor[row] and object_state[9] < 0.0):
            if count % stride == 0:
                records[row, count // stride] = object_state
            step_free(object_state, objects.body[row], objects.wind[row], objects.air, step)
            count += 1
        steps[row] = count
        for k in range((count + stride - 1) // stride, records.shape[1]):
            records[row, k] = object_state


@kernel
def end_settled(
    sensors: Floats3, rate: Floats2, rows: Ints1, spin: Floats2, rim: Floats1, end: int, last_steps: Ints1
) -> None:
    """End the falls of objects with too little energy to rise to their rims, in place.

    Args:
        sensors: position and velocity of some objects in the first six columns of several moments, the last of which
            counts (M, K, 6+).
        rate: their angular velocities (M, 3) [rad/s].
        rows: these objects among all N (M,).
        spin: inertia over mass of all objects (N, 3) [m2].
        rim: heights of the rims (N,) [m].
        end: the present step.
        last_steps: last step of each object (N,); not later than the present step where the object has settled.
    """
    for k in range(rows.size):
        row, moment = rows[k], sensors[k, sensors.shape[1] - 1]
        x, y, z = moment[3], moment[4], moment[5]
        turning = 0.0
        for axis in range(3):
            turning += spin[row, axis] * (rate[k, axis] * rate[k, axis])
        # z + (v^2 + I w^2 / m) / (2 g): energy over weight.
        if moment[2] + (x * x + y * y + z * z + turning) / (2.0 * GRAVITY) < rim[row]:
            last_steps[row] = min(last_steps[row], end)


@kernel_part
def _step_swing(
    state: Floats, body: Body, pivot: Pivot, air: float, step: float, acceleration: Vector, velocity: Vector
) -> None:
    """Advance an object that swings under a hand by one step, in place.

    Attitude, acceleration of the hand, and velocity of the hand against the air are in the axes in which the object
    hung at rest.
    """
    turn, rate, arm, mass = _quaternion(state, 3), _vector(state, 10), _vector(pivot.arm), body.mass
    w, x, y, z = turn
    rx, ry, rz = arm
    ax, ay, az = acceleration
    # The lip as a spring and damper: rotation vector and angular velocity in the axes of the hand.
    sine = math.sqrt(x * x + y * y + z * z)
    angle = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
    turning = _rotate(turn, rate)
    stiffness, damping = pivot.stiffness, pivot.damping
    spring = (
        -stiffness[0] * angle * x - damping[0] * turning[0],
        -stiffness[1] * angle * y - damping[1] * turning[1],
        -stiffness[2] * angle * z - damping[2] * turning[2],
    )
    torque = _rotate(_inverse(turn), spring)
    # Air, weight and inertia at the centre of mass.
    velocity = _add_cross(_rotate(_inverse(turn), velocity), rate, arm)
    force, moment = _body_air_force(body, air, velocity, rate)
    force = _add(force, -mass, _rotate(_inverse(turn), (ax, ay, az + GRAVITY)))
    torque = _add_cross(_add(torque, 1.0, moment), arm, force)
    # Inertia about the pivot, and Euler's equations there.
    ix, iy, iz = _vector(body.inertia)
    xx, yy, zz = ix + mass * (ry * ry + rz * rz), iy + mass * (rz * rz + rx * rx), iz + mass * (rx * rx + ry * ry)
    xy, yz, zx = -mass * rx * ry, -mass * ry * rz, -mass * rz * rx
    spin = _dot((xx, xy, zx), rate), _dot((xy, yy, yz), rate), _dot((zx, yz, zz), rate)
    torque = (
        torque[0] - rate[1] * spin[2] + rate[2] * spin[1],
        torque[1] - rate[2] * spin[0] + rate[0] * spin[2],
        torque[2] - rate[0] * spin[1] + rate[1] * spin[0],
    )
    cxx, cyy, czz = yy * zz - yz * yz, zz * xx - zx * zx, xx * yy - xy * xy
    cxy, cyz, czx = yz * zx - xy * zz, zx * xy - yz * xx, xy * yz - zx * yy
    share = step / (xx * cxx + xy * cxy + zx * czx)
    state[10] = rate[0] + share * _dot((cxx, cxy, czx), torque)
    state[11] = rate[1] + share * _dot((cxy, cyy, cyz), torque)
    state[12] = rate[2] + share * _dot((czx, cyz, czz), torque)
    _turn(state, step)


@kernel
def swing_down(
    state: Floats2, objects: Hanging, hands: Carrying, steps: Ints1, step: float, stride: int, records: Floats3
) -> None:
    """Simulate N objects that swing under their hands until each is released, in place.

    Args:
        state: states (N, STATE); only attitude and angular velocity are read and changed.
        objects: the objects and the lips of their cups.
        hands: motions of the hands at the beginnings of K steps.
        steps: number of steps until each object's release (N,), at most K.
        step: length of a physics step [s].
        stride: steps between two records.
        records: filled with the attitudes every `stride` steps from the first on, and then with the last one (N, L, 4).
    """
    for row in range(state.shape[0]):
        object_state, wind, cosine, sine = state[row], hands.wind[row], hands.cosine[row], hands.sine[row]
        for k in range(steps[row]):
            if k % stride == 0:
                records[row, k // stride] = object_state[3:7]
            (x, y, z), (p, q, r) = _vector(hands.acceleration[row, k]), _vector(hands.velocity[row, k])
            (x, y), (p, q) = turned_back(x, y, cosine, sine), turned_back(p - wind[0], q - wind[1], cosine, sine)
            _step_swing(object_state, objects.body[row], objects.pivot[row], objects.air, step, (x, y, z), (p, q, r))
        for k in range((steps[row] + stride - 1) // stride, records.shape[1]):
            records[row, k] = object_state[3:7]
