"""What a hand that rides with the belt saves in slip and costs in time, and how often throws sweep through neighbours.

Shifts of the analytic planner at `waste_plain`, so that every pick holds, at two speeds of the belt, with gaps between
centres and between edges: the hand stands still or rides, neighbours are ghosts or solid. Hands move as planned
(`fidelity: flight`): cycles, slips and sweeps follow from the plans in the full physics as well.

Run: python benchmarks/study_neighbours.py --json results/neighbours.json      (a minute)
"""

from __future__ import annotations

import sys
from typing import Any, Final

import numpy as np

from agents.ground.files import write_json
from agents.ground.metrics import mean_interval
from benchmarks.study import infos, seeded_cells, study_options, study_parser
from pnt_gym.cells.conveyor.config import ConveyorConfig

SHIFTS: Final = 24
SPEEDS: Final = (0.25, 0.8)
GAPS: Final[dict[str, dict[str, Any]]] = {
    "centre": {"gap": "centre", "spacing": [0.10, 0.30]},
    "edge": {"gap": "edge", "spacing": [0.02, 0.18]},
}


def measured(belt: dict[str, Any], throws: int, seed: int, threads: int) -> dict[str, Any]:
    """Figures of all shifts with such a belt."""
    config = ConveyorConfig.load({"base": "waste_plain", "fidelity": "flight", "belt": belt, "picks_per_shift": throws})
    core = seeded_cells(config, "belt", SHIFTS, seed, threads)
    zero = np.zeros((SHIFTS, *core.action_space.shape))
    info = infos(core, lambda _: zero, throws * SHIFTS)
    by_shift = {
        name: info[name].reshape(throws, SHIFTS) for name in ("cycle_time", "disturbed", "passed", "is_success")
    }
    return {
        **belt,
        "picks_per_min": vars(mean_interval(60.0 / by_shift["cycle_time"].mean(axis=0))),
        "disturbed": vars(mean_interval(by_shift["disturbed"].mean(axis=0))),
        "passed_per_pick": vars(mean_interval(by_shift["passed"].mean(axis=0))),
        "success": float(by_shift["is_success"].mean()),
        "slip_mean_m": float(info["slip"].mean()),
        "slip_p95_m": float(np.quantile(info["slip"], 0.95)),
        "slip_below_1mm": float((info["slip"] < 1e-3).mean()),
    }


def main() -> None:
    options = study_options(study_parser(__doc__, 60, f"shift, of which there are {SHIFTS}"))
    result: dict[str, Any] = {"throws": options.throws, "shifts": SHIFTS, "seed": options.seed, "neighbours": []}
    for gap in GAPS.values():
        for speed in SPEEDS:
            for tracking in (False, True):
                for neighbours in ("ghosts", "solid"):
                    belt = {**gap, "speed": speed, "tracking": tracking, "neighbours": neighbours}
                    found = measured(belt, options.throws, options.seed, options.threads)
                    result["neighbours"].append(found)
                    print(
                        f"{gap['gap']:<8}{speed:<6g}{'rides' if tracking else 'stands':<8}{neighbours:<8}"
                        f"{found['picks_per_min']['value']:.1f} picks/min  "
                        f"swept {100 * found['disturbed']['value']:5.1f} %  "
                        f"slip {1000 * found['slip_mean_m']:.2f} mm, p95 {1000 * found['slip_p95_m']:.2f}  "
                        f"{found['passed_per_pick']['value']:.2f} passed a pick"
                    )
                    sys.stdout.flush()
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
