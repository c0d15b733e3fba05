"""Work shifts of lines as arrays: whole shifts, with the same streams of objects for all controllers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.core import LineCore

from ...controllers.protocol import Controller
from ...dispatchers.decisions import work_shifts
from ...dispatchers.registry import line_core
from ...ground.environments import Env
from ...ground.infos import results

MEANS: Final = {
    "value_per_min": "shift_value_per_min",
    "sorted_per_min": "shift_sorted_per_min",
    "recovery": "shift_recovery",
    "value_recovery": "shift_value_recovery",
    "purity": "shift_purity",
    "passed_value_per_min": "shift_passed_value_per_min",
    "passed_tried": "shift_passed_tried",
}
"""Info keys of the figures that are averaged over shifts, by name."""
LISTS: Final = {
    "utilisation": "shift_utilisation",
    "picks_by_robot": "shift_picks_by_robot",
    "recovery_by_item": "shift_recovery_by_item",
    "passed_by_item": "shift_passed_by_item",
}
"""Info keys of the figures by robot or item that are averaged over shifts, by name."""
RECORDED: Final = (
    "by", "object", "item", "true_kind", "bin", "percent", "start", "cycle_time", "wait_time", "value", "picked",
    "is_success", "sorted", "ended_in",
)  # fmt: skip
"""Info keys that are kept for each decision."""
SIMULATED: Final = ("energy", "lost", "miss_x", "miss_y")
"""Columns of decisions that only simulated throws have."""


@final
@dataclass(frozen=True)
class Shifts:
    """S work shifts, and the T decisions in them."""

    figures: dict[str, NDArray[Any]]
    """Figures of the shifts by info key, (S, ...) each."""
    decisions: dict[str, NDArray[Any]]
    """Values of the decisions by info key (T,), and `shift`, the number of the decision's shift."""
    invalid: int
    """Number of decisions that chose no object on offer."""
    decision_count: int
    """Number of all decisions, including those in shifts that are not counted."""
    seconds: float
    """Computing time of all decisions [s]."""

    @property
    def value(self) -> Floats:
        """Value per minute of each shift (S,)."""
        return self.figures["shift_value_per_min"]


def run_shifts(
    controller: Controller, env: Env, shifts: int, env_seed: int, progress: Callable[[int], object] | None = None
) -> Shifts:
    """Let a controller work whole shifts on lines.

    Each row works its shifts one after the other, so the streams depend on the seed and the number of rows alone.

    Args:
        controller: decides.
        env: vector environment of lines.
        shifts: number of shifts.
        env_seed: seed of the environment.
        progress: called with the number of shifts just ended.
    """
    rows = env.num_envs
    figures_by_shift, decisions = dict[str, dict[int, Any]](), list[dict[str, Any]]()
    seconds, invalid, core = 0.0, 0, line_core(env)
    for step in work_shifts(controller.act, env, env_seed, -(-shifts // rows)):
        number = np.arange(rows) + rows * step.shift
        info, counted = results(step.info, rows), number < shifts
        seconds += step.seconds
        invalid += int(info["invalid_action"][counted].sum())
        valid = counted & ~info["invalid_action"]
        info |= _simulated(info, core)
        names = [name for name in (*RECORDED, *SIMULATED) if name in info]
        decisions.append({"shift": number[valid], **{name: info[name][valid] for name in names}})
        ended = np.flatnonzero(step.over & counted)
        for row in ended:
            for name, values in step.info["final_info"].items():
                if name.startswith("shift_"):
                    figures_by_shift.setdefault(name, {})[int(number[row])] = values[row]
        if progress is not None:
            progress(len(ended))
    columns = {name: np.concatenate([part[name] for part in decisions]) for name in decisions[0]}
    figures = {name: np.array([of[k] for k in sorted(of)]) for name, of in figures_by_shift.items()}
    return Shifts(figures, columns, invalid, len(decisions) * rows, seconds)


def _simulated(info: dict[str, Any], core: LineCore) -> dict[str, NDArray[Any]]:
    """Further results of simulated throws (N,); nothing where a table gives the results."""
    if "energy" not in info or core.last is None:
        return {}
    results = core.last.results
    return {"lost": results["lost"], "miss_x": results["miss"][:, 0], "miss_y": results["miss"][:, 1]}


def mean(values: NDArray[Any]) -> NDArray[Any]:
    """Mean over the shifts (S, ...) that have a finite value; NaN where no shift has one."""
    finite = np.isfinite(values)
    total = np.where(finite, values, 0.0).sum(axis=0)
    return np.divide(total, finite.sum(axis=0), out=np.full_like(total, np.nan), where=finite.any(axis=0))
