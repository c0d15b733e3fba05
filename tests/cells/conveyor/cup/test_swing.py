"""A cup that yields: the engine's swing against closed forms and against the swing that flights reckon with."""

from functools import cache
from itertools import product

import mujoco
import numpy as np
import pytest

from pnt_gym.cells.base.bodies import lying_size, solid_shell_inertia, vertical
from pnt_gym.cells.base.plant import roll_out
from pnt_gym.cells.conveyor.config import LIP_LENGTH
from pnt_gym.cells.conveyor.cup.swing import LARGEST_PHASE, springs
from pnt_gym.cells.conveyor.hand import ThrowClock
from tests.tools.nightly import with_nightly
from tests.tools.t3kr import control_columns
from tests.tools.throws import item, make_core, same_bits, whole_cycle, with_objects

COUNT = 60


def level(base="waste_plain", fidelity="full", timestep=0.001, mismatch=1.0, **cup):
    return {"base": base, "fidelity": fidelity, "timestep": timestep, "mismatch": mismatch, "cup": cup}


def cycle_of(core):
    """Cycles without a correction."""
    return whole_cycle(core, core.plan(np.zeros((core.count, 2)))[0])[1]


def clock_of(core):
    return ThrowClock.of(core.context, cycle_of(core), core.config)


@cache
def infos(fidelity, base="waste_plain", count=COUNT, **cup):
    core = make_core(level(base, fidelity, **cup), count)
    return core.step(np.random.default_rng(0).uniform(-0.3, 0.3, (count, 2))).info


def inertia_about_the_lip(objects, grasp):
    """About x and y of objects that lie along them (N, 2), by the parallel axes."""
    own = solid_shell_inertia(objects.mass, lying_size(objects.shape, objects.size), objects.shape)[:, :2]
    return own + objects.mass[:, None] * (grasp[:, ::-1] ** 2 + objects.com_depth[:, None] ** 2)


def test_the_inertia_that_a_lip_feels_is_that_about_it_less_what_turns_the_other_axes():
    """By summing up small parts of a box that stand for its inertia."""
    core = make_core("waste_plain", COUNT)
    with_objects(core, yaw=np.zeros(COUNT))
    picks = core.context
    found, o = picks.lip_inertia, picks.objects
    own = solid_shell_inertia(o.mass, lying_size(o.shape, o.size), o.shape)
    for row in range(COUNT):
        spread = np.sqrt(np.maximum(own[row].sum() / 2 - own[row], 0.0) / o.mass[row])
        parts = np.concatenate([np.diag(spread), -np.diag(spread)]) * np.sqrt(3.0)
        places = parts + np.append(picks.grasp[row], -o.com_depth[row])
        inertia = sum(o.mass[row] / 6 * (p @ p * np.eye(3) - np.outer(p, p)) for p in places)
        turned = np.linalg.solve(inertia, np.eye(3))
        np.testing.assert_allclose(found[row], 1.0 / np.diag(turned), rtol=1e-9)
    assert (found[:, :2] <= inertia_about_the_lip(o, picks.grasp) * (1.0 + 1e-9)).all()


LIPS = [(0.1, 0.25), (1.0, 0.0), (3.0, 0.6)]


@pytest.mark.parametrize(("stiffness", "ratio"), with_nightly(LIPS, LIPS[1:]))
def test_steps_have_frequency_and_decay_of_the_lip_at_any_step(stiffness, ratio):
    for step in (0.002, 0.001, 0.0002):
        core = make_core(level(timestep=step, stiffness=stiffness, damping=ratio), COUNT)
        inertia, spring = core.context.lip_inertia[:, :2], springs(core.context, core.config)
        k, c = spring.stiffness[:, :2] / inertia, spring.damping[:, :2] / inertia
        ones = np.ones_like(k)
        steps = np.moveaxis(
            np.array([[ones - step**2 * k, step * (1 - step * c)], [-step * k, 1 - step * c]]), (0, 1), (2, 3)
        )
        phase = np.sqrt(stiffness / inertia) * step
        wanted = np.exp(phase * (-ratio + 1j * np.sqrt(1 - ratio**2)))
        found = np.linalg.eigvals(steps)
        resolved = phase < LARGEST_PHASE
        assert resolved.mean() > 0.15
        best = found[np.arange(COUNT)[:, None], np.arange(2), found.imag.argmax(axis=2)]
        np.testing.assert_allclose(best[resolved], wanted[resolved], rtol=1e-9)
        assert (np.abs(found) < 1.0 + 1e-12).all()


