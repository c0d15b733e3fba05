"""What the cup loses on the way to the release, level by level, and what a safety of the grip costs.

The analytic planner throws: without care, and slowed until the measured objects are held with some safety. A level of
heavy objects shows what a cup is not made for.

Run: python benchmarks/study_grip.py --throws 1000 --json results/grip.json      (a minute)
"""

from __future__ import annotations

import sys
from typing import Any, Final

import numpy as np

from agents.ground.files import write_json
from agents.ground.metrics import throughput
from benchmarks.study import infos, seeded_cells, study_options, study_parser
from pnt_gym.cells.conveyor.config import ConveyorConfig

CELLS: Final = 50
SAFETIES: Final = (None, 1.0, 1.25, 1.5, 2.0, "surface")
_ROUND: Final = {
    "shape": "cylinder",
    "drag": 0.8,
    "seal_force": 20.0,
    "friction": 0.47,
    "rolling_friction": 0.002,
    "restitution": 0.2,
    "source": "a filled container at the seal of a smooth wall",
}
HEAVY: Final = {
    "base": "nominal",
    "items": ["full_can", "jar"],
    "extra_items": [
        {"name": "full_can", "size": [0.115, 0.066, 0.066], "mass": 0.36, **_ROUND},
        {"name": "jar", "size": [0.110, 0.070, 0.070], "mass": 0.20, **_ROUND},
    ],
    "bins": {"fixed": [{"name": "inside", "x": 0.30, "y": 0.40, "size": [0.24, 0.235]}]},
}
LEVELS: Final[dict[str, dict[str, Any]]] = {
    **{name: {"base": name} for name in ("nominal", "waste", "unseen")},
    "heavy": HEAVY,
}


def measured(level: dict[str, Any], safety: float | str | None, count: int, seed: int, threads: int) -> dict[str, Any]:
    """Figures of `count` throws."""
    config = ConveyorConfig.load({**level, "grip": {"safety": safety}})
    core = seeded_cells(config, "independent", CELLS, seed, threads)
    info = infos(core, lambda _: np.zeros((CELLS, 2)), count)
    pace, held = throughput(info["is_success"], info["cycle_time"]), info["picked"].astype(bool)
    return {
        "safety": safety,
        "picked": float(held.mean()),
        **{f"below_{value:g}": float((info["grip_margin"][held] < value).mean()) for value in (1.0, 1.5, 2.0)},
        "dropped": float(info["dropped"][held].mean()),
        "success": float(info["is_success"].mean()),
        "cycle_time": pace.cycle_time,
        "sorted_per_min": pace.sorted,
        "dropped_by_item": {
            name: float(info["dropped"][held & (info["item"] == index)].mean())
            for index, name in enumerate(config.items)
            if (held & (info["item"] == index)).any()
        },
    }


def main() -> None:
    options = study_options(study_parser(__doc__, 1000, "row"))
    result: dict[str, Any] = {"throws": options.throws, "seed": options.seed, "grip": {}}
    for name, level in LEVELS.items():
        for safety in SAFETIES:
            found = measured(level, safety, options.throws, options.seed, options.threads)
            result["grip"].setdefault(name, []).append(found)
            print(
                f"{name:<9}safety {safety!s:<9}lost {100 * found['dropped']:5.1f} %  "
                f"success {100 * found['success']:5.1f} %  cycle {found['cycle_time']:.3f} s  "
                f"{found['sorted_per_min']:.1f} sorted/min"
            )
            sys.stdout.flush()
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
