"""Independent ways to the same numbers: the algorithm as printed, and brute force over the elevation."""

import numpy as np

GRAVITY = 9.81


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


def half_stroke(p, limits, root=None):
    """Speed at p and time to p when the stroke is 2p, from the smallest peak any limit allows; arrays."""
    v_max, a_max, j = limits
    stroke = 2 * p
    root = np.cbrt(p) if root is None else root
    a = np.minimum(np.cbrt(j * j) * root, np.minimum(np.sqrt(j * v_max), a_max))
    # Speed if the stroke had no cruise: P = V (V / A + A / J).
    v = np.minimum((-a * a + np.sqrt(a * a * a * a + 4 * j * j * stroke * a)) / (2 * j), v_max)
    return v, 0.5 * (stroke / v + v / a + a / j)


def brute_force(reach, rise, limits, *, ceiling=np.inf, nodes=700, rounds=7):
    """Least time to a release that hits (reach, rise) with z <= ceiling: grid of elevations, then zoom.

    At every elevation the release distance is bisected on "released here, does the object fly too far?", with
    the flight taken from the equations of motion. Returns time, distance, speed and elevation; infinite time
    if there is no such release.
    """
    low, high = np.arctan2(rise, reach), 0.5 * np.pi
    theta = low + (high - low) * (np.arange(nodes) + 0.5) / nodes
    best = (np.inf, np.nan, np.nan, np.nan)
    for turn in range(rounds):
        distance, speed, time = _at_elevations(theta, reach, rise, limits, 54 if turn else 40)
        time = np.where(distance * np.sin(theta) <= ceiling, time, np.inf)
        k = int(np.argmin(time))
        if not np.isfinite(time[k]):
            break
        if time[k] < best[0]:
            best = (time[k], distance[k], speed[k], theta[k])
        step = theta[1] - theta[0]
        theta = np.linspace(best[3] - step, best[3] + step, 61)
        theta = theta[(theta > low) & (theta < high)]
    return best


def _at_elevations(theta, reach, rise, limits, steps):
    sine, cosine = np.sin(theta), np.cos(theta)
    short, far = np.zeros_like(theta), np.cbrt(reach / cosine)
    for _ in range(steps):
        # Bisecting the cube root of the distance spares the cubic root of the jerk-only ramp.
        root = 0.5 * (short + far)
        p = root * root * root
        v, _ = half_stroke(p, limits, root)
        remaining = reach - p * cosine
        flight = remaining / (v * cosine)
        height = p * sine + v * sine * flight - 0.5 * GRAVITY * flight**2
        over = height >= rise
        short, far = np.where(over, short, root), np.where(over, root, far)
    v, time = half_stroke(far**3, limits)
    return far**3, v, time


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
