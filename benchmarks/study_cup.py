"""What a cup that yields does to landings on `waste_plain`, effect by effect, and whether a learner sees it.

`effects`: the analytic planner throws the same objects from a rigid cup and from one with a single effect, in the full
physics and in flights. `moved_*` is where the same throw lands otherwise than from the rigid cup, `flight_*` where a
flight lands otherwise than the full physics; both without throws in which the cup touched the object again.

`swings`: with which tilt and speed the objects leave a cup that yields, and the share of flights that are simulated in
full because the object meets belt or cup on the way.

`learning`: an MLP practises on flights from a cup of some stiffness and is judged in the full physics on held-out
throws, beside the analytic planner and the oracle, which simulates every throw with all hidden values known and so is
the floor.

Run: python benchmarks/study_cup.py --json results/cup.json      (half an hour on one core; resumes)
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, Final

import numpy as np

from agents.controllers import make_controller
from agents.ground.amounts import NUM_ENVS
from agents.ground.environments import make_vector
from agents.ground.files import read_json, write_json
from agents.ground.metrics import throughput
from agents.judging.loop import held_out, practise
from agents.judging.throws.data import summary
from benchmarks.study import Floats, infos, seeded_cells, study_options, study_parser
from pnt_gym.arrays import joined, length
from pnt_gym.cells.base.rotations import vertical
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.cup.parting import Parting
from pnt_gym.cells.conveyor.hand import HandCycle, ThrowClock
from pnt_gym.planning.motion.trajectory import JerkTrajectory

LEVEL: Final = "waste_plain"
CELLS: Final = 50
RIGID: Final = "rigid"
EFFECTS: Final[dict[str, dict[str, Any]]] = {
    RIGID: {},
    "3 N m/rad": {"stiffness": 3.0},
    "1 N m/rad": {"stiffness": 1.0},
    "0.3 N m/rad": {"stiffness": 0.3},
    "0.1 N m/rad": {"stiffness": 0.1},
    "0.3 N m/rad, damping 0.1": {"stiffness": 0.3, "damping": 0.1},
    "0.3 N m/rad, damping 0.5": {"stiffness": 0.3, "damping": 0.5},
    "peel": {"peel": True},
    "blow-off 0.15 m/s": {"blow_off": 0.15},
    "blow-off 0.3 m/s": {"blow_off": 0.3},
    "fitted": {"fitted": True},
}
LEARNT: Final = (RIGID, "1 N m/rad", "0.3 N m/rad", "0.1 N m/rad")
SEEDS: Final = (0, 1)
PRACTICE: Final = 10_000
"""Flights that the MLP learns from."""
ORACLE: Final = 400
"""Throws of the oracle."""


def throws(cup: dict[str, Any], fidelity: str, options: argparse.Namespace) -> dict[str, Floats]:
    """Infos of the planner's throws; the same objects and targets for every cup."""
    config = ConveyorConfig.load({"base": LEVEL, "fidelity": fidelity, "cup": cup})
    core = seeded_cells(config, "independent", CELLS, options.seed, options.threads)
    return infos(core, lambda _: np.zeros((CELLS, 2)), options.throws)


def apart(one: dict[str, Floats], other: dict[str, Floats]) -> Floats:
    """How otherwise the same throws land, along and across (2, K) [m], where no cup touched again."""
    untouched = ~(one["recontact"] | other["recontact"])
    return np.stack([one[name] - other[name] for name in ("landing_along", "landing_across")])[:, untouched]


def effect(info: dict[str, Floats], rigid: dict[str, Floats], flight: dict[str, Floats]) -> dict[str, float]:
    """Figures of one cup; lengths in m."""
    moved, left = apart(info, rigid), np.hypot(*apart(info, flight))
    pace = throughput(info["is_success"], info["cycle_time"])
    return {
        "landing_error": float(info["landing_error"].mean()),
        "success": float(info["is_success"].mean()),
        "sorted_per_min": pace.sorted,
        "recontact": float(info["recontact"].mean()),
        "along_sd": float(info["landing_along"].std()),
        "across_sd": float(info["landing_across"].std()),
        "moved_along_mean": float(moved[0].mean()),
        "moved_along_sd": float(moved[0].std()),
        "moved_across_sd": float(moved[1].std()),
        "moved_p95": float(np.quantile(np.hypot(*moved), 0.95)),
        "flight_p95": float(np.quantile(left, 0.95)),
        "flight_mean": float(left.mean()),
        "grip_below_1": float((info["grip_margin"] < 1.0).mean()),
    }


