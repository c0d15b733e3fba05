"""Objects on the belt from random draws: true (hidden) values of each object and the sensors' measurements.

One object is one row of standard draws (normal and uniform) from the cell's generator. All functions of this module are
pure functions of these rows, so a cell draws the same objects alone and in a batch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.fluid import GYRATION
from pnt_gym.cells.base.items import ItemTable
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects import kernel
from pnt_gym.cells.conveyor.objects.records import TARGET_DRAWS, Objects, objects_in_block
from pnt_gym.cells.conveyor.sections import Suction
from pnt_gym.constants import GRAVITY

NORMALS, UNIFORMS = 24, 12 + 3 * TARGET_DRAWS
"""Numbers of an object's standard normal and uniform draws, whose columns stand in `kernel`."""


@final
@dataclass(frozen=True)
class SideDraws:
    """Draws aside for effects that a level switches on, uniform in [0, 1), with any leading shape S."""

    pick: Floats
    """Draw that decides whether the cup seals; 1 where picks do not fail."""
    seen: Floats
    """Draw of the item that the classifier sees."""
    fill: Floats
    """Draw of the content of each bin, S + (B,)."""

    @classmethod
    def none(cls, config: ConveyorConfig, *shape: int) -> SideDraws:
        """Draws with which no pick fails and all bins are empty."""
        return cls(np.ones(shape), np.zeros(shape), np.zeros((*shape, max(len(config.bins.fixed), 1))))


@final
class ObjectMaker:
    """Makes objects from standard draws.

    Args:
        config: the cell; its mismatch scales every hidden effect, but not the catalogue and the sensor noise.
        table: the items as arrays.
    """

    def __init__(self, config: ConveyorConfig, table: ItemTable) -> None:
        self._config, self._table = config, table
        spread, noise, belt = config.spread, config.noise, config.belt
        self._numbers = np.array(
            [
                config.mismatch, spread.residue_chance, spread.residue, spread.com_depth, spread.height, spread.grasp,
                spread.yaw, spread.belt_speed, spread.spin, spread.spin_per_offset, noise.size, noise.yaw, noise.grasp,
                config.suction.jitter, float(config.cup.fitted), *belt.lane_y, *belt.spacing,
            ]
        )  # fmt: skip
        columns = (
            table.shape, table.size, table.mass, table.drag, table.com_depth, table.seal_force, table.container,
            table.friction, table.rolling_friction, table.solref, table.cup_friction, table.cup_radius,
            table.pick_chance,
        )  # fmt: skip
        self._items = np.column_stack([np.asarray(column, dtype=np.float64) for column in columns])
        self._shares = np.cumsum(config.shares()) if config.mix else np.empty(0)
        has_confusion = bool(config.classifier.confusion)
        self._confusion = np.cumsum(config.confusion(), axis=1) if has_confusion else np.empty((0, 0))
        self._percent = np.array(config.limits.percent, dtype=np.float64)
        self._scales = np.array([spread.mass, spread.seal, spread.drag, noise.mass, noise.seal])
        """Spreads of the logarithms of mass, seal, drag and of their measurements."""

    def make(self, normals: Floats, uniforms: Floats, side_draws: SideDraws) -> Objects:
        """Objects S from standard normal draws S + (NORMALS,), uniform draws S + (UNIFORMS,) and side draws S."""
        shape, bins = normals.shape[:-1], side_draws.fill.shape[-1]
        z = np.ascontiguousarray(normals).reshape(-1, normals.shape[-1])
        u = np.ascontiguousarray(uniforms).reshape(-1, uniforms.shape[-1])
        side = np.empty((len(z), 2 + bins))
        side[:, 0], side[:, 1] = side_draws.pick.reshape(-1), side_draws.seen.reshape(-1)
        side[:, 2:] = side_draws.fill.reshape(-1, bins)
        block = np.empty((len(z), kernel.FILL + bins))
        kernel.draw_objects(
            z, u, side, self._factors(z), self._numbers, self._items, self._shares, self._confusion, self._percent,
            block,
        )  # fmt: skip
        config, seal, mass = self._config, block[:, kernel.SEAL], block[:, kernel.MASS]
        tau = time_constant(seal, config.suction)
        delay = (
            _release_delay(seal, mass, tau, config.suction) + self._table.clings[block[:, kernel.KIND].astype(np.int64)]
        )
        # An object cannot be free before the valve's command, whatever the jitter.
        block[:, kernel.DELAY] = np.maximum(config.mismatch * delay + block[:, kernel.JITTER_TIME], 0.0)
        bodies = mass, block[:, kernel.SIZE : kernel.SIZE + 3], block[:, kernel.SHAPE], block[:, kernel.TURN].copy()
        cups = block[:, kernel.OFFSET : kernel.OFFSET + 2], block[:, kernel.RADIUS], tau
        _add_spins(*bodies, *cups, block[:, kernel.SPIN_RATE : kernel.SPIN_RATE + 3], config)
        return objects_in_block(block.reshape(*shape, -1), bins)

    def _factors(self, normals: Floats) -> Floats:
        """Exponential factors (N, 8) as `kernel` names them; spreads are log-normal, so values stay positive."""
        spread, exponents = self._config.spread, np.empty((len(normals), 8))
        exponents[:, :5] = self._scales * normals[:, _SPREAD_COLUMNS]
        exponents[:, 5:] = spread.size * normals[:, 1:2] + spread.size_axis * normals[:, 2:5]
        return np.exp(exponents)


