"""Quick motions along the ellipse of Choe et al. 2023 from rest to rest, row by row in machine code.

With phi from 0 to pi the arc is x = l (1 - cos phi), y = h (1 - cos phi) + w sin phi, relative to its start; l, h and w
are half the width, half the rise and half the vertical chord through the middle. The curvature is -l w / g^3 with
g = |(x', y')|. The speed law along the arc has nine phases of constant jerk: from rest with little jerk as long as the
path is strongly curved, then with much jerk, a plateau of the acceleration, a decrease into the cruise, and the same
phases backwards. A search tries some laws, each slowed until it keeps all limits, then neighbours of the quickest law.
The result is a cubic spline through points of that motion, with constant jerk between the points, slowed until it keeps
its limits.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.paths.rows import Arc, Phase
from pnt_gym.rows import Floats2, Floats3, Rows1

PHASES = 9
CRUISE = 4
RUN_UP = 26
"""Pieces of constant jerk in the phases before the cruise, about even in time; a phase may be too short for a piece."""
CRUISING = 20
"""Pieces in the cruise, longest in its middle."""
PIECES = 2 * (RUN_UP + 3) + CRUISING
CELLS = 128
"""Cells of the table of arc lengths."""
SAMPLES = 10
"""Samples per phase of a law for the check of the limits, both ends included."""
FIRST = ((0.75, 0.45, 0.39), (0.45, 0.45, 0.95), (0.9, 0.3, 0.3))
"""First laws, as shares of the limits: acceleration of the plateau, acceleration at the knee, jerk below the knee."""
FINER = (0.25, 0.12, 0.06, 0.03)
"""Distances of the neighbours in each round of the search, in logarithms of a law's three numbers."""
INNER = 0.99
"""Jerk above the knee, as a share of the limit."""
HALVINGS = 48
NEWTON = 3
SHARES = 8
"""Samples of the speed per piece of the spline."""
GAUSS = ((-0.8611363115940526, 0.34785484513745385), (-0.33998104358485626, 0.6521451548625461),
         (0.33998104358485626, 0.6521451548625461), (0.8611363115940526, 0.34785484513745385))  # fmt: skip
"""Nodes and weights of the Gauss-Legendre rule of four points on [-1, 1]."""
PHASE = Phase.dtype


@kernel_part
def _pace(arc: Arc, phi: float) -> float:
    """Arc length per angle, g = |(x', y')| [m/rad]."""
    return math.hypot(arc.width * math.sin(phi), arc.rise * math.sin(phi) + arc.chord * math.cos(phi))


@kernel_part
def _way(arc: Arc, low: float, high: float) -> float:
    """Arc length [m] between two neighbouring angles, by Gauss-Legendre quadrature of `_pace`."""
    half, middle, total = 0.5 * (high - low), 0.5 * (high + low), 0.0
    for place, weight in GAUSS:
        total += weight * _pace(arc, middle + half * place)
    return half * total


@kernel_part
def _state_after(t: float, s: float, v: float, a: float, jerk: float) -> tuple[float, float, float]:
    """Way, speed and acceleration after a time of constant jerk."""
    return s + t * (v + t * (0.5 * a + t * jerk / 6.0)), v + t * (a + 0.5 * t * jerk), a + t * jerk


@kernel_part
def _run_up(speed: float, law: tuple[float, float, float, float]) -> tuple[float, float, float, float, float]:
    """Durations of the four phases from rest to a speed, and the way that the phases take.

    Args:
        speed: [m/s].
        law: plateau and knee of the acceleration, jerks below and above the knee.
    """
    plateau, knee, outer, inner = law
    knee = min(knee, plateau)
    # Square of the plateau that is reached for a moment only: k^2 / (2 outer) + (p^2 - k^2 + p^2) / (2 inner) = v.
    square = inner * (speed - 0.5 * knee**2 * (1.0 / outer - 1.0 / inner))
    if square < knee**2:
        # Much jerk is not reached on the rise: p^2 / (2 outer) + p^2 / (2 inner) = v.
        knee = plateau = math.sqrt(2.0 * speed * outer * inner / (outer + inner))
    else:
        plateau = min(plateau, math.sqrt(square))
    first, second, last = knee / outer, (plateau - knee) / inner, plateau / inner
    gained = 0.5 * knee * first + 0.5 * (knee + plateau) * second + 0.5 * plateau * last
    flat = max((speed - gained) / plateau, 0.0)
    s, v, a = _state_after(first, 0.0, 0.0, 0.0, outer)
    s, v, a = _state_after(second, s, v, a, inner)
    s, v, a = _state_after(flat, s, v, a, 0.0)
    s, v, a = _state_after(last, s, v, a, -inner)
    return first, second, flat, last, s


