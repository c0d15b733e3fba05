"""Workspace of Leveziel et al. (Fig. 5 and the video): sections with kappa, shares, extent, singularities.

Sections are drawn through the home position, which the paper's Fig. 6 names; its Fig. 5 does not say where it cuts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from agents.report.figures import svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.leveziel_cases import (
    CENTRE,
    HOME_THETA,
    PAPER_COUNT,
    PAPER_STEP,
    held,
    lowest,
    posed,
    reduced,
)
from agents.reproduce.leveziel_drawings import Section, sections_figure, turned_figure
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.gripper4 import (
    inverse_kinematics,
    kappa,
    scan_workspace,
    singular_angle,
    singularity,
)

if TYPE_CHECKING:
    pass

PIXEL: Final = 0.001
"""Spacing of the sections [m]."""
PLANES: Final = {"x-y": (0, 1), "x-z": (0, 2), "y-z": (1, 2)}
"""Sections and the coordinates in them."""
TURNED: Final = (-60.0, -30.0, 0.0, 30.0, 45.0, 55.0)
"""Angles of the halves at which kappa is drawn anew, from the paper's video [deg]."""
ROUND_STEPS: Final = (0.004, 0.0045, 0.005)
"""[m]"""
GOOD, POOR = 0.5, 0.1
"""Values of kappa that shares are given of."""
_REACH: Final = 0.235
"""Beyond the workspace's extent to the side [m]."""


def workspace_findings(step: float = PAPER_STEP, pixel: float = PIXEL) -> Findings:
    """Sections and shares at -45 deg, the count of positions, and singular positions."""
    sections = {name: section(name, HOME_THETA, pixel) for name in PLANES}
    rows = [*_size(step), *_kappa(step), *_shares(step, sections), *_turned(step, pixel)]
    figures = {
        "leveziel_workspace.svg": svg(sections_figure(sections)),
        "leveziel_theta.svg": svg(turned_figure({a: _pair(a, pixel) for a in TURNED})),
    }
    return Findings(tuple(rows), {"leveziel_workspace": _data(step)}, figures)


def section(name: str, theta: float, pixel: float, at: tuple[float, float, float] = CENTRE) -> Section:
    """Conditioning over the full workspace in a plane through a position, and where the strokes allow the pose."""
    across, up = (_axis(k, pixel) for k in PLANES[name])
    positions = np.tile(np.array(at), (across.size, up.size, 1))
    first, second = PLANES[name]
    positions[..., first], positions[..., second] = across[:, None], up[None, :]
    poses = posed(positions, theta)
    return Section(name, across, up, kappa(poses), np.isfinite(inverse_kinematics(poses)[..., 0]), held(poses))


def _axis(coordinate: int, pixel: float) -> Floats:
    low, high = (-0.31, 0.0) if coordinate == 2 else (-_REACH, _REACH)
    return pixel * np.arange(round(low / pixel), round(high / pixel) + 1, dtype=np.float64)


def _pair(degrees: float, pixel: float) -> tuple[Section, Section]:
    theta, coarse = float(np.deg2rad(degrees)), 2.0 * pixel
    return section("x-y", theta, coarse), section("y-z", theta, coarse)


def _data(step: float) -> dict[str, Any]:
    space = reduced(step)
    return {"step": step, "positions": len(space.positions), "extent": space.extent.tolist()}


def _size(step: float) -> list[Row]:
    space = reduced(step)
    full = scan_workspace(step, reduced=False)
    counts = {f"{1e3 * s:g} mm": len(reduced(s).positions) for s in ROUND_STEPS}
    other = {
        f"{1e3 * s:g} mm, {degrees} deg": len(scan_workspace(s, np.deg2rad(degrees)).positions)
        for s, degrees in ((0.0045, -60), (0.0048, -30), (0.005, 0))
    }
    low, high = space.extent
    return [
        Row(
            "leveziel/workspace/positions",
            float(PAPER_COUNT),
            float(len(space.positions)),
            "-",
            "not reproducible",
            f"positions of the reduced workspace at -45 deg with a step of {1e3 * step:.2f} mm; neither step nor angle "
            f"is printed, and round steps give {_listed(counts)} at -45 deg and {_listed(other)} elsewhere",
            {"counts": counts, "counts_at_other_angles": other},
        ),
        Row(
            "leveziel/workspace/volume",
            None,
            space.volume,
            "m3",
            "ours",
            f"of the reduced workspace at -45 deg, {100.0 * space.volume / full.volume:.0f} % of the full one below "
            "the base",
            {"full": full.volume},
        ),
        Row(
            "leveziel/workspace/extent",
            None,
            ", ".join(f"{axis} {1e3 * a:.0f} to {1e3 * b:.0f} mm" for axis, a, b in zip("xyz", low, high, strict=True)),
            "-",
            "ours",
            f"of the reduced workspace at -45 deg on a grid of {1e3 * step:.2f} mm",
            {"extent": space.extent.tolist()},
        ),
    ]


def _listed(counts: dict[str, int]) -> str:
    return ", ".join(f"{count:,} ({name})" for name, count in counts.items())


