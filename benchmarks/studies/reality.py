"""Contact held against measurement: a cube that people tossed onto a board, and a square that fell in a plane.

The measured bodies are none of the catalogue's objects. The study tells whether the contact engine follows real
bodies once friction and restitution are right, how much both scatter from drop to drop, and whether a real body rises
higher after its impact than the bound that ends a simulated fall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from itertools import pairwise, product
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from agents.ground import metrics
from agents.ground.cli import UsageError
from agents.results import content
from agents.results.study import Amount, Figures, Settings, share
from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.bodies import contact_solref
from pnt_gym.cells.base.settle_kernel import MARGIN
from pnt_gym.cells.base.stage import add_floor, add_free_object
from pnt_gym.constants import GRAVITY
from pnt_gym.engine import mujoco
from pnt_gym.robots.specification import set_options

FITTED: Final = 95
"""Number of tosses, and of drops, by which the fitted contacts are chosen; all others judge them."""
FRICTIONS: Final = (0.12, 0.15, 0.18, 0.22, 0.3, 0.4)
"""Frictions among which the fit chooses."""
SLOW, FAST = (0.0, 0.2, 0.3, 0.35), (0.3, 0.325, 0.35, 0.375, 0.4, 0.425, 0.45, 0.475, 0.5)
"""Restitutions among which the fit chooses: of the cube, which is tossed, and of the square, which falls faster."""
AROUND: Final = 12
"""Frames of a drop that are compared, from two frames before its first impact on."""
AFTER: Final = 4
"""Frame from which on the impact is over, also in the smoothed velocities of the measurement."""
RISING: Final = 60
"""Frames in which a simulated square has risen."""
SPREAD: Final = 0.35
"""Standard deviation of the logarithm of a restitution that is drawn anew for each drop."""
STEPS: Final = np.arange(0.05, 0.96, 0.05)
"""Restitutions among which that of a single drop is chosen."""
KICK: Final = 0.3
"""Change of the vertical velocity between two frames that gravity cannot make [m/s]."""


class Body(NamedTuple):
    """A measured body, its motions, and the camera's frames."""

    half: float
    """Half of its side [m]."""
    mass: float
    """[kg]; for contacts with the floor alone it has no effect."""
    inertia: float
    """About every axis [kg m2]."""
    frame: float
    """Time between two frames [s]."""
    substeps: int
    """Physics steps in a frame; a step is at most 1 ms long."""


CUBE: Final = Body(half=0.0524, mass=0.37, inertia=0.81e-3, frame=1.0 / 148.0, substeps=7)
"""The acrylic cube of ContactNets (Pfrommer, Halm and Posa 2020)."""
SQUARE: Final = Body(half=0.030, mass=0.1, inertia=0.1 * 0.060**2 / 6.0, frame=1.0 / 250.0, substeps=4)
"""The square of the MCube Lab's planar impacts (CoRL 2017); mass assumed, inertia that of a solid square."""


def read_tosses(folder: str) -> list[Floats]:
    """States (K, 13) of every toss of the cube: position [m], attitude (w first), velocity [m/s], spin in its axes.

    Raises:
        UsageError: the folder holds no such file.
    """
    file = Path(folder) / "contactnets_cube_tosses.npz"
    found = content.arrays(file, "state|offset")
    state, offset = (found.get(name, np.zeros(0)) for name in ("state", "offset"))
    is_table = state.ndim == 2 and state.shape[1] == 13 and bool(np.isfinite(state).all())
    ends = np.append(offset, 0)[: offset.size]
    if not (is_table and offset.ndim == 1 and offset.size > FITTED + 1 and (np.diff(ends) > AROUND).all()):
        raise UsageError(
            f"{str(file)!r} is no file of tosses: `state` (K, 13) finite and `offset`, where each of at least "
            f"{FITTED + 1} tosses begins and the last one ends, are needed"
        )
    if offset[0] != 0 or offset[-1] != len(state):
        raise UsageError(f"{str(file)!r}: `offset` must go from 0 to {len(state)}, got {offset[0]} to {offset[-1]}")
    return [state[begin:end].astype(np.float64) for begin, end in pairwise(offset)]


