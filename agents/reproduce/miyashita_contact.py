"""Learning of Miyashita et al. 2010 where the stoppers stay solid: the block is pushed while it leaves the arm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.miyashita_cases import (
    ARM,
    BLOCK,
    GOAL,
    POSITION,
    TRIALS,
    Learned,
    Thrower,
    feasible_goals,
    learn,
    listed,
    misses,
    share,
)
from pnt_gym.cells.pallet.config import PalletConfig, load
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.one_joint import Flight, ReleaseBox, arrival, plan_releases, plan_throws, random_goals
from pnt_gym.planning.one_joint.virtual_goal import broyden, newton_step, pull_back, release_jacobian
from pnt_gym.robots.one_joint.model import STOPPER_HEIGHT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GOALS: Final = 20
"""The paper's goal and random ones."""
THROWS: Final = 30
TIMESTEP: Final = 0.00025
"""Physics step [s]. With 1 ms, a contact of some milliseconds takes 4 to 5 rad/s off the spin, depending on where in a
step it begins, and the same throw scatters by 4 deg; with 0.1 ms by less than 1 deg."""
WITHIN: Final = (0.005, 2.0)
"""What is to be reached: position [m] and angle [deg]."""
SCALES: Final = {"position": 1.0, "angle": 0.14, "speed": 0.03}
"""T: 5 mm and 2 deg weigh the same; of the vertical speed little is asked."""
UNITS: Final = np.array([0.005, 0.005, np.deg2rad(2.0), 0.5])
"""What errors in x, y, phi, dy are divided by."""
LARGEST: Final = np.array([0.12, 1.2, 0.02, 0.06])
"""Largest step of a release in theta_t [rad], omega_t [rad/s], l_t [m], t_f [s]."""
HEIGHTS: Final = (0.0002, 0.0005, 0.001, STOPPER_HEIGHT)
"""Of stoppers [m]; the last one is published."""
NUDGE: Final = np.array([0.01, 0.08, 0.002])
"""Differences for the slopes of the simulated map."""
SCANNED: Final = 400
"""Releases all over the range of the arm that are simulated to begin with."""
SCAN: Final = ReleaseBox(angle=(-0.9, 1.5), speed=(4.0, 12.5), radius=(0.10, 0.28), flight=(0.30, 0.31))
SEARCHES: Final = 6
"""Newton steps from the best release of the scan."""


class Slopes(NamedTuple):
    """States (N, 4) that N releases led to, and their derivatives (N, 4, 4)."""

    z: Floats
    jacobian: Floats


def contact_findings(goals: int = GOALS, throws: int = THROWS) -> Findings:
    """What the push does, and how the paper's update and Newton's method fail that know nothing of it."""
    goal = _goals(goals)
    paper = learn(Thrower(cell(), range(goals)), goal, np.full(goals, 0.5), TRIALS)
    plans = plan_throws(goal)
    blind = newton(goal, plans.u, release_jacobian(plans.u), throws)
    curves = {"the paper's update, K = 0.5": paper.true, "Newton and Broyden from Eq. 11": blind}
    figures = {"miyashita_contact.svg": svg(contact_figure(curves, f"{goals} goals"))}
    return Findings((*_push(), _paper_row(paper), _blind_row(blind)), {"miyashita_contact": _sizes(curves)}, figures)


def reach_findings(goals: int = GOALS, scanned: int = SCANNED, throws: int = THROWS) -> Findings:
    """Which goals some release still reaches, and learning that begins from the simulated push."""
    goal = _goals(goals)
    best, found = search(goal, scanned)
    reachable = near(found.z - goal)
    rows, figures, curves = [_reach_row(reachable, scanned)], dict[str, str](), dict[str, Floats]()
    if reachable.any():
        told = newton(goal[reachable], best[reachable], found.jacobian[reachable], throws)
        rows.append(_told_row(told))
        curves["goals within reach"] = told
        figures["miyashita_contact_reach.svg"] = svg(contact_figure(curves, "Newton from a simulated push"))
    return Findings(tuple(rows), {"miyashita_contact_reach": _sizes(curves)}, figures)


