"""Objects in machine code are those of the formulas written in NumPy, to the last bit; side draws come from afar."""

import numpy as np
import pytest

from pnt_gym.cells.base.cell import JUMPS_PER_PURPOSE, Purpose, draw_aside
from pnt_gym.cells.base.items import CUP_RADIUS, CYLINDER, ELLIPSOID, item_arrays
from pnt_gym.cells.conveyor.objects.drawing import NORMALS, UNIFORMS, SideDraws, random_spin, release_delay
from pnt_gym.cells.conveyor.objects.kernel import inside_outline
from tests.tools.throws import objects_from_draws, parts_of, same_bits, vary

COUNT = 400
NO_LIP = {"peel": False}
CONFUSION = {"can": {"can": 0.6, "pet_05": 0.4}, "cork": {"cap": 0.3, "cork": 0.7}}
LEVELS = [
    vary("waste", cup=NO_LIP),
    vary("waste", mismatch=0.4, cup={**NO_LIP, "fitted": False}, mix={"can": 1.0, "cork": 2.5, "tray": 0.5}),
    vary("waste", cup=NO_LIP, classifier={"confusion": CONFUSION}),
    vary("nominal", mismatch=2.0, cup=NO_LIP),
    vary(
        "waste",
        cup={**NO_LIP, "stiffness": None},
        suction={"valve": 0.006, "tau": 0.014},
        spread={"restitution": 0.8, "friction": 0.5, "blow_off": 0.3},
    ),
]


def draws(config, seed):
    random = np.random.default_rng(seed)
    bins = max(len(config.bins.fixed), 1)
    uniform = random.random((COUNT, 2)), random.random((COUNT, 2)), random.random((COUNT, 2, bins))
    normals, uniforms = random.standard_normal((COUNT, 2, NORMALS)), random.random((COUNT, 2, UNIFORMS))
    return normals, uniforms, SideDraws(*uniform, *(random.standard_normal((COUNT, 2, size)) for size in (4, 3)))


def kinds(config, u, side):
    count = len(config.items)
    kind = np.minimum((u[..., 0] * count).astype(int), count - 1)
    if config.mix:
        kind = np.minimum(np.searchsorted(np.cumsum(config.shares()), u[..., 0], side="right"), count - 1)
    seen = kind
    if config.classifier.confusion:
        reached = np.cumsum(config.confusion(), axis=1)[kind]
        seen = np.minimum((side.seen[..., None] >= reached).sum(axis=-1), count - 1)
    return kind, seen