def read_drops(folder: str) -> Floats:
    """States (N, K, 6) of every drop of the square: x, z [m], theta [rad], and their rates.

    Raises:
        UsageError: the folder holds no such file.
    """
    file = Path(folder) / "planar_square_drops.npz"
    state = content.arrays(file, "state").get("state", np.zeros(0))
    if not (state.ndim == 3 and state.shape[2] == 6 and len(state) > FITTED and state.shape[1] > AROUND):
        raise UsageError(f"{str(file)!r} is no file of drops: `state` (N, K, 6) of more than {FITTED} drops is needed")
    if not np.isfinite(state).all():
        raise UsageError(f"{str(file)!r}: `state` must be finite")
    return state.astype(np.float64)


class Floor:
    """The engine with the options and contacts of the cells, a floor at height 0, and one free box."""

    def __init__(self, body: Body, friction: float, restitution: float) -> None:
        spec = mujoco.MjSpec()
        set_options(spec, body.frame / body.substeps)
        add_floor(spec, 0.0, 1.0)
        contact = {"friction": [friction, 0.005, 0.0001], "solref": contact_solref(restitution).tolist()}
        add_free_object(spec, body.mass, body.inertia, body.half, condim=6, priority=1, **contact)
        self._body, self._model = body, spec.compile()
        self._data = mujoco.MjData(self._model)

    def follow(self, start: Floats, frames: int) -> Floats:
        """States (frames, 13) of the box from a state (13,) on, which is the first."""
        data, states = self._data, np.empty((frames, 13))
        mujoco.mj_resetData(self._model, data)
        data.qpos[:], data.qvel[:] = start[:7], start[7:]
        for row in states:
            row[:7], row[7:] = data.qpos, data.qvel
            mujoco.mj_step(self._model, data, self._body.substeps)
        return states


# The cube


class Deviation(NamedTuple):
    """Differences of simulated tosses from the measured ones (N,)."""

    path: Floats
    """Mean distance along the toss over the side of the cube."""
    turn: Floats
    """Mean angle along the toss [deg]."""
    rest: Floats
    """Distance of the places of rest [m]."""
    same_face: Bools
    """Whether the cube comes to rest on the same face."""


def compare_tosses(tosses: Sequence[Floats], friction: float, restitution: float) -> Deviation:
    """Differences between the tosses of a contact and the measured ones, from the same first frames."""
    floor, rows = Floor(CUBE, friction, restitution), list[tuple[float, float, float, bool]]()
    for measured in tosses:
        # The tracked cube rests slightly below half of its side: the board of the data is not exactly at height 0.
        lift = np.zeros(13)
        lift[2] = CUBE.half - float(measured[-1, 2])
        found = floor.follow(measured[0] + lift, len(measured)) - lift
        distance = np.linalg.norm(found[:, :3] - measured[:, :3], axis=1)
        cosines = np.abs(np.sum(found[:, 3:7] * measured[:, 3:7], axis=1)) / np.linalg.norm(measured[:, 3:7], axis=1)
        turn = 2.0 * np.degrees(np.arccos(np.minimum(cosines, 1.0)))
        faces = [_upper_face(attitude) for attitude in (found[-1, 3:7], measured[-1, 3:7])]
        side = 2.0 * CUBE.half
        rows.append((float(distance.mean()) / side, float(turn.mean()), float(distance[-1]), faces[0] == faces[1]))
    path, turn, rest, same = (np.array(column) for column in zip(*rows, strict=True))
    return Deviation(path, turn, rest, same)


def _upper_face(attitude: Floats) -> tuple[int, bool]:
    """The body axis that is most vertical, and whether it points up."""
    w, x, y, z = attitude / np.linalg.norm(attitude)
    up = np.array([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)])
    axis = int(np.abs(up).argmax())
    return axis, bool(up[axis] > 0.0)


def cube(settings: Settings, amount: Amount) -> Figures:
    """The cube's tosses in the engine beside the measured ones.

    Args:
        settings: `data`, the folder of the measured tosses; `friction` and `restitution`, or neither of both: they are
            then fitted on the first tosses.
        amount: number of tosses that judge.
    """
    tosses = read_tosses(settings["data"])
    contact = _contact(settings) or min(
        product(FRICTIONS, SLOW), key=lambda pair: float(compare_tosses(tosses[:FITTED], *pair).path.mean())
    )
    found = compare_tosses(tosses[FITTED : FITTED + amount.throws], *contact)
    return {
        "friction": contact[0],
        "restitution": contact[1],
        "tosses": len(found.path),
        "path": _interval(found.path),
        "turn_deg": _interval(found.turn),
        "rest_m": _interval(found.rest),
        "rest_p90_m": float(np.quantile(found.rest, 0.9)),
        "same_face": share(found.same_face.tolist()),
    }


