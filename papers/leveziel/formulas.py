"""Formulas of Leveziel et al.: inverse and forward kinematics, Jacobians, and conventions that are not printed."""

from __future__ import annotations

import timeit
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final, cast

import numpy as np
from scipy.optimize import brentq

from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper import (
    PROTOTYPE,
    closure_excess,
    forward_kinematics,
    inverse_jacobian,
    inverse_kinematics,
    jacobian_q,
    jacobian_x,
    kappa,
    singular_angle,
    singularity,
    tau,
)

from .cases import HOME_THETA, PAPER_STEP, poses_at, random_poses, reduced
from .scan import scan_workspace, tau_hull
from .workspace import LEAST

POSES: Final = 10_000
"""Number of random poses of the reduced workspace, theta from -60 to -30 deg, seed 0."""
ASIDE: Final = (0.0, 0.06, -0.2)
"""A position outside the plane of symmetry, where one half is coplanar with its forearm without a singularity [m]."""
TEETH: Final = 40
"""Number of teeth of each gear wheel (section VI-A)."""
ZERO: Final = 1e-9
"""Greatest length [m] or index that counts as zero."""
EXACT: Final = 1e-6
"""Greatest difference of derivatives that agree, in their units; finite differences are not more precise."""
ROUGH: Final = 0.1
"""Relative difference within which lengths are roughly the same."""
_STEP: Final = 1e-5
"""Step of finite differences [m] or [rad]."""


def formula_findings(count: int = POSES, repeats: int = 7) -> Findings:
    """Rows on round trip, Jacobians, conventions, and the speed of the kinematics in batches."""
    poses = random_poses(count)
    rows = (
        *_kinematics_rows(poses),
        *_jacobian_rows(poses),
        _guideline_row(),
        *_stroke_rows(),
        _condition_row(count),
        _coplanar_row(),
        _theta_row(poses),
        *_omission_rows(),
        *_rate_rows(repeats),
    )
    return table_findings("Formulas and conventions", rows, drop="leveziel/")


def forearm_lengths(pose: Floats, q: Floats) -> Floats:
    """Lengths (N, 4) [m] of the forearms from the printed points A_i and B_i, with the printed angles q_3 and q_4."""
    k, r, u, v, w = (getattr(PROTOTYPE, name) for name in "kruvw")
    (x, y, z, theta), (first, second, third, fourth) = pose.T, q.T
    third, fourth = np.pi - third, np.pi - fourth
    zero, side, lift = np.zeros_like(x), v + w * np.cos(theta), w * np.sin(theta)
    a = ((x + u, y, z), (x, y + side, z + lift), (x - u, y, z), (x, y - side, z + lift))
    b = (
        (r * np.cos(first) + k, zero, r * np.sin(first)),
        (zero, r * np.cos(second) + k, r * np.sin(second)),
        (r * np.cos(third) - k, zero, r * np.sin(third)),
        (zero, r * np.cos(fourth) - k, r * np.sin(fourth)),
    )
    return np.linalg.norm(np.array(a) - np.array(b), axis=1).T


def _kinematics_rows(poses: Floats) -> Iterator[Row]:
    gap = float(np.abs(forearm_lengths(poses, inverse_kinematics(poses)) - PROTOTYPE.l).max())
    note = (
        "largest difference of a forearm from l, its ends written out from the printed A_i and B_i, with the motor "
        f"angles of the inverse kinematics; {len(poses):,} random poses of the reduced workspace"
    )
    yield Row.compared("leveziel/formula/eqs-1-6", "Eqs. 1 to 6", gap, "m", holds=gap < ZERO, note=note)
    gaps = np.abs(forward_kinematics(inverse_kinematics(poses)) - poses).max(axis=1)
    note = (
        "largest error of a pose after inverse and forward kinematics (Newton's method from the home pose), "
        f"{len(poses):,} random poses of the reduced workspace, theta from -60 to -30 deg"
    )
    yield Row.ours("leveziel/formula/round-trip", float(gaps.max()), "m, rad", note=note)
    note = f"of these {len(poses):,} poses came back as another pose or not at all"
    yield Row.ours("leveziel/formula/wrong-assembly-mode", float((~(gaps < 1e-6)).sum()), "-", note=note)


def central_differences(function: Callable[[Floats], Floats], arguments: Floats) -> Floats:
    """Derivatives (N, 4, 4) of ``function`` at arguments (N, 4), by central differences of fourth order."""
    columns: list[Floats] = []
    for step in _STEP * np.eye(4):
        near = function(arguments + step) - function(arguments - step)
        far = function(arguments + 2.0 * step) - function(arguments - 2.0 * step)
        columns.append((8.0 * near - far) / (12.0 * _STEP))
    return np.stack(columns, axis=-1)


