"""Compiled motion of objects in the air, free or swinging under a hand: MuJoCo's fluid model and its Euler steps.

The forces are those of MuJoCo's manual (computation, fluid forces, ellipsoid model) without added mass times
acceleration, which the engine leaves out too. Velocities are stepped before positions, as in the engine, so a flight
equals the engine's to rounding, and a test compares the two. A swinging object is a rigid body on a pivot: its motion
equals the engine's as far as the engine's constraints are rigid.
"""

from __future__ import annotations

import math

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import AIR_DENSITY, AIR_VISCOSITY, GRAVITY

STATE = 13
"""Numbers in a state: position [m] (3), attitude (4, w first), world velocity [m/s] (3), body angular velocity [rad/s]
(3)."""
BODY = 24
"""Numbers of a body: mass [kg], inertia [kg m2] (3), height of the geom in the body [m], and the geom's attitude (4),
semi-axes [m] (3) and `geom_fluid` (12)."""


@kernel_part
def _rotate(w: float, x: float, y: float, z: float, a: float, b: float, c: float) -> tuple[float, float, float]:
    """A vector (a, b, c) turned by a unit quaternion."""
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return a + w * p + y * r - z * q, b + w * q + z * p - x * r, c + w * r + x * q - y * p


@kernel_part
def _geom_air_force(
    body: Floats, air: float, vx: float, vy: float, vz: float, wx: float, wy: float, wz: float
) -> tuple[float, float, float, float, float, float]:
    """Air force [N] and torque [N m] on a geom with a velocity and an angular velocity, all in the geom's axes."""
    rx, ry, rz = body[9], body[10], body[11]
    density, viscosity = air * AIR_DENSITY, air * AIR_VISCOSITY
    blunt, slender, angular, kutta, magnus = body[13], body[14], body[15], body[16], body[17]
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    # Added mass and inertia: momentum of the air that moves with the body.
    px, py, pz = density * body[18] * vx, density * body[19] * vy, density * body[20] * vz
    lx, ly, lz = density * body[21] * wx, density * body[22] * wy, density * body[23] * wz
    fx, fy, fz = py * wz - pz * wy, pz * wx - px * wz, px * wy - py * wx
    gx = py * vz - pz * vy + ly * wz - lz * wy
    gy = pz * vx - px * vz + lz * wx - lx * wz
    gz = px * vy - py * vx + lx * wy - ly * wx
    # Magnus lift.
    lift = magnus * density * (4.0 / 3.0 * math.pi) * rx * ry * rz
    fx += lift * (wy * vz - wz * vy)
    fy += lift * (wz * vx - wx * vz)
    fz += lift * (wx * vy - wy * vx)
    # Kutta lift, by the ellipsoid's area across the flow.
    largest, smallest = max(rx, ry, rz), min(rx, ry, rz)
    widest = math.pi * largest * (rx + ry + rz - largest - smallest)
    nx, ny, nz = (ry * rz) ** 2 * vx, (rz * rx) ** 2 * vy, (rx * ry) ** 2 * vz
    along = nx * vx + ny * vy + nz * vz
    normal = nx * nx + ny * ny + nz * nz
    met = 0.0
    if along > 1e-40:
        met = math.pi * math.sqrt(normal / along)
        share = kutta * density * met * along / (speed * normal)
        cx, cy, cz = ny * vz - nz * vy, nz * vx - nx * vz, nx * vy - ny * vx
        fx += share * (cy * vz - cz * vy)
        fy += share * (cz * vx - cx * vz)
        fz += share * (cx * vy - cy * vx)
    # Viscous drag of a sphere of the mean diameter (Stokes), and pressure drag of the area across and along the flow.
    ball = 2.0 / 3.0 * (rx + ry + rz)
    drag = 3.0 * math.pi * viscosity * ball + density * speed * (blunt * met + slender * (widest - met))
    # Drag against rotation, by the areas' moments.
    ix = 8.0 / 15.0 * math.pi * rx * max(ry, rz) ** 4
    iy = 8.0 / 15.0 * math.pi * ry * max(rz, rx) ** 4
    iz = 8.0 / 15.0 * math.pi * rz * max(rx, ry) ** 4
    top = max(ix, iy, iz)
    tx = wx * (angular * ix + slender * (top - ix))
    ty = wy * (angular * iy + slender * (top - iy))
    tz = wz * (angular * iz + slender * (top - iz))
    turn = math.pi * viscosity * ball**3 + density * math.sqrt(tx * tx + ty * ty + tz * tz)
    return fx - drag * vx, fy - drag * vy, fz - drag * vz, gx - turn * wx, gy - turn * wy, gz - turn * wz