def _kappa(step: float) -> list[Row]:
    space = reduced(step)
    values = kappa(space.poses)
    tip, smallest = lowest(kappa, HOME_THETA)
    return [
        Row(
            "leveziel/fig-5/smallest-kappa",
            "> 0.3",
            float(values.min()),
            "-",
            "reproduced" if values.min() > 0.3 else "differs",
            f"at -45 deg over the {len(values):,} positions of the reduced workspace",
        ),
        Row(
            "leveziel/fig-5/smallest-kappa-anywhere",
            "> 0.3",
            smallest,
            "-",
            "reproduced" if smallest > 0.3 else "differs",
            f"between these positions, in the extreme tip ({_millimetres(tip)}) mm where three motors stand at "
            "the ends of their strokes; below 0.3 for some millimetres only",
            {"position": tip.tolist()},
        ),
        Row(
            "leveziel/fig-5/over-0.5",
            "majority",
            float(100.0 * (values > GOOD).mean()),
            "%",
            "reproduced",
            "share of the reduced workspace at -45 deg, by volume, where kappa exceeds 0.5",
            {"largest": float(values.max())},
        ),
    ]


def _shares(step: float, sections: dict[str, Section]) -> list[Row]:
    rows: list[Row] = []
    where = {"x-y": "z = -200 mm", "x-z": "y = 0", "y-z": "x = 0"}
    for name, cut in sections.items():
        values = cut.kappa[cut.reduced]
        share = float(100.0 * (values > GOOD).mean())
        rows.append(
            Row(
                f"leveziel/fig-5/over-0.5-in-{name}",
                "majority of the surface",
                share,
                "%",
                "reproduced" if share > 50.0 else "differs",
                f"of the reduced workspace's section at {where[name]}; from {values.min():.3f} to {values.max():.3f}",
                {"smallest": float(values.min()), "area_m2": float(cut.reduced.sum()) * cut.pixel**2},
            )
        )
    return rows


def _turned(step: float, pixel: float) -> list[Row]:
    return [_positive(step, pixel), *_singularities(step)]


def _positive(step: float, pixel: float) -> Row:
    quarter, negative = float(np.deg2rad(45.0)), (-90.0, -75.0, -60.0, -45.0, -30.0, -15.0)
    smallest = {f"{a:.0f}": float(kappa(reduced(2.0 * step, float(np.deg2rad(a))).poses).min()) for a in negative}
    dead = float(kappa(reduced(step, quarter).poses).min())
    cut = section("x-y", quarter, pixel)
    poor = 100.0 * float((cut.kappa[cut.reduced] < POOR).mean())
    axis = cut.kappa[:, cut.up.size // 2][cut.reduced[:, cut.up.size // 2]]
    return Row(
        "leveziel/video/kappa-at-45-deg",
        "close to zero in central areas",
        dead,
        "-",
        "reproduced" if dead < 0.01 else "differs",
        f"smallest in the reduced workspace at +45 deg; {poor:.0f} % of its section at z = -200 mm are below {POOR:g}, "
        f"on both sides of the line y = 0, where kappa stays at {axis.min():.2f} to {axis.max():.2f}. At angles of -90 "
        f"to -15 deg it is {min(smallest.values()):.2f} at least",
        {"smallest_at_negative_angles": smallest, "poor_percent": poor},
    )


def _singularities(step: float) -> list[Row]:
    angles = singular_angle(reduced(step).positions)
    poses = np.column_stack([reduced(step).positions, angles])[np.isfinite(angles)]
    on_grid = float(np.rad2deg(poses[held(poses), 3].min()))
    place, first = first_singular()
    anywhere = float(np.rad2deg(first))
    centre = float(singular_angle(CENTRE))
    before, after = (float(singularity([*CENTRE, centre + turn]).value) for turn in (-0.01, 0.01))
    return [
        Row(
            "leveziel/video/first-singular-angle",
            "around 45 deg",
            on_grid,
            "deg",
            "reproduced" if abs(on_grid - 45.0) < 5.0 else "differs",
            f"smallest theta with det J_x = 0 at one of the {len(angles):,} positions, strokes kept; {anywhere:.2f} "
            f"deg between them, at ({_millimetres(place)}) mm on the edge",
            {"anywhere": anywhere, "position": place.tolist()},
        ),
        Row(
            "leveziel/video/singular-centre",
            None,
            float(np.rad2deg(centre)),
            "deg",
            "ours",
            f"theta at which det J_x = 0 at x = y = 0, z = -200 mm; det J_x / (l^4 w) goes from {before:.4f} to "
            f"{after:.4f} within 0.01 rad of it",
        ),
    ]


def first_singular() -> tuple[Floats, float]:
    """The pose (4,) of the reduced workspace that is singular at the smallest theta, and that angle [rad]."""
    low, high, pose = HOME_THETA, float(np.deg2rad(60.0)), np.full(4, np.nan)
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        worst, value = lowest(lambda poses: singularity(poses).value, middle)
        low, high = (low, middle) if value <= 0.0 else (middle, high)
        pose = worst if value <= 0.0 else pose
    return pose, high


def _millimetres(place: Floats) -> str:
    return ", ".join(f"{1e3 * v + 0.0:.0f}" for v in place[:3])


PARTS = (Part("workspace", workspace_findings),)
