"""What the physics is worth: the planner in its own world, and the ladder from the planner to an oracle.

Three parts, each on the same seeded throws:

* `ideal`: landing error and success of the analytic planner without any unmodelled effect.
* `ladder`: analytic planner and oracle (which simulates every throw beforehand) on each level, with the shares of
  picks that did not hold, of objects lost on the way, and of throws that missed the opening, crossed it without staying
  in the bin, or were touched by the cup again.
* `dial`: the analytic planner on `waste` as the mismatch dial is turned.

Run: python benchmarks/study_physics.py --throws 1000 --json study.json      (minutes)
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from typing import Any

from agents.controllers.analytic import Analytic
from agents.controllers.oracle import Oracle
from agents.controllers.protocol import Controller, Observation
from agents.ground.files import write_json
from agents.ground.metrics import landing, throughput, wilson
from benchmarks.study import Floats, infos, seeded_cells, study_options, study_parser
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.config import ConveyorConfig

LEVELS = ("nominal", "waste", "unseen", "tight", "nominal_plain", "waste_plain", "unseen_plain")
DIAL = (0.0, 0.25, 0.5, 1.0, 1.5)
BATCH = 100


def oracle(core: Core) -> Controller:
    """The oracle of the suite."""
    if core.correction is None:
        raise RuntimeError(f"actions {core.action_mode!r} do not shift the landing")
    return Oracle(core, core.correction)


CONTROLLERS: dict[str, Callable[[Core], Controller]] = {"analytic": lambda core: Analytic(2), "oracle": oracle}


def throws(config: ConveyorConfig, name: str, count: int, seed: int, threads: int) -> dict[str, Floats]:
    """Infos of `count` independent throws; controllers get the same throws at the same seed."""
    core = seeded_cells(config, "independent", min(BATCH, count), seed, threads)
    controller = CONTROLLERS[name](core)
    return infos(core, lambda _: controller.act(Observation(core.cell.observe(), core.cell.context.kind)), count)


def summary(info: dict[str, Floats]) -> dict[str, Any]:
    """Landing, success with its Wilson interval, and what stands between."""
    success, held = info["is_success"], info["picked"] & ~info["dropped"]
    return {
        "throws": len(success),
        "landing": asdict(landing(info["landing_error"])),
        "success": asdict(wilson(int(success.sum()), len(success))),
        "unpicked": float((~info["picked"]).mean()),
        "dropped": float(info["dropped"].mean()),
        "missed_opening": float((held & ~info["in_opening"]).mean()),
        "rim": float((held & info["rim"]).mean()),
        "recontact": float(info["recontact"].mean()),
        "residual_clipped": float(info["residual_clipped"].mean()),
        "throughput": asdict(throughput(success, info["cycle_time"])),
        "peak_torque": float(info["peak_torque"].max()),
    }


def studies(throws_each: int, seed: int, threads: int, step: float) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Part, row and summary, one after the other."""

    def measured(level: str, controller: str, **changes: float) -> dict[str, Any]:
        config = ConveyorConfig.load(level, timestep=step, **changes)
        return summary(throws(config, controller, throws_each, seed, threads))

    yield "ideal", "analytic", measured("ideal", "analytic")
    for level in LEVELS:
        for controller in CONTROLLERS:
            yield "ladder", f"{level}/{controller}", measured(level, controller)
    for m in DIAL:
        yield "dial", f"{m:g}", measured("waste", "analytic", mismatch=m)


def line(part: str, row: str, found: dict[str, Any]) -> str:
    s, e = found["success"], found["landing"]
    return (
        f"{part:<7}{row:<18}{e['mean'] * 1e3:7.2f} mm (p95 {e['p95'] * 1e3:6.1f})  "
        f"{s['value'] * 100:6.2f} % [{s['low'] * 100:.2f}, {s['high'] * 100:.2f}]  "
        f"missed {found['missed_opening'] * 100:5.2f} %  rim {found['rim'] * 100:5.2f} %  "
        f"recontact {found['recontact'] * 100:5.2f} %  {found['throughput']['sorted']:.1f} sorted/min"
    )


def main() -> None:
    parser = study_parser(__doc__, 1000, "row")
    parser.add_argument("--timestep", type=float, default=0.001, help="physics step [s]")
    options = study_options(parser)
    result: dict[str, Any] = {"throws": options.throws, "seed": options.seed, "timestep": options.timestep}
    for part, row, found in studies(options.throws, options.seed, options.threads, options.timestep):
        print(line(part, row, found))
        sys.stdout.flush()
        result.setdefault(part, {})[row] = found
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