@kernel_part
def _write_law(length: float, arc: Arc, shares: tuple[float, float, float], phases: Rows1[Phase]) -> None:
    """Write the phases of a law; the last row holds the total time."""
    plateau, knee, below = shares
    law = (plateau * arc.acceleration, knee * arc.acceleration, below * arc.jerk, INNER * arc.jerk)
    speed = arc.velocity
    if 2.0 * _run_up(speed, law)[4] > length:
        # The arc is too short for the speed limit: bisection for the speed whose two run-ups fill the arc.
        low, high = 0.0, speed
        for _ in range(HALVINGS):
            speed = 0.5 * (low + high)
            if 2.0 * _run_up(speed, law)[4] > length:
                high = speed
            else:
                low = speed
    first, second, flat, last, way = _run_up(speed, law)
    cruise = max(length - 2.0 * way, 0.0) / speed
    durations = (first, second, flat, last, cruise, last, flat, second, first)
    outer, inner = law[2], law[3]
    jerks = (outer, inner, 0.0, -inner, 0.0, -inner, 0.0, inner, outer)
    start, s, v, a = 0.0, 0.0, 0.0, 0.0
    for k in range(PHASES):
        phase = phases[k]
        phase.start, phase.way, phase.speed, phase.acceleration, phase.jerk = start, s, v, a, jerks[k]
        start += durations[k]
        s, v, a = _state_after(durations[k], s, v, a, jerks[k])
    phases[PHASES].start = start


@kernel_part
def _moment(phases: Rows1[Phase], k: int, share: float) -> tuple[float, float, float, float]:
    """Way, speed, acceleration and jerk along the path at a share of a phase."""
    phase = phases[k]
    t = share * (phases[k + 1].start - phase.start)
    s, v, a = _state_after(t, phase.way, phase.speed, phase.acceleration, phase.jerk)
    return s, v, a, phase.jerk


@kernel_part
def _cell(ways: Floats, s: float, first: int) -> int:
    """Cell of the table that contains a way, searched for from a first cell on."""
    while first < CELLS - 1 and ways[first + 1] < s:
        first += 1
    return first


@kernel_part
def _angle(angles: Floats, ways: Floats, cell: int, s: float) -> float:
    """Approximate angle at a way, by linear interpolation within a cell."""
    return angles[cell] + (s - ways[cell]) / (ways[cell + 1] - ways[cell]) * (angles[cell + 1] - angles[cell])


@kernel_part
def _slowdown(arc: Arc, speed: float, acceleration: float, jerk: float) -> float:
    """Factor by which a motion with given peaks must be slowed to keep the limits of its arc.

    A motion that takes k times as long has peaks of speed, acceleration and jerk divided by k, k^2 and k^3.
    """
    return max(speed / arc.velocity, math.sqrt(acceleration / arc.acceleration), (jerk / arc.jerk) ** (1.0 / 3.0))


