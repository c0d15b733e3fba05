"""What `fidelity: flight` leaves out, level by level: the same seeded throws in both, one against the other.

Landings are compared of what is thrown, where the cup touches nothing again in either. The analytic planner throws, as
it is and with a random correction, so that rims and openings are met as an untrained agent meets them.

Run: python benchmarks/study_fidelity.py --throws 1000 --json results/fidelity.json
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from agents.ground.files import write_json
from benchmarks.study import infos, seeded_cells, study_options, study_parser
from pnt_gym.cells.conveyor.config import ConveyorConfig

LEVELS = ("ideal", "nominal", "waste", "unseen", "tight", "fast", "nominal_plain", "waste_plain", "unseen_plain")
CELLS = 50
ACTIONS = 0.3
"""Random corrections up to this share of the largest, on half of the throws."""


def throws(level: str, fidelity: str, count: int, seed: int, threads: int) -> dict[str, np.ndarray]:
    """Infos of `count` independent throws; both fidelities get the same objects, targets and actions."""
    config = ConveyorConfig.load({"base": level, "fidelity": fidelity})
    core = seeded_cells(config, "independent", CELLS, seed, threads)
    actions = np.random.default_rng(seed).uniform(-ACTIONS, ACTIONS, (-(-count // CELLS), CELLS, 2))
    actions[::2] = 0.0
    return infos(core, lambda step: actions[step], count)


def compared(level: str, count: int, seed: int, threads: int) -> dict[str, float]:
    """Flights against the full physics, lengths in m."""
    full, flight = (throws(level, fidelity, count, seed, threads) for fidelity in ("full", "flight"))
    untouched = ~(full["recontact"] | flight["recontact"])
    apart = np.hypot(*(flight[name] - full[name] for name in ("landing_along", "landing_across")))[untouched]
    apart = apart[np.isfinite(apart)]
    return {
        "landing_mean_m": float(apart.mean()),
        "landing_p95_m": float(np.quantile(apart, 0.95)),
        "landing_max_m": float(apart.max()),
        "success_full": float(full["is_success"].mean()),
        "success_flight": float(flight["is_success"].mean()),
        "success_differs": float((full["is_success"] != flight["is_success"]).mean()),
        "losses_differ": float(((full["dropped"] != flight["dropped"]) | (full["picked"] != flight["picked"])).mean()),
        "recontact_full": float(full["recontact"].mean()),
        "recontact_flight": float(flight["recontact"].mean()),
        "landing_error_full_m": float(np.nanmean(full["landing_error"])),
        "landing_error_flight_m": float(np.nanmean(flight["landing_error"])),
    }


def main() -> None:
    options = study_options(study_parser(__doc__, 1000, "level and fidelity"))
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
