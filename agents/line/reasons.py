"""Table of a line's plans, the smallest plan that is enough, and the reason why it is not: in counted causes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import itemgetter
from typing import Any, Final

import numpy as np

from ..ground.tables import Grid, percent
from ..judging.losses import FATES
from .changes import Gain
from .goal import Goal
from .plans import Planned

MAJOR: Final = 0.25
"""Share of lost objects from which on a fate is named as a reason, and of a fate's objects for an item."""
BEST: Final = 4
"""Number of changes that a reason names at most, of those that help and of those that make no difference."""
VERBS: Final[Mapping[str, str]] = {
    "misplaced": "end in wrong bins",
    "missed": "are thrown and miss",
    "lost": "are lost on the way",
    "unsealed": "pass the end after picks in which the cup did not seal",
    "passed": "pass the end, not tried",
    "out_of_reach": "are out of reach: no robot can throw them into a bin that takes them",
}
"""Fates as parts of a sentence."""
THROWN: Final = ("misplaced", "missed", "lost")
"""Fates of objects that were thrown in vain."""

ENDED: Final = ("unsealed", "passed", "out_of_reach")
"""Fates of objects that passed the end of the belt."""


def table(title: str, plans: Sequence[Planned], goal: Goal) -> Grid:
    """Table of all plans, with the causes for which objects were not sorted.

    What is the same in all plans stands in the title, because a terminal has room for about twelve columns.
    """
    header = ["robots", "skills", "belt", "limits", "recovery", "sorted/min", "value/min", "at work"]
    header += ["missed", "unsealed", "not tried", "out of reach", "worst item", "J each", "money/h", "enough"]
    rows = [_row(plan, goal) for plan in plans]
    # What no level names, no goal asks for, or no object meets would only take room.
    idle = {"money/h"} if all(plan.row["money_per_hour"] is None for plan in plans) else set[str]()
    idle |= {"sorted/min"} if goal.figure == "recovery" else {"value/min"}
    idle |= {"out of reach"} if all(plan.row["fates"]["out_of_reach"] == 0.0 for plan in plans) else set[str]()
    alike = [name for name in ("skills", "belt", "limits") if len({row[header.index(name)] for row in rows}) == 1]
    parts = [title, *(f"{name} {rows[0][header.index(name)]}" for name in alike if name != "skills")]
    kept = [index for index, name in enumerate(header) if name not in idle | {*alike}]
    cells = [[row[index] for index in kept] for row in rows]
    return Grid(", ".join(parts), [header[index] for index in kept], cells)


def _row(plan: Planned, goal: Goal) -> list[str]:
    row, fates = plan.row, plan.row["fates"]
    # The item of which the least share is sorted, among those that came.
    came = [item for item, count in zip(plan.config.cell.items, plan.row["arrived"], strict=True) if count > 0.0]
    worst = min(came, key=lambda item: plan.row["fates_by_item"][item]["sorted"])
    energy, money = row["energy_per_sorted_j"], row["money_per_hour"]
    return [
        str(row["robots"]),
        row["skills"],
        f"{row['belt_speed']:.2f} m/s",
        f"{row['percent']:g} %",
        f"{100 * row['recovery']:.1f} ({100 * row['recovery_low']:.1f}..{100 * row['recovery_high']:.1f})",
        f"{row['sorted_per_min']:.1f}",
        f"{row['value_per_min']:.1f}",
        " ".join(f"{100 * share:.0f}" for share in row["utilisation"]),
        *(f"{100 * share:.1f}" for share in (sum(fates[n] for n in THROWN), *(fates[n] for n in ENDED))),
        f"{worst} {100 * row['fates_by_item'][worst]['sorted']:.1f}",
        "-" if energy is None else f"{energy:.1f}",
        "-" if money is None else f"{money:.2f}",
        "yes" if goal.is_reached(row) else "no",
    ]


def choose(plans: Sequence[Planned], goal: Goal) -> tuple[Planned, bool]:
    """The cheapest plan that reaches a goal, or else the best plan; and whether the plan reaches it.

    The cheapest plan is the one that earns the most where the level names costs, and the smallest one elsewhere.
    """
    enough = [plan for plan in plans if goal.is_reached(plan.row)]
    if not enough:
        return max(plans, key=lambda plan: plan.row[goal.figure]), False
    return min(enough, key=lambda plan: (-(plan.row["money_per_hour"] or 0.0), *_size(plan))), True


def _size(plan: Planned) -> tuple[float, ...]:
    """Numbers by which plans are ordered, the smallest first."""
    return plan.row["robots"], plan.row["percent"], plan.row["belt_speed"]