def test_the_dial_turns_compliance():
    half, full = (
        springs(
            make_core(level(mismatch=m, stiffness=0.2), 8).context,
            make_core(level(mismatch=m, stiffness=0.2), 1).config,
        )
        for m in (0.5, 1.0)
    )
    np.testing.assert_allclose(half.stiffness[:, :2] / full.stiffness[:, :2], 2.0, rtol=0.12)


def hung_in_the_engine(core, tilt, seconds):
    """Turn about y of the first object, in the engine, from a tilt on; the hand is held by its motors."""
    cell = core.cell
    model, data = cell.pose(0)
    scene, site = cell.plant.scene, cell.plant.scene.grip_site
    model.geom_contype[scene.object_geom] = model.geom_conaffinity[scene.object_geom] = 0
    columns = control_columns(model, scene.robot)
    data.ctrl[columns[0::3]] = [data.qpos[model.joint(f"arm_{arm}").qposadr[0]] for arm in range(4)]
    data.ctrl[scene.swing_controls] = 1.0
    data.eq_active[:] = 1
    first = scene.object_qpos
    tip, arm = data.site_xpos[scene.tcp_site].copy(), model.site_pos[site]
    turn = np.array([np.cos(tilt / 2), 0.0, np.sin(tilt / 2), 0.0])
    turned = np.zeros(3)
    mujoco.mju_rotVecQuat(turned, arm, turn)
    data.qpos[first : first + 3], data.qpos[first + 3 : first + 7] = tip - turned, turn
    angles = []
    for _ in range(round(seconds / model.opt.timestep)):
        angles.append(2.0 * np.arctan2(data.qpos[first + 5], data.qpos[first + 3]))
        mujoco.mj_step(model, data)
    return np.array(angles), model, data


@pytest.mark.parametrize(("stiffness", "ratio"), [(0.3, 0.05), (1.0, 0.1)])
def test_in_the_engine_a_small_swing_is_that_of_the_closed_form(stiffness, ratio):
    core = make_core({**level(stiffness=stiffness, damping=ratio), "items": ["can"]}, 1)
    with_objects(core, yaw=np.zeros(1), grasp=np.zeros((1, 2)), belt_error=np.zeros(1))
    core.cell.context = core.context.replace(belt_shift=np.zeros(1))
    o = core.context.objects
    inertia = inertia_about_the_lip(o, core.context.grasp)[0, 1]
    weight = o.mass[0] * 9.81 * o.com_depth[0]
    angles, *_ = hung_in_the_engine(core, 0.05, 0.3)
    decay = ratio * np.sqrt(stiffness / inertia)
    wave = np.sqrt((stiffness + weight) / inertia - decay**2)
    t = np.arange(len(angles)) * 0.001
    expected = 0.05 * np.exp(-decay * t) * (np.cos(wave * t) + decay / wave * np.sin(wave * t))
    np.testing.assert_allclose(angles, expected, atol=0.004)
    crossings = np.flatnonzero(np.diff(np.sign(angles)))
    assert np.diff(crossings).mean() == pytest.approx(np.pi / wave / 0.001, rel=0.02)


def test_the_lip_does_not_twist():
    """A hand that pushes sideways past the centre of mass turns no object about the upright by much."""
    core = make_core(level(stiffness=0.3), COUNT)
    quats = clock_of(core).parting.attitude
    yaw = np.arctan2(quats[:, 3], quats[:, 0]) * 2.0
    apart = (yaw - core.context.objects.yaw + np.pi) % (2.0 * np.pi) - np.pi
    assert np.abs(apart).max() < 0.02


