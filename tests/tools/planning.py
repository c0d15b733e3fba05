"""Independent ways to the same numbers: the algorithm as printed, and brute force over the elevation."""

import numpy as np
from ruckig import InputParameter, Result, Ruckig, Trajectory

GRAVITY = 9.81
SOLVER = Ruckig(1)


def printed_algorithm(p, v_max, a_max, j):
    """Algorithm 1 of Hassan et al. 2022 as printed, one stroke at a time: V and A."""
    if j**2 * p <= 2 * a_max**3:
        if j * p**2 <= 4 * v_max**3:
            return (j * p**2 / 4) ** (1 / 3), (j**2 * p / 2) ** (1 / 3)
        return v_max, (j * v_max) ** 0.5
    if (j * v_max) ** 0.5 <= a_max:
        return v_max, (j * v_max) ** 0.5
    v = (-(a_max**2) + (a_max**4 + 4 * j**2 * p * a_max) ** 0.5) / (2 * j)
    return min(v, v_max), a_max


def travel_time(distance, velocity, acceleration, jerk):
    """Time from rest to rest over a distance, by another implementation."""
    if distance == 0.0:
        return 0.0
    request, trajectory = InputParameter(1), Trajectory(1)
    request.target_position = [distance]
    request.max_velocity, request.max_acceleration, request.max_jerk = [velocity], [acceleration], [jerk]
    assert SOLVER.calculate(request, trajectory) == Result.Working
    return trajectory.duration


def half_stroke(p, limits, root=None):
    """Speed at p and time to p when the stroke is 2p, from the smallest peak any limit allows; arrays."""
    v_max, a_max, j = limits
    stroke = 2 * p
    root = np.cbrt(p) if root is None else root
    a = np.minimum(np.cbrt(j * j) * root, np.minimum(np.sqrt(j * v_max), a_max))
    # Speed if the stroke had no cruise: P = V (V / A + A / J).
    v = np.minimum((-a * a + np.sqrt(a * a * a * a + 4 * j * j * stroke * a)) / (2 * j), v_max)
    return v, 0.5 * (stroke / v + v / a + a / j)


def brute_force(reach, rise, limits, *, ceiling=np.inf, nodes=500, rounds=4):
    """Least time to releases that hit (reach, rise) with z <= ceiling: grid of elevations, then zoom.

    At every elevation the release distance is bisected on "released here, does the object fly too far?", with
    the flight taken from the equations of motion. All arguments are numbers or (N,). Returns time, distance,
    speed and elevation, each (N,); infinite time where there is no such release.
    """
    columns = np.broadcast_arrays(*np.atleast_1d(reach, rise, *limits, ceiling))
    blocks = [tuple(c[k : k + 25, None] for c in columns) for k in range(0, columns[0].size, 25)]
    return np.concatenate([_zoom(*block, nodes=nodes, rounds=rounds) for block in blocks], axis=1)


def _zoom(reach, rise, v_max, a_max, j, ceiling, *, nodes, rounds):
    low, high = np.arctan2(rise, reach), 0.5 * np.pi
    theta = low + (high - low) * (np.arange(nodes) + 0.5) / nodes
    best = np.full((4, reach.size), np.nan)
    best[0] = np.inf
    for turn in range(rounds):
        distance, speed, time = _at_elevations(theta, reach, rise, (v_max, a_max, j), 50 if turn else 36)
        kept = (distance * np.sin(theta) <= ceiling) & (theta > low) & (theta < high)
        time = np.where(kept, time, np.inf)
        k = np.argmin(time, axis=1)[:, None]
        found = np.array([np.take_along_axis(x, k, axis=1)[:, 0] for x in (time, distance, speed, theta)])
        best = np.where(found[0] < best[0], found, best)
        step = theta[:, 1:2] - theta[:, :1]
        middle = np.where(np.isnan(best[3]), np.pi / 4, best[3])[:, None]
        theta = middle + step * np.linspace(-1.0, 1.0, 161)
    return best


def _at_elevations(theta, reach, rise, limits, steps):
    # Elevations outside the sensible range are evaluated at its ends; the caller drops them.
    theta = np.clip(theta, np.arctan2(rise, reach), 0.5 * np.pi - 1e-9)
    sine, cosine = np.sin(theta), np.cos(theta)
    short, far = np.zeros_like(theta), np.cbrt(reach / cosine)
    for _ in range(steps):
        # Bisecting the cube root of the distance spares the cubic root of the jerk-only ramp.
        root = 0.5 * (short + far)
        p = root * root * root
        v, _ = half_stroke(p, limits, root)
        remaining = reach - p * cosine
        flight = remaining / (v * cosine)
        over = p * sine + v * sine * flight - 0.5 * GRAVITY * flight**2 >= rise
        short, far = np.where(over, short, root), np.where(over, root, far)
    v, time = half_stroke(far**3, limits)
    return far**3, v, time


def units(rng, count):
    """Directions (N, 3) in space."""
    vectors = rng.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def random_throws(count, seed, rise=(-0.25, 0.15)):
    """Picks, targets and limits (V, A, J) over the T3KR's table, 15 to 100 % with J scaled or not."""
    rng = np.random.default_rng(seed)
    picks = np.stack(
        [rng.uniform(-0.4, 0.4, count), rng.uniform(-0.6, 0.6, count), rng.uniform(-0.95, -0.75, count)],
        axis=1,
    )
    span, azimuth = rng.uniform(0.1, 1.4, count), rng.uniform(-np.pi, np.pi, count)
    step = np.stack([span * np.cos(azimuth), span * np.sin(azimuth), rng.uniform(*rise, count)], axis=1)
    share = rng.uniform(0.15, 1.0, count)
    jerk = np.where(rng.random(count) < 0.5, 3000.0 * share, 3000.0)
    return picks, picks + step, (6.0 * share, 120.0 * share, jerk)