def _contact(settings: Settings) -> tuple[float, float] | None:
    """Friction and restitution of the settings, if they say both."""
    if "friction" not in settings:
        return None
    return float(settings["friction"]), float(settings["restitution"])


def _interval(values: Floats) -> Figures:
    """A mean with its interval, as a figure of a row."""
    return asdict(metrics.interval(values))


# The square


class Rebound(NamedTuple):
    """Simulated drops beside the measured ones (N,), over the frames around the first impact."""

    velocity: Floats
    """Distance of the mean velocities after the impact [m/s]."""
    upward: Floats
    """Simulated minus measured vertical velocity after the impact [m/s]."""
    spin: Floats
    """Difference of the spins after the impact [rad/s]."""
    place: Floats
    """Distance in the last frame [m]."""
    rise: Floats
    """Simulated rise of the centre after the impact [m]."""


def first_impacts(drops: Floats) -> list[tuple[int, Floats]]:
    """Number and measured states (`AROUND`, 6) of each drop around its first impact, if all of them were filmed."""
    jumps = np.diff(drops[:, :, 4], axis=1) > KICK
    begins = jumps.argmax(axis=1) - 1
    whole = np.flatnonzero(jumps.any(axis=1) & (begins >= 0) & (begins + AROUND <= drops.shape[1]))
    return [(int(k), drops[k, begins[k] : begins[k] + AROUND]) for k in whole]


def compare_drops(impacts: Sequence[Floats], friction: float, restitutions: Floats) -> Rebound:
    """Differences between simulated and measured drops from the first of their frames on.

    Args:
        impacts: measured states (`AROUND`, 6) of N drops.
        friction: of the contact.
        restitutions: of the contact of each drop (N,).
    """
    rows = list[tuple[float, ...]]()
    for measured, restitution in zip(impacts, restitutions.tolist(), strict=True):
        found = _planar(Floor(SQUARE, friction, restitution).follow(_in_space(measured[0]), RISING))
        off = found[AFTER:AROUND] - measured[AFTER:]
        after = off[:, 3:].mean(axis=0)
        place, rise = float(np.hypot(*off[-1, :2])), rise_after(found[:, 1], found[:, 4])
        rows.append((float(np.hypot(*after[:2])), after[1], abs(after[2]), place, rise))
    return Rebound(*(np.array(column) for column in zip(*rows, strict=True)))


def _in_space(planar: Floats) -> Floats:
    """A state in the plane as one in space (13,): theta turns x towards z, so about the negative y axis."""
    x, z, theta, vx, vz, spin = planar
    return np.array([x, 0.0, z, np.cos(theta / 2.0), 0.0, -np.sin(theta / 2.0), 0.0, vx, 0.0, vz, 0.0, -spin, 0.0])


def _planar(states: Floats) -> Floats:
    """States in space (K, 13) as states in the plane (K, 6)."""
    theta = -2.0 * np.arctan2(states[:, 5], states[:, 3])
    return np.column_stack([states[:, 0], states[:, 2], theta, states[:, 7], states[:, 9], -states[:, 11]])


def rise_after(height: Floats, upward: Floats) -> float:
    """Rise of the centre from the lowest frame of the first impact to the next fall [m], by frames (K,)."""
    jumps = np.diff(upward) > KICK
    if not jumps.any():
        return 0.0
    lowest = int(jumps.argmax())
    lowest += int(height[lowest : lowest + AFTER].argmin())
    falls = np.flatnonzero(upward[lowest + AFTER :] < 0.0)
    end = lowest + AFTER + int(falls[0]) if falls.size > 0 else len(height)
    return float(height[lowest : end + 1].max() - height[lowest])