def _goals(count: int) -> Floats:
    """The paper's goal and random ones (count, 4)."""
    return np.concatenate([GOAL[None], feasible_goals(count - 1)[0]])


def _sizes(curves: Mapping[str, Floats]) -> dict[str, list[float]]:
    """Quartiles from throw to throw."""
    return {name: listed(np.quantile(_size(e), (0.25, 0.5, 0.75), axis=1).T) for name, e in curves.items()}


def cell(mismatch: float = 1.0) -> PalletConfig:
    """The cell whose stoppers stay solid."""
    return load("contact", mismatch=mismatch, timestep=TIMESTEP, scale=SCALES)


def near(error: Floats) -> Bools:
    """Which errors (..., 4) are within 5 mm and 2 deg."""
    found = misses(error)
    return (found.position < WITHIN[0]) & (found.angle < WITHIN[1])


def _size(error: Floats) -> Floats:
    """Errors as multiples of what is to be reached."""
    found = misses(error)
    return np.maximum(found.position / WITHIN[0], found.angle / WITHIN[1])


def has_motion(u: Floats) -> Bools:
    """Which releases (N, 4) have a motion from rest."""
    return plan_releases(u).feasible


def search(goal: Floats, scanned: int) -> tuple[Floats, Slopes]:
    """Releases (N, 4) that come nearest to goals in a cell without other errors, and the slopes there."""
    u = random_goals(np.random.default_rng(2), scanned, box=SCAN).u
    u = u[has_motion(u)]
    flight = Thrower(cell(0.0), range(len(u))).throw(plan_releases(u), np.zeros_like(u)).fitted
    weights = cell().scale.weights()
    start = np.stack([_nearest(flight, u, z, weights) for z in goal])
    thrower = Thrower(cell(0.0), np.tile(np.arange(len(goal)), 4).tolist())
    found = slopes(thrower, start, goal)
    best, now, here = start.copy(), start.copy(), found
    for _ in range(SEARCHES):
        now = onward(now, step(goal - here.z, scaled(here.jacobian)))
        here = slopes(thrower, now, goal)
        better = _size(here.z - goal) < _size(found.z - goal)
        best = np.where(better[:, None], now, best)
        found = Slopes(
            np.where(better[:, None], here.z, found.z),
            np.where(better[:, None, None], here.jacobian, found.jacobian),
        )
    return best, found


def _nearest(flight: Flight, u: Floats, goal: Floats, weights: Floats) -> Floats:
    """The release (4,) whose flight passes nearest to a goal, with the time when it does."""
    found = arrival(flight, np.tile(goal, (len(u), 1)), weights, np.zeros(len(u)))
    best = int((((found.z - goal) / UNITS) ** 2).sum(axis=1).argmin())
    return np.append(u[best, :3], found.time[best])


def slopes(thrower: Thrower, u: Floats, goal: Floats) -> Slopes:
    """States and their derivatives by throws with slightly different releases, four per row.

    The time in ``u`` is replaced by the one at which the flight passes nearest to the goal.
    """
    count = len(u)
    moved = [u.copy()]
    for k, size in enumerate(NUDGE):
        up, down = u.copy(), u.copy()
        up[:, k] += size
        down[:, k] -= size
        moved.append(np.where(has_motion(up)[:, None], up, np.where(has_motion(down)[:, None], down, u)))
    every = np.concatenate(moved)
    flown = thrower.throw(plan_releases(every), np.tile(goal, (4, 1)))
    time = flown.time[:count]
    u[:, 3] = time
    states = flown.fitted.state(np.tile(time, 4)).reshape(4, count, 4)
    jacobian = np.zeros((count, 4, 4))
    for k in range(3):
        way = moved[k + 1][:, k] - u[:, k]
        jacobian[:, :, k] = np.where(
            way[:, None] != 0.0, (states[k + 1] - states[0]) / np.where(way, way, 1.0)[:, None], 0.0
        )
    fitted, still = flown.fitted, np.full(count, -GRAVITY)
    rates = (fitted.vx[:count], fitted.vy[:count] - GRAVITY * time, fitted.spin[:count], still)
    jacobian[:, :, 3] = np.stack(rates, axis=1)
    return Slopes(states[0], jacobian)