@kernel_part
def _law_slowdown(arc: Arc, phases: Rows1[Phase], angles: Floats, ways: Floats) -> float:
    """Factor by which a law must be slowed to keep its limits, from samples of all phases.

    With curvature c and its derivative c' by the way, the acceleration is (a, c v^2) along and across the path, and the
    jerk is (j - c^2 v^3, 3 c v a + c' v^3).
    """
    width, rise, chord = arc.width, arc.rise, arc.chord
    cell, speed, acceleration, jerk = 0, 0.0, 0.0, 0.0
    for i in range(PHASES * SAMPLES):
        s, v, a, third = _moment(phases, i // SAMPLES, (i % SAMPLES) / (SAMPLES - 1.0))
        cell = _cell(ways, s, cell)
        phi = _angle(angles, ways, cell, s)
        sin, cos = math.sin(phi), math.cos(phi)
        # x' = l sin phi, y' = h sin phi + w cos phi, c = -l w / g^3, and c' is dc / dphi over g.
        climb = rise * sin + chord * cos
        square = (width * sin) ** 2 + climb**2
        bend = -width * chord / (square * math.sqrt(square))
        slope = (
            3.0
            * width
            * chord
            * (width * sin * width * cos + climb * (rise * cos - chord * sin))
            / (square * square * square)
        )
        speed = max(speed, v)
        acceleration = max(acceleration, math.hypot(a, bend * v * v))
        jerk = max(jerk, math.hypot(third - bend * bend * v * v * v, 3.0 * bend * v * a + slope * v * v * v))
    return _slowdown(arc, speed, acceleration, jerk)


@kernel_part
def _write_quickest_law(arc: Arc, angles: Floats, ways: Floats, best: Rows1[Phase]) -> None:
    """Write the quickest law of the search, before the law is slowed to keep its limits."""
    trial, least, best_shares = empty_rows(PHASES + 1, PHASE), math.inf, (0.0, 0.0, 0.0)
    for level in range(len(FINER) + 1):
        middle = best_shares
        for i in range(len(FIRST) if level == 0 else 6):
            if level == 0:
                shares = FIRST[i]
            else:
                # Neighbours of a law: each of its three numbers less and more.
                by = math.exp(FINER[level - 1] * (2.0 * (i % 2) - 1.0))
                plateau, knee, outer = middle
                shares = (
                    plateau * by if i < 2 else plateau,
                    knee * by if 2 <= i < 4 else knee,
                    min(outer * by, 1.0) if i >= 4 else outer,
                )
            _write_law(ways[CELLS], arc, shares, trial)
            needed = trial[PHASES].start * _law_slowdown(arc, trial, angles, ways)
            if needed < least:
                least, best_shares = needed, shares
                best[:] = trial


@kernel_part
def _write_points(arc: Arc, phases: Rows1[Phase], angles: Floats, ways: Floats, points: Floats, steps: Floats) -> int:
    """Write points (2, PIECES + 1) of the motion and the times between the points; return the number of times."""
    width, rise, chord, run_up = arc.width, arc.rise, arc.chord, phases[CRUISE].start
    cell, n, last_time = 0, 0, 0.0
    points[0, 0] = points[1, 0] = 0.0
    for k in range(PHASES):
        start = phases[k].start
        duration = phases[k + 1].start - start
        count = CRUISING if k == CRUISE else int(RUN_UP * duration / run_up + 0.5)
        if k == CRUISE and duration < run_up / RUN_UP:
            count = 0
        for i in range(1, count + 1):
            share = 0.5 * (1.0 - math.cos(math.pi * i / count)) if k == CRUISE else i / count
            s = _moment(phases, k, share)[0]
            cell = _cell(ways, s, cell)
            phi = _angle(angles, ways, cell, s)
            for _ in range(NEWTON):
                # Newton's method: the arc length's derivative by the angle is the pace.
                phi += (s - ways[cell] - _way(arc, angles[cell], phi)) / _pace(arc, phi)
            time = start + share * duration
            steps[n], last_time = time - last_time, time
            n += 1
            points[0, n] = width * (1.0 - math.cos(phi))
            points[1, n] = rise * (1.0 - math.cos(phi)) + chord * math.sin(phi)
    points[0, n], points[1, n] = 2.0 * width, 2.0 * rise
    return n


@kernel_part
def _write_second_derivatives(x: Floats, steps: Floats, n: int, out: Floats) -> None:
    """Second derivatives of the cubic spline through points with given times between the points, at rest at both ends.

    Rest adds two conditions at the ends, so the spline does not pass through the second point and the last but one.
    The tridiagonal equations are solved by elimination and back substitution (Thomas algorithm).
    """
    above = np.empty(n + 1)
    out[0] = out[n] = above[0] = 0.0
    for k in range(1, n):
        near, far = steps[k - 1], steps[k]
        # Rest at the start gives x[1] = x[0] + steps[0]^2 out[1] / 6, and the end likewise; both replace given points.
        before = x[0] if k == 2 else x[k - 1]
        after = x[n] if k == n - 2 else x[k + 1]
        lower, middle, upper = near, 2.0 * (near + far), far
        right_side = 6.0 * ((after - x[k]) / far - (x[k] - before) / near)
        if k == 1:
            middle, right_side = middle + near * near / far + near, 6.0 * (x[2] - x[0]) / far
        if k == 2:
            lower -= steps[0] * steps[0] / near
        if k == n - 2:
            upper -= steps[n - 1] * steps[n - 1] / far
        if k == n - 1:
            middle, right_side = middle + far * far / near + far, 6.0 * (x[n - 2] - x[n]) / near
        pivot = middle - lower * above[k - 1]
        above[k] = upper / pivot
        out[k] = (right_side - lower * out[k - 1]) / pivot
    for k in range(n - 2, 0, -1):
        out[k] -= above[k] * out[k + 1]


@kernel_part
def _spline_slowdown(arc: Arc, accelerations: Floats, steps: Floats, n: int) -> float:
    """Factor by which the spline with second derivatives (2, n + 1) must be slowed to keep its limits."""
    vx, vy, speed, acceleration, jerk, room = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(n):
        step, ax, ay, bx, by = (
            steps[k],
            accelerations[0, k],
            accelerations[1, k],
            accelerations[0, k + 1],
            accelerations[1, k + 1],
        )
        third = math.hypot(bx - ax, by - ay) / step
        jerk, acceleration = max(jerk, third), max(acceleration, math.hypot(bx, by))
        # Between two samples |v| exceeds both by at most |j| (dt)^2 / 8.
        room = third * (step / SHARES) ** 2 / 8.0
        for i in range(1, SHARES + 1):
            t, share = step * i / SHARES, 0.5 * i / SHARES
            fast = math.hypot(vx + t * (ax + share * (bx - ax)), vy + t * (ay + share * (by - ay)))
            speed = max(speed, fast + room)
        vx, vy = vx + 0.5 * step * (ax + bx), vy + 0.5 * step * (ay + by)
    return _slowdown(arc, speed, acceleration, jerk)


@kernel
def arc_segments(arcs: Rows1[Arc], steps: Floats2, accelerations: Floats3) -> None:
    """Compute the motions over N arcs.

    Args:
        arcs: the arcs.
        steps: durations of each arc's pieces (N, PIECES) [s], written; 0 for pieces that are not needed.
        accelerations: to the side and up, at the borders of the pieces (N, 2, PIECES + 1) [m/s2], written.
    """
    angles, ways, points = np.empty(CELLS + 1), np.empty(CELLS + 1), np.empty((2, PIECES + 1))
    law = empty_rows(PHASES + 1, PHASE)
    for row in range(len(arcs)):
        arc = arcs[row]
        # The table has angles, densest at both ends, and the arc lengths up to the angles.
        angles[0] = ways[0] = 0.0
        for i in range(1, CELLS + 1):
            angles[i] = 0.5 * math.pi * (1.0 - math.cos(math.pi * i / CELLS))
            ways[i] = ways[i - 1] + _way(arc, angles[i - 1], angles[i])
        _write_quickest_law(arc, angles, ways, law)
        steps[row], accelerations[row] = 0.0, 0.0
        n = _write_points(arc, law, angles, ways, points, steps[row])
        _write_second_derivatives(points[0], steps[row], n, accelerations[row, 0])
        _write_second_derivatives(points[1], steps[row], n, accelerations[row, 1])
        factor = _spline_slowdown(arc, accelerations[row], steps[row], n) * (1.0 + 1e-9)
        steps[row] *= factor
        accelerations[row] /= factor * factor
