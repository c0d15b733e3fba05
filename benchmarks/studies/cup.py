"""What a cup that yields does to landings, and whether a learner sees it."""

from __future__ import annotations

import json
from contextlib import closing
from functools import cache
from typing import Any

import numpy as np

from agents.controllers import make_controller
from agents.ground.cli import NUM_ENVS
from agents.ground.environments import make_vector
from agents.ground.metrics import throughput
from agents.judging.loop import practise, throw_held_out
from agents.judging.throw_record import summary
from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import CELLS, Infos, distance, make_seeded_cells, throw
from pnt_gym.arrays import concatenate_records, length
from pnt_gym.cells.base.bodies import vertical
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.cup.hold import Parting
from pnt_gym.cells.conveyor.hand import HandCycle, ThrowClock
from pnt_gym.planning.motion.trajectory import JerkTrajectory


@cache
def _throws(level: str, amount: Amount) -> Infos:
    """Infos of the planner's throws on a level as JSON; the same objects and targets for every cup."""
    return throw(json.loads(level), amount)


def _throws_with(level: Settings, amount: Amount, **changes: Any) -> Infos:
    return _throws(json.dumps({**level, **changes}), amount)


def effect(settings: Settings, amount: Amount) -> Figures:
    """The same throws from a cup, from a rigid one, and in flights; lengths in m.

    `moved_*` is where the same throw lands otherwise than from the rigid cup, `flight_*` where a flight lands otherwise
    than the full physics; both without throws in which the cup touched the object again.

    Args:
        settings: `level` with its `cup`.
        amount: throws.
    """
    level = settings["level"]
    info = _throws_with(level, amount)
    cup_distance = distance(info, _throws_with(level, amount, cup={}))
    flight_distance = np.hypot(*distance(info, _throws_with(level, amount, fidelity="flight")))
    return {
        "landing_error": float(info["landing_error"].mean()),
        "success": float(info["is_success"].mean()),
        "sorted_per_min": throughput(info["is_success"], info["cycle_time"]).sorted,
        "recontact": float(info["recontact"].mean()),
        "along_sd": float(info["landing_along"].std()),
        "across_sd": float(info["landing_across"].std()),
        "moved_along_mean": float(cup_distance[0].mean()),
        "moved_along_sd": float(cup_distance[0].std()),
        "moved_across_sd": float(cup_distance[1].std()),
        "moved_p95": float(np.quantile(np.hypot(*cup_distance), 0.95)),
        "flight_p95": float(np.quantile(flight_distance, 0.95)),
        "flight_mean": float(flight_distance.mean()),
        "grip_below_1": float((info["grip_margin"] < 1.0).mean()),
        **(_leaving(level, amount) if "stiffness" in level["cup"] else {}),
    }


def _leaving(level: Settings, amount: Amount) -> Figures:
    """With which tilt and speed objects leave a cup that yields, and the share of flights simulated in full."""
    config = ConveyorConfig.load({**level, "fidelity": "flight"})
    partings: list[Parting] = []
    for batch in range(-(-amount.throws // CELLS)):
        core = make_seeded_cells(config, "independent", CELLS, amount.seed + batch)
        picks, plans, planner = core.context, core.plan(np.zeros((CELLS, 2)))[0], core.cell.planner
        motion = planner.mover.throw(picks.pick, plans, picks.throw_limits, picks.ceiling)
        back = planner.mover.back(motion, picks.pick, planner.config.robot.limits(picks.objects.percent))
        path = JerkTrajectory.concatenate(picks.pick, [motion.segments, back])
        partings.append(ThrowClock.of(picks, HandCycle(plans, motion.release_time, path), config).parting)
    parting = concatenate_records(partings)
    tilt = np.arccos(np.clip(vertical(parting.attitude)[:, 2], -1.0, 1.0))
    speed = length(parting.velocity)
    return {
        "tilt_median_rad": float(np.median(tilt)),
        "tilt_p95_rad": float(np.quantile(tilt, 0.95)),
        "speed_median": float(np.median(speed)),
        "speed_p95": float(np.quantile(speed, 0.95)),
        "simulated_in_full": float(parting.unsure.mean()),
    }


def learning(settings: Settings, amount: Amount) -> Figures:
    """A controller practises on flights from a cup, and is judged in the full physics on held-out throws.

    Args:
        settings: `level` with its `cup`; `controller`, `seed` and the throws of its `practice`.
        amount: held-out throws.
    """
    level, name, seed = settings["level"], settings["controller"], settings["seed"]
    rows = CELLS if name == "oracle" else NUM_ENVS
    with (
        closing(make_vector("PnTRelease-v0", {**level, "fidelity": "flight"}, NUM_ENVS, 1)) as flight,
        closing(make_vector("PnTRelease-v0", level, rows, 1)) as full,
    ):
        controller = make_controller(name, full)
        controller.reset(seed)
        practise(controller, flight, settings["practice"], seed)
        worth = summary(throw_held_out(controller, full, amount.throws, seed))
    return {"landing_error": worth["landing_error_mean_m"], "success": worth["success_rate"]}