def _jacobian_rows(poses: Floats) -> Iterator[Row]:
    q = inverse_kinematics(poses)
    by_pose = central_differences(lambda p: closure_excess(p, q), poses) - jacobian_x(poses)
    by_angle = central_differences(lambda a: closure_excess(poses, a), q) + jacobian_q(poses)
    inverse = central_differences(inverse_kinematics, poses) - inverse_jacobian(poses)
    gaps = (
        ("J_x", "J_x", "m, m2", by_pose, "of the closure equations by the pose"),
        ("J_q", "J_q", "m2", by_angle, "of the closure equations by the motor angles"),
        ("inverse", "J_q^-1 J_x", "rad/m, rad/rad", inverse, "of the inverse kinematics"),
    )
    for name, matrix, unit, differences, derivative in gaps:
        gap = float(np.abs(differences).max())
        note = f"largest difference from finite differences {derivative}, {len(poses):,} random poses"
        yield Row.compared(f"leveziel/formula/{name}", f"{matrix}, Eq. 8", gap, unit, holds=gap < EXACT, note=note)


def _guideline_row() -> Row:
    lengths = np.array([PROTOTYPE.r, 2.0 * (PROTOTYPE.k - PROTOTYPE.u), PROTOTYPE.l / 3.0])
    values = ", ".join(f"{1e3 * length:.3g}" for length in lengths) + " mm"
    alike = bool((np.abs(lengths / PROTOTYPE.r - 1.0) < ROUGH).all())
    note = f"within {100.0 * np.ptp(lengths) / lengths.min():.0f} % of each other, and within a tenth of r"
    published = "r = 2 (k - u) = l/3, roughly"
    return Row.compared("leveziel/claim/guidelines", published, values, "-", holds=alike, note=note)


def _stroke_rows() -> Iterator[Row]:
    """Rows on the workspace when the strokes are applied to the printed angles, or with the opposite sign."""
    full = scan_workspace(PAPER_STEP, reduced=False)
    q = inverse_kinematics(full.poses)
    low, high = PROTOTYPE.stroke
    printed = np.column_stack([q[:, :2], np.arctan2(np.sin(q[:, 2:]), -np.cos(q[:, 2:]))])
    count = int(((printed >= low) & (printed <= high)).all(axis=1).sum())
    expected = len(reduced().positions)
    mirrored = replace(PROTOTYPE, stroke=(-high, -low))
    space = scan_workspace(PAPER_STEP, dimensions=mirrored)
    smallest = float(kappa(space.poses, mirrored).min())
    note = (
        "positions at -45 deg that keep them with the printed q_3 and q_4: B_3 = (r c_3 - k, 0, r s_3) puts an arm "
        f"that points outward at 180 deg; {expected:,} keep them with every angle counted from the outward horizontal, "
        "up positive, as here"
    )
    quantity, published = "leveziel/statement/angles-of-arms-3-and-4", "strokes 45 to -85 deg"
    yield Row.compared(quantity, published, float(count), "-", holds=count == expected, note=note)
    least = float(kappa(reduced().poses).min())
    yield Row.compared(
        f"{quantity}/outward",
        published,
        least,
        "-",
        holds=least > LEAST,
        statement=quantity,
        note="the other reading: the strokes count every motor's angle from its outward horizontal, whatever B_3 and "
        f"B_4 say. Smallest kappa of the {expected:,} positions at -45 deg, beside the published bound of {LEAST:g}",
    )
    note = (
        f"smallest kappa at -45 deg if the strokes counted downward, -45 to 85 deg, {len(space.positions):,} "
        "positions: against the published bound of 0.3, so up is positive"
    )
    yield Row.ours("leveziel/statement/sign-of-the-strokes", smallest, "-", beside="45 to -85 deg", note=note)


def _condition_row(count: int) -> Row:
    """Row on condition 7: sines and cosines of Eq. 6 wherever its root is real, reachable or not."""
    rng = np.random.default_rng(1)
    d, e, f = rng.normal(size=(3, count))
    square = d**2 + e**2
    real = square >= f**2
    d, e, f, square = d[real], e[real], f[real], square[real]
    root = np.sqrt(square - f**2)
    sin, cos = (d * f + e * root) / square, (e * f - d * root) / square
    over = float(np.maximum(np.abs(sin), np.abs(cos)).max() - 1.0)
    norm = float(np.abs(sin**2 + cos**2 - 1.0).max())
    return Row.ours(
        "leveziel/statement/condition-7",
        "redundant" if over < ZERO else "needed",
        "-",
        beside="|s_i| <= 1 and |c_i| <= 1",
        note=f"of {count:,} random D, E, F the {len(d):,} with D^2 + E^2 >= F^2 exceed 1 by {max(over, 0.0):g} and s^2 "
        f"+ c^2 is 1 within {norm:.0e}",
        over=over,
        norm=norm,
    )