_SPREAD_COLUMNS: Final = np.array([0, 6, 5, 19, 20])
"""Columns of the normal draws of mass, seal, drag, measured mass and measured seal."""


def objects_from_draws(
    normals: Floats, uniforms: Floats, config: ConveyorConfig, table: ItemTable, side_draws: SideDraws | None = None
) -> Objects:
    """Objects as `ObjectMaker.make`; side draws None where no effect needs them."""
    side_draws = SideDraws.none(config, *normals.shape[:-1]) if side_draws is None else side_draws
    return ObjectMaker(config, table).make(normals, uniforms, side_draws)


def release_delay(seal: Floats, mass: Floats, suction: Suction) -> Floats:
    """Mean delay between the valve command and the moment the object is free [s].

    The vacuum decays exponentially and holds the object until its force drops below the weight. A porous seal (low F0)
    vents through its leak too, which shortens the time constant.

    Args:
        seal: vacuum force before the release F0 [N], any shape.
        mass: mass of the object [kg], same shape.
        suction: valve delay, time constant and leak.

    Returns:
        valve + tau_e ln(F0 / (m g)) [s], never below 0.
    """
    return _release_delay(seal, mass, time_constant(seal, suction), suction)


def _release_delay(seal: Floats, mass: Floats, tau: Floats, suction: Suction) -> Floats:
    """Delays as `release_delay`, for time constants tau_e [s]."""
    return np.maximum(suction.valve + tau * np.log(seal / (mass * GRAVITY)), 0.0)


def time_constant(seal: Floats, suction: Suction) -> Floats:
    """Time constant tau_e [s] of the vacuum of seals that hold F0 [N]."""
    # tau_e = tau / (1 + leak (F_ref / F0 - 1)) for F0 < F_ref, see `Suction`.
    leak = np.where(seal < suction.leak_reference, suction.leak_reference / seal - 1.0, 0.0)
    return suction.tau / (1.0 + suction.leak * leak)


def _add_spins(
    mass: Floats,
    size: Floats,
    shape: Floats,
    yaw: Floats,
    grasp: Floats,
    radius: Floats,
    tau: Floats,
    spin: Floats,
    config: ConveyorConfig,
) -> None:
    """Write the spins of N objects at release (N, 3) [rad/s], in place: of the peeling lip and of blown air."""
    cup, turn = config.cup, np.array([np.cos(yaw), np.sin(yaw)])
    kernel.write_spins(
        config.mismatch, cup.peel, cup.blow_off, mass, size, shape, turn, grasp, radius, tau, GYRATION, spin
    )


def spin_at_grasp(objects: Objects, grasp: Floats, config: ConveyorConfig, seal: Floats | None = None) -> Floats:
    """Spin (N, 3) [rad/s] of objects with another grasp offset than drawn; the other parts of the spin stay.

    Args:
        objects: the objects as drawn (N,).
        grasp: the new grasp offset (N, 2) [m].
        config: the cell.
        seal: the new vacuum force (N,) [N]; None: as drawn.
    """
    bodies = objects.mass, objects.size, objects.shape.astype(np.float64), objects.yaw

    def of(place: Floats, force: Floats) -> Floats:
        spin = random_spin(np.zeros_like(objects.spin), config.spread.spin_per_offset * place)
        _add_spins(*bodies, place, objects.cup_radius, time_constant(force, config.suction), spin, config)
        return spin

    return objects.spin + (of(grasp, objects.seal if seal is None else seal) - of(objects.grasp, objects.seal))


def random_spin(random: Floats, offset: Floats) -> Floats:
    """Spin at release, S + (3,) [rad/s]: a random part (a third of it about z) plus a part from the grasp offset.

    Args:
        random: random part, S + (3,) [rad/s].
        offset: grasp offset times spin per offset, along x, y, S + (2,) [rad/s].
    """
    spin = random.copy()
    spin[..., 2] /= 3.0
    spin[..., 0] += offset[..., 1]
    spin[..., 1] -= offset[..., 0]
    return spin
