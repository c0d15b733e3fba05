"""Planned cycles executed by the closed-chain robot: what each cell of a table gives in MuJoCo.

A plan holds a few cycles, one per pick. Each cycle is carried out once per object and strength of the mismatch, all
plans side by side in a few large batches, and the trials of a plan are summed up in one `Measured`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Final, NamedTuple, Protocol, TypeAlias, final

import numpy as np

from pnt_gym.cells.items import PAPER_ITEMS
from pnt_gym.cells.trial import Trials, run_trials
from pnt_gym.errors import PntGymError
from pnt_gym.planning.arrays import Bools, Floats, Ints, Point
from pnt_gym.planning.trajectory import JerkTrajectory
from pnt_gym.rows import take

BATCH: Final = 72
"""Trials simulated side by side; more of them take more memory and no less time."""


class PlannedCycles(Protocol):
    """What is needed of K planned cycles (`pnt_gym.planning.cycle.Cycle` has it)."""

    @property
    def path(self) -> JerkTrajectory:
        """Motion of the hand from pick to next pick, K rows."""
        ...

    @property
    def release_time(self) -> Floats:
        """When the object is let go (K,) [s]."""
        ...

    @property
    def release_position(self) -> Floats:
        """Where (K, 3) [m]."""
        ...

    @property
    def release_velocity(self) -> Floats:
        """How fast (K, 3) [m/s]."""
        ...

    @property
    def feasible(self) -> Bools:
        """Which rows hold a plan (K,)."""
        ...


Plan: TypeAlias = tuple[PlannedCycles, Point]
"""Cycles and their common target [m]."""


@final
@dataclass(frozen=True)
class Measured:
    """What the trials of one plan gave, lengths in m, torque in N m.

    Attributes:
        trials: cycles executed.
        landing_error_mean: mean distance of the landing from the target; an object put down lands where it is let go.
        landing_error_max: the largest one.
        landing_error_by_item: mean of each object.
        sorted: landed in the opening and stayed in the bin.
        recontacts: touched by the cup after the release.
        clearance: smallest distance of cup and object from 20 ms after the release on.
        peak_torque: largest motor torque.
        release_tracking: largest distance of the hand from its reference at a release.
        tracking: largest distance of the hand from its reference at any time.
    """

    trials: int
    landing_error_mean: float
    landing_error_max: float
    landing_error_by_item: Mapping[str, float]
    sorted: int
    recontacts: int
    clearance: float
    peak_torque: float
    release_tracking: float
    tracking: float

    def as_json(self) -> dict[str, Any]:
        """The figures by name."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return values | {"landing_error_by_item": dict(self.landing_error_by_item)}


class _Rows(NamedTuple):
    """All trials of all plans, one row each."""

    plan: Ints
    item: Ints
    seed: Ints
    target: Floats
    path: JerkTrajectory
    release_time: Floats
    release_position: Floats
    release_velocity: Floats


def simulate(
    plans: Mapping[str, Plan],
    *,
    items: Sequence[str] = PAPER_ITEMS,
    mismatches: Sequence[float] = (0.0, 1.0),
    timestep: float = 0.0004,
    seed: int = 0,
    threads: int = 2,
) -> dict[str, dict[float, Measured]]:
    """Execute every cycle of every plan with every object at every mismatch.

    The hidden values of an object depend on seed, item and pick only, so that all plans are tried with the same
    objects. Picks without a plan are left out.

    Args:
        plans: cycles and target by name.
        items: objects to carry, names in the catalogue.
        mismatches: strengths of the unmodelled effects; 0 is the planner's own world, 1 realistic.
        timestep: physics step [s].
        seed: of the objects.
        threads: worker threads of the physics; results do not depend on it.

    Returns:
        For each plan and mismatch what was measured.

    Raises:
        PntGymError: a plan without any cycle, or one that the cell cannot execute (see `run_trials`).
    """
    if not plans:
        return {}
    rows = _rows(plans, items, seed)
    found: dict[str, dict[float, Measured]] = {name: {} for name in plans}
    for mismatch in mismatches:
        trials = _run(rows, items, mismatch, timestep, threads)
        for index, name in enumerate(plans):
            mine = rows.plan == index
            found[name][mismatch] = _measured(take(trials, mine), rows.item[mine], items)
    return found


