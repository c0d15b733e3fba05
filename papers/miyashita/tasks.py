"""Sorting and assembly of Miyashita et al. (Figs. 13 to 18) in the simulator, with physical pallets.

The paper shows a single run of each task. Its pallets, parts and gains are not published, so they are chosen here, and
the figures get no verdict by the paper's words.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from typing import Any, Final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Controller, Learner
from agents.ground.drawings import COLOURS, WIDTH, Figure, frames_figure, subplots, tile_panels
from agents.ground.environments import core_of, make_vector, stream_seed
from agents.ground.metrics import wilson
from agents.judging.loop import practise, throw_batches, throw_held_out
from agents.judging.throws import Throws
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.base.canvas import Frame
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.one_joint.pallets import ASSEMBLY, SORTING
from pnt_gym.cells.one_joint.parts import BLOCK, block
from pnt_gym.cells.one_joint.view import DOTS, camera
from pnt_gym.planning.one_joint import ThrowPlans, landing_state, plan_throws

from .cases import ARM
from .drawings import draw_arm, draw_flight, draw_motion, draw_pallets, draw_plane
from .passing import clear_vertical_speeds, clearance, flight_poses

RUNS: Final = 100
"""Number of runs of each task."""
PRACTICE: Final = 120
"""Number of practice throws over all pallets or parts."""
GAIN: Final = 0.5
"""Gain K of the learning, which the paper does not print."""
ROWS: Final = 16
"""Number of cells in the batch."""
SPEEDS: Final[Floats] = np.linspace(-3.0, 3.0, 121).round(2)
"""Vertical speeds at a goal that are checked [m/s]."""
ORDINALS: Final = ("first", "second", "third")
DISTINCT: Final = 0.01
"""Distance between flights that counts as another path; the square of it is the tolerance of their common end [m]."""
PICTURES: Final = 14
"""Number of pictures of the block along a flight."""
FILMED: Final = 20
"""Frames per second."""
VIEW: Final = (slice(250, 570), slice(400, 880))
"""Rows and columns of a picture that are kept."""
FLYING: Final = 0.75
"""Moment of a picture as a share of the flight."""


def _practise_and_throw(env_id: str, picks: int, practice: int) -> tuple[Controller, Throws]:
    """The controller `virtual_goal` after its practice, and its held-out throws."""
    with closing(make_vector(env_id, "nominal", ROWS, threads=1)) as env:
        controller = make_controller("virtual_goal", env, gain=GAIN)
        controller.reset(0)
        practise(controller, env, practice, seed=0)
        return controller, throw_held_out(controller, env, picks, seed=0)


def _success_row(name: str, successes: Bools, description: str, practice: int, **details: Any) -> Row:
    rate = wilson(int(successes.sum()), successes.size)
    return Row.ours(
        f"{name}/success",
        float(successes.sum()),
        "-",
        beside="successful",
        note=f"of {successes.size} {description}; every unmodelled effect at its realistic strength, ideal release, "
        f"learned from {practice} throws by the virtual goal with K = {GAIN:g}. 95 % interval {100.0 * rate.low:.0f} "
        f"to {100.0 * rate.high:.0f} %. The paper's only failures, turns of the part out of the plane of the throw, "
        "cannot occur: parts move in that plane here",
        runs=int(successes.size),
        practice=practice,
        **details,
    )


def sorting_findings(runs: int = RUNS, practice: int = PRACTICE) -> Findings:
    """Success of runs that sort blocks into three pallets, clearances, and vertical speeds."""
    throws = _practise_and_throw("OneJointSort-v0", 5 * runs, practice)[1]
    # The pallet is drawn for each throw: the n-th throws into the three pallets are run n.
    successes_by_pallet = [throws.is_success[throws.item == k] for k in range(len(SORTING))]
    count = min(runs, *(len(flags) for flags in successes_by_pallet))
    successes = np.stack([flags[:count] for flags in successes_by_pallet])
    description = (
        "runs of three throws, one into each pallet: all three at rest in their pallets and no other pallet touched"
    )
    plans = plan_throws(np.stack([pallet.state for pallet in SORTING]))
    rows = (
        _success_row(
            "miyashita/sorting",
            np.all(successes, axis=0),
            description,
            practice,
            per_pallet=successes.sum(axis=1).tolist(),
        ),
        *(_clearance_row(k, plans.u) for k in range(len(SORTING))),
        *(_speeds_row(k) for k in range(len(SORTING))),
        _paths_row(),
    )
    figures = {
        "miyashita_sorting.svg": sorting_figure(plans.u),
        "miyashita_task_motions.svg": motions_figure(plans, assembly_plans()),
    }
    data = {"miyashita_sorting": {"goals": [list(pallet.goal) for pallet in SORTING]}}
    return table_findings("Sorting in the simulator", rows, figures, data, drop="miyashita/")


def _clearance_row(k: int, u: Floats) -> Row:
    """Row with the smallest gap between the block's flight to pallet k and the other pallets."""
    pallets = [pallet for pallet in SORTING if pallet is not SORTING[k]]
    x, y, phi, dy = SORTING[k].goal
    return Row.ours(
        f"miyashita/sorting/clearance-{k + 1}",
        float(clearance(u[k : k + 1], BLOCK, pallets)[0]),
        "m",
        note=f"smallest gap between the swept block and the other pallets on the way to ({x:g} m, {y:g} m, "
        f"{np.rad2deg(phi):.0f} deg, {dy:g} m/s); the places of the paper's pallets are not published, but the first",
    )


