"""Objects on the belt from random draws: true (hidden) values of each object and the sensors' measurements.

One object is one row of standard draws (normal and uniform) from the cell's generator. All functions of this module are
pure functions of these rows, so a cell draws the same objects alone and in a batch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, join_columns
from pnt_gym.cells.base.fluid import lying_extents, solid_shell_inertia
from pnt_gym.cells.base.items import ItemTable
from pnt_gym.cells.base.rotations import to_body_axes
from pnt_gym.cells.conveyor.config import ConveyorConfig, Suction
from pnt_gym.cells.conveyor.objects.records import TARGET_DRAWS, Objects, objects_in_block
from pnt_gym.constants import GRAVITY

NORMALS, UNIFORMS = 24, 12 + 3 * TARGET_DRAWS
"""Numbers of an object's standard normal and uniform draws, whose columns stand in `kernel`."""
HALF_LIP: Final = 4.0 / (3.0 * np.pi)
"""Distance of half a disc's centroid from the disc's middle, in radii."""


@final
@dataclass(frozen=True)
class SideDraws:
    """Draws of side generators for effects that a level switches on, uniform in [0, 1), with any leading shape S."""

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
        from pnt_gym.cells.conveyor.objects.kernel import COLUMN, draw_objects  # noqa: PLC0415 - numba takes a while

        shape, bins = normals.shape[:-1], side_draws.fill.shape[-1]
        z = np.ascontiguousarray(normals).reshape(-1, normals.shape[-1])
        u = np.ascontiguousarray(uniforms).reshape(-1, uniforms.shape[-1])
        side = np.empty((len(z), 2 + bins))
        side[:, 0], side[:, 1] = side_draws.pick.reshape(-1), side_draws.seen.reshape(-1)
        side[:, 2:] = side_draws.fill.reshape(-1, bins)
        block = np.empty((len(z), COLUMN["draws.fill"] + bins))
        draw_objects(
            z, u, side, self._factors(z), self._numbers, self._items, self._shares, self._confusion, self._percent,
            block,
        )  # fmt: skip
        objects, config = objects_in_block(block, bins), self._config
        mean = release_delay(objects.seal, objects.mass, config.suction) + self._table.clings[objects.kind]
        # An object cannot be free before the valve's command, whatever the jitter.
        block[:, COLUMN["delay"]] = np.maximum(config.mismatch * mean + objects.jitter, 0.0)
        begin = COLUMN["spin"]
        block[:, begin : begin + 3] = _spin(objects, config)
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
    tau = time_constant(seal, suction)
    return np.maximum(suction.valve + tau * np.log(seal / (mass * GRAVITY)), 0.0)


def time_constant(seal: Floats, suction: Suction) -> Floats:
    """Time constant tau_e [s] of the vacuum of seals that hold F0 [N]."""
    # tau_e = tau / (1 + leak (F_ref / F0 - 1)) for F0 < F_ref, see `Suction`.
    leak = np.where(seal < suction.leak_reference, suction.leak_reference / seal - 1.0, 0.0)
    return suction.tau / (1.0 + suction.leak * leak)


def _spin(objects: Objects, config: ConveyorConfig) -> Floats:
    """Spin of objects at release, S + (3,) [rad/s]: as drawn, or from the peeling lip, and from blown air."""
    m, cup, body = config.mismatch, config.cup, (objects.mass, objects.size, objects.shape, objects.yaw)
    spin = objects.spin
    if cup.peel:
        tau = time_constant(objects.seal, config.suction)
        impulse = peel_impulse(objects.mass * GRAVITY, objects.grasp, objects.cup_radius, tau)
        spin = spin_from_impulse(m * impulse, *body)
    if cup.blow_off > 0.0:
        spin = spin + spin_from_impulse(blow_impulse(objects.mass, objects.grasp, m * cup.blow_off), *body)
    return spin


def spin_at_grasp(objects: Objects, grasp: Floats, config: ConveyorConfig, seal: Floats | None = None) -> Floats:
    """Spin S + (3,) [rad/s] of objects with another grasp offset than drawn; the other parts of the spin stay.

    Args:
        objects: the objects as drawn, S.
        grasp: the new grasp offset, S + (2,) [m].
        config: the cell.
        seal: the new vacuum force, S [N]; None: as drawn.
    """

    def of(place: Floats, force: Floats) -> Floats:
        drawn = objects.replace(grasp=place, seal=force, spin=np.zeros_like(objects.spin))
        if not config.cup.peel:
            drawn = drawn.replace(spin=random_spin(drawn.spin, config.spread.spin_per_offset * place))
        return _spin(drawn, config)

    return objects.spin + (of(grasp, objects.seal if seal is None else seal) - of(objects.grasp, objects.seal))


def peel_impulse(weight: Floats, grasp: Floats, radius: Floats, tau: Floats) -> Floats:
    """Angular impulse of a lip that peels off at one side, about x and y, S + (2,) [N m s].

    An object is free when the vacuum has decayed to the object's weight. The lip opens first where the object is
    heavier, on the side of its centre of mass. The remaining force of the vacuum, m g exp(-t / tau), is assumed to act
    on the other half of the lip, whose centroid is 4 r / (3 pi) from the middle. With the grasp offset e the arm about
    the centre of mass is e + 4 r / (3 pi), and the impulse is m g tau (e + 4 r / (3 pi)). The open side goes down. The
    impulse is an upper bound, because the half lip is assumed to hold until the vacuum is gone.

    Args:
        weight: weight of the object, S [N].
        grasp: centre of mass relative to the cup's axis, along x, y, S + (2,) [m].
        radius: radius of the lip, S [m].
        tau: time constant of the vacuum, S [s].
    """
    offset = np.sqrt(grasp[..., 0] ** 2 + grasp[..., 1] ** 2)
    side = grasp / np.maximum(offset, 1e-12)[..., None]
    # The force m g exp(-t / tau) over all times gives m g tau; the rest is its arm.
    size = weight * tau * (offset + HALF_LIP * radius)
    return size[..., None] * join_columns(-side[..., 1], side[..., 0])


def blow_impulse(mass: Floats, grasp: Floats, speed: float) -> Floats:
    """Angular impulse about x and y of air that blows objects down along the cup's axis, S + (2,) [N m s].

    Args:
        mass: mass of the objects, S [kg].
        grasp: centre of mass relative to the cup's axis, along x, y, S + (2,) [m].
        speed: speed that the air gives the centre of mass [m/s].
    """
    return (mass * speed)[..., None] * join_columns(grasp[..., 1], -grasp[..., 0])


def spin_from_impulse(impulse: Floats, mass: Floats, size: Floats, shape: Ints, yaw: Floats) -> Floats:
    """Spin of free objects about x, y, z, S + (3,) [rad/s], from angular impulses about x and y.

    Args:
        impulse: angular impulses about the world's x and y, S + (2,) [N m s].
        mass: mass of the objects, S [kg].
        size: full extents, S + (3,) [m].
        shape: index in `items.SHAPES`, S.
        yaw: yaw of the objects, S [rad].
    """
    index = shape.reshape(-1)
    inertia = solid_shell_inertia(mass.reshape(-1), lying_extents(index, size.reshape(-1, 3)), index)
    level = np.concatenate([impulse, np.zeros_like(impulse[..., :1])], axis=-1)
    # The inertia is diagonal only in the object's axes: there the impulse becomes a spin, which is turned back.
    return to_body_axes(to_body_axes(level, yaw) / inertia.reshape(size.shape), -yaw)


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
