"""How an object gets to its bin, method by method: the central table of Hassan et al. 2022 for a moving belt.

Pick-and-place, the level throw, the straight throw, the throw in a free direction, and Choe's ellipse, each in the
cells of `nominal` and `waste` at 15 to 60 % of the limits, by the analytic planner on the same objects. Then, in the
cell of `nominal` with one bin, where throwing stops paying: as its opening shrinks, as it moves away, and as cans that
a cup holds with 20 N become heavier, each slowed until the cup could hold 1.5 times what is measured.

Rows that the file holds already, of the same throws and seed, are not made again.

Run: python benchmarks/study_methods.py --throws 200 --json results/methods.json      (ten minutes)
"""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np

import pnt_gym
from agents.ground.files import write_json
from agents.ground.metrics import recovery, throughput
from benchmarks.study import Floats, infos, seeded_cells, study_options, study_parser
from pnt_gym.cells.conveyor.cell import ConveyorCell, Picks
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.errors import ConfigError

CELLS: Final = 20
METHODS: Final = ("pick_and_place", "ellipse", "horizontal", "straight", "free_direction")
PERCENTS: Final = (15, 20, 30, 40, 60)
LEVELS: Final = ("nominal", "waste")
OPENINGS: Final = (0.08, 0.10, 0.12, 0.14, 0.16, 0.20, 0.24)
DISTANCES: Final = (0.10, 0.25, 0.40, 0.55, 0.65, 0.75, 0.90)
MASSES: Final = (0.03, 0.09, 0.15, 0.21, 0.27, 0.33, 0.39)
"""Of cans [kg]."""
SAFETY: Final = 1.5
CAN: Final[dict[str, Any]] = {
    "name": "filled",
    "shape": "cylinder",
    "size": [0.115, 0.066, 0.066],
    "drag": 0.8,
    "seal_force": 20.0,
    "friction": 0.47,
    "rolling_friction": 0.002,
    "restitution": 0.2,
    "source": "a can filled to some mass, at the seal of a smooth wall",
}
SWEEP_PERCENT: Final = 40
ARRIVED: Final = 0.001
"""A hand this close to its next pick for good has arrived [m]."""
FREE_WINDOW: Final = 0.030
"""Of the throw in a free direction, as in the level `fast`: its hand is planned to stay above the object [s]."""


class Watch:
    """Keeps what a cell last handed to its plant."""

    def __init__(self, cell: ConveyorCell) -> None:
        self._fly = cell.plant.fly
        self.last: tuple[Any, Any] | None = None
        cell.plant.fly = self  # pyright: ignore[reportAttributeAccessIssue]

    def __call__(self, thrown: Any, plans: Any) -> Any:
        """What the plant makes of it."""
        self.last = thrown, plans
        return self._fly(thrown, plans)


def level_of(base: str, planner: str, percent: float, **changes: Any) -> dict[str, Any]:
    """A level with a method."""
    window = {"motion": {"follow_through": {"window": FREE_WINDOW}}} if planner == "free_direction" else {}
    return {"base": base, "planner": planner, "limits": {"percent": [percent]}, **window, **changes}


def arrival(place: Floats, end: Floats, times: Floats, duration: Floats) -> Floats:
    """Last times (N,) at which hands (N, M, 3) are away from their ends (N, 3), until durations (N,) [s]."""
    away = (np.linalg.norm(place - end[:, None], axis=2) > ARRIVED) & (times <= duration[:, None])
    return np.take_along_axis(times, (away.shape[1] - 1 - away[:, ::-1].argmax(axis=1))[:, None], axis=1)[:, 0]


def flown_over_planned(cell: ConveyorCell, watch: Watch) -> float:
    """How many times the planned way the hands take from lift to their next picks, the robot simulated to the end."""
    if watch.last is None:
        raise RuntimeError("nothing was thrown yet")
    thrown, plans = watch.last
    followed, path = cell.plant.follow(thrown, plans), plans.path
    steps = np.arange(followed.hand.shape[1])
    times = followed.start[:, None] + steps * cell.config.timestep
    end = path.end + thrown.cup_offset
    planned = path.sample(times).position + thrown.cup_offset[:, None]
    came, due = (arrival(place, end, times, path.duration) for place in (followed.hand, planned))
    return float(((path.duration + came - due) / path.duration).mean())


