"""How a throw is computed: the stages of one step, as a table and as a drawing of the rooms that they pass."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import dataclass
from html import escape
from operator import attrgetter
from typing import Any, Final

from .marks import table


@dataclass(frozen=True)
class Stage:
    """One stage of a step."""

    name: str
    functions: tuple[str, ...]
    """As MODULE:NAME; the room of the first function is the room of the stage."""
    text: str


ROOMS: Final = {
    "agents": "agents",
    "pnt_gym.envs": "envs",
    "pnt_gym.cells.conveyor": "cells/conveyor",
    "pnt_gym.cells.base": "cells/base",
    "pnt_gym.robots": "robots",
    "pnt_gym.planning": "planning",
}
"""Titles of the rooms by the beginning of their modules, from left to right: none imports a room to its left."""
BASE: Final = "pnt_gym.cells.base"
CONVEYOR: Final = "pnt_gym.cells.conveyor"
STAGES: Final = (
    Stage(
        "observation",
        (f"{BASE}.cell:Cell.observe", f"{BASE}.features:FeatureTable.encode"),
        "The cell holds the coming pick and its nominal plan. The observation is the measured features of both, as "
        "(value - centre) / scale. Hidden values stay out.",
    ),
    Stage(
        "action",
        ("agents.controllers.protocol:Controller.act",),
        "The controller answers the observation with an action in [-1, 1]. Zero is the nominal plan.",
    ),
    Stage(
        "step",
        ("pnt_gym.envs.base:CoreEnv.step",),
        "The facade passes the action on, and later turns arrays of one row into a reward and an `info`.",
    ),
    Stage(
        "check",
        (f"{BASE}.core:Core.step", f"{BASE}.action:clip_actions"),
        "The core checks shape and numbers of the action, and clips it.",
    ),
    Stage(
        "correction",
        (f"{BASE}.action:corrected",),
        "The action mode reads the action as a residual on the nominal plan. A residual without a feasible plan is "
        "shortened, by bisection, to the longest part with a feasible plan; `residual_clipped` reports it.",
    ),
    Stage(
        "plan",
        ("pnt_gym.planning.straight.release:aim_lines",),
        "The planner computes the release for the shifted target, at the planned elevation. The mode `virtual_goal` "
        "plans from scratch instead, with `plan_release_batch`.",
    ),
    Stage(
        "motion",
        (
            f"{CONVEYOR}.cell:ConveyorCell.throw",
            f"{CONVEYOR}.movers.tracking:TrackingMover.throw",
            f"{CONVEYOR}.cup.hold:picked",
            f"{CONVEYOR}.cup.hold:grips",
        ),
        "The plan becomes a path of the hand: ride with the belt, throw, follow-through. The cup seals or not, and "
        "holds the load of this path or not.",
    ),
    Stage(
        "next object",
        (f"{CONVEYOR}.belt.belt_picks:BeltPicks.following",),
        "The next object is chosen on the belt, and planned, with the way back of the hand. `PnTRelease-v0` has no "
        "belt and draws a pick instead.",
    ),
    Stage(
        "references",
        ("pnt_gym.robots.t3kr.kinematics:joint_knots", f"{CONVEYOR}.hand:ThrowClock.of"),
        "Path and way back become positions, speeds and torques of the motors, for every step of the physics.",
    ),
    Stage(
        "rollout",
        (f"{BASE}.plant:roll_out", f"{CONVEYOR}.plant:ConveyorPlant.fly"),
        "MuJoCo simulates all cells of the batch in its own threads: one `Batch.rollout`, without Python inside. The "
        "object leaves the cup late by the delay of its vacuum.",
    ),
    Stage(
        "flight",
        (f"{CONVEYOR}.free:FreeObjects.fall", f"{BASE}.recorded:Touchdown.landing_fields"),
        "Once object and cup are clear of each other, the object flies on without the robot, through the air and into "
        "the bin. The landing is where it crosses the plane of the rim.",
    ),
    Stage(
        "judge",
        (f"{CONVEYOR}.outcome:judge",),
        "The outcome is computed once and complete: landing, success, cycle time, bin, energy.",
    ),
    Stage(
        "reward",
        (f"{CONVEYOR}.cell:ConveyorCell.reward", f"{CONVEYOR}.cell:ConveyorCell.info"),
        "The reward is the sum of weighted terms of the outcome; `info` has the outcome and every term. The next "
        "observation follows.",
    ),
    Stage(
        "learning",
        ("agents.controllers.protocol:Learner.learn",),
        "A controller that learns receives the errors of the throws, in the coordinates that its actions shift.",
    ),
)
"""Of a step of `PnTConveyor-v0`, level `waste`."""
LANE: Final = 132
ROW: Final = 46
TOP: Final = 44
LEFT: Final = 34
WIDTH: Final = LEFT + LANE * len(ROOMS)
"""Of the drawing [pixels]."""


def function(name: str) -> Any:
    """The function that a stage names.

    Raises:
        AttributeError, ModuleNotFoundError: there is no such function.
    """
    module, _, path = name.partition(":")
    return attrgetter(path)(importlib.import_module(module))


def resolve(name: str) -> Any:
    """What a dotted name is: a module, a class, a function, or an attribute of one.

    Raises:
        AttributeError, ModuleNotFoundError: there is nothing of this name.
    """
    return pkgutil.resolve_name(name)


def stage_table(_: str) -> str:
    """A table of the stages, with the functions of each."""
    rows = [
        (
            f"{number}. {stage.name}".replace(" ", "&nbsp;"),
            ", ".join(f"`{_function_name(name)}`" for name in stage.functions),
            stage.text,
        )
        for number, stage in enumerate(STAGES, 1)
    ]
    return table(("stage", "functions", "what happens"), rows)


def _function_name(name: str) -> str:
    function(name)
    return name.partition(":")[2]


def _lane(stage: Stage) -> int:
    """Which room a stage is in, from the left."""
    return next(lane for lane, room in enumerate(ROOMS) if f"{stage.functions[0]}.".startswith(f"{room}."))


def drawing() -> str:
    """The rooms as columns, the stages from top to bottom, as SVG."""
    height = TOP + ROW * len(STAGES) + 6
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
        'font-family="sans-serif" font-size="13">',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 0 8 4 0 8z" fill="#555"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>',
    ]
    for lane, title in enumerate(ROOMS.values()):
        x = LEFT + lane * LANE
        parts.append(f'<rect x="{x}" y="6" width="{LANE - 4}" height="{height - 12}" rx="6" fill="#f2f5f9"/>')
        parts.append(f'<text x="{x + LANE / 2 - 2}" y="27" text-anchor="middle" font-weight="bold">{title}</text>')
    for number, (stage, below) in enumerate(zip(STAGES, (*STAGES[1:], None), strict=True)):
        parts += _box(number, stage)
        if below is not None:
            parts.append(_arrow(number, _lane(stage), _lane(below)))
    return "\n".join([*parts, "</svg>", ""])


def _box(number: int, stage: Stage) -> list[str]:
    """A stage with its number and name, in the column of its room."""
    x, y = LEFT + _lane(stage) * LANE + 8, TOP + number * ROW
    title = escape(", ".join(map(_function_name, stage.functions)))
    return [
        f'<text x="{LEFT - 8}" y="{y + 19}" text-anchor="end" fill="#555">{number + 1}</text>',
        f'<rect x="{x}" y="{y}" width="{LANE - 20}" height="30" rx="5" fill="#0b5cad"><title>{title}</title></rect>',
        f'<text x="{x + LANE / 2 - 10}" y="{y + 20}" text-anchor="middle" fill="#fff">{escape(stage.name)}</text>',
    ]


def _arrow(number: int, lane: int, below: int) -> str:
    """From a stage down to the one after it."""
    start, end = (LEFT + column * LANE + LANE // 2 - 2 for column in (lane, below))
    y = TOP + number * ROW + 30
    middle = y + (ROW - 30) // 2
    way = f"M{start} {y} V{middle} H{end} V{y + ROW - 30}"
    return f'<path d="{way}" fill="none" stroke="#555" stroke-width="1.5" marker-end="url(#tip)"/>'