def _rows(plans: Mapping[str, Plan], items: Sequence[str], seed: int) -> _Rows:
    parts: list[_Rows] = []
    for index, (name, (cycles, target)) in enumerate(plans.items()):
        picks = np.flatnonzero(cycles.feasible)
        if picks.size == 0:
            raise PntGymError(f"plan {name!r} holds no feasible cycle")
        pick, item = np.tile(picks, len(items)), np.repeat(np.arange(len(items)), picks.size)
        parts.append(
            _Rows(
                plan=np.full(pick.size, index),
                item=item,
                seed=seed + item * len(cycles.feasible) + pick,
                target=np.tile(np.asarray(target, dtype=np.float64), (pick.size, 1)),
                path=cycles.path.take(pick),
                release_time=cycles.release_time[pick],
                release_position=cycles.release_position[pick],
                release_velocity=cycles.release_velocity[pick],
            )
        )
    return _Rows(*(_below(column) for column in zip(*parts, strict=True)))


def _below(column: Sequence[Any]) -> Any:
    """One field of all parts, below one another."""
    return stacked(column) if isinstance(column[0], JerkTrajectory) else np.concatenate(column)


def stacked(paths: Sequence[JerkTrajectory]) -> JerkTrajectory:
    """Paths below one another; those with fewer segments end in segments of no duration."""
    most = max(path.durations.shape[1] for path in paths)

    def padded(values: Floats) -> Floats:
        missing = [(0, 0)] * values.ndim
        missing[1] = (0, most - values.shape[1])
        return np.pad(values, missing)

    return JerkTrajectory(
        np.concatenate([path.start for path in paths]),
        np.concatenate([padded(path.durations) for path in paths]),
        np.concatenate([padded(path.jerks) for path in paths]),
        np.concatenate([path.knots.velocity[:, 0] for path in paths]),
        np.concatenate([path.knots.acceleration[:, 0] for path in paths]),
    )


def _run(rows: _Rows, items: Sequence[str], mismatch: float, timestep: float, threads: int) -> Trials:
    """All trials in batches of about equal duration, in the order of the rows."""
    order = np.lexsort((rows.path.duration, rows.target[:, 2]))
    levels = np.flatnonzero(np.diff(rows.target[order, 2])) + 1
    groups = [
        part for level in np.split(order, levels) for part in np.array_split(level, int(np.ceil(level.size / BATCH)))
    ]
    done = [
        run_trials(
            rows.path.start[group],
            rows.target[group],
            [items[int(index)] for index in rows.item[group]],
            rows.path.take(group),
            rows.release_time[group],
            rows.release_position[group],
            rows.release_velocity[group],
            mismatch=mismatch,
            timestep=timestep,
            seed=[int(value) for value in rows.seed[group]],
            threads=threads,
        )
        for group in groups
    ]
    back = np.argsort(np.concatenate(groups))
    return Trials(
        **{field.name: np.concatenate([getattr(part, field.name) for part in done])[back] for field in fields(Trials)}
    )


def _measured(trials: Trials, item: Ints, items: Sequence[str]) -> Measured:
    error = trials.landing_error
    return Measured(
        trials=len(trials),
        landing_error_mean=float(error.mean()),
        landing_error_max=float(error.max()),
        landing_error_by_item={name: float(error[item == index].mean()) for index, name in enumerate(items)},
        sorted=int((trials.in_opening & trials.in_bin).sum()),
        recontacts=int(trials.recontact.sum()),
        clearance=float(trials.clearance.min()),
        peak_torque=float(trials.peak_torque.max()),
        release_tracking=float(trials.release_tracking.max()),
        tracking=float(trials.path_tracking.max()),
    )
