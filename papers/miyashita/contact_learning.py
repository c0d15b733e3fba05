"""Learning of the virtual goal when the stoppers push the block: goal by goal, and on the level `contact`."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from typing import Any, Final, NamedTuple

import numpy as np

from agents.controllers import make_controller
from agents.ground.drawings import COLOURS, Figure, dress, subplots
from agents.ground.environments import make_vector, stream_seed
from agents.judging.loop import practise, throw_batches, throw_held_out
from agents.judging.throws import Throws
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Bools, Floats, concatenate_records
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.tasks import PUSHED

from .cases import percent, round_values
from .reach import SCALES, SCANNED, WITHIN, Search, errors, goals_above_arm, paths, size

LEARNER: Final = "virtual_goal"
"""The controller that learns as the paper does."""
GOALS: Final = 34
"""Greatest number of goals to learn: the first reachable goals."""
SEARCHED: Final = 100
"""Number of goals for which a release is searched; about a third are reachable."""
PRACTICE, KEPT = 25, 5
"""Number of throws in which a controller explores, and number of throws afterwards with its final choice."""
REPEATS: Final = 8
"""Number of throws with the best release, whose scatter no controller removes."""
ANY_SPEED: Final = 10.0
"""Tolerance of the vertical speed [m/s], so wide that any speed is allowed."""
NEAR: Final = f"within {1e3 * WITHIN[0]:g} mm and {WITHIN[1]:g} deg"
SEEDS: Final = (0, 1, 2, 3, 4, 5)
"""Seeds of practice and of held-out throws."""
LEVEL_PRACTICE, HELD, ROWS = 240, 96, 16
"""Numbers of practice throws (some 30 per goal), of held-out throws, and of cells in the batch."""


class Course(NamedTuple):
    """Results of a controller's J throws at each of G goals, (G, J) each."""

    near: Bools
    """Whether the true state was within 5 mm and 2 deg of the goal."""
    refused: Bools
    """Whether the arm could not do the requested throw."""


def learning_findings(
    goals: int = GOALS, searched: int = SEARCHED, scanned: int = SCANNED, practice: int = PRACTICE
) -> Findings:
    """Share of learned goals among the goals that a pushed block can reach, and the share that scatter would allow."""
    goal, floor = reachable_goals(searched, scanned)
    goal, floor = goal[:goals], floor[:, :goals]
    headline = "Learning although the block is pushed, goals that some release reaches"
    if len(goal) == 0:
        return table_findings(headline, [_floor_row(floor)], drop="miyashita/")
    course = learn_goals(goal, practice)
    rows = [*_course_rows(course, practice), _floor_row(floor)]
    near = 100.0 * course.near.mean(axis=0)
    figures = {"miyashita_contact_learning.svg": course_figure(near, percent(floor))}
    curves = {"miyashita_contact_learning": {LEARNER: round_values(near, 4)}}
    return table_findings(headline, rows, figures, curves, drop="miyashita/")


def reachable_goals(searched: int, scanned: int) -> tuple[Floats, Bools]:
    """Goals (G, 4) that a release reaches, and whether each of R throws of that release came near (R, G)."""
    config, goal = OneJointConfig.load("contact"), goals_above_arm(searched)
    reached = Search(config, scanned).reach(goal)
    rows = np.flatnonzero(reached.miss < 1.0)
    near = [size(errors(paths(config, reached.share[rows], seed), goal[rows])) < 1.0 for seed in range(REPEATS)]
    return goal[rows], np.stack(near)


def learn_goals(goal: Floats, practice: int) -> Course:
    """Let the learner learn goals (G, 4), each goal with a new learner in a separate cell."""
    throws = [_learn(target, row, practice) for row, target in enumerate(goal)]
    return Course(np.array([t.is_success for t in throws]), np.array([t.clipped for t in throws]))


def level_config(goal: Floats) -> OneJointConfig:
    """Configuration of the cell with solid stoppers and a single goal of any vertical speed."""
    x, y, phi, dy = (float(value) for value in goal)
    return OneJointConfig.load(
        "contact",
        goals={"fixed": [{"x": x, "y": y, "phi_deg": float(np.rad2deg(phi)), "dy": dy}]},
        tolerance={"position": WITHIN[0], "angle_deg": WITHIN[1], "speed": ANY_SPEED},
        scale=SCALES,
    )


def _learn(goal: Floats, seed: int, practice: int) -> Throws:
    with closing(make_vector("OneJointThrow-v0", level_config(goal), num_envs=1, threads=1)) as env:
        controller: Any = make_controller(LEARNER, env)
        controller.reset(seed)
        controller.begin_practice(practice)
        parts = list(throw_batches(controller, env, practice, stream_seed("practice", seed), learn=True))
        controller.end_practice()
        parts += list(throw_batches(controller, env, KEPT, stream_seed("evaluate", seed), learn=True))
    return concatenate_records(parts)