@kernel_part
def _body_air_force(
    body: Floats, air: float, vx: float, vy: float, vz: float, ox: float, oy: float, oz: float
) -> tuple[float, float, float, float, float, float]:
    """Air force [N] and torque [N m] about the centre of mass of an object with velocities, all in the body's axes."""
    a, b, c, d, up = body[5], body[6], body[7], body[8], body[4]
    # Velocity of the geom's middle, in the body's axes and then in the geom's.
    ux, uy, uz = _rotate(a, -b, -c, -d, vx + oy * up, vy - ox * up, vz)
    rx, ry, rz = _rotate(a, -b, -c, -d, ox, oy, oz)
    fx, fy, fz, gx, gy, gz = _geom_air_force(body, air, ux, uy, uz, rx, ry, rz)
    fx, fy, fz = _rotate(a, b, c, d, fx, fy, fz)
    gx, gy, gz = _rotate(a, b, c, d, gx, gy, gz)
    return fx, fy, fz, gx - up * fy, gy + up * fx, gz


@kernel_part
def step_free(state: Floats, body: Floats, wind: Floats, air: float, step: float) -> None:
    """Advance the state of a free object in a wind (2,) by one Euler step, in place."""
    w, x, y, z = state[3], state[4], state[5], state[6]
    mass, ix, iy, iz = body[0], body[1], body[2], body[3]
    ox, oy, oz = state[10], state[11], state[12]
    vx, vy, vz = _rotate(w, -x, -y, -z, state[7] - wind[0], state[8] - wind[1], state[9])
    fx, fy, fz, gx, gy, gz = _body_air_force(body, air, vx, vy, vz, ox, oy, oz)
    # Euler's equations about the centre of mass.
    ox, oy, oz = (
        ox + step * (gx - oy * oz * (iz - iy)) / ix,
        oy + step * (gy - oz * ox * (ix - iz)) / iy,
        oz + step * (gz - ox * oy * (iy - ix)) / iz,
    )
    fx, fy, fz = _rotate(w, x, y, z, fx, fy, fz)
    state[7] += step * fx / mass
    state[8] += step * fy / mass
    state[9] += step * (fz / mass - GRAVITY)
    state[10], state[11], state[12] = ox, oy, oz
    state[0] += step * state[7]
    state[1] += step * state[8]
    state[2] += step * state[9]
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


