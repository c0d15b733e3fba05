"""Table of a line's plans, the smallest plan that is enough, and the reason why it is not: in counted causes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from ..ground.tables import Grid, percent
from .plans import Planned

MAJOR: Final = 0.25
"""Share of all objects thrown in vain from which on an item is named as a reason."""
THROWN: Final = ("misplaced", "missed", "lost")
"""Fates of objects that were thrown in vain."""

ENDED: Final = ("unsealed", "passed", "out_of_reach")
"""Fates of objects that passed the end of the belt."""


def table(title: str, plans: Sequence[Planned], recovery: float) -> Grid:
    """Table of all plans, with the causes for which objects were not sorted.

    What is the same in all plans stands in the title, because a terminal has room for about twelve columns.
    """
    header = ["robots", "skills", "belt", "limits", "recovery", "value/min", "at work"]
    header += ["missed", "unsealed", "not tried", "out of reach", "worst item", "J each", "money/h", "enough"]
    rows = [_row(plan, recovery) for plan in plans]
    # Money that no level names would only take room.
    idle = {"money/h"} if all(plan.row["money_per_hour"] is None for plan in plans) else set[str]()
    alike = [name for name in ("skills", "belt", "limits") if len({row[header.index(name)] for row in rows}) == 1]
    parts = [title, *(f"{name} {rows[0][header.index(name)]}" for name in alike if name != "skills")]
    kept = [index for index, name in enumerate(header) if name not in idle | {*alike}]
    cells = [[row[index] for index in kept] for row in rows]
    return Grid(", ".join(parts), [header[index] for index in kept], cells)


def _row(plan: Planned, recovery: float) -> list[str]:
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
        f"{row['value_per_min']:.1f}",
        " ".join(f"{100 * share:.0f}" for share in row["utilisation"]),
        *(f"{100 * share:.1f}" for share in (sum(fates[n] for n in THROWN), *(fates[n] for n in ENDED))),
        f"{worst} {100 * row['fates_by_item'][worst]['sorted']:.1f}",
        "-" if energy is None else f"{energy:.1f}",
        "-" if money is None else f"{money:.2f}",
        "yes" if row["recovery_low"] >= recovery else "no",
    ]


def choose(plans: Sequence[Planned], recovery: float) -> tuple[Planned, bool]:
    """The smallest plan that reaches a recovery, or else the best plan; and whether the plan reaches it."""
    enough = [plan for plan in plans if plan.row["recovery_low"] >= recovery]
    if not enough:
        return max(plans, key=lambda plan: plan.row["recovery"]), False
    return min(enough, key=lambda plan: (plan.row["robots"], plan.row["percent"], plan.row["belt_speed"])), True


def answer(plan: Planned, is_enough: bool, recovery: float) -> str:
    """The smallest plan that reaches the recovery, or the best one, in one sentence."""
    if is_enough:
        return f"the smallest plan with a recovery of {percent(recovery)}: {_plan(plan.row)}"
    return (
        f"no plan reaches a recovery of {percent(recovery)}; the best plan, {_plan(plan.row)}, reaches "
        f"{percent(plan.row['recovery'])}"
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


def _plan(row: dict[str, Any]) -> str:
    """A plan in words."""
    robots = "1 robot" if row["robots"] == 1 else f"{row['robots']} robots"
    return f"{robots} at {row['percent']:g} % and a belt at {row['belt_speed']:g} m/s"


def throws_are_the_reason(plan: Planned, recovery: float) -> bool:
    """Whether throws keep a plan from a recovery, and not the objects that pass the end."""
    fates = plan.row["fates"]
    # Throws cost the plan more objects than all that pass the end.
    is_thrown_badly = sum(fates[name] for name in THROWN) > fates["passed"] + fates["unsealed"]
    return is_thrown_badly or plan.bound < recovery


def reason(
    plan: Planned, recovery: float, release: str, twin: tuple[str, Planned], changes: Mapping[str, float]
) -> str:
    """What keeps a plan from sorting more, in one sentence that follows from counted causes.

    Args:
        plan: the plan.
        recovery: recovery to reach.
        release: name of the plan's release.
        twin: name of another release, and the same plan with it.
        changes: recovery of the same plan with one thing changed, by words for the change.
    """
    if throws_are_the_reason(plan, recovery):
        better, other = twin
        helps = "more robots do not help" if plan.bound < recovery else "better throws help more than more robots"
        items = plan.config.cell.items
        # Indices of the items that make up most of the objects thrown in vain, the one that misses most often first.
        losses = np.array(plan.row["arrived"]) * [plan.thrown_badly(item) for item in range(len(items))]
        vain = sorted(np.flatnonzero(losses >= MAJOR * losses.sum()).tolist(), key=plan.thrown_badly, reverse=True)
        texts = [_text(plan, index) for index in vain]
        others = [f"{percent(other.thrown_badly(index))} of {items[index]}" for index in vain]
        return (
            f"the reason: {' and '.join(texts)}, so {helps}: with every object picked these throws sort "
            f"{percent(plan.bound)}; release {better} loses {' and '.join(others)}, and the plan sorts "
            f"{percent(other.row['recovery'])} instead of {percent(plan.row['recovery'])} with {release}"
        )
    fates = plan.row["fates"]
    cause = max(("passed", "unsealed"), key=fates.__getitem__)
    items = plan.config.cell.items
    weight = [count * plan.shares(index)[cause] for index, count in enumerate(plan.row["arrived"])]
    worst = int(np.argmax(weight))
    head = f"the reason: {percent(plan.shares(worst)[cause])} of {items[worst]} pass the end"
    if cause == "unsealed":
        return f"{head} after picks in which the cup did not seal{_changes_text(changes)}"
    takers = np.flatnonzero(plan.config.can_take()[:, worst]).tolist()
    names = ", ".join(plan.config.robots[index].name for index in takers)
    times = ", ".join(percent(plan.row["utilisation"][index]) for index in takers)
    return f"{head}, not tried; taken by {names}, at work {times}{_changes_text(changes)}"


def _changes_text(changes: Mapping[str, float]) -> str:
    """What changes of a plan bring, as the end of a sentence."""
    texts = [f"{percent(recovery)} with {words}" for words, recovery in changes.items()]
    return f"; by the same table the plan would sort {', '.join(texts)}" if texts else ""


def _text(plan: Planned, item: int) -> str:
    """How an item is thrown in vain, in words."""
    shares, name = plan.shares(item), plan.config.cell.items[item]
    cause = max(THROWN, key=shares.__getitem__)
    verb = {"misplaced": "ends in wrong bins", "missed": "misses", "lost": "is lost on the way"}[cause]
    return f"{name} is thrown and {verb} ({percent(plan.thrown_badly(item))})"