def _speeds_row(k: int) -> Row:
    """Row with the vertical speeds that avoid the other pallets (section 6.3), for pallet k."""
    pallet = SORTING[k]
    clear = SPEEDS[clear_vertical_speeds(pallet, SPEEDS, BLOCK, SORTING)]
    free = _thrown_speeds(pallet.state)[0]
    own = "" if k == 2 else f"-pallet-{k + 1}"
    return Row.ours(
        f"miyashita/claim/vertical-speed-avoids-pallets{own}",
        f"{clear.min():g} to {clear.max():g} m/s",
        "-",
        beside="larger or smaller collides" if k == 2 else None,
        note=f"vertical speeds at which the {ORDINALS[k]} pallet is reached past the others by 5 mm and more; without "
        f"the others {free.min():g} to {free.max():g} m/s can be thrown. The pallets stand where they were chosen to",
    )


def _thrown_speeds(goal: Floats) -> tuple[Floats, Floats]:
    """The `SPEEDS` with which throws reach the pose of a goal (4,), and their releases (N, 4)."""
    goals: Floats = np.tile(goal, (SPEEDS.size, 1))
    goals[:, 3] = SPEEDS
    plans = plan_throws(goals)
    return SPEEDS[plans.feasible], plans.u[plans.feasible]


def _paths_row() -> Row:
    """Row on section 3.2: the vertical speed at the goal leads to paths of various loci to one and the same pose."""
    speeds, releases = _thrown_speeds(SORTING[0].state)
    poses = flight_poses(releases, BLOCK.half_height)
    middles = poses[:, poses.shape[1] // 2, :2]
    ends = poses[:, -1]
    spread, miss = float(np.linalg.norm(middles - middles[:1], axis=1).max()), float(np.ptp(ends, axis=0).max())
    return Row.compared(
        "miyashita/claim/vertical-speed-chooses-path",
        "various loci to the same pose",
        spread,
        "m",
        holds=spread > DISTINCT and miss < DISTINCT**2,
        note=f"largest distance between the middles of {len(speeds)} flights to the published goal's pose, with "
        f"vertical speeds of {speeds.min():g} to {speeds.max():g} m/s there; their ends agree within {miss:.0e}",
        speeds=speeds.tolist(),
    )


def assembly_plans() -> list[ThrowPlans]:
    """Plans of the throws of the H and of the T, each with its part on the arm."""
    return [plan_throws(np.array([goal]), arm=ARM, block=block(part)) for part, goal in ASSEMBLY]


def assembly_findings(runs: int = RUNS, practice: int = PRACTICE) -> Findings:
    """Success of assemblies of two throws: an H onto a fixed T, and a T onto the H."""
    controller, throws = _practise_and_throw("OneJointAssembly-v0", 2 * runs + ROWS * (runs // 25 + 2), practice)
    ended, complete = count_assemblies(throws)
    first = throws.is_success[throws.item == 0]
    description = "assemblies of two throws: both parts at rest, the second one joined to the first"
    counts = {"first_part": int(first.sum()), "first_part_of": first.size, "ended": ended}
    rows = (_success_row("miyashita/assembly", complete[:runs], description, practice, **counts), *_fall_rows())
    figures = {"miyashita_assembly.svg": frames_figure(assembly_frames(controller))}
    data = {"miyashita_assembly": {"goals": [list(goal) for _, goal in ASSEMBLY]}}
    return table_findings("Assembly in the simulator", rows, figures, data, drop="miyashita/")


def count_assemblies(throws: Throws) -> tuple[int, Bools]:
    """Number of ended assemblies, and whether each of them is complete, in the order of their last throws."""
    is_last = (throws.item == 1) | ~throws.is_success
    return int(is_last.sum()), (throws.is_success & (throws.item == 1))[is_last]


def _fall_rows() -> Iterator[Row]:
    """Rows with the directions in which the parts arrive."""
    for (part, goal), plans in zip(ASSEMBLY, assembly_plans(), strict=True):
        theta, omega, length, flight = plans.u[0]
        start = landing_state(np.array([theta, omega, length, 0.0]), part.half_height)
        across = (goal[0] - start[0]) / flight
        yield Row.ours(
            f"miyashita/assembly/{part.name}-direction",
            float(np.rad2deg(np.arctan2(across, -goal[3]))),
            "deg",
            beside="-y as much as possible",
            note=f"of the velocity at the goal off the vertical: {across:.2f} m/s across and {goal[3]:g} m/s up; "
            "the slots stand in that direction",
        )


def assembly_frames(controller: Controller) -> list[tuple[str, Frame]]:
    """Four pictures of an assembly by a controller after its practice.

    Raises:
        ConfigError: this machine cannot draw.
    """
    with closing(make_vector("OneJointAssembly-v0", "nominal", 1, threads=1)) as env:
        fresh = make_controller("virtual_goal", env, gain=GAIN)
        if isinstance(fresh, Learner) and isinstance(controller, Learner):
            fresh.restore(controller.state())
        cell: Any = core_of(env).cell
        with closing(ThrowView(cell, camera(), DOTS, (720, 960))) as view:
            return _film(fresh, env, view)


def _film(controller: Controller, env: Any, view: ThrowView) -> list[tuple[str, Frame]]:
    frames: list[tuple[str, Frame]] = []
    throws = throw_batches(controller, env, len(ASSEMBLY), stream_seed("evaluate", 0))
    for name, plans, _ in zip(("H", "T"), assembly_plans(), throws, strict=True):
        moment = float(plans.motion.duration[0] + FLYING * plans.u[0, 3])
        frames += [(f"the {name} flies", view.at(moment, FILMED)), (f"the {name} lies", view.at(np.inf, FILMED))]
    return [(title, frame[VIEW]) for title, frame in frames]


def sorting_figure(u: Floats) -> Figure:
    """Drawing of the flights from releases (3, 4) into the three pallets, each past the other pallets (Fig. 13)."""
    figure, axes = tile_panels(3, 2, (WIDTH / 2, 3.4))
    for k, panel in enumerate(axes):
        draw_arm(panel, float(u[k, 0]))
        draw_pallets(panel, SORTING)
        draw_flight(panel, u[k], COLOURS[k], PICTURES)
        x, y, phi, dy = SORTING[k].goal
        title = f"({x:g} m, {y:g} m, {np.rad2deg(phi):.0f}°, {dy:g} m/s)"
        draw_plane(panel, (-0.52, 0.36), (-0.30, 0.56), title)
    return figure


def motions_figure(sorting: ThrowPlans, assembly: Sequence[ThrowPlans]) -> Figure:
    """Drawing of the arm's planned motions to the releases (Figs. 14 and 17)."""
    figure, axes = subplots(3, 1, (WIDTH, 8.0), sharex=True)
    throws = [(f"sorting, throw {k + 1}", take(sorting, [k])) for k in range(len(sorting.u))]
    throws += [(f"assembly, throw {k + 1}", plans) for k, plans in enumerate(assembly)]
    for colour, (name, plans) in zip(COLOURS, throws, strict=False):
        end = float(plans.motion.duration[0])
        draw_motion(axes, plans.motion, end, color=colour, label=name, marker="o", markersize=4, markevery=[-1])
    for panel in axes:
        panel.label_outer()
    axes[1].axhline(ARM.speed, color="black", linestyle="--", linewidth=1)
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=3, loc="outside lower center")
    return figure