@compile_for(
    "void(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1], float64, float64, int64,"
    "float64[:, :, ::1], int64[::1])"
)
def fly_down(
    state: Floats,
    body: Floats,
    wind: Floats,
    floor: Floats,
    air: float,
    step: float,
    stride: int,
    records: Floats,
    steps: Ints,
) -> None:
    """Simulate free objects until each is below a height and sinks, in place.

    Args:
        state: states of N objects (N, STATE); at the end those just below the objects' heights.
        body: constants of the objects (N, BODY).
        wind: horizontal velocity of the air around each object (N, 2) [m/s].
        floor: the heights (N,) [m].
        air: share of the air's density and viscosity.
        step: length of a physics step [s].
        stride: steps between two records.
        records: filled with the objects' states every `stride` steps from the first state on, and then with the last
            state (N, K, STATE); a flight ends after (K - 1) `stride` steps at the latest.
        steps: filled with the number of steps of each flight (N,).
    """
    for row in range(state.shape[0]):
        object_state, last = state[row], (records.shape[1] - 1) * stride
        count = 0
        while count < last and not (object_state[2] < floor[row] and object_state[9] < 0.0):
            if count % stride == 0:
                records[row, count // stride] = object_state
            step_free(object_state, body[row], wind[row], air, step)
            count += 1
        steps[row] = count
        for k in range((count + stride - 1) // stride, records.shape[1]):
            records[row, k] = object_state


@compile_for(
    "void(float64[:, :, ::1], float64[:, :], int64[::1], int64[::1], float64[:, ::1], float64[:], int64, int64[::1])"
)
def end_settled(
    sensors: Floats, qvel: Floats, simulations: Ints, rows: Ints, spin: Floats, rim: Floats, end: int, last_steps: Ints
) -> None:
    """End the falls of objects with too little energy to rise to their rims, in place.

    Args:
        sensors: position and velocity of some objects in the first six columns of several moments, the last of which
            counts (M, K, 6+).
        qvel: velocities of all simulations, the object's angular velocity in columns 3 to 5 (S, 6+).
        simulations: simulations of all N objects (N,).
        rows: these objects among the N (M,).
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
            rate = qvel[simulations[row], 3 + axis]
            turning += spin[row, axis] * (rate * rate)
        # z + (v^2 + I w^2 / m) / (2 g): energy over weight.
        if moment[2] + (x * x + y * y + z * z + turning) / (2.0 * GRAVITY) < rim[row]:
            last_steps[row] = min(last_steps[row], end)


@kernel_part
def _step_swing(state: Floats, body: Floats, pivot: Floats, air: float, step: float, hand: Floats) -> None:
    """Advance an object that swings under a hand with an acceleration and a velocity (6,) by one step, in place.

    Attitude, acceleration and velocity are in the axes in which the object hung at rest.
    """
    w, x, y, z = state[3], state[4], state[5], state[6]
    ox, oy, oz = state[10], state[11], state[12]
    rx, ry, rz = pivot[0], pivot[1], pivot[2]
    mass, ix, iy, iz = body[0], body[1], body[2], body[3]
    # The lip as a spring and damper: rotation vector and angular velocity in the axes of the hand.
    sine = math.sqrt(x * x + y * y + z * z)
    angle = 2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0
    px, py, pz = _rotate(w, x, y, z, ox, oy, oz)
    tx = -pivot[3] * angle * x - pivot[6] * px
    ty = -pivot[4] * angle * y - pivot[7] * py
    tz = -pivot[5] * angle * z - pivot[8] * pz
    tx, ty, tz = _rotate(w, -x, -y, -z, tx, ty, tz)
    # Air, weight and inertia at the centre of mass.
    vx, vy, vz = _rotate(w, -x, -y, -z, hand[3], hand[4], hand[5])
    vx, vy, vz = vx + oy * rz - oz * ry, vy + oz * rx - ox * rz, vz + ox * ry - oy * rx
    fx, fy, fz, gx, gy, gz = _body_air_force(body, air, vx, vy, vz, ox, oy, oz)
    ax, ay, az = _rotate(w, -x, -y, -z, hand[0], hand[1], hand[2] + GRAVITY)
    fx, fy, fz = fx - mass * ax, fy - mass * ay, fz - mass * az
    tx, ty, tz = tx + gx + ry * fz - rz * fy, ty + gy + rz * fx - rx * fz, tz + gz + rx * fy - ry * fx
    # Inertia about the pivot, and Euler's equations there.
    xx, yy, zz = ix + mass * (ry * ry + rz * rz), iy + mass * (rz * rz + rx * rx), iz + mass * (rx * rx + ry * ry)
    xy, yz, zx = -mass * rx * ry, -mass * ry * rz, -mass * rz * rx
    lx, ly, lz = xx * ox + xy * oy + zx * oz, xy * ox + yy * oy + yz * oz, zx * ox + yz * oy + zz * oz
    tx, ty, tz = tx - oy * lz + oz * ly, ty - oz * lx + ox * lz, tz - ox * ly + oy * lx
    cxx, cyy, czz = yy * zz - yz * yz, zz * xx - zx * zx, xx * yy - xy * xy
    cxy, cyz, czx = yz * zx - xy * zz, zx * xy - yz * xx, xy * yz - zx * yy
    share = step / (xx * cxx + xy * cxy + zx * czx)
    state[10] = ox + share * (cxx * tx + cxy * ty + czx * tz)
    state[11] = oy + share * (cxy * tx + cyy * ty + cyz * tz)
    state[12] = oz + share * (czx * tx + cyz * ty + czz * tz)
    _turn(state, step)


@compile_for(
    "void(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64, float64, float64[:, :, ::1], int64[::1],"
    "int64, float64[:, :, ::1])"
)
def swing_down(
    state: Floats,
    body: Floats,
    pivot: Floats,
    air: float,
    step: float,
    hand: Floats,
    steps: Ints,
    stride: int,
    records: Floats,
) -> None:
    """Simulate objects that swing under their hands until each is released, in place.

    Args:
        state: states of N objects (N, STATE); only attitude and angular velocity are read and changed.
        body: constants of the objects (N, BODY).
        pivot: centre of mass from the lip in the object's axes [m], stiffness [N m/rad] and damping [N m s/rad] of the
            lip about each of the axes in which the object hangs at rest (N, 9).
        air: share of the air's density and viscosity.
        step: length of a physics step [s].
        hand: acceleration [m/s2] of the hand and velocity [m/s] of the hand against the air at the beginning of each
            step, in the axes in which the object hangs at rest (N, K, 6).
        steps: number of steps until each object's release (N,), at most K.
        stride: steps between two records.
        records: filled with the attitudes every `stride` steps from the first on, and then with the last one (N, L, 4).
    """
    for row in range(state.shape[0]):
        object_state = state[row]
        for k in range(steps[row]):
            if k % stride == 0:
                records[row, k // stride] = object_state[3:7]
            _step_swing(object_state, body[row], pivot[row], air, step, hand[row, k])
        for k in range((steps[row] + stride - 1) // stride, records.shape[1]):
            records[row, k] = object_state[3:7]
