"""What the release gives an object: peel and blown air, against forces summed up one by one; and cups by item."""

import numpy as np
import pytest

from pnt_gym.cells.base.bodies import lying_size, solid_shell_inertia
from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.cup.hold import true_hold
from pnt_gym.cells.conveyor.objects.drawing import time_constant
from pnt_gym.cells.conveyor.objects.kernel import blow_impulse, peel_impulse, write_spins
from pnt_gym.cells.conveyor.objects.rows import Lips
from pnt_gym.errors import ConfigError
from tests.tools.throws import item, make_core

COUNT, GRAVITY = 80, 9.81


def core_of(fidelity="full", mismatch=1.0, **cup):
    return make_core({"base": "waste_plain", "fidelity": fidelity, "mismatch": mismatch, "cup": cup}, COUNT)


def half_a_lip(radius, side):
    """Points of the half of a disc that lies away from a side (2,), evenly spread over it (K, 2)."""
    steps = (np.arange(400) + 0.5) / 400 * 2.0 * radius - radius
    x, y = (grid.ravel() for grid in np.meshgrid(steps, steps))
    inside = (np.hypot(x, y) < radius) & (x * side[0] + y * side[1] < 0.0)
    return np.stack([x, y], axis=1)[inside]


@pytest.mark.parametrize("grasp", [(0.006, 0.0), (-0.004, 0.009), (0.0, -0.012)])
def test_a_peel_is_the_moment_of_what_is_left_of_the_vacuum_over_its_decay(grasp):
    weight, radius, tau = 0.3, 0.018, 0.009
    points = half_a_lip(radius, np.array(grasp) / np.hypot(*grasp))
    arms = np.concatenate([points - grasp, np.zeros((len(points), 1))], axis=1)
    moment = np.cross(arms, [0.0, 0.0, weight]).mean(axis=0)
    t = (np.arange(20000) + 0.5) * 20.0 * tau / 20000
    impulse = moment * (np.exp(-t / tau) * 20.0 * tau / 20000).sum()
    found = peel_impulse(weight, *grasp, radius, tau)
    np.testing.assert_allclose(found, impulse[:2], rtol=2e-3, atol=1e-9)
    assert abs(impulse[2]) < 1e-12


def test_the_side_that_opened_goes_down():
    grasp = np.array([0.008, -0.003])
    spin = np.append(peel_impulse(0.2, *grasp, 0.018, 0.009), 0.0)
    assert np.cross(spin, np.append(grasp, 0.0))[2] < 0.0
    blown = np.append(blow_impulse(0.02, *grasp, 0.2), 0.0)
    assert np.cross(blown, np.append(grasp, 0.0))[2] > 0.0


def test_impulses_turn_objects_by_their_own_inertia():
    o, speed = core_of().context.objects, 0.2
    grasp, spin = np.random.default_rng(0).normal(0.0, 0.01, (COUNT, 2)), np.zeros((COUNT, 3))
    own = solid_shell_inertia(o.mass, lying_size(o.shape, o.size), o.shape)
    lips = Lips(*o.turn, grasp, np.zeros(COUNT))
    write_spins(1.0, False, o.replace(blow_off=np.full(COUNT, speed)).rows, lips, spin)
    for row in range(COUNT):
        cos, sin = np.cos(o.yaw[row]), np.sin(o.yaw[row])
        turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
        inertia = turn @ np.diag(own[row]) @ turn.T
        impulse = blow_impulse(o.mass[row], *grasp[row], speed)
        np.testing.assert_allclose(inertia @ spin[row], [*impulse, 0.0], rtol=1e-9, atol=1e-15)


def test_a_level_asks_for_peel_and_the_dial_turns_it():
    half, full = core_of(mismatch=0.5, peel=True), core_of(peel=True)
    o = full.context.objects
    size = np.hypot(*o.grasp.T)
    impulse = o.mass * GRAVITY * time_constant(o.seal, o.tau, full.config.suction) * (size + 4 * 0.018 / (3 * np.pi))
    own = solid_shell_inertia(o.mass, lying_size(o.shape, o.size), o.shape)[:, :2]
    rate = np.linalg.norm(o.spin, axis=1)
    assert (rate <= impulse / own.min(axis=1) + 1e-12).all()
    assert (rate >= impulse / own.max(axis=1) - 1e-12).all()
    assert (o.spin[:, 2] == 0.0).all()
    less = np.linalg.norm(half.context.objects.spin, axis=1)
    assert (less < 0.51 * rate).all()
    assert (less > 0.2 * rate).all()