def square(settings: Settings, amount: Amount) -> Figures:
    """The square's drops in the engine beside the measured ones.

    Args:
        settings: `data`, the folder of the measured drops; `friction` and `restitution`, or neither of both: they are
            then fitted on the first drops; `spread`, with which the restitution is drawn for each drop.
        amount: number of drops that judge, and the seed of drawn restitutions.
    """
    impacts = [states for _, states in first_impacts(read_drops(settings["data"]))]
    contact = _contact(settings) or fitted_contact(impacts[:FITTED])
    judged, rng = impacts[FITTED : FITTED + amount.throws], np.random.default_rng(amount.seed)
    factors = np.exp(settings.get("spread", 0.0) * rng.standard_normal(len(judged)))
    found = compare_drops(judged, contact[0], np.minimum(contact[1] * factors, STEPS[-1]))
    real = np.array([rise for rise, _ in measured_rises("square", settings["data"])])
    return {
        "friction": contact[0],
        "restitution": contact[1],
        "drops": len(judged),
        "velocity_m_s": _interval(found.velocity),
        "upward_m_s": _interval(found.upward),
        "spin_rad_s": _interval(found.spin),
        "place_m": _interval(found.place),
        "rise_ratio": float(np.median(found.rise) / np.median(real)),
    }


def fitted_contact(impacts: Sequence[Floats]) -> tuple[float, float]:
    """Friction and restitution with the least error of the velocity after the impact."""

    def error(pair: tuple[float, float]) -> float:
        return float(compare_drops(impacts, pair[0], np.full(len(impacts), pair[1])).velocity.mean())

    return min(product(FRICTIONS[:4], FAST), key=error)


def scatter(settings: Settings, amount: Amount) -> Figures:
    """The restitution that fits each drop of the square alone, of those that the fitted friction judges.

    Args:
        settings: `data`, the folder of the measured drops.
        amount: number of drops.
    """
    impacts = [states for _, states in first_impacts(read_drops(settings["data"]))]
    friction = fitted_contact(impacts[:FITTED])[0]
    judged = impacts[FITTED : FITTED + amount.throws]
    errors = [np.abs(compare_drops(judged, friction, np.full(len(judged), e)).upward) for e in STEPS]
    best = STEPS[np.argmin(errors, axis=0)]
    quantiles = {f"e_q{q:02d}": float(np.quantile(best, q / 100.0)) for q in (5, 25, 50, 75, 95)}
    return {"drops": len(judged), "friction": friction, **quantiles, "spread": float(np.log(best).std())}


# The bound


def measured_rises(body: str, folder: str) -> list[tuple[float, tuple[float, float]]]:
    """Rise after the first impact of each measured motion [m]; downward speed, and speed of all its energy [m/s]."""
    rises = list[tuple[float, tuple[float, float]]]()
    if body == "square":
        for k, states in first_impacts(drops := read_drops(folder)):
            vx, vz, spin = states[1, 3:]
            speed = float(np.sqrt(vx * vx + vz * vz + SQUARE.inertia / SQUARE.mass * spin * spin))
            rises.append((rise_after(drops[k, :, 1], drops[k, :, 4]), (float(-vz), speed)))
        return rises
    for toss in read_tosses(folder):
        jumps = np.diff(toss[:, 9]) > KICK
        if not jumps.any() or jumps.argmax() == 0:
            continue
        before = toss[int(jumps.argmax()), 7:]
        energy = before[:3] @ before[:3] + CUBE.inertia / CUBE.mass * (before[3:] @ before[3:])
        rises.append((rise_after(toss[:, 2], toss[:, 9]), (float(-before[2]), float(np.sqrt(energy)))))
    return rises


def rises(settings: Settings, amount: Amount) -> Figures:
    """Measured rises after an impact against the bound by which a simulated fall into a bin ends, see `settle_kernel`.

    Args:
        settings: `data`; `body`, "cube" or "square"; `restitution`, that of the bound.
        amount: number of motions.
    """
    found = measured_rises(settings["body"], settings["data"])[: amount.throws]
    rise = np.array([height for height, _ in found])
    down, speed = np.array([speeds for _, speeds in found]).T
    leap = np.maximum(0.5 * (1.0 + settings["restitution"]) * (down + speed) - down, 0.0)
    bound = leap * leap / (2.0 * GRAVITY)
    return {
        "motions": len(rise),
        "rise_median_m": float(np.median(rise)),
        "rise_p90_m": float(np.quantile(rise, 0.9)),
        "rise_max_m": float(rise.max()),
        "above": share((rise > bound).tolist()),
        "above_by_margin": share((rise > bound + MARGIN).tolist()),
    }
