"""Plain throws of the conveyor cell, every figure that a plan may ask for of them, and what `agents.evaluate` says."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np

from agents.ground import metrics
from agents.ground.cli import check_known
from agents.ground.places import at
from agents.judging.evaluation import evaluate
from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import CELLS, Infos, infos, make_seeded_cells, oracle_actions, zero_actions
from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.errors import ConfigError

ARRIVED: Final = 0.001
"""A hand this close to its next pick for good has arrived [m]."""


class Watch:
    """Keeps what a cell of the conveyor last handed to its plant."""

    def __init__(self, cell: Any) -> None:
        self._fly = cell.plant.fly
        self.last: tuple[Any, Any] | None = None
        cell.plant.fly = self

    def __call__(self, thrown: Any, plans: Any, cells: Any = None) -> Any:
        """Hand throws on to the plant."""
        self.last = thrown, plans
        return self._fly(thrown, plans, cells)


def arrival(place: Floats, end: Floats, times: Floats, duration: Floats) -> Floats:
    """Last times (N,) at which hands (N, M, 3) are away from their ends (N, 3), until durations (N,) [s]."""
    away = (np.linalg.norm(place - end[:, None], axis=2) > ARRIVED) & (times <= duration[:, None])
    return np.take_along_axis(times, (away.shape[1] - 1 - away[:, ::-1].argmax(axis=1))[:, None], axis=1)[:, 0]


def time_ratio(cell: Any, watch: Watch) -> float:
    """How many times the planned way the hands take from lift to their next picks, the robot simulated to the end."""
    if watch.last is None:
        raise RuntimeError("nothing was thrown yet")
    thrown, plans = watch.last
    followed, path = cell.plant.follow(thrown, plans), plans.path
    steps = np.arange(followed.hand.shape[1])
    times = followed.start[:, None] + steps * cell.config.timestep
    end = path.end + thrown.cup_offset
    planned = path.sample(times).position + thrown.cup_offset[:, None]
    arrived, due = (arrival(place, end, times, path.duration) for place in (followed.hand, planned))
    return float(((path.duration + arrived - due) / path.duration).mean())


class Thrown(NamedTuple):
    """Throws that were carried out.

    Attributes:
        info: infos of N throws, (N,) each.
        core: cells that threw.
        watch: what the cells last handed to their plant.
        shifts: rows, each of which is a work shift; 0 where throws are counted one by one.
    """

    info: Infos
    core: Core
    watch: Watch
    shifts: int

    @property
    def picked(self) -> Bools:
        """Which objects were picked (N,)."""
        return self.info["picked"].astype(np.bool_)

    @property
    def pace(self) -> metrics.Throughput:
        """Picks per minute; sorted are those that ended where they belong."""
        return metrics.throughput(self.info["sorted"], self.info["cycle_time"])

    def by_shift(self, name: str) -> Floats:
        """An info of every throw and shift (T, S)."""
        return self.info[name].reshape(-1, self.shifts)

    def by_item(self, name: str, counts: Bools) -> dict[str, float]:
        """Mean of an info over the throws that are counted, by the item's name; none of an item that was not thrown."""
        items = {item: counts & (self.info["item"] == k) for k, item in enumerate(self.core.item_names)}
        return {item: float(self.info[name][rows].mean()) for item, rows in items.items() if rows.any()}


def _mean(name: str) -> Callable[[Thrown], float]:
    return lambda thrown: float(np.nanmean(thrown.info[name]))


def _of_picked(name: str, bound: float) -> Callable[[Thrown], float]:
    return lambda thrown: float((thrown.info[name][thrown.picked] < bound).mean())


def _of_thrown(failed: Callable[[Infos], Any]) -> Callable[[Thrown], float]:
    return lambda thrown: float((thrown.picked & ~thrown.info["dropped"] & failed(thrown.info)).mean())


def _interval_by_shift(name: str) -> Callable[[Thrown], dict[str, float]]:
    return lambda thrown: vars(metrics.interval(thrown.by_shift(name).mean(axis=0)))


def _success_interval(thrown: Thrown) -> dict[str, float]:
    success = thrown.info["is_success"]
    return vars(metrics.wilson(int(success.sum()), len(success)))


def _most_lost(thrown: Thrown) -> str | None:
    """The kind that is lost most often, and how often."""
    rates = thrown.by_item("dropped", thrown.picked)
    kind = max(rates, key=lambda name: rates[name])
    return f"{kind} {100 * rates[kind]:.0f} %" if rates[kind] > 0.0 else None