def _course_rows(course: Course, practice: int) -> list[Row]:
    goals, throws = course.near.shape
    is_reached, last = np.any(course.near, axis=1), course.near[:, -KEPT:]
    is_kept = last.sum(axis=1) > KEPT // 2
    refused = course.refused[:, :practice]
    learned = f"of {goals} random goals (seed 0) that some release reaches, a cell and a {LEARNER} each"
    base = f"{learned}, the true state {NEAR}"
    return [
        Row.ours(
            f"miyashita/contact/{LEARNER}/once",
            percent(is_reached),
            "%",
            note=f"{base} at one of {throws} throws at least",
            goals=goals,
            throws=throws,
            first=[int(k) + 1 for k in course.near.argmax(axis=1)[is_reached]],
        ),
        Row.ours(
            f"miyashita/contact/{LEARNER}/kept",
            percent(is_kept),
            "%",
            note=f"{base} at most of the last {KEPT} of {throws} throws, after {practice} throws of practice. "
            f"{_refusals(refused, is_kept)}",
            share_last=percent(last),
            share_refused=percent(refused),
            share_refused_kept=percent(refused[is_kept]) if is_kept.any() else None,
            share_refused_lost=percent(refused[~is_kept]) if not is_kept.all() else None,
        ),
    ]


def _refusals(refused: Bools, is_kept: Bools) -> str:
    """Sentence on the share of throws that the arm could not do."""
    if not refused.any():
        return "No throw was spent on what the arm cannot do"
    if is_kept.all() or not is_kept.any():
        return f"{percent(refused):.0f} % of the practice asked for what the arm cannot do"
    return (
        f"Where it fails, {percent(refused[~is_kept]):.0f} % of the practice asked for what the arm cannot do, "
        f"elsewhere {percent(refused[is_kept]):.0f} %"
    )


def _floor_row(near: Bools) -> Row:
    throws, goals = near.shape
    share_near = percent(near) if goals > 0 else None
    return Row.ours(
        "miyashita/contact/best-release",
        percent(near.mean(axis=0) > 0.5) if goals > 0 else None,
        "%",
        note=f"of the same {goals} goals, {NEAR} at most of {throws} throws with the best release that was found, each "
        f"with scatter of its own: what a perfect controller would keep. {share_near or 0.0:.0f} % of all these throws "
        "are within",
        share_throws=share_near,
        goals=goals,
    )


def course_figure(near: Floats, floor: float) -> Figure:
    """Drawing of the share of goals [%] at which each throw came near (J,), and of the share that scatter allows."""
    figure, (panel,) = subplots(1, 1, (6.4, 3.6))
    panel.plot(np.arange(1, len(near) + 1), near, ".-", color=COLOURS[3], label=LEARNER)
    panel.axhline(floor, color="black", linestyle="--", linewidth=1, label="best release, with its scatter")
    end = len(near) + 0.5
    panel.axvspan(end - KEPT, end, color="black", alpha=0.06, lw=0)
    panel.text(end - 0.1, 2.0, "kept", ha="right", fontsize=8)
    panel.set_ylim(0.0, 100.0)
    dress(
        panel, "throw", "goals within 5 mm and 2° [%]", "block pushed by the stoppers: goals that some release reaches"
    )
    figure.legend(*panel.get_legend_handles_labels(), fontsize=8, ncols=3, loc="outside lower center")
    return figure


def level_findings(seeds: Sequence[int] = SEEDS, practice: int = LEVEL_PRACTICE, picks: int = HELD) -> Findings:
    """Success of held-out throws on the level `contact`, of the planner alone and after practice of the learner."""
    rows: list[Row] = []
    with closing(make_vector("OneJointThrow-v0", "contact", ROWS, threads=1)) as env:
        for name in ("analytic", LEARNER):
            controller, throws = make_controller(name, env), list[Throws]()
            for seed in seeds:
                controller.reset(seed)
                practise(controller, env, practice, seed)
                throws.append(throw_held_out(controller, env, picks, seed))
            rows.append(_level_row(name, throws, practice))
    return table_findings("Level contact", rows, drop="miyashita/")


def _level_row(name: str, throws: list[Throws], practice: int) -> Row:
    by_seed = [percent(record.is_success) for record in throws]
    practice_text = "" if name == "analytic" else f", after {practice} throws of practice with {len(PUSHED)} goals"
    note = (
        f"of {sum(map(len, throws))} held-out throws on the level `contact` {NEAR}{practice_text}, {len(throws)} "
        f"seeds, {ROWS} cells side by side"
    )
    return Row.ours(f"miyashita/contact/level/{name}", float(np.mean(by_seed)), "%", note=note, success_by_seed=by_seed)