CUPS = [{"stiffness": 1.0}, {"stiffness": 0.3}, {"stiffness": 0.3, "peel": True, "blow_off": 0.2}]


@pytest.mark.parametrize("cup", with_nightly(CUPS, CUPS[1:]))
def test_objects_leave_the_engine_as_flights_reckon(cup):
    core = make_core(level(**cup), COUNT)
    picks, cycle, plant = core.context, cycle_of(core), core.cell.plant
    clock = ThrowClock.of(picks, cycle, core.config)
    sure = ~clock.parting.unsure
    assert sure.mean() > 0.6
    flight, rows = plant.follow(picks, cycle).flight, np.arange(COUNT)
    hand = clock.path.sample(clock.free_at[:, None] - [0.0, 0.0005])
    apart = flight.position[rows, clock.release] - hand.position[:, 0] - clock.offset
    np.testing.assert_allclose(apart[sure], clock.parting.centre[sure], atol=0.0015)
    # One step later, blown off; the step before belongs to the velocity.
    velocity = flight.velocity[rows, clock.release + 1] + [0.0, 0.0, 9.81e-3] - hand.velocity[:, 1]
    swung = np.linalg.norm(clock.parting.velocity, axis=1)
    assert swung[sure].max() > 0.01
    np.testing.assert_allclose(velocity[sure], clock.parting.velocity[sure], atol=0.025)
    assert np.abs(velocity - clock.parting.velocity)[sure].mean() < 0.003


def test_a_softer_lip_spreads_landings_further():
    rigid = infos("flight", count=120)
    spread = []
    for stiffness in (3.0, 1.0, 0.3, 0.1):
        soft = infos("flight", count=120, stiffness=stiffness)
        untouched = ~(rigid["recontact"] | soft["recontact"])
        apart = np.stack([soft[name] - rigid[name] for name in ("landing_along", "landing_across")])[:, untouched]
        spread.append(np.sqrt((apart**2).sum(axis=0).mean()))
    assert (np.diff(spread) > 0.0).all()
    assert spread[0] < 0.004
    assert 0.015 < spread[-1] < 0.06


def test_releases_converge_with_the_step():
    """The release falls on the same moment at every step, so that only the swing differs."""
    found = []
    for step in (0.001, 0.0005, 0.00025, 0.000125):
        core = make_core(level(fidelity="flight", timestep=step, stiffness=0.3), COUNT)
        found.append(clock_of(core).parting.velocity)
    apart = [np.abs(one - found[-1]).mean() for one in found[:-1]]
    assert apart[0] < 0.004
    assert apart[1] < 0.7 * apart[0]
    assert apart[2] < 0.6 * apart[1]


@pytest.mark.nightly
def test_landings_in_the_full_physics_converge_with_the_step():
    """As those from a rigid cup do, which move by 1.7 mm in the mean between 1 ms and 0.125 ms."""
    count, landed = 25, []
    for step in (0.001, 0.0005, 0.00025):
        info = make_core(level(timestep=step, stiffness=0.3), count).step(np.zeros((count, 2))).info
        landed.append(np.stack([info["landing_along"], info["landing_across"]])[:, ~info["recontact"]])
    coarse, fine = (np.hypot(*(one - landed[-1])).mean() for one in landed[:-1])
    assert coarse < 0.003
    assert fine < 0.6 * coarse


@cache
def steps_until_clear(stiffness, count=200):
    """Of throws with the robot, from the release on."""
    core = make_core(level(stiffness=stiffness), count)
    clock = clock_of(core)
    return clock.clear(core.context) - clock.release


@pytest.mark.parametrize("stiffness", with_nightly((1.0, 0.3), [0.3]))
def test_a_soft_cup_is_clear_as_early_as_a_rigid_one(stiffness):
    """Its solid part begins above the lip, so that a throw needs the robot no longer; few swing back towards it."""
    soft, rigid = steps_until_clear(stiffness), steps_until_clear(None)
    assert soft.mean() < 0.5 * rigid.mean()
    assert (soft <= rigid).mean() > 0.95


