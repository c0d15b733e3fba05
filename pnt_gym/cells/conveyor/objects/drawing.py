"""Objects on the belt from random draws: true (hidden) values of each object and the sensors' measurements.

One object is one row of standard draws (normal and uniform) from the cell's generator. All functions of this module are
pure functions of these rows, so a cell draws the same objects alone and in a batch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats, rows_of_words
from pnt_gym.cells.base.items import ItemTable
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects import kernel
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.objects.rows import (
    Aside,
    CellNumbers,
    Factors,
    ItemMix,
    ItemRow,
    Lips,
    Normals,
    StandardDraws,
    Uniforms,
)
from pnt_gym.cells.conveyor.sections import Suction
from pnt_gym.constants import GRAVITY

NORMALS, UNIFORMS = Normals.dtype.itemsize // 8, Uniforms.dtype.itemsize // 8
"""Numbers of an object's standard normal and uniform draws."""


@final
@dataclass(frozen=True)
class SideDraws:
    """Draws aside for effects that a level switches on, with any leading shape S; uniform in [0, 1) unless noted."""

    pick: Floats
    """Draw that decides whether the cup seals; 1 where picks do not fail."""
    seen: Floats
    """Draw of the item that the classifier sees."""
    fill: Floats
    """Draw of the content of each bin, S + (B,)."""
    spread: Floats
    """Standard normal draws of restitution, friction, blown air and residue, S + (4,)."""
    hand: Floats
    """Standard normal draws of the hand's error in the object's throw, S + (3,)."""

    @classmethod
    def none(cls, config: ConveyorConfig, *shape: int) -> SideDraws:
        """Draws with which no pick fails, bins are empty, contacts and air have their medians, and no hand errs."""
        empty = np.zeros((*shape, max(len(config.bins.fixed), 1)))
        return cls(np.ones(shape), np.zeros(shape), empty, np.zeros((*shape, 4)), np.zeros((*shape, 3)))


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
        cell = CellNumbers.zeros(
            1, mismatch=config.mismatch, com_depth=spread.com_depth, height=spread.height, grasp=spread.grasp,
            yaw=spread.yaw, belt_speed=spread.belt_speed, spin=spread.spin, spin_per_offset=spread.spin_per_offset,
            size_noise=noise.size, yaw_noise=noise.yaw, grasp_noise=noise.grasp, jitter=config.suction.jitter,
            fitted=config.cup.fitted, lane_y=belt.lane_y, spacing=belt.spacing, **cup_numbers(config),
        )  # fmt: skip
        self._mix = ItemMix(
            cell=cell,
            items=ItemRow.zeros(len(table.mass), **{name: getattr(table, name) for name in ItemRow.fields}),
            shares=np.cumsum(config.shares()) if config.mix else np.empty(0),
            confusion=np.cumsum(config.confusion(), axis=1) if config.classifier.confusion else np.empty((0, 0)),
            percent=np.array(config.limits.percent, dtype=np.float64),
        )
        self._scales = np.array([spread.mass, spread.seal, spread.drag, noise.mass, noise.seal])
        """Spreads of the logarithms of mass, seal, drag and of their measurements."""
        hidden = config.mismatch * np.array([spread.restitution, spread.friction])
        self._side_scales = np.array([*hidden, spread.blow_off, spread.residue])
        """Spreads of the logarithms of restitution, friction, the speed of blown air and the residue."""

    def make(self, normals: Floats, uniforms: Floats, side_draws: SideDraws) -> Objects:
        """Objects S from standard normal draws S + (NORMALS,), uniform draws S + (UNIFORMS,) and side draws S."""
        shape, config = normals.shape[:-1], self._config
        rows: Any = Objects.empty(*shape)
        aside: Any = Aside.empty(*shape)
        aside["pick"], aside["seen"] = side_draws.pick, side_draws.seen
        doubles, made = normals.reshape(-1, NORMALS), rows.reshape(-1)
        z, u = rows_of_words(doubles, Normals.dtype), rows_of_words(uniforms.reshape(-1, UNIFORMS), Uniforms.dtype)
        # Exponential factors; spreads are log-normal, so values stay positive.
        spread, exponents = config.spread, np.empty((len(z), 12))
        exponents[:, :5] = self._scales * doubles[:, _SPREAD_COLUMNS]
        exponents[:, 5:9] = self._side_scales * side_draws.spread.reshape(-1, 4)
        # The residue of an item is a mean, the other values are medians.
        exponents[:, 8] -= spread.residue**2 / 2.0
        exponents[:, 9:] = spread.size * doubles[:, 1:2] + spread.size_axis * doubles[:, 2:5]
        factors = rows_of_words(np.exp(exponents), Factors.dtype)
        kernel.draw_objects(StandardDraws(z, u, aside.reshape(-1), factors), self._mix, made)
        seal, mass = made["seal"], made["mass"]
        delay = release_delay(seal, mass, made["valve"], made["tau"], config.suction)
        delay += self._table.clings[made["kind"]]
        # An object cannot be free before the valve's command, whatever the jitter.
        made["delay"] = np.maximum(config.mismatch * delay + made["jitter"], 0.0)
        spin = made["spin"].copy()
        tau = time_constant(seal, made["tau"], config.suction)
        drawn = Objects(made, side_draws.fill)
        kernel.write_spins(config.mismatch, config.cup.peel, made, Lips(*drawn.turn, drawn.grasp, tau), spin)
        made["spin"] = spin
        made["hand_error"] = config.mismatch * config.robot.accuracy * side_draws.hand.reshape(-1, 3)
        return Objects(rows, side_draws.fill)