def step(error: Floats, scaled: Floats) -> Floats:
    """Newton's step of releases (N, 4) by scaled slopes, in each number no longer than `LARGEST`."""
    change = newton_step(error / UNITS, scaled, damping=1e-3)
    return LARGEST * change / np.maximum(np.abs(change).max(axis=1), 1.0)[:, None]


def onward(u: Floats, change: Floats) -> Floats:
    """Releases (N, 4) after a step that slides along the arm's limits, or what of it has a motion from rest."""
    room = 1e-4
    low = np.array([ARM.angle[0] + room, room, BLOCK.half_height + room, room])
    longest = np.hypot(ARM.largest_radius(BLOCK), BLOCK.half_height)
    high = np.array([ARM.angle[1] - room, ARM.speed - room, longest - room, np.inf])
    return pull_back(u, np.clip(u + change, low, high), has_motion)[0]


def scaled(jacobian: Floats) -> Floats:
    """Slopes (N, 4, 4) of errors in `UNITS` by releases in `LARGEST`."""
    return jacobian / UNITS[:, None] * LARGEST


def newton(goal: Floats, u: Floats, jacobian: Floats, throws: int) -> Floats:
    """True errors (J, N, 4) of throws that follow Newton's steps, with Broyden's update of the slopes."""
    thrower, found = Thrower(cell(), range(len(goal))), list[Floats]()
    now, last, known = u.copy(), None, scaled(jacobian)
    for _ in range(throws):
        thrown = thrower.throw(plan_releases(now), goal)
        found.append(thrown.true - goal)
        # The time is not chosen but seen: it belongs to the state that was measured.
        now[:, 3] = thrown.time
        if last is not None:
            known = broyden(known, (now - last[0]) / LARGEST, (thrown.measured - last[1]) / UNITS)
        last = now.copy(), thrown.measured
        now = onward(now, step(goal - thrown.measured, known))
    return np.stack(found)


def _push() -> list[Row]:
    """Spin that the block has lost when it is free, by the height of the stoppers."""
    count = len(HEIGHTS)
    plans = plan_throws(np.tile(GOAL, (count, 1)))
    thrower = Thrower(cell(0.0), range(count))
    sunk = STOPPER_HEIGHT - np.array(HEIGHTS)
    for body in thrower.plant.scene.stoppers or ():
        thrower.plant.batch.expand("body_pos")[:, body, 2] -= sunk
    fitted = thrower.throw(plans, plans.goal).fitted
    lost = plans.u[:, 1] - fitted.spin
    return [
        Row(
            f"miyashita/contact/spin-lost-{1e3 * height:g}mm",
            "0 rad/s" if height == STOPPER_HEIGHT else None,
            float(value),
            "rad/s",
            "differs" if height == STOPPER_HEIGHT else "ours",
            f"of {plans.u[k, 1]:.2f} rad/s at the paper's goal, with stoppers of {1e3 * height:g} mm and no other "
            "error: "
            f"{np.rad2deg(value * plans.u[k, 3]):.0f} deg less at the goal. The outer one pushes from below the centre "
            "of mass until the block has risen past it; the paper takes the release as instantaneous",
        )
        for k, (height, value) in enumerate(zip(HEIGHTS, lost, strict=True))
    ]


