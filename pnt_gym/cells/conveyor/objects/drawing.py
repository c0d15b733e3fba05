"""Objects on the belt from random draws: true (hidden) values of each object and the sensors' measurements.

One object is one row of standard draws (normal and uniform) from the cell's generator. All functions of this module are
pure functions of these rows, so a cell draws the same objects alone and in a batch.
"""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.fluid import lying_size, solid_shell_inertia
from pnt_gym.cells.base.grip import CUP_RADIUS
from pnt_gym.cells.base.items import CYLINDER, ItemTable
from pnt_gym.cells.base.rotations import to_body_axes
from pnt_gym.cells.conveyor.config import ConveyorConfig, Suction
from pnt_gym.cells.conveyor.objects.records import Draws, Measured, Objects
from pnt_gym.constants import GRAVITY

TARGET_DRAWS = 8
"""Largest number of bins that are tried for one object before it stays on the belt."""

_NORMALS: Final = {
    "mass": np.s_[..., 0],
    "size": np.s_[..., 1:2],
    "size_axis": np.s_[..., 2:5],
    "drag": np.s_[..., 5],
    "seal": np.s_[..., 6],
    "com_depth": np.s_[..., 7],
    "grasp": np.s_[..., 8:10],
    "height": np.s_[..., 10],
    "belt_speed": np.s_[..., 11],
    "jitter": np.s_[..., 12],
    "spin": np.s_[..., 13:16],
    "measured_size": np.s_[..., 16:19],
    "measured_mass": np.s_[..., 19],
    "measured_seal": np.s_[..., 20],
    "measured_yaw": np.s_[..., 21],
    "grasp_noise": np.s_[..., 22:24],
}
"""Columns of an object's standard normal draws."""
NORMALS = 24
_UNIFORMS: Final = {
    "kind": np.s_[..., 0],
    "lane": np.s_[..., 1],
    "gap": np.s_[..., 2],
    "yaw": np.s_[..., 3],
    "residue_chance": np.s_[..., 4],
    "residue": np.s_[..., 5],
    "percent": np.s_[..., 6],
    "place": np.s_[..., 8:12],
    "bin": np.s_[..., 12 : 12 + 3 * TARGET_DRAWS],
}
"""Columns of an object's uniform draws; column 7 is not used."""
UNIFORMS = 12 + 3 * TARGET_DRAWS
_KIND_FIELDS: Final = ("shape", "friction", "cup_friction", "rolling_friction", "solref", "pick_chance")
"""Fields that are the same for all objects of a kind."""
_SMALLEST_EXTENT = 0.005
"""Smallest extent that the camera reports [m]."""
_MIN_DEPTH, _MAX_DEPTH = 0.05, 0.95
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


def objects_from_draws(
    normals: Floats, uniforms: Floats, config: ConveyorConfig, table: ItemTable, side_draws: SideDraws | None = None
) -> Objects:
    """Objects from standard draws.

    Args:
        normals: S + (NORMALS,) standard normal.
        uniforms: S + (UNIFORMS,) in [0, 1).
        config: the cell; its mismatch scales every hidden effect, but not the catalogue and the sensor noise.
        table: the items as arrays.
        side_draws: draws of side generators, S; None where no effect needs them.
    """
    side_draws = SideDraws.none(config, *normals.shape[:-1]) if side_draws is None else side_draws
    m, spread, noise = config.mismatch, config.spread, config.noise
    z = dict(zip(_NORMALS, itemgetter(*_NORMALS.values())(normals), strict=True))
    u = dict(zip(_UNIFORMS, itemgetter(*_UNIFORMS.values())(uniforms), strict=True))
    kind = _kinds(u["kind"], config)
    seen_kind = _classify(kind, side_draws.seen, config)
    size = _sizes(table, kind, z["size"], z["size_axis"], config)
    leftover = table.container[kind] & (u["residue_chance"] < spread.residue_chance)
    residue = np.where(leftover, spread.residue * u["residue"], 0.0)
    # Spreads are log-normal, so masses, forces and drag stay positive.
    mass = table.mass[kind] * np.exp(spread.mass * z["mass"]) * (1.0 + residue)
    seal = table.seal_force[kind] * np.exp(spread.seal * z["seal"])
    depth = table.com_depth[kind] + spread.com_depth * z["com_depth"] + 0.12 * residue / (1.0 + residue)
    com_depth = np.clip(depth, _MIN_DEPTH, _MAX_DEPTH) * size[..., 2] + m * spread.height * z["height"]
    grasp = m * spread.grasp * z["grasp"]
    jitter = m * config.suction.jitter * z["jitter"]
    yaw = spread.yaw * (2.0 * u["yaw"] - 1.0)
    lane, gap = config.belt.lane_y, config.belt.spacing
    objects = Objects(
        kind=kind,
        size=size,
        mass=mass,
        drag=table.drag[kind] * np.exp(spread.drag * z["drag"]),
        com_depth=com_depth,
        # At mismatch 0 the planner throws the centre of mass, from mismatch 1 on the tip of the cup.
        known_depth=max(1.0 - m, 0.0) * com_depth,
        seal=seal,
        # An object cannot be free before the valve's command, whatever the jitter.
        delay=np.maximum(m * (release_delay(seal, mass, config.suction) + table.clings[kind]) + jitter, 0.0),
        jitter=jitter,
        cup_radius=np.where(config.cup.fitted, table.cup_radius[kind], CUP_RADIUS),
        **{name: getattr(table, name)[kind] for name in _KIND_FIELDS},
        yaw=yaw,
        grasp=grasp,
        belt_error=m * spread.belt_speed * z["belt_speed"],
        spin=random_spin(m * spread.spin * z["spin"], spread.spin_per_offset * grasp),
        pick_draw=side_draws.pick,
        measured=Measured(
            kind=seen_kind,
            shape=table.shape[kind],
            size=_measure_size(size, noise.size * z["measured_size"]),
            mass=mass * np.exp(noise.mass * z["measured_mass"]),
            seal=seal * np.exp(noise.seal * z["measured_seal"]),
            yaw=yaw + noise.yaw * z["measured_yaw"],
            friction=table.cup_friction[seen_kind],
            grasp_noise=noise.grasp * z["grasp_noise"],
        ),
        percent=_choose(config.limits.percent, u["percent"]),
        draws=Draws(
            lane_y=lane[0] + (lane[1] - lane[0]) * u["lane"],
            gap=gap[0] + (gap[1] - gap[0]) * u["gap"],
            place=u["place"],
            bin=u["bin"].reshape(*uniforms.shape[:-1], TARGET_DRAWS, 3),
            fill=side_draws.fill,
        ),
    )
    return objects.replace(spin=_spin(objects, config)).pack()