def _coplanar_row() -> Row:
    """Row with the angles at one position where entry (2, 4) of J_x vanishes and where J_x is singular."""
    ends = np.deg2rad([60.0, 80.0])
    angle = cast(float, brentq(lambda theta: jacobian_x([*ASIDE, theta])[1, 3], *ends, xtol=1e-12))
    coplanar, singular = [*ASIDE, angle], [*ASIDE, float(singular_angle(ASIDE))]
    entries = jacobian_x(singular)[[1, 3], 3]
    index = float(tau(coplanar))
    return Row.compared(
        "leveziel/statement/coplanar-half-is-singular",
        "either half coplanar with its forearm",
        index,
        "-",
        holds=index < ZERO,
        note=f"tau at (0, 60, -200) mm and {np.rad2deg(angle):.1f} deg, where the right half is coplanar with A_2 B_2 "
        f"and det J_x is not zero; it vanishes at {np.rad2deg(singular[3]):.1f} deg, where neither half is (entries "
        f"{1e4 * entries[0]:.1f} and {1e4 * entries[1]:.1f} cm2). Both are needed at once, so det J_x is tested here",
        coplanar_deg=float(np.rad2deg(angle)),
        singular_deg=float(np.rad2deg(singular[3])),
        determinant=float(singularity(coplanar).value),
        entries_m2=entries.tolist(),
    )


def _theta_row(poses: Floats) -> Row:
    """Row on the definition of theta as "the relative angle between the two parts": Eqs. 3 and 4 turn each by theta."""
    # Directions of both halves, from their joints with the middle part to their ends in Eqs. 3 and 4.
    theta = poses[:, 3]
    right, left = np.stack([np.cos(theta), np.sin(theta)]), np.stack([-np.cos(theta), np.sin(theta)])
    # Two halves in one plane have no relative angle.
    relative = np.pi - np.arccos(np.clip((right * left).sum(axis=0), -1.0, 1.0))
    ratio = relative / np.abs(theta)
    each = "the angle of each part"
    return Row.compared(
        "leveziel/misprint/definition-of-theta",
        "the relative angle between the two parts",
        each if np.allclose(ratio, 2.0) else "the relative angle between the two parts",
        "-",
        note=f"by Eqs. 3 and 4 the two parts stand {ratio.min():.3f} to {ratio.max():.3f} times theta apart: each "
        "turns by theta against the middle level, one up and one down, and half of the relative angle is meant",
    ).explain("the relative angle between the two parts" if np.allclose(0.5 * ratio, 1.0) else None)


def _omission_rows() -> Iterator[Row]:
    note = (
        f"of wheels with {TEETH} teeth whose axes are 2 v = {2e3 * PROTOTYPE.v:.0f} mm apart; only the teeth are given"
    )
    yield Row.ours("leveziel/statement/gear-module", 2.0 * PROTOTYPE.v / TEETH, "m", note=note)
    note = (
        "no acceleration, torque, mass, claw geometry or grip force is given; those of the simulated robot are the "
        "servo's data sheet and the weight of such parts"
    )
    quantity = "leveziel/statement/nothing-about-dynamics"
    yield Row.ours(quantity, "assumed", "-", note=note)


def _rate_rows(repeats: int) -> Iterator[Row]:
    poses = random_poses(20 * POSES, seed=1)
    rate = len(poses) / _shortest_time(lambda: inverse_kinematics(poses), repeats)
    backward = inverse_kinematics(poses)
    forward = len(poses) / _shortest_time(lambda: forward_kinematics(backward), 1)
    positions = reduced().positions
    seconds = _shortest_time(lambda: tau_hull(positions), min(repeats, 3))
    single = poses_at(np.array([0.0, 0.0, -0.2]), HOME_THETA)
    single_time = _shortest_time(lambda: inverse_kinematics(single), 50 * repeats)
    note = (
        f"on one core of the machine that made this, in a batch of {len(poses):,}, quickest of {repeats} runs; a "
        f"single pose takes {1e6 * single_time:.0f} us"
    )
    yield Row.ours("leveziel/speed/inverse-kinematics", rate, "poses/s", note=note, single_s=single_time)
    note = "on one core in the same batch, Newton's method from the home pose"
    yield Row.ours("leveziel/speed/forward-kinematics", forward, "poses/s", note=note)
    note = f"for tau and the strokes at {len(positions):,} positions times 101 angles on the same core"
    yield Row.ours("leveziel/speed/scan", seconds, "s", note=note, poses=101 * len(positions))


def _shortest_time(action: Callable[[], object], repeats: int) -> float:
    """Time [s] of the quickest of several runs, which other processes disturbed least."""
    return min(timeit.repeat(action, number=1, repeat=repeats))
