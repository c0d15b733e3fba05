"""What `fidelity: flight` leaves out: the same seeded throws in both, with random corrections in half of them."""

from __future__ import annotations

import numpy as np

from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import CELLS, distance, throw


def figures(settings: Settings, amount: Amount) -> Figures:
    """Flights against the full physics, lengths in m.

    Args:
        settings: `level`, and `actions`, the largest random correction as a share of the largest there is.
        amount: throws.
    """
    largest, steps = settings["actions"], -(-amount.throws // CELLS)
    actions = np.random.default_rng(amount.seed).uniform(-largest, largest, (steps, CELLS, 2))
    actions[::2] = 0.0
    full, flight = (
        throw({**settings["level"], "fidelity": fidelity}, amount, lambda core: lambda step: actions[step])
        for fidelity in ("full", "flight")
    )
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