@pytest.mark.nightly
def test_a_stiff_cup_is_clear_as_early_as_a_rigid_one():
    assert (steps_until_clear(100.0) <= steps_until_clear(None)).all()


@pytest.mark.parametrize("fidelity", ["full", "flight"])
def test_in_the_planners_own_world_nothing_swings(fidelity):
    soft = make_core(level(fidelity=fidelity, mismatch=0.0, stiffness=0.1, peel=True, blow_off=0.3), 8)
    rigid = make_core(level(fidelity=fidelity, mismatch=0.0), 8)
    for _ in range(2):
        one, other = (core.step(np.zeros((8, 2))) for core in (soft, rigid))
        assert same_bits(one.observation, other.observation)
        assert all(same_bits(one.info[name], other.info[name]) for name in one.info)
    assert soft.cell.plant.scene.swing == slice(0, 0)


def test_heavy_objects_meet_the_solid_part_of_a_soft_cup():
    """Their tilt ends there in the engine, and flights leave such throws to it."""
    heavy = item("block", shape="box", size=(0.1, 0.1, 0.06), mass=0.3, drag=1.0, seal_force=60.0)
    soft = {**level(base="nominal_plain", stiffness=0.1), "items": ["block"], "extra_items": [heavy]}
    core = make_core(soft, 20)
    clock = clock_of(core)
    assert clock.parting.unsure.all()
    plant = core.cell.plant
    plant.write(core.context)
    control = plant._references(np.arange(20), core.context, clock, clock.release + 1)
    held = roll_out(plant.batch, control, clock.release + 1, ("qpos",))
    first = plant.scene.object_qpos
    up = vertical(held["qpos"][:, : int(clock.release.min()), first + 3 : first + 7].copy())[..., 2]
    steepest = LIP_LENGTH / core.context.objects.cup_radius[0]
    assert np.arccos(up.min()) < steepest + 0.15
    assert np.arccos(up.min()) > 0.3
    told = [
        make_core({**soft, "fidelity": fidelity}, 20).step(np.zeros((20, 2))).info for fidelity in ("full", "flight")
    ]
    np.testing.assert_allclose(told[0]["landing_error"], told[1]["landing_error"], atol=0.004)


STIFFNESSES, DAMPINGS = (0.05, 3.0, 100.0), (0.0, 0.25, 0.95)


@pytest.mark.parametrize(
    ("stiffness", "damping"), with_nightly(product(STIFFNESSES, DAMPINGS), [*zip(STIFFNESSES, DAMPINGS, strict=True)])
)
def test_no_swing_runs_away_however_far_beside_its_middle_an_object_hangs(stiffness, damping):
    """Small objects that hang 30 mm beside their cups, where every axis turns the others."""
    hard = {**level(stiffness=stiffness, damping=damping), "items": ["cork", "jar_lid", "foil_ball"]}
    hard["spread"] = {"grasp": 0.02}
    for fidelity in ("flight", "full"):
        info = make_core({**hard, "fidelity": fidelity}, 40).step(np.zeros((40, 2))).info
        assert np.isfinite(info["landing_error"]).all()
        assert np.median(info["landing_error"]) < 0.3


def test_a_flight_whose_object_met_the_belt_as_it_swung_is_the_full_physics():
    cores = [make_core(level("waste", fidelity, stiffness=0.3), COUNT) for fidelity in ("full", "flight")]
    met = clock_of(cores[1]).parting.unsure
    met = met & ~cores[1].preview(np.zeros((COUNT, 2)), jitter=True).dropped
    assert 0 < met.sum() < COUNT
    full, flight = (core.preview(np.zeros((COUNT, 2)), jitter=True) for core in cores)
    for name in ("landing", "final", "peak_torque", "energy", "in_bin"):
        assert same_bits(getattr(full, name)[met], getattr(flight, name)[met]), name
