"""What to do with objects that air carries away: throw them all the same, let them ride on, or put them down.

Level `light`, on the belt: the can and the package of the paper among sheet, film and bag. The analytic planner throws
everything, throws what is throwable and lets the rest ride on, puts the rest down (`planner: auto`), or puts everything
down; then the rule's bound is varied.

Run: python benchmarks/study_throwable.py --throws 400 --json results/throwable.json      (two minutes)
"""

from __future__ import annotations

import sys
from typing import Any, Final

import numpy as np

import pnt_gym
from agents.ground.files import write_json
from agents.ground.metrics import recovery, throughput
from benchmarks.study import infos, seeded_cells, study_options, study_parser
from pnt_gym.cells.conveyor.config import ConveyorConfig

CELLS: Final = 20
LEVEL: Final = "light"
ANYTHING: Final[dict[str, Any]] = {"throwable": {"drag_area": None}}
WAYS: Final[dict[str, dict[str, Any]]] = {
    "throw everything": {"planner": "straight", **ANYTHING},
    "let the rest ride on": {"planner": "straight"},
    "put the rest down": {},
    "put everything down": {"planner": "ellipse", **ANYTHING},
}
BOUNDS: Final = (1.0, 2.5, 5.0, 10.0)


def measured(changes: dict[str, Any], options: Any) -> dict[str, Any]:
    """Figures of throws at the belt."""
    config = ConveyorConfig.load({"base": LEVEL, **changes})
    core = seeded_cells(config, "belt", CELLS, options.seed, options.threads)
    info = infos(core, lambda _: np.zeros((CELLS, 2)), options.throws)
    pace = throughput(info["sorted"], info["cycle_time"])
    return {
        "picks_per_min": pace.attempted,
        "sorted_per_min": pace.sorted,
        "success": float(info["is_success"].mean()),
        "recovery": recovery(info["sorted"], info["passed"]),
        "placed": float(info["placed"].mean()),
        "landing_error": float(np.nanmean(info["landing_error"])),
        "energy": float(info["energy"].mean()),
        "success_by_item": {
            name: float(info["is_success"][info["item"] == index].mean())
            for index, name in enumerate(config.items)
            if (info["item"] == index).any()
        },
    }


def main() -> None:
    options = study_options(study_parser(__doc__, 400, "row"))
    bounds = {f"put down from {bound:g} m2/kg": {"throwable": {"drag_area": bound}} for bound in BOUNDS}
    rows: dict[str, Any] = {}
    for name, changes in {**WAYS, **bounds}.items():
        rows[name] = found = measured(changes, options)
        print(
            f"{name:<24}{found['sorted_per_min']:5.1f} sorted/min  success {100 * found['success']:5.1f} %  "
            f"recovery {100 * found['recovery']:5.1f} %  put down {100 * found['placed']:3.0f} %"
        )
        sys.stdout.flush()
    if options.json is not None:
        about = {"version": pnt_gym.__version__, "throws": options.throws, "seed": options.seed, "level": LEVEL}
        write_json(options.json, {**about, "throwable": rows})


if __name__ == "__main__":
    main()
