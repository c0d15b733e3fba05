"""The cycles of Table I executed by the closed-chain robot: what stands beside each cell, and the sums of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final, TypeAlias

from agents.reproduce.findings import Row
from agents.reproduce.hassan_cases import TARGETS
from agents.reproduce.simulation import Measured, PlannedCycles, simulate
from pnt_gym.robots.t3kr.geometry import T3KR

ByMismatch: TypeAlias = Mapping[float, Measured]
IDEAL, REALISTIC = 0.0, 1.0
MISMATCHES: Final = (IDEAL, REALISTIC)


def simulated(plans: Mapping[str, tuple[PlannedCycles, str]]) -> dict[str, dict[float, Measured]]:
    """What each plan gave with the paper's three objects, by its name and the strength of the mismatch.

    Args:
        plans: cycles and the zone of their target by name.
    """
    aimed = {name: (cycles, TARGETS[zone]) for name, (cycles, zone) in plans.items()}
    # Parts of a reproduction run side by side, so one thread each.
    return simulate(aimed, mismatches=MISMATCHES, threads=1)


def simulated_details(measured: ByMismatch) -> dict[str, Any]:
    """The figures of one plan as an entry of its row."""
    return {"simulated": {f"{mismatch:g}": figures.as_json() for mismatch, figures in measured.items()}}


def simulated_rows(folder: str, plans: Iterable[ByMismatch]) -> list[Row]:
    """Worst landing, touches and torque of several plans, and what is left of them with the mismatch."""
    found = list(plans)
    ideal, realistic = ([by[mismatch] for by in found] for mismatch in MISMATCHES)
    count = sum(one.trials for one in ideal)
    torque = max(one.peak_torque for by in found for one in by.values())
    landed = 100.0 * sum(one.sorted for one in realistic) / sum(one.trials for one in realistic)
    touched = float(sum(one.recontacts for one in ideal))
    of = f"of {count} cycles in the simulator without mismatch"
    return [
        Row(
            f"{folder}/landing-max",
            None,
            max(one.landing_error_max for one in ideal),
            "m",
            "ours",
            f"largest distance from the target {of}; throws are aimed short by delta",
        ),
        Row(f"{folder}/recontacts", None, touched, "-", "ours", f"objects touched again by the cup, {of}"),
        Row(
            f"{folder}/peak-torque",
            None,
            torque,
            "N m",
            "ours",
            f"largest motor torque; the motors give {T3KR.torque_limit:g} N m",
            {"limit": T3KR.torque_limit},
        ),
        Row(
            f"{folder}/sorted-with-mismatch",
            None,
            landed,
            "%",
            "ours",
            "in the opening and at rest in the bin, with every unmodelled effect at its realistic strength",
        ),
    ]
