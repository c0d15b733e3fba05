"""What the order of picks is worth along a line: every rule, planner and learner on every level, shift by shift.

All of them work the same shifts, whose streams none of them was tuned or trained on. Throws go by the tables that ship;
`full` says how far the same shifts are off when everything is really thrown, and `release` what a learned release and a
learned order are worth, together and alone, where bins are small.

What has been measured is kept after each level, and not measured again by the same command.

Run: python benchmarks/study_line.py --json results/line.json      (an hour)
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from agents.controllers.protocol import Controller
from agents.environments import make_vector, stream_seed
from agents.files import read_json, write_json
from agents.line.evaluation import Shifts, worked
from agents.line.making import NAMES, line_controller, the_line
from agents.line.releasing import releaser
from agents.line.tuned import settings, written_settings
from agents.places import POLICY, SHIPPED
from agents.versions import versions
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore

ENV: Final = "PnTLine-v0"
LEVELS: Final = ("single", "value", "speed", "line3", "skills3", "skills3_burst")
LEARNED: Final = SHIPPED / "results" / "policies" / "PnTLine-v0"
"""Folders of what was learned, LEVEL/NAME; whatever there is takes part."""
OF_SEVERAL: Final = ("price", "price_beam", "joint_beam")
"""Who decides as another one does where there is one robot only."""
PLANNED: Final = 25
BEHIND: Final = ("beam", "joint_beam")
"""Planners that are not ahead where there is much to choose between, and how many shifts they work there: they take a
thousand times as long as a rule."""
ROWS: Final = 25
SHIFTS: Final = 100
THROWN: Final = ("fifo", "atc", "price", "price_beam", "index", "residual_ppo")
"""What is really thrown as well."""
THROWN_LEVELS: Final = ("single", "value", "skills3", "skills3_burst")
THROWN_SHIFTS: Final = 25
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


def names_of(level: str) -> list[str]:
    """Controllers of a level: those with names and something of their own to say, and what was learned for it."""
    place, robots = LEARNED / level, len(LineConfig.load(level).robots)
    tuned = written_settings().get(level, {})
    idle = {*(OF_SEVERAL if robots == 1 else ()), *(() if "index" in tuned else ("index",))}
    if not settings(level, "price_beam", robots)["share"]:
        idle.add("price_beam")  # it is `beam` there
    return [
        *(name for name in NAMES if name not in idle),
        *(sorted(one.stem for one in place.iterdir()) if place.is_dir() else ()),
    ]


def controller_of(name: str, level: str, core: LineCore) -> Controller:
    """A controller by name, or from the folder of what was learned."""
    place = LEARNED / level / name
    return line_controller(name if name in NAMES else str(place if place.is_dir() else f"{place}.npz"), core)


def told(found: Shifts) -> dict[str, Any]:
    """What is kept of shifts."""
    figures = {name.removeprefix("shift_"): values for name, values in found.told.items()}
    each = {name: figures[name].tolist() for name in ("value_per_min", "sorted_per_min", "recovery", "value_recovery")}
    picked = found.decisions["picked"].astype(bool)
    return {
        **each,
        "utilisation": figures["utilisation"].mean(axis=0).tolist(),
        "picks_by_robot": figures["picks_by_robot"].mean(axis=0).tolist(),
        "purity": float(np.nanmean(figures["purity"])),
        "picks": len(picked),
        "pick_rate": float(picked.mean()),
        "success": float(found.decisions["is_success"].astype(bool)[picked].mean()),
        "ms_per_decision": 1e3 * found.seconds / found.taken,
        "invalid": found.invalid,
    }


def measured(
    level: Any, names: list[str], shifts: int, seed: int, threads: int, result: dict[str, Any], keep: Callable[[], None]
) -> None:
    """Add figures of controllers on a level, but for what is known already, and keep each as soon as it is there."""
    with closing(make_vector(ENV, level, ROWS, threads)) as env:
        core = the_line(env)
        for name in names:
            if name in result:
                continue
            controller = controller_of(name, core.config.name, core)
            controller.reset(seed)
            much = len(core.config.robots) > 1 or len(core.config.cell.limits.percent) > 1
            count = min(shifts, PLANNED) if name in BEHIND and much else shifts
            result[name] = told(worked(controller, env, count, stream_seed("evaluate", seed)))
            say(f"{core.config.name} ({core.config.throws})", name, result[name])
            keep()


def say(level: str, name: str, found: dict[str, Any]) -> None:
    """One line."""
    value, recovery = np.mean(found["value_per_min"]), np.mean(found["recovery"])
    print(f"{level:<24}{name:<16}{value:8.2f} value/min  recovery {recovery:.3f}  {found['ms_per_decision']:.2f} ms")
    sys.stdout.flush()


def releases(shifts: int, seed: int, threads: int) -> dict[str, Any]:
    """Value a minute with each release and each order, on the same shifts with small bins, in full physics."""
    result: dict[str, Any] = {}
    with closing(make_vector(ENV, {**SMALL, "throws": "full"}, ROWS, threads)) as env:
        core = the_line(env)
        for release in ("analytic", "learned"):
            core.use(releaser("analytic" if release == "analytic" else str(POLICY), core))
            for order in ("fifo", "atc", "residual_ppo"):
                if order not in names_of("value"):
                    continue
                controller = controller_of(order, "value", core)
                controller.reset(seed)
                found = told(worked(controller, env, shifts, stream_seed("evaluate", seed)))
                result[f"{release}, {order}"] = found
                say(f"small bins, {release}", order, found)
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2, help="physics threads; results do not depend on it")
    parser.add_argument("--json", type=Path, help="file to write the figures to")
    parser.add_argument("--shifts", type=int, default=SHIFTS, help="shifts of each controller on each level")
    parser.add_argument("--thrown", type=int, default=THROWN_SHIFTS, help="shifts that are really thrown")
    parser.add_argument("--level", action="append", choices=LEVELS, help="only this level; may be given more than once")
    options = parser.parse_args()
    old: dict[str, Any] = read_json(options.json) if options.json is not None and Path(options.json).is_file() else {}
    head = {"shifts": options.shifts, "thrown_shifts": options.thrown, "seed": options.seed}
    if any(old.get(name) != value for name, value in head.items()):
        old = {}
    result = {**head, "versions": versions(), "line": old.get("line", {}), "full": old.get("full", {})}
    result |= {"release": old.get("release", {}), "learned": old.get("learned", {})}

    def keep() -> None:
        if options.json is not None:
            write_json(options.json, result)

    given = options.seed, options.threads
    for level in options.level or LEVELS:
        measured(level, names_of(level), options.shifts, *given, result["line"].setdefault(level, {}), keep)
    for level in (level for level in options.level or LEVELS if level in THROWN_LEVELS):
        thrown = [name for name in THROWN if name in names_of(level)]
        full = {"base": level, "name": level, "throws": "full"}
        measured(full, thrown, options.thrown, *given, result["full"].setdefault(level, {}), keep)
    if not options.level and not result["release"]:
        result["release"] = releases(options.thrown, *given)
    keep()


if __name__ == "__main__":
    main()