def test_blown_air_adds_its_speed_downwards_and_nothing_else_changes():
    blown, still = (core_of("flight", blow_off=speed) for speed in (0.25, 0.0))
    one, other = (core.step(np.zeros((COUNT, 2))).info for core in (blown, still))
    free = ~(one["recontact"] | other["recontact"])
    assert (one["landing_along"] < other["landing_along"])[free].mean() > 0.95
    for name in ("item", "target_x", "target_y", "cycle_time"):
        np.testing.assert_array_equal(one[name], other[name])
    assert (blown.context.objects.mass == still.context.objects.mass).all()


def test_full_physics_and_flights_blow_alike():
    full, flight = (core_of(fidelity, blow_off=0.3).step(np.zeros((COUNT, 2))).info for fidelity in ("full", "flight"))
    free = ~(full["recontact"] | flight["recontact"])
    for name in ("landing_along", "landing_across"):
        assert np.quantile(np.abs(full[name] - flight[name])[free], 0.95) < 0.003


def test_what_is_lost_on_the_way_is_not_blown_off():
    heavy = {
        "base": "nominal_plain", "items": ["block"],
        "extra_items": [item("block", mass=0.3, seal_force=12.0)], "grip": {"limit": True},
    }  # fmt: skip
    still, blown = (
        make_core({**heavy, "cup": {"blow_off": speed, "peel": True}}, 20).step(np.zeros((20, 2))).info
        for speed in (0.0, 0.3)
    )
    assert still["dropped"].all()
    np.testing.assert_allclose(still["landing_along"], blown["landing_along"], atol=1e-9)


def test_every_item_of_the_catalogue_bears_the_cup_that_is_made_for_it():
    held = [one for one in CATALOGUE.values() if one.seal_force is not None]
    assert all(2.0 * one.fitted_radius <= min(one.size[:2]) for one in held)
    for name in ("cork", "cap", "can"):
        assert 0.020 <= 2.0 * CATALOGUE[name].fitted_radius <= 0.025
    strength = 0.6e5 * np.pi * np.array([one.fitted_radius for one in held]) ** 2
    assert (np.array([one.seal_force for one in held]) <= strength).all()


def test_fitted_cups_hold_and_touch_with_their_own_radius():
    fitted, common = core_of(fitted=True), core_of()
    radius = np.array([CATALOGUE[name].fitted_radius for name in fitted.config.items])[fitted.context.kind]
    np.testing.assert_array_equal(true_hold(fitted.context).radius, radius)
    np.testing.assert_array_equal(true_hold(common.context).radius, 0.018)
    batch, geom = fitted.cell.plant.batch, fitted.cell.plant.scene.cup_geoms[0]
    fitted.cell.plant.write(fitted.context)
    np.testing.assert_array_equal(batch.expand("geom_size")[:, geom, 0], radius)
    assert (batch.expand("geom_rbound")[:, geom] > radius).all()
    one, other = (core.step(np.zeros((COUNT, 2))).info for core in (fitted, common))
    small = radius < 0.018
    assert (one["grip_margin"] <= other["grip_margin"] + 1e-12).all()
    assert (one["grip_margin"] < other["grip_margin"])[small].any()
    np.testing.assert_array_equal(one["grip_margin"][~small], other["grip_margin"][~small])


def with_a_pea(fitted=True, **cup):
    small = item("pea", size=(0.045, 0.03, 0.03), mass=0.005, **cup)
    return {"base": "nominal_plain", "items": ["pea"], "extra_items": [small], "cup": {"fitted": fitted}}


@pytest.mark.parametrize(("size", "radius"), [((0.045, 0.03, 0.03), 0.012), ((0.12, 0.08, 0.05), 0.018)])
def test_an_item_that_says_nothing_of_its_cup_gets_one_that_fits(size, radius):
    """Four fifths as wide as the item, and no wider than the common one."""
    level = {**with_a_pea(), "extra_items": [item("pea", size=size, shape="box", mass=0.005)]}
    core = make_core(level, 4)
    np.testing.assert_allclose(true_hold(core.context).radius, radius)
    common = make_core({**level, "cup": {"fitted": False}}, 4)
    np.testing.assert_array_equal(true_hold(common.context).radius, 0.018)


@pytest.mark.parametrize("fitted", [True, False])
def test_a_cup_wider_than_its_item_is_refused(fitted):
    """Whether the level uses it or not."""
    with pytest.raises(ConfigError, match=r"cup_radius of 'pea' is 0.016 m, .* 32 mm wide, .* 30 mm across"):
        ConveyorConfig.load(with_a_pea(fitted, cup_radius=0.016))
    assert ConveyorConfig.load(with_a_pea(fitted, cup_radius=0.015)).item_list()[0].fitted_radius == 0.015