def answer(plan: Planned, is_enough: bool, goal: Goal) -> str:
    """The cheapest plan that reaches a goal, or the best one, in one sentence."""
    which = "smallest" if plan.row["money_per_hour"] is None else "cheapest"
    if is_enough:
        return f"the {which} plan with {goal.text(goal.least)}: {plan_text(plan.row)}"
    return (
        f"no plan reaches {goal.text(goal.least)}; the best plan, {plan_text(plan.row)}, reaches "
        f"{goal.text(plan.row[goal.figure]).removeprefix('a recovery of ')}"
    )


def check_text(checked: dict[str, Any]) -> str:
    """Figures of a plan in the full physics, in one sentence."""
    low, high = checked["over_table_low"], checked["over_table_high"]
    points = 100.0 * checked["over_table"]
    verdict = f"{abs(points):.1f} points {'more' if points > 0.0 else 'less'} than by the table"
    if low <= 0.0 <= high:
        verdict = "which agrees with the table"
    return (
        f"in the full physics {checked['shifts']} of these shifts sort {percent(checked['recovery'])} "
        f"({100.0 * checked['recovery_low']:.1f}..{100.0 * checked['recovery_high']:.1f}), {verdict}"
    )


def plan_text(row: dict[str, Any]) -> str:
    """A plan in words."""
    robots = "1 robot" if row["robots"] == 1 else f"{row['robots']} robots"
    return f"{robots} at {row['percent']:g} % and a belt at {row['belt_speed']:g} m/s"


def main_losses(plan: Planned) -> list[tuple[str, float]]:
    """Fates by which a plan loses objects, with their shares of all objects: the largest first, as far as they matter.

    A fate matters if it takes at least `MAJOR` of the lost objects.
    """
    fates = plan.row["fates"]
    lost = {name: fates[name] for name in FATES if name != "sorted"}
    total = sum(lost.values())
    ordered = sorted(lost.items(), key=itemgetter(1), reverse=True)
    return [(name, share) for name, share in ordered if share > 0.0 and share >= MAJOR * total]


def worst_items(plan: Planned, fate: str) -> list[int]:
    """Items with large shares of the objects of a fate, the largest first; of many small shares the first."""
    weight = np.array([count * plan.shares(item)[fate] for item, count in enumerate(plan.row["arrived"])])
    worst = np.argsort(-weight, kind="stable")
    return worst[: max(int((weight >= MAJOR * weight.sum()).sum()), 1)].tolist()


def worst_item(plan: Planned) -> str:
    """The item that loses the most objects by the largest loss; the first item where no object is lost."""
    found = main_losses(plan)
    return plan.config.cell.items[worst_items(plan, found[0][0])[0] if found else 0]


def reason(plan: Planned, gains: Sequence[Gain]) -> str:
    """What keeps a plan from sorting more, the largest loss first, and what changes bring, in one sentence.

    Args:
        plan: the plan.
        gains: what changes bring, the best first.
    """
    found = main_losses(plan)
    if not found:
        return "no object was lost"
    causes = ", and ".join(_cause(plan, fate, share) for fate, share in found)
    # The best one of each kind, such as of all robots that were tried.
    first = {gain.what: gain for gain in reversed(gains)}
    kinds = [gain for gain in gains if first[gain.what] is gain]
    better = [gain for gain in kinds if gain.points.low > 0.0][:BEST]
    alike = [gain.words for gain in kinds if gain.points.low <= 0.0 <= gain.points.high][:BEST]
    texts = [f"{_points(gain)} with {gain.words}" for gain in better]
    if better:
        causes += f"; over the same shifts recovery rises by {', by '.join(texts)}"
    elif gains:
        causes += "; no change that was tried brings more"
    return f"the reason: {causes}" + (f"; no difference with {', with '.join(alike)}" if alike else "")


def _cause(plan: Planned, fate: str, share: float) -> str:
    """A loss in words: the share of all objects, its worst items, and for objects that nobody tried the robots."""
    items, worst = plan.config.cell.items, worst_items(plan, fate)
    texts = ", ".join(f"{percent(plan.shares(item)[fate])} of {items[item]}" for item in worst)
    text = f"{percent(share)} of all objects {VERBS[fate]} ({texts})"
    if fate != "passed":
        return text
    takers = np.flatnonzero(plan.config.can_take()[:, worst].any(axis=1)).tolist()
    names = ", ".join(plan.config.robots[robot].name for robot in takers)
    times = ", ".join(percent(plan.row["utilisation"][robot]) for robot in takers)
    return f"{text}; taken by {names}, at work {times}"


def _points(gain: Gain) -> str:
    """A gain in points with its interval."""
    value, low, high = (100.0 * part for part in (gain.points.value, gain.points.low, gain.points.high))
    return f"{value:.1f} points ({low:.1f}..{high:.1f})"