def _paper_row(learned: Learned) -> Row:
    first, last = misses(learned.true[0]), misses(learned.true[-1])
    worse = share(_size(learned.true[-1]) > _size(learned.true[0]))
    return Row(
        "miyashita/contact/paper-update",
        f"< {POSITION:g} m",
        float(np.median(last.position)),
        "m",
        "differs",
        f"median true position error of {len(learned.guarded)} goals at throw {TRIALS} with K = 0.5, after "
        f"{np.median(first.position):.3f} m at the first; the angle goes from {np.median(first.angle):.0f} to "
        f"{np.median(last.angle):.0f} deg, {worse:.0f} % of the goals end farther off than they began: more speed "
        "means "
        f"more push. {share(learned.guarded):.0f} % of the virtual goals had to be held back at the arm's limits",
        {
            "position_paper_goal": [float(v) for v in misses(learned.true[:, 0]).position],
            "angle_paper_goal_deg": [float(v) for v in misses(learned.true[:, 0]).angle],
            "share_worse": worse,
            "share_reached": share(near(learned.true[-1])),
        },
    )


def _blind_row(error: Floats) -> Row:
    ever = near(error).any(axis=0)
    return Row(
        "miyashita/contact/newton-from-eq-11",
        None,
        share(ever),
        "%",
        "ours",
        f"of {error.shape[1]} goals within 5 mm and 2 deg (true state) at least once in {len(error)} throws, "
        "learned by "
        "Newton's step and Broyden's update from the slopes of Eq. 11, which knows of no push",
        {"share_last": share(near(error[-1]))},
    )


def _reach_row(reachable: Bools, scanned: int) -> Row:
    return Row(
        "miyashita/contact/reachable",
        None,
        share(reachable),
        "%",
        "ours",
        f"of {reachable.size} goals that some release reaches within 5 mm and 2 deg although the block is pushed: "
        f"best of {scanned} "
        f"releases all over the arm's range and {SEARCHES} Newton steps, simulated without other errors. The rest are "
        "goals that a free release reaches; with half of the spin lost they ask for more speed than there is or for a "
        "longer flight than leads there" + ("" if reachable[0] else "; the paper's goal is one of them"),
        {"paper_goal": bool(reachable[0])},
    )


def _told_row(error: Floats) -> Row:
    hit = near(error)
    ever = hit.any(axis=0)
    settled = near(np.median(error[-5:], axis=0))
    first = [int(throw) + 1 for throw in hit.argmax(axis=0)[ever]]
    spread = np.rad2deg(error[-10:, :, 2].std(axis=0))
    return Row(
        "miyashita/contact/newton-from-simulation",
        None,
        share(ever),
        "%",
        "ours",
        f"of the {error.shape[1]} goals within reach, within 5 mm and 2 deg (true state) at least once in {len(error)} "
        f"throws, from the release and slopes found in simulation; {share(settled):.0f} % by the median of the last "
        "five. "
        f"The angle of the last ten throws scatters by {np.median(spread):.1f} deg (median): how long the stopper "
        "pushes "
        "depends on much less than is known of a throw",
        {"share_settled": share(settled), "reached_at": first},
    )


def contact_figure(curves: Mapping[str, Floats], title: str) -> Figure:
    """Errors from throw to throw: medians and quartiles over the goals."""
    figure, (panel,) = subplots(1, 1, (6.4, 3.8))
    for colour, (name, error) in zip((COLOURS[3], COLOURS[0]), curves.items(), strict=False):
        low, middle, high = np.quantile(_size(error), (0.25, 0.5, 0.75), axis=1)
        throws = np.arange(1, len(error) + 1)
        panel.plot(throws, middle, ".-", color=colour, label=f"{name} ({error.shape[1]})")
        panel.fill_between(throws, low, high, color=colour, alpha=0.15, lw=0)
    panel.axhline(1.0, color="black", linestyle="--", linewidth=1, label="5 mm and 2°")
    panel.set_yscale("log")
    panel.set_xlabel("throw")
    panel.set_ylabel("true error / (5 mm, 2°), the larger")
    panel.set_title(f"block pushed by the stoppers: {title}; median and quartiles", fontsize=10)
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8)
    return figure


PARTS = (Part("contact", contact_findings), Part("contact-reach", reach_findings))