def measured(level: dict[str, Any], picks: Picks, options: Any, throws: int) -> dict[str, Any]:
    """Figures of throws with a method; what is told where it cannot be used."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of bins out of reach
            core = seeded_cells(ConveyorConfig.load(level), picks, CELLS, options.seed, options.threads)
            cell, watch = core.cell, Watch(core.cell)
            info = infos(core, lambda _: np.zeros((CELLS, 2)), throws)
    except ConfigError as error:
        return {"impossible": str(error)}
    pace, thrown = throughput(info["is_success"], info["cycle_time"]), info["picked"] & ~info["dropped"]
    return {
        "picks_per_min": pace.attempted,
        "sorted_per_min": pace.sorted,
        "success": float(info["is_success"].mean()),
        "unpicked": float((~info["picked"]).mean()),
        "dropped": float(info["dropped"].mean()),
        "missed": float((thrown & ~info["in_opening"]).mean()),
        "rim": float((thrown & info["rim"]).mean()),
        "cycle_time": pace.cycle_time,
        "wait_time": float(info["wait_time"].mean()),
        "flown_over_planned": flown_over_planned(cell, watch),
        "landing_error_mean_m": float(np.nanmean(info["landing_error"])),
        "grip_margin_below_1": float((info["grip_margin"] < 1.0).mean()),
        "recovery": recovery(info["sorted"], info["passed"]) if picks == "belt" else None,
        "energy_per_pick_j": float(info["energy"].mean()),
        "peak_torque": float(info["peak_torque"].max()),
    }


def rows() -> list[tuple[tuple[str, str, str], dict[str, Any], Picks, float]]:
    """Table, row and method; level; where picks come from; share of the throws."""
    found: list[tuple[tuple[str, str, str], dict[str, Any], Picks, float]] = []
    for base in LEVELS:
        for percent in PERCENTS:
            for planner in METHODS:
                key = (base, str(percent), planner)
                found.append((key, level_of(base, planner, percent), "belt", 1.0))
    for name, values in (("opening", OPENINGS), ("distance", DISTANCES), ("grip", MASSES)):
        for value in values:
            for planner in METHODS:
                level = level_of("nominal", planner, SWEEP_PERCENT, **swept(name, value))
                found.append(((name, f"{value:g}", planner), level, "independent", 0.5))
    return found


def swept(sweep: str, value: float) -> dict[str, Any]:
    """What a row of a sweep has instead of `nominal`'s."""
    side, y = {"opening": (value, 0.35), "distance": (0.20, value), "grip": (0.24, 0.35)}[sweep]
    bins = {"bins": {"fixed": [{"name": "only", "x": 0.0, "y": y, "size": [side, side]}]}}
    if sweep != "grip":
        return bins
    return {**bins, "items": ["filled"], "extra_items": [{**CAN, "mass": value}], "grip": {"safety": SAFETY}}


def begun(path: Path | None, fresh: dict[str, Any]) -> dict[str, Any]:
    """What the file holds of the same study, or nothing yet."""
    if path is not None and path.exists():
        held = json.loads(path.read_text())
        if all(held.get(name) == fresh[name] for name in ("version", "throws", "seed")):
            return held
    return fresh


def main() -> None:
    options = study_options(study_parser(__doc__, 200, "row"))
    fresh = {"version": pnt_gym.__version__, "throws": options.throws, "seed": options.seed, "methods": {}}
    result = begun(options.json, fresh)
    for (table, row, planner), level, picks, share in rows():
        own = result["methods"].setdefault(table, {}).setdefault(row, {})
        if planner in own:
            continue
        own[planner] = found = measured(level, picks, options, max(round(share * options.throws), 1))
        said = found.get("impossible", "")[:60] or (
            f"{found['picks_per_min']:.1f} picks/min {found['sorted_per_min']:.1f} sorted/min "
            f"{100 * found['success']:.1f} %  flown/planned {found['flown_over_planned']:.4f}"
        )
        print(f"{table:<9}{row:<6}{planner:<15}{said}")
        sys.stdout.flush()
        if options.json is not None:
            write_json(options.json, result)


if __name__ == "__main__":
    main()