def values(config, table, z, u, side):
    """Every value of objects without the spin of a lip, by the names of `parts_of`."""
    m, spread, noise, belt = config.mismatch, config.spread, config.noise, config.belt
    kind, seen = kinds(config, u, side)
    axes = spread.size_axis * z[..., 2:5]
    axes[..., 1] = np.where(table.shape[kind] == CYLINDER, axes[..., 2], axes[..., 1])
    size = table.size[kind] * np.exp(spread.size * z[..., 1:2] + axes)
    side_scales = np.array([m * spread.restitution, m * spread.friction, spread.blow_off, spread.residue])
    factors = np.exp(side_scales * side.spread - [0.0, 0.0, 0.0, spread.residue**2 / 2.0])
    residue = table.residue[kind] * factors[..., 3]
    mass = table.mass[kind] * np.exp(spread.mass * z[..., 0]) * (1.0 + residue)
    seal = table.seal_force[kind] * np.exp(spread.seal * z[..., 6])
    share = table.com_depth[kind] + spread.com_depth * z[..., 7] + 0.12 * residue / (1.0 + residue)
    depth = np.clip(share, 0.05, 0.95) * size[..., 2] + m * spread.height * z[..., 10]
    grasp, jitter = m * spread.grasp * z[..., 8:10], m * config.suction.jitter * z[..., 12]
    yaw = spread.yaw * (2.0 * u[..., 3] - 1.0)
    valve, tau = np.full(kind.shape, config.suction.valve), np.full(kind.shape, config.suction.tau)
    delay = release_delay(seal, mass, valve, tau, config.suction) + table.clings[kind]
    measured_size = np.maximum(size + noise.size * z[..., 16:19], 0.005)
    measured_size[..., 2] = size[..., 2]
    percent = np.array(config.limits.percent)
    setting = np.minimum((u[..., 6] * len(percent)).astype(int), len(percent) - 1)
    return {
        "kind": kind,
        "shape": table.shape[kind],
        "size": size,
        "mass": mass,
        "drag": table.drag[kind] * np.exp(spread.drag * z[..., 5]),
        "com_depth": depth,
        "known_depth": max(1.0 - m, 0.0) * depth,
        "seal": seal,
        "valve": valve,
        "tau": tau,
        "delay": np.maximum(m * delay + jitter, 0.0),
        "jitter": jitter,
        "friction": table.friction[kind] * factors[..., 1],
        "cup_friction": table.cup_friction[kind],
        "cup_radius": np.where(config.cup.fitted, table.cup_radius[kind], CUP_RADIUS),
        "rolling_friction": table.rolling_friction[kind],
        "stiffness": np.full(kind.shape, np.inf if config.cup.stiffness is None else config.cup.stiffness),
        "blow_off": config.cup.blow_off * factors[..., 2],
        "restitution": np.minimum(table.restitution[kind] * factors[..., 0], 1.0),
        "yaw": yaw,
        "grasp": grasp,
        "belt_error": m * spread.belt_speed * z[..., 11],
        "spin": random_spin(m * spread.spin * z[..., 13:16], spread.spin_per_offset * grasp),
        "pick_chance": table.pick_chance[kind],
        "pick_draw": side.pick,
        "percent": percent[setting],
        "measured.kind": seen,
        "measured.shape": table.shape[kind],
        "measured.size": measured_size,
        "measured.mass": mass * np.exp(noise.mass * z[..., 19]),
        "measured.seal": seal * np.exp(noise.seal * z[..., 20]),
        "measured.yaw": yaw + noise.yaw * z[..., 21],
        "measured.friction": table.cup_friction[seen],
        "measured.grasp_noise": noise.grasp * z[..., 22:24],
        "draws.lane_y": belt.lane_y[0] + (belt.lane_y[1] - belt.lane_y[0]) * u[..., 1],
        "draws.gap": belt.spacing[0] + (belt.spacing[1] - belt.spacing[0]) * u[..., 2],
        "draws.place": u[..., 8:12],
        "draws.bin": u[..., 12:36].reshape(COUNT, 2, 8, 3),
        "hand_error": m * config.robot.accuracy * side.hand,
        "fill": side.fill,
    }


@pytest.mark.parametrize("config", LEVELS, ids=["waste", "mix", "confusion", "nominal", "contact"])
def test_objects_are_those_of_the_formulas(config):
    table = item_arrays(config.item_list())
    z, u, side = draws(config, 1)
    found, expected = parts_of(objects_from_draws(z, u, config, table, side)), values(config, table, z, u, side)
    assert found.keys() == expected.keys()
    for name, column in expected.items():
        assert same_bits(found[name], column), name


@pytest.mark.parametrize("purpose", Purpose)
def test_a_generator_aside_draws_as_one_that_jumps_and_comes_back(purpose):
    generator = np.random.default_rng([5, purpose])
    generator.integers(3)  # leaves half of a number behind
    before = generator.bit_generator.state
    found, again = draw_aside(generator, *[(purpose, lambda aside: aside.random(7))] * 2)
    assert same_bits(found, again)
    assert generator.bit_generator.state == before
    jumped = np.random.default_rng(generator.bit_generator.jumped(JUMPS_PER_PURPOSE * purpose))
    assert same_bits(found, jumped.random(7))


def test_distances_from_outlines_are_those_of_the_formula():
    config = vary("waste")
    objects = objects_from_draws(*(x[:, 0] for x in draws(config, 3)[:2]), config, item_arrays(config.item_list()))
    place = np.random.default_rng(4).uniform(-0.15, 0.15, (COUNT, 2))
    cos, sin, (x, y) = np.cos(objects.yaw), np.sin(objects.yaw), place.T
    a, b = np.abs(cos * x + sin * y), np.abs(cos * y - sin * x)
    length, width = objects.size[:, 0] / 2.0, objects.size[:, 1] / 2.0
    outside = np.hypot(np.maximum(a - length, 0.0), np.maximum(b - width, 0.0))
    rectangle = np.maximum(np.minimum(length - a, width - b), 0.0) - outside
    ellipse = (1.0 - np.hypot(a / length, b / width)) * np.minimum(length, width)
    expected = np.where(objects.shape == ELLIPSOID, ellipse, rectangle)
    np.testing.assert_allclose(inside_outline(objects.rows, place), expected, rtol=1e-12, atol=1e-15)
    assert 0.1 < (expected > 0.0).mean() < 0.9
