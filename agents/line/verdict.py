"""The verdict on a line's plans: which plan is enough, or why none is, and whether air jets could do it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from .jets import stations_text
from .planned import Conditions, Planned, judge_plan
from .reasons import answer, chosen_plan, reason

ANALYTIC: Final = "analytic"
LEARNED: Final = "shipped:waste-sac"
"""Release with which the analytic one is compared."""


@dataclass(frozen=True)
class Verdict:
    """Verdict on plans with one release, compared with another release."""

    plan: Planned
    """The smallest plan that reaches the recovery, or else the best one."""
    release: str
    twin: Planned
    """The same plan with the other release."""
    other_release: str
    sentences: tuple[str, ...]
    """The plan, the reason why it does not sort more, and arm against jet."""

    @property
    def entries(self) -> dict[str, Any]:
        """The verdict by the names of the JSON contract."""
        other = {"release": self.other_release, **self.twin.row}
        return {"release": self.release, "sentences": list(self.sentences), "other_release": other}


def give_verdict(plans: Sequence[Planned], recovery: float, conditions: Conditions, release: str | None) -> Verdict:
    """The verdict on plans; judges the chosen plan once more, with another release.

    Args:
        plans: all plans, with one release.
        recovery: recovery to reach.
        conditions: how plans are judged.
        release: the plans' release; None for the analytic one.
    """
    plan, is_enough = chosen_plan(plans, recovery)
    name, other = (ANALYTIC, LEARNED) if release is None else (release, ANALYTIC)
    config = plan.config.model_copy(update={"chances": None})
    numbers = {key: plan.row[key] for key in ("robots", "belt_speed", "percent", "skills")}
    twin = judge_plan(numbers, config, conditions, None if other == ANALYTIC else other)
    sentences = (
        answer(plan, is_enough, recovery),
        reason(plan, plans, recovery, name, (other, twin)),
        stations_text(plan.row["against"], plan.row["recovery"], plan.row["energy_per_sorted_j"]),
    )
    return Verdict(plan, name, twin, other, sentences)
