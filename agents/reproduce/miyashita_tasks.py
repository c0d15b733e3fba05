"""Sorting and assembly of Miyashita et al. 2010 (Figs. 13 to 18) in the simulator, with physical pallets."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Controller, Learner
from agents.environments import make_vector, stream_seed
from agents.evaluation import Throws, evaluate, practise, thrown
from agents.report.figures import frames_figure, svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.miyashita_cases import ARM
from agents.reproduce.miyashita_task_drawings import sorting_figure, task_motions_figure
from pnt_gym.cells.pallet.pallets import ASSEMBLY, SORTING, clear_vertical_speeds, clearance
from pnt_gym.cells.pallet.parts import BLOCK, block
from pnt_gym.metrics import wilson
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.one_joint import ThrowPlans, plan_throws
from pnt_gym.render.canvas import Frame
from pnt_gym.render.pallet import PalletView

RUNS: Final = 100
SUCCESS: Final = 0.95
"""Share of runs from which on a task counts as reproduced; the paper shows one run of each."""
STEEP: Final = 10.0
"""Largest angle off the vertical that counts as falling straight down [deg]."""
PRACTICE: Final = 120
"""Throws to learn from, over all pallets or parts."""
ROWS: Final = 16
"""Cells side by side."""
SPEEDS: Final = np.round(np.arange(-3.0, 0.01, 0.05), 2)
"""Vertical speeds at a goal that are tried [m/s]."""
FILMED: Final = 20
"""Frames per second."""
VIEW: Final = (slice(250, 570), slice(400, 880))
"""Rows and columns of a picture that show what moves."""
FLYING: Final = 0.75
"""Share of the flight after which a picture is taken."""


class Learnt(NamedTuple):
    """A controller after its practice, and its throws with other seeds."""

    controller: Controller
    throws: Throws


def sorting_findings(runs: int = RUNS, practice: int = PRACTICE) -> Findings:
    """Blocks into three pallets."""
    learnt = _thrown("OneJointSort-v0", 5 * runs, practice)
    # The pallet is drawn for each throw: the n-th throws into the three pallets are run n.
    each = [learnt.throws.is_success[learnt.throws.item == k] for k in range(len(SORTING))]
    least = min(runs, *(len(one) for one in each))
    done = np.stack([one[:least] for one in each])
    whole = done.all(axis=0)
    plans = plan_throws(np.stack([pallet.state for pallet in SORTING]))
    rows = [
        _success(
            "miyashita/sorting",
            whole,
            "runs of three throws, one into each pallet: all three at rest in their pallets and no other pallet "
            "touched",
            {"per_pallet": [int(one.sum()) for one in done], "practice": practice},
        ),
        *_flights(plans),
        _speeds_row(),
    ]
    figures = {
        "miyashita_sorting.svg": svg(sorting_figure(plans.u)),
        "miyashita_task_motions.svg": svg(task_motions_figure(plans, assembly_plans())),
    }
    return Findings(tuple(rows), {"miyashita_sorting": {"goals": [list(p.goal) for p in SORTING]}}, figures)


def _thrown(env_id: str, picks: int, practice: int) -> Learnt:
    """Practise with the virtual goal, then throw with other seeds."""
    env = make_vector(env_id, "nominal", ROWS, threads=1)
    try:
        controller = make_controller("virtual_goal", env)
        controller.reset(0)
        practise(controller, env, practice, seed=0)
        return Learnt(controller, evaluate(controller, env, picks, seed=0))
    finally:
        env.close()


def _success(name: str, done: Bools, what: str, details: dict[str, Any]) -> Row:
    rate = wilson(int(done.sum()), done.size)
    return Row(
        f"{name}/success",
        "successful",
        float(done.sum()),
        "-",
        "reproduced" if rate.value >= SUCCESS else "differs",
        f"of {done.size} {what}; every unmodelled effect at its realistic strength, ideal release, learned from "
        f"{details['practice']} throws by the virtual goal with K = 0.5. 95 % interval {100.0 * rate.low:.0f} to "
        f"{100.0 * rate.high:.0f} %",
        {"runs": int(done.size), **details},
    )


def _flights(plans: ThrowPlans) -> list[Row]:
    """How far the swept block stays from the pallets that it is not thrown at."""
    rows: list[Row] = []
    for k, pallet in enumerate(SORTING):
        others = [other for other in SORTING if other is not pallet]
        gap = float(clearance(plans.u[k : k + 1], BLOCK, others)[0])
        x, y, phi, dy = pallet.goal
        rows.append(
            Row(
                f"miyashita/sorting/clearance-{k + 1}",
                None,
                gap,
                "m",
                "ours",
                f"smallest gap between the swept block and the other pallets on the way to ({x:g} m, {y:g} m, "
                f"{np.rad2deg(phi):.0f} deg, {dy:g} m/s); the places of the paper's pallets are not published, but the "
                "first",
            )
        )
    return rows


def _speeds_row() -> Row:
    pallet = SORTING[2]
    clear = SPEEDS[clear_vertical_speeds(pallet, SPEEDS, BLOCK, SORTING)]
    free = SPEEDS[plan_throws(_with_speeds(pallet.state)).feasible]
    return Row(
        "miyashita/claim/vertical-speed-avoids-pallets",
        "larger or smaller collides",
        f"{clear.min():g} to {clear.max():g} m/s",
        "-",
        "reproduced" if clear.size < free.size else "differs",
        f"vertical speeds at which the third pallet is reached past the others by 5 mm and more; without the others "
        f"{free.min():g} to {free.max():g} m/s can be thrown",
    )


def _with_speeds(goal: Floats) -> Floats:
    goals = np.tile(goal, (SPEEDS.size, 1))
    goals[:, 3] = SPEEDS
    return goals


def assembly_plans() -> list[ThrowPlans]:
    """The H and the T, each with its own part on the arm."""
    return [plan_throws(np.array([goal]), arm=ARM, block=block(part)) for part, goal in ASSEMBLY]


def assembly_findings(runs: int = RUNS, practice: int = PRACTICE) -> Findings:
    """An H onto a fixed T, and a T onto the H."""
    learnt = _thrown("OneJointAssembly-v0", 2 * runs + ROWS * (runs // 25 + 2), practice)
    ended, whole = assemblies(learnt.throws)
    first = learnt.throws.item == 0
    rows = [
        _success(
            "miyashita/assembly",
            whole[:runs],
            "assemblies of two throws: both parts at rest, the second one joined to the first",
            {
                "practice": practice,
                "first_part": int(learnt.throws.is_success[first].sum()),
                "first_part_of": int(first.sum()),
                "ended": int(ended),
            },
        ),
        *_falls(),
    ]
    frames = assembly_frames(learnt.controller)
    figures = {"miyashita_assembly.svg": svg(frames_figure(frames))}
    return Findings(tuple(rows), {"miyashita_assembly": {"goals": [list(g) for _, g in ASSEMBLY]}}, figures)


def assemblies(throws: Throws) -> tuple[int, Bools]:
    """How many assemblies came to an end, and which of them were complete, in the order of their last throw."""
    over = (throws.item == 1) | ~throws.is_success
    return int(over.sum()), (throws.is_success & (throws.item == 1))[over]


def _falls() -> list[Row]:
    """How steeply the parts arrive."""
    rows: list[Row] = []
    for (part, goal), plans in zip(ASSEMBLY, assembly_plans(), strict=True):
        theta, omega, length, _ = plans.u[0]
        across = -length * omega * np.sin(theta + np.arcsin(part.half_height / length))
        off = float(np.rad2deg(np.arctan2(across, -goal[3])))
        rows.append(
            Row(
                f"miyashita/assembly/{part.name}-direction",
                "-y as much as possible",
                off,
                "deg",
                "reproduced" if abs(off) < STEEP else "differs",
                f"of the velocity at the goal off the vertical: {across:.2f} m/s across and {goal[3]:g} m/s up; the "
                "slots "
                "stand in that direction",
            )
        )
    return rows


def assembly_frames(controller: Controller, size: tuple[int, int] = (720, 960)) -> list[tuple[str, Frame]]:
    """Four pictures of an assembly by what the controller has learned.

    Raises:
        ConfigError: this machine cannot draw.
    """
    env = make_vector("OneJointAssembly-v0", "nominal", 1, threads=1)
    try:
        fresh = make_controller("virtual_goal", env)
        if isinstance(fresh, Learner) and isinstance(controller, Learner):
            fresh.restore(controller.state())
        core: Any = env.unwrapped.core  # pyright: ignore[reportAttributeAccessIssue]
        view = PalletView(core.cell, size)
        try:
            return _filmed(fresh, env, view)
        finally:
            view.close()
    finally:
        env.close()


def _filmed(controller: Controller, env: Any, view: PalletView) -> list[tuple[str, Frame]]:
    found: list[tuple[str, Frame]] = []
    throws = thrown(controller, env, len(ASSEMBLY), stream_seed("evaluate", 0))
    for name, plans, _ in zip(("H", "T"), assembly_plans(), throws, strict=True):
        frames = view.last_throw(FILMED)
        flying = float(plans.motion.duration[0] + FLYING * plans.u[0, 3])
        found += [(f"the {name} flies", frames[round(FILMED * flying)]), (f"the {name} lies", frames[-1])]
    return [(title, frame[VIEW]) for title, frame in found]


PARTS = (Part("sorting", sorting_findings), Part("assembly", assembly_findings))