FIGURES: Final[dict[str, Callable[[Thrown], Any]]] = {
    "landing": lambda thrown: vars(metrics.landing(thrown.info["landing_error"])),
    "landing_error_mean_m": _mean("landing_error"),
    "success": _mean("is_success"),
    "success_interval": _success_interval,
    "success_by_item": lambda thrown: thrown.by_item("is_success", np.full(len(thrown.picked), True)),
    "picks_per_min": lambda thrown: thrown.pace.attempted,
    "picks_per_min_interval": lambda thrown: vars(metrics.interval(60.0 / thrown.by_shift("cycle_time").mean(axis=0))),
    "sorted_per_min": lambda thrown: thrown.pace.sorted,
    "cycle_time": lambda thrown: thrown.pace.cycle_time,
    "wait_time": _mean("wait_time"),
    "flown_over_planned": lambda thrown: time_ratio(thrown.core.cell, thrown.watch),
    "recovery": lambda thrown: metrics.recovery(thrown.info["sorted"], thrown.info["passed"]),
    "placed": _mean("placed"),
    "picked": _mean("picked"),
    "unpicked": lambda thrown: float((~thrown.picked).mean()),
    "dropped": _mean("dropped"),
    "dropped_of_picked": lambda thrown: float(thrown.info["dropped"][thrown.picked].mean()),
    "dropped_by_item": lambda thrown: thrown.by_item("dropped", thrown.picked),
    "most_dropped": _most_lost,
    "missed": _of_thrown(lambda info: ~info["in_opening"]),
    "rim": _of_thrown(lambda info: info["rim"]),
    "recontact": _mean("recontact"),
    "residual_clipped": _mean("residual_clipped"),
    "margin_below_1": lambda thrown: float((thrown.info["grip_margin"] < 1.0).mean()),
    **{f"margin_of_picked_below_{bound:g}": _of_picked("grip_margin", bound) for bound in (1.0, 1.5, 2.0)},
    "energy_per_pick_j": _mean("energy"),
    "peak_torque": lambda thrown: float(thrown.info["peak_torque"].max()),
    "disturbed": _interval_by_shift("disturbed"),
    "passed_per_pick": _interval_by_shift("passed"),
    "slip_mean_m": _mean("slip"),
    "slip_p95_m": lambda thrown: float(np.quantile(thrown.info["slip"], 0.95)),
    "slip_below_1mm": lambda thrown: float((thrown.info["slip"] < 1e-3).mean()),
}
"""What a plan may ask for; lengths in m."""


def figures(settings: Settings, amount: Amount) -> Figures:
    """Figures of throws.

    Args:
        settings: `figures`, names in `FIGURES`; `level`; `picks`, `cells`, `controller` and `shifts` as `throw` takes
            them; `impossible`, true where a level in which nothing can be thrown is told and is no error.
        amount: throws, or throws of each shift.

    Raises:
        UsageError: a figure is unknown.
    """
    check_known("figure", settings["figures"], FIGURES)
    if not settings.get("impossible", False):
        return _figures(settings, amount)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of bins out of reach
        try:
            return _figures(settings, amount)
        except ConfigError as error:
            return {"impossible": str(error)}


def _figures(settings: Settings, amount: Amount) -> Figures:
    thrown = throw(settings, amount)
    return {name: FIGURES[name](thrown) for name in settings["figures"]}


def throw(settings: Settings, amount: Amount) -> Thrown:
    """Carry out throws.

    Args:
        settings: `level`; `picks`, "belt" or "independent"; `cells` side by side; `controller`, "analytic" or "oracle";
            `shifts`, of each of which the throws are, instead of cells.
        amount: throws, or throws of each shift.
    """
    shifts = settings.get("shifts", 0)
    level = settings["level"] | ({"picks_per_shift": amount.throws} if shifts else {})
    cells = shifts or settings.get("cells", CELLS)
    config = ConveyorConfig.load(level)
    core = make_seeded_cells(config, settings.get("picks", "independent"), cells, amount.seed)
    act = oracle_actions(core) if settings.get("controller", "analytic") == "oracle" else zero_actions(core)
    watch = Watch(core.cell)
    return Thrown(infos(core, act, amount.throws * max(shifts, 1)), core, watch, shifts)


def confusion(materials: dict[str, list[str]], wrong: float) -> dict[str, dict[str, float]]:
    """Shares in which each kind is seen as another one: evenly as all kinds of other materials."""
    shares: dict[str, dict[str, float]] = {}
    for items in materials.values():
        strangers = [item for kinds in materials.values() if kinds is not items for item in kinds]
        for item in items:
            shares[item] = {item: 1.0 - wrong, **dict.fromkeys(strangers, wrong / len(strangers))}
    return shares


def evaluation(settings: Settings, amount: Amount) -> Figures:
    """Figures of a controller.

    Args:
        settings: `env`, `level`, `controller` and the names of `figures`; with `wrong`, the share of every kind that is
            seen as one of another of the `materials`.
        amount: throws.
    """
    level: dict[str, Any] = dict(settings["level"])
    if "wrong" in settings:
        level["classifier"] = {"confusion": confusion(settings["materials"], settings["wrong"])}
    name = settings["controller"]
    controller = str(at(name)) if "/" in name else name
    config = ConveyorConfig.load(level)
    report = evaluate(controller, settings["env"], amount.throws, amount.seed, level=config, threads=1)
    return {name: report[name] for name in settings["figures"] if name in report}
