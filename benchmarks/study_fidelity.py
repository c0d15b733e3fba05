"""What `fidelity: flight` leaves out, level by level: the same seeded throws in both, one against the other.

Landings are compared where the cup touches nothing again in either. The analytic planner throws, as it is and with a
random correction, so that rims and openings are met as an untrained agent meets them.

Run: python benchmarks/study_fidelity.py --throws 1000 --json results/fidelity.json
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

from agents.files import write_json
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig

LEVELS = ("ideal", "nominal", "waste", "unseen", "tight", "fast")
CELLS = 50
ACTIONS = 0.3
"""Random corrections up to this share of the largest, on half of the throws."""


def throws(level: str, fidelity: str, count: int, seed: int, threads: int) -> dict[str, np.ndarray]:
    """Infos of `count` independent throws; both fidelities get the same objects, targets and actions."""
    config = ConveyorConfig.load({"base": level, "fidelity": fidelity})
    core = Core(ConveyorCell(config, CELLS, "independent", threads))
    core.reset(np.arange(CELLS), [np.random.default_rng([seed, row]) for row in range(CELLS)], seeded=True)
    actions = np.random.default_rng(seed).uniform(-ACTIONS, ACTIONS, (-(-count // CELLS), CELLS, 2))
    actions[::2] = 0.0
    infos = [core.step(action).info for action in actions]
    return {name: np.concatenate([info[name] for info in infos])[:count] for name in infos[0]}


def compared(level: str, count: int, seed: int, threads: int) -> dict[str, float]:
    """Flights against the full physics, lengths in m."""
    full, flight = (throws(level, fidelity, count, seed, threads) for fidelity in ("full", "flight"))
    untouched = ~(full["recontact"] | flight["recontact"])
    apart = np.hypot(*(flight[name] - full[name] for name in ("landing_along", "landing_across")))[untouched]
    return {
        "landing_mean_m": float(apart.mean()),
        "landing_p95_m": float(np.quantile(apart, 0.95)),
        "landing_max_m": float(apart.max()),
        "success_full": float(full["is_success"].mean()),
        "success_flight": float(flight["is_success"].mean()),
        "success_differs": float((full["is_success"] != flight["is_success"]).mean()),
        "recontact_full": float(full["recontact"].mean()),
        "recontact_flight": float(flight["recontact"].mean()),
        "landing_error_full_m": float(full["landing_error"].mean()),
        "landing_error_flight_m": float(flight["landing_error"].mean()),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--throws", type=int, default=1000, help="throws per level and fidelity")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2, help="physics threads; results do not depend on it")
    parser.add_argument("--json", type=Path, help="file to write the figures to")
    options = parser.parse_args()
    if options.throws < 1:
        parser.error(f"--throws is {options.throws}; at least 1 throw is needed")
    result: dict[str, Any] = {"throws": options.throws, "seed": options.seed, "fidelity": {}}
    for level in LEVELS:
        found = compared(level, options.throws, options.seed, options.threads)
        result["fidelity"][level] = found
        print(f"{level:<9}" + "  ".join(f"{name} {value:.4g}" for name, value in found.items()))
        sys.stdout.flush()
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
