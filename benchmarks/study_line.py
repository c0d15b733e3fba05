"""What throwing makes of an order of picks: the same shifts of a line by the tables of throws and really thrown.

`release` is what a learned release and a learned order are worth, together and alone, where bins are small. What the
order itself is worth, by tables and on many more shifts, is `python -m agents.benchmark --config
configs/benchmark_line.yaml`; the shifts here are its first ones.

Run: python benchmarks/study_line.py --json results/line.json      (half an hour)
"""

from __future__ import annotations

import sys
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from agents.controllers.protocol import Controller
from agents.dispatchers.registry import ENV, NAMES, line_controller, the_line
from agents.dispatchers.release import releaser
from agents.ground.environments import make_vector, stream_seed
from agents.ground.files import write_json
from agents.ground.places import POLICY, SHIPPED
from agents.ground.versions import versions
from agents.judging.work_shifts import Shifts, worked
from benchmarks.checks import check_parser
from pnt_gym.cells.line.core import LineCore

LEARNED: Final = SHIPPED / "results" / "policies" / "PnTLine-v0"
"""Run folders of what was learned, LEVEL/NAME."""
DECIDING: Final = {
    "single": ("fifo", "atc", "index"),
    "value": ("fifo", "atc", "index", "residual_ppo"),
    "skills3": ("fifo", "atc", "price", "price_beam", "index", "residual_ppo", "guided_beam"),
    "skills3_burst": ("fifo", "atc", "price", "price_beam", "index", "residual_ppo", "guided_beam"),
}
"""Who works on each level."""
SHIFTS: Final = 25
SMALL: Final[dict[str, Any]] = {
    "base": "value",
    "name": "value, small bins",
    "cell": {
        "bins": {
            "fixed": [
                {"name": "paper", "x": -0.39, "y": 0.34, "size": [0.14, 0.14], "accepts": ["paper_ball"]},
                {"name": "trays", "x": -0.13, "y": 0.40, "size": [0.20, 0.20], "accepts": ["tray"]},
                {"name": "cans", "x": 0.13, "y": 0.40, "size": [0.175, 0.175], "accepts": ["can"]},
                {"name": "cups", "x": 0.39, "y": 0.34, "size": [0.14, 0.14], "accepts": ["yoghurt_cup"]},
            ]
        }
    },
}
"""Openings 6 cm wider than what they take is long, as on `waste`."""
ORDERS: Final = ("fifo", "atc", "residual_ppo")
"""Who works there, with each release."""


def controller_of(name: str, level: str, core: LineCore) -> Controller:
    """A controller by name, or what was learned for a level."""
    return line_controller(name if name in NAMES else str(LEARNED / level / name), core)


def told(found: Shifts) -> dict[str, Any]:
    """What is kept of shifts."""
    picked = found.decisions["picked"].astype(bool)
    return {
        "value_per_min": found.value.tolist(),
        "picks": len(picked),
        "pick_rate": float(picked.mean()),
        "success": float(found.decisions["is_success"].astype(bool)[picked].mean()),
        "invalid": found.invalid,
    }


def measured(level: str, throws: str, shifts: int, seed: int, threads: int) -> dict[str, dict[str, Any]]:
    """Figures of everybody on a level with throws of a kind."""
    result: dict[str, Any] = {}
    with closing(make_vector(ENV, {"base": level, "name": level, "throws": throws}, SHIFTS, threads)) as env:
        for name in DECIDING[level]:
            controller = controller_of(name, level, the_line(env))
            controller.reset(seed)
            result[name] = told(worked(controller, env, shifts, stream_seed("evaluate", seed)))
            say(f"{level} ({throws})", name, result[name])
    return result


def releases(shifts: int, seed: int, threads: int) -> dict[str, Any]:
    """Value a minute with each release and each order, on the same shifts with small bins, in full physics."""
    result: dict[str, Any] = {}
    with closing(make_vector(ENV, {**SMALL, "throws": "full"}, SHIFTS, threads)) as env:
        core = the_line(env)
        for release in ("analytic", "learned"):
            core.use(releaser("analytic" if release == "analytic" else str(POLICY), core))
            for order in ORDERS:
                controller = controller_of(order, "value", core)
                controller.reset(seed)
                result[f"{release}, {order}"] = told(worked(controller, env, shifts, stream_seed("evaluate", seed)))
                say(f"small bins, {release}", order, result[f"{release}, {order}"])
    return result


def say(level: str, name: str, found: dict[str, Any]) -> None:
    """One line."""
    print(f"{level:<24}{name:<16}{np.mean(found['value_per_min']):8.2f} value/min  success {found['success']:.3f}")
    sys.stdout.flush()


def main() -> None:
    parser = check_parser(__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2, help="physics threads; results do not depend on it")
    parser.add_argument("--json", type=Path, help="file to write the figures to")
    parser.add_argument("--shifts", type=int, default=SHIFTS, help="shifts of each controller on each level")
    options = parser.parse_args()
    given = options.shifts, options.seed, options.threads
    thrown: dict[str, dict[str, Any]] = {}
    for level in DECIDING:
        full, table = (measured(level, throws, *given) for throws in ("full", "table"))
        thrown[level] = {name: {"full": full[name], "table": table[name]} for name in full}
    result = {"shifts": options.shifts, "seed": options.seed, "thrown": thrown, "release": releases(*given)}
    if options.json is not None:
        write_json(options.json, {"versions": versions(), **result})


if __name__ == "__main__":
    main()