def _choose(values: tuple[float, ...], draw: Floats) -> Floats:
    """One of the values, S, for uniform draws S."""
    return np.asarray(values)[np.minimum((draw * len(values)).astype(np.int64), len(values) - 1)]


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


def spin_at_grasp(objects: Objects, grasp: Floats, config: ConveyorConfig) -> Floats:
    """Spin S + (3,) [rad/s] of objects with another grasp offset than drawn; the other parts of the spin stay.

    Args:
        objects: the objects as drawn, S.
        grasp: the new grasp offset, S + (2,) [m].
        config: the cell.
    """

    def of(place: Floats) -> Floats:
        drawn = objects.replace(grasp=place, spin=np.zeros_like(objects.spin))
        if not config.cup.peel:
            drawn = drawn.replace(spin=random_spin(drawn.spin, config.spread.spin_per_offset * place))
        return _spin(drawn, config)

    return objects.spin + (of(grasp) - of(objects.grasp))


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
    return size[..., None] * np.stack([-side[..., 1], side[..., 0]], axis=-1)


def blow_impulse(mass: Floats, grasp: Floats, speed: float) -> Floats:
    """Angular impulse about x and y of air that blows objects down along the cup's axis, S + (2,) [N m s].

    Args:
        mass: mass of the objects, S [kg].
        grasp: centre of mass relative to the cup's axis, along x, y, S + (2,) [m].
        speed: speed that the air gives the centre of mass [m/s].
    """
    return (mass * speed)[..., None] * np.stack([grasp[..., 1], -grasp[..., 0]], axis=-1)


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
    inertia = solid_shell_inertia(mass.reshape(-1), lying_size(index, size.reshape(-1, 3)), index)
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


def _kinds(draw: Floats, config: ConveyorConfig) -> Ints:
    """Items of objects for uniform draws S: all items equally often, or in the shares of the level's `mix`."""
    if not config.mix:
        return np.minimum((draw * len(config.items)).astype(np.int64), len(config.items) - 1)
    return np.minimum(np.searchsorted(np.cumsum(config.shares()), draw, side="right"), len(config.items) - 1)


def _classify(kind: Ints, draw: Floats, config: ConveyorConfig) -> Ints:
    """Items that the classifier sees in objects of kinds S, for uniform draws S."""
    if not config.classifier.confusion:
        return kind.copy()
    # Inverse of a cumulative distribution: the draw passes as many bounds as there are items before the seen one.
    reached = np.cumsum(config.confusion(), axis=1)[kind]
    return np.minimum((draw[..., None] >= reached).sum(axis=-1), len(config.items) - 1)


def _sizes(table: ItemTable, kind: Ints, common: Floats, axes: Floats, config: ConveyorConfig) -> Floats:
    """True extents from draws common to the axes S + (1,) and per axis S + (3,); a cylinder keeps one diameter."""
    axis_spread = config.spread.size_axis * axes
    axis_spread[..., 1] = np.where(table.shape[kind] == CYLINDER, axis_spread[..., 2], axis_spread[..., 1])
    return table.size[kind] * np.exp(config.spread.size * common + axis_spread)


def _measure_size(size: Floats, noise: Floats) -> Floats:
    """Measured extents, S + (3,) [m]: length and width by the camera, the height without noise by the cup."""
    measured = np.maximum(size + noise, _SMALLEST_EXTENT)
    measured[..., 2] = size[..., 2]
    return measured
