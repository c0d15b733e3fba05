"""Flights against full physics: what `fidelity: flight` leaves out, and flights judged before they come to rest."""

from __future__ import annotations

import numpy as np

from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import CELLS, distance, infos, make_seeded_cells, throw
from pnt_gym.arrays import Floats, Ints, in_order, take
from pnt_gym.cells.base.airborne import Airborne
from pnt_gym.cells.base.recorded import Touchdown, lies_in
from pnt_gym.cells.base.settling import FallEnd
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.free import FreeObjects
from pnt_gym.cells.conveyor.outcome import bins_of


def fidelity(settings: Settings, amount: Amount) -> Figures:
    """Flights against the full physics, lengths in m.

    Args:
        settings: `level`, and `actions`, the largest random correction as a share of the largest there is.
        amount: throws.
    """
    largest, steps = settings["actions"], -(-amount.throws // CELLS)
    actions = np.random.default_rng(amount.seed).uniform(-largest, largest, (steps, CELLS, 2))
    actions[::2] = 0.0
    full, flight = (
        throw({**settings["level"], "fidelity": simulated}, amount, lambda core: lambda step: actions[step])
        for simulated in ("full", "flight")
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


class EngineCheck:
    """Simulates every object that counts as staying in the engine until its throw ends, and compares the bins."""

    def __init__(self, free: FreeObjects, config: ConveyorConfig) -> None:
        self._free, self._settle, self._config = free, free.settle, config
        self.near, self.untouched, self.early, self.differing, self.steps = 0, 0, 0, 0, 0

    def settle(self, rows: Ints, context: Context, flying: Airborne, state: Floats, steps: Ints) -> FallEnd:
        """As `FreeObjects.settle`."""
        end = self._settle(rows, context, flying, state, steps)
        stays = np.flatnonzero(end.stays)
        self.near += len(rows)
        self.untouched += int((end.stays & (end.simulated == 0)).sum())
        self.early += stays.size
        self.steps += int(end.simulated.sum())
        if stays.size > 0:
            judged = ended_in(take(context, stays), end.position[stays], end.velocity[stays], self._config)
            self.differing += int((judged != self._simulate(rows[stays], take(context, stays), take(end, stays))).sum())
        return end

    def _simulate(self, rows: Ints, context: Context, end: FallEnd) -> Ints:
        """Bins in which the objects lie when their throws end (N,), -1 for none, in the engine alone."""
        fallen = self._free.fall(rows, context, end.state[:, :7], end.state[:, 7:], end.steps)
        last = fallen.sensors[np.arange(len(rows)), fallen.steps - 1]
        return ended_in(context, last[:, :3], last[:, 3:6], self._config)


def ended_in(context: Context, position: Floats, velocity: Floats, config: ConveyorConfig) -> Ints:
    """Indices of the bins in which objects lie (N,), -1 for none, by positions [m] and velocities [m/s] (N, 3)."""
    state = in_order(position[:, :2], position, velocity)
    touchdown = Touchdown(*state, np.zeros(len(position), dtype=np.bool_))
    in_bin = lies_in(touchdown, context.target, context.opening, context.bin_depth)
    return bins_of(touchdown, context, config, in_bin)


def margins(settings: Settings, amount: Amount) -> Figures:
    """Flights near openings, by how they were judged.

    Args:
        settings: `level`; `actions`, the largest random correction of every second throw as a share of the largest
            there is; `seed`, beside that of the study.
        amount: throws.
    """
    config = ConveyorConfig.load({**settings["level"], "fidelity": "flight"})
    seed, steps = amount.seed + settings["seed"], -(-amount.throws // CELLS)
    core = make_seeded_cells(config, "independent", CELLS, seed)
    assert isinstance(core.cell, ConveyorCell)
    free = core.cell.plant.free
    check = EngineCheck(free, config)
    setattr(free, "settle", check.settle)  # noqa: B010 - in place of the method
    actions = np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, CELLS, *core.action_space.shape))
    actions[::2] = 0.0
    success = infos(core, lambda step: settings["actions"] * actions[step], amount.throws)["is_success"]
    return {
        "throws": steps * CELLS,
        "success": float(success.mean()),
        "near": check.near,
        "untouched": check.untouched,
        "early": check.early,
        "differing": check.differing,
        "engine_steps": check.steps / (steps * CELLS),
        "untouched_share": check.untouched / check.near,
        "early_share": check.early / check.near,
    }