_SPREAD_COLUMNS: Final = np.array([0, 6, 5, 19, 20])
"""Places among the normal draws of mass, seal, drag, measured mass and measured seal."""


def cup_numbers(config: ConveyorConfig) -> dict[str, float]:
    """Numbers of the cell's cup and of its valve, by their fields of `Objects`."""
    cup, suction = config.cup, config.suction
    stiffness = np.inf if cup.stiffness is None else cup.stiffness
    return {"valve": suction.valve, "tau": suction.tau, "stiffness": stiffness, "blow_off": cup.blow_off}


def release_delay(seal: Floats, mass: Floats, valve: Floats, tau: Floats, suction: Suction) -> Floats:
    """Mean delay between the valve command and the moment the object is free [s].

    The vacuum decays exponentially and holds the object until its force drops below the weight. A porous seal (low F0)
    vents through its leak too, which shortens the time constant.

    Args:
        seal: vacuum force before the release F0 [N], any shape.
        mass: mass of the object [kg], same shape.
        valve: delay of the valve [s].
        tau: time constant of the vacuum under a tight seal [s].
        suction: the leak.

    Returns:
        valve + tau_e ln(F0 / (m g)) [s], never below 0.
    """
    return np.maximum(valve + time_constant(seal, tau, suction) * np.log(seal / (mass * GRAVITY)), 0.0)


def time_constant(seal: Floats, tau: Floats, suction: Suction) -> Floats:
    """Time constant tau_e [s] of the vacuum of seals that hold F0 [N]; tau [s] is that under a tight seal."""
    # tau_e = tau / (1 + leak (F_ref / F0 - 1)) for F0 < F_ref, see `Suction`.
    leak = np.where(seal < suction.leak_reference, suction.leak_reference / seal - 1.0, 0.0)
    return tau / (1.0 + suction.leak * leak)


def spin_at_grasp(objects: Objects, grasp: Floats, config: ConveyorConfig, seal: Floats | None = None) -> Floats:
    """Spin (N, 3) [rad/s] of objects with another grasp offset than drawn; the other parts of the spin stay.

    Args:
        objects: the objects as drawn (N,).
        grasp: the new grasp offset (N, 2) [m].
        config: the cell.
        seal: the new vacuum force (N,) [N]; None: as drawn.
    """
    after, before = lip_spin(objects, grasp, config, seal), lip_spin(objects, objects.grasp, config)
    return objects.spin + (after - before)


def lip_spin(objects: Objects, grasp: Floats, config: ConveyorConfig, seal: Floats | None = None) -> Floats:
    """Spin (N, 3) [rad/s] that lips and blown air give objects at a grasp offset; arguments as in `spin_at_grasp`."""
    spin = random_spin(np.zeros_like(objects.spin), config.spread.spin_per_offset * grasp)
    tau = time_constant(objects.seal if seal is None else seal, objects.tau, config.suction)
    kernel.write_spins(config.mismatch, config.cup.peel, objects.rows, Lips(*objects.turn, grasp, tau), spin)
    return spin


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
