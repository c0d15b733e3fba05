"""Small versions of the parts of Leveziel et al., and the printed kinematics written out anew."""

from functools import cache

import numpy as np

from agents.reproduce.finding import Findings, Row
from papers.leveziel import circle as leveziel_circle
from papers.leveziel import closing as leveziel_closing
from papers.leveziel import formulas as leveziel_formulas
from papers.leveziel import indices as leveziel_indices
from papers.leveziel import moves as leveziel_moves
from papers.leveziel import workspace as leveziel_workspace
from pnt_gym.arrays import Bools, Floats

STEP, PIXEL = 0.008, 0.008
HOME = float(np.deg2rad(-45.0))
K, R, L, U, V, W = 82.5, 80.0, 223.0, 40.0, 13.5, 26.5
"""The printed lengths [mm]."""


@cache
def findings(name: str) -> Findings:
    """Small versions of the parts."""
    small = {
        "workspace": lambda: leveziel_workspace.workspace_findings(STEP, PIXEL),
        "indices": lambda: leveziel_indices.index_findings(STEP),
        "circle": lambda: leveziel_circle.circle_findings(PIXEL),
        "moves": lambda: leveziel_moves.move_findings(pairs=100),
        "closing": lambda: leveziel_closing.closing_findings(STEP),
        "formulas": lambda: leveziel_formulas.formula_findings(count=500, repeats=1),
    }
    return small[name]()


ALL = ("workspace", "indices", "circle", "moves", "closing", "formulas")


def row(name: str, quantity: str) -> Row:
    return next(r for r in findings(name).rows if r.quantity == f"leveziel/{quantity}")


def angles_of(poses: Floats) -> Floats:
    """Motor angles (N, 4) [rad] from the outward horizontal by Eqs. 5 and 6 in mm, NaN out of reach."""
    x, y, z = 1e3 * poses[:, :3].T
    theta = poses[:, 3]
    side, lift = V + W * np.cos(theta), z + W * np.sin(theta)
    found = []
    for out, across, up in ((x + U, y, z), (y + side, x, lift), (U - x, y, z), (side - y, x, lift)):
        d, e = 2.0 * R * up, 2.0 * R * (out - K)
        f = (out - K) ** 2 + across**2 + up**2 + R**2 - L**2
        with np.errstate(invalid="ignore"):
            root = np.sqrt(d**2 + e**2 - f**2)
        sin, cos = (d * f + e * root) / (d**2 + e**2), (e * f - d * root) / (d**2 + e**2)
        found.append(np.arctan2(sin, cos))
    return np.stack(found, axis=1)


def allowed(poses: Floats) -> Bools:
    """Which poses keep the strokes, by the angles above."""
    q = np.rad2deg(angles_of(poses))
    return ((q >= -85.0) & (q <= 45.0)).all(axis=1)
