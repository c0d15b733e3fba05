"""What `fidelity: flight` leaves out: the same seeded throws in both, with random corrections in half of them."""

from __future__ import annotations

import numpy as np

from benchmarks.studies.cells import CELLS, Amount, Figures, Infos, Settings, distance, infos, make_seeded_cells
from pnt_gym.cells.conveyor.config import ConveyorConfig


def _throws(settings: Settings, fidelity: str, amount: Amount) -> Infos:
    """Infos of independent throws; both fidelities get the same objects, targets and actions."""
    config = ConveyorConfig.load({**settings["level"], "fidelity": fidelity})
    core = make_seeded_cells(config, "independent", CELLS, amount.seed, amount.threads)
    largest, steps = settings["actions"], -(-amount.throws // CELLS)
    actions = np.random.default_rng(amount.seed).uniform(-largest, largest, (steps, CELLS, 2))
    actions[::2] = 0.0
    return infos(core, lambda step: actions[step], amount.throws)


def figures(settings: Settings, amount: Amount) -> Figures:
    """Flights against the full physics, lengths in m.

    Args:
        settings: `level`, and `actions`, the largest random correction as a share of the largest there is.
        amount: throws.
    """
    full, flight = (_throws(settings, fidelity, amount) for fidelity in ("full", "flight"))
    off = np.hypot(*distance(flight, full))
    off = off[np.isfinite(off)]
    return {
        "landing_mean_m": float(off.mean()),
        "landing_p95_m": float(np.quantile(off, 0.95)),
        "landing_max_m": float(off.max()),
        "success_full": float(full["is_success"].mean()),
        "success_flight": float(flight["is_success"].mean()),
        "success_differs": float((full["is_success"] != flight["is_success"]).mean()),
        "losses_differ": float(((full["dropped"] != flight["dropped"]) | (full["picked"] != flight["picked"])).mean()),
        "recontact_full": float(full["recontact"].mean()),
        "recontact_flight": float(flight["recontact"].mean()),
        "landing_error_full_m": float(np.nanmean(full["landing_error"])),
        "landing_error_flight_m": float(np.nanmean(flight["landing_error"])),
    }