def effects(options: argparse.Namespace, known: dict[str, Any]) -> Iterator[tuple[str, dict[str, float]]]:
    """Figures of the cups that are not known yet."""
    rigid = throws({}, "full", options)
    for name, cup in EFFECTS.items():
        if name not in known:
            yield name, effect(throws(cup, "full", options), rigid, throws(cup, "flight", options))


def leaving(cup: dict[str, Any], options: argparse.Namespace) -> dict[str, float]:
    """How the planner's objects leave a cup; lengths in m."""
    config = ConveyorConfig.load({"base": LEVEL, "fidelity": "flight", "cup": cup})
    partings: list[Parting] = []
    for batch in range(-(-options.throws // CELLS)):
        core = seeded_cells(config, "independent", CELLS, options.seed + batch, options.threads)
        picks, plans, mover = core.context, core.plan(np.zeros((CELLS, 2)))[0], core.cell.planner.mover
        motion = mover.throw(picks.pick, plans, picks.throw_limits, picks.ceiling)
        back = mover.back(motion, picks.pick, picks.limits)
        path = JerkTrajectory.concatenate(picks.pick, [motion.segments, back])
        partings.append(ThrowClock.of(picks, HandCycle(plans, motion.release_time, path), config).parting)
    all_of_them = joined(partings)
    tilt = np.arccos(np.clip(vertical(all_of_them.attitude)[:, 2], -1.0, 1.0))
    speed = length(all_of_them.velocity)
    return {
        "tilt_median_rad": float(np.median(tilt)),
        "tilt_p95_rad": float(np.quantile(tilt, 0.95)),
        "speed_median": float(np.median(speed)),
        "speed_p95": float(np.quantile(speed, 0.95)),
        "simulated_in_full": float(all_of_them.unsure.mean()),
    }


def swings(options: argparse.Namespace, known: dict[str, Any]) -> Iterator[tuple[str, dict[str, float]]]:
    """How objects leave the cups that are not known yet."""
    for name, cup in EFFECTS.items():
        if "stiffness" in cup and name not in known:
            yield name, leaving(cup, options)


def judged(name: str, cup: dict[str, Any], picks: int, seed: int, threads: int) -> dict[str, float]:
    """What a controller is worth under one cup, in the full physics."""
    level = {"base": LEVEL, "cup": cup}
    count = CELLS if name == "oracle" else NUM_ENVS
    with (
        closing(make_vector("PnTRelease-v0", {**level, "fidelity": "flight"}, NUM_ENVS, threads)) as flight,
        closing(make_vector("PnTRelease-v0", level, count, threads)) as full,
    ):
        controller = make_controller(name, full)
        controller.reset(seed)
        practise(controller, flight, PRACTICE, seed)
        found = summary(held_out(controller, full, picks, seed))
    return {"landing_error": found["landing_error_mean_m"], "success": found["success_rate"]}


def learning(options: argparse.Namespace, known: dict[str, Any]) -> Iterator[tuple[str, dict[str, float]]]:
    """Figures of the controllers under cups, by "CUP: CONTROLLER SEED", where they are not known yet."""
    each = ("analytic", options.throws, SEEDS), ("mlp", options.throws, SEEDS), ("oracle", ORACLE, SEEDS[:1])
    for cup in LEARNT:
        for controller, picks, seeds in each:
            for seed in seeds:
                if (name := f"{cup}: {controller} {seed}") not in known:
                    yield name, judged(controller, EFFECTS[cup], picks, seed, options.threads)


def started(file: Path | None, head: dict[str, Any]) -> dict[str, Any]:
    """What an earlier run with the same settings has found."""
    before = read_json(file) if file is not None and file.is_file() else {}
    same = {name: before.get(name) for name in head} == head
    return before if same else {**head, "effects": {}, "swings": {}, "learning": {}}


def main() -> None:
    options = study_options(study_parser(__doc__, 1000, "row"))
    head = {"level": LEVEL, "throws": options.throws, "seed": options.seed, "practice": PRACTICE}
    head["oracle_throws"] = ORACLE
    result = started(options.json, head)
    for part, study in (("effects", effects), ("swings", swings), ("learning", learning)):
        for name, found in study(options, result.setdefault(part, {})):
            result[part][name] = found
            result[part] = {key: result[part][key] for key in (*EFFECTS, *result[part]) if key in result[part]}
            print(f"{part:<10}{name:<26}{found}")
            sys.stdout.flush()
            if options.json is not None:
                write_json(options.json, result)


if __name__ == "__main__":
    main()
