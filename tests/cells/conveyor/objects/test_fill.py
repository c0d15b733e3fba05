"""Bins that fill: objects lie on what is there, and what ends in a bin makes it shallower until it is emptied."""

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym  # noqa: F401 - registers the environments
from pnt_gym.cells.base.items import BOX, item_arrays
from pnt_gym.cells.conveyor.objects.fill import LEAST_DEPTH, Fill, bins_of_cells, draw_fill, mean_volumes, volume_of
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core, parts_of, same_bits, vary

PAIR = {
    "fixed": [
        {"name": "a", "x": -0.15, "y": 0.35, "size": [0.2, 0.2]},
        {"name": "b", "x": 0.15, "y": 0.35, "size": [0.25, 0.2]},
    ]
}


def filling(emptied=30, level="nominal_plain", **bins):
    kept = PAIR if level == "nominal_plain" else {}
    return vary(level, bins={**kept, "emptied": emptied, **bins}, picks_per_shift=1000)


@pytest.mark.parametrize("level", ["nominal_plain", "waste_plain"])
def test_an_object_comes_to_rest_on_what_lies_in_its_bin(level):
    """Dropped into the middle of bins of any depth, without the robot: nothing sinks through."""
    depths = np.linspace(0.02, 0.30, 15)
    config = filling(level=level)
    core = make_core(config, 15, seed=1)
    context = core.context
    if config.bins.fixed:
        context = context.replace(depth=np.stack([depths, depths[::-1]], axis=1))
    else:
        context = context.replace(depth=depths[:, None])
    depth, free = context.bin_depth, core.cell.plant.free
    qpos = np.tile([0.0, 0.0, -0.80, 1.0, 0.0, 0.0, 0.0], (15, 1))
    qpos[:, :2] = context.target[:, :2]
    free.fall(np.arange(15), context, qpos, np.zeros((15, 6)), np.full(15, 1))
    free.batch.bind("qpos")[:], free.batch.bind("qvel")[:] = qpos, 0.0
    seen = free.batch.rollout(900, record=("sensordata",))["sensordata"]
    above = seen[:, -1, 2] - (config.bins.rim - depth)
    half = context.objects.size.min(axis=1) / 2.0
    deep = depth > 0.05
    assert (above[deep] > 0.5 * half[deep]).all()
    assert (above[deep] < context.objects.size.max(axis=1)[deep]).all()
    assert (np.abs(seen[deep, -1, 3:6]) < 0.05).all()


def test_volumes_are_those_of_the_bodies():
    size = np.array([[0.2, 0.1, 0.1], [0.2, 0.1, 0.1], [0.2, 0.1, 0.05]])
    found = volume_of(np.array([0, 1, 2]), size)
    np.testing.assert_allclose(found, [4 / 3 * np.pi * 0.1 * 0.05**2, np.pi * 0.05**2 * 0.2, 0.001], rtol=1e-12)


def test_three_litres_in_a_bin_by_hand():
    """0.2 m x 0.2 m, half of a filling is air: 1 l more is 50 mm less, until it is emptied."""
    config = filling(emptied=3)
    bins, objects = bins_of_cells(config, 1, carried=True), make_core(config, 1, seed=1).context.objects
    litre = objects.replace(shape=np.array([BOX]), size=np.full((1, 3), 0.1))
    depth = bins.begin(np.arange(1), np.zeros((1, 2)))
    expected = [[0.25, 0.30], [0.20, 0.30], [0.20, 0.26], [0.30, 0.26], [0.30, 0.26]]
    for where, left in zip([0, 0, 1, 0, -1], expected, strict=True):
        depth = bins.after(litre, np.array([where]), depth)
        np.testing.assert_allclose(depth, [left], rtol=1e-12)


def test_an_overfull_bin_keeps_a_least_depth():
    config = filling()
    heap = Fill(np.array([[20, 0]]), np.array([[0.05, 0.0]]))
    np.testing.assert_allclose(heap.depth(np.array([0.04, 0.05]), config), [[LEAST_DEPTH, 0.30]])
    low = filling(depth=0.01)
    np.testing.assert_allclose(heap.depth(np.array([0.04, 0.05]), low), [[0.01, 0.01]])


def test_bins_that_are_held_back_forget_what_ended_in_them():
    config = filling()
    bins, objects = bins_of_cells(config, 2, carried=True), make_core(config, 2, seed=1).context.objects
    empty = bins.begin(np.arange(2), np.zeros((2, 2)))
    with bins.hold_back(np.array([True, False])):
        filled = bins.after(objects, np.array([0, 0]), empty)
    kept = bins.after(objects, np.array([-1, -1]), filled)
    assert (filled[:, 0] < empty[:, 0]).all()
    np.testing.assert_array_equal(kept, [empty[0], filled[1]])


@pytest.mark.parametrize("fidelity", ["full", "flight"])
def test_what_a_shift_brings_is_what_its_bins_hold(fidelity):
    """Every bin's depth from the list of all that ended there since it was emptied, throw by throw."""
    core = make_core(vary("nominal_plain", bins={**PAIR, "emptied": 7}, fidelity=fidelity), 6, picks="belt", seed=3)
    config = core.config
    inside: dict[tuple[int, int], list[float]] = {(row, b): [] for row in range(6) for b in range(2)}
    areas = [fixed.size[0] * fixed.size[1] for fixed in config.bins.fixed]
    emptied = 0
    for _ in range(16):
        thrown = core.context
        info = core.step(np.zeros((6, 2))).info
        for row in range(6):
            volume = sum(inside[row, int(info["bin"][row])])
            depth = max(0.30 - volume / (config.bins.packing * areas[info["bin"][row]]), LEAST_DEPTH)
            assert info["bin_depth"][row] == pytest.approx(depth, abs=1e-12)
            if info["ended_in"][row] >= 0:
                objects = inside[row, int(info["ended_in"][row])]
                o = thrown.objects
                objects.append(float(volume_of(o.shape[row], o.size[row])))
                if len(objects) == 7:
                    objects.clear()
                    emptied += 1
    assert emptied > 3


def test_a_new_shift_begins_with_empty_bins():
    env = gym.make_vec(
        "PnTConveyor-v0", num_envs=3, level=vary("nominal_plain", bins={**PAIR, "emptied": 50}, picks_per_shift=4)
    )
    env.reset(seed=0)
    depths = [env.step(np.zeros((3, 2)))[4]["bin_depth"] for _ in range(8)]
    assert (depths[3] < 0.30).all()
    assert (depths[4] == 0.30).all()
    assert (depths[0] == 0.30).all()


def test_a_drawn_fill_is_any_between_two_emptyings():
    config = filling(emptied=4)
    table = item_arrays(config.item_list())
    fill = draw_fill(np.array([[0.0, 0.26], [0.74, 0.99]]), 4, mean_volumes(config, table))
    assert fill.count.tolist() == [[0, 1], [2, 3]]
    mean = volume_of(table.shape, table.size).mean()
    np.testing.assert_allclose(fill.volume, fill.count * mean)
    own = vary(
        "nominal_plain", bins={"fixed": [{**PAIR["fixed"][0], "accepts": ["paper"]}, PAIR["fixed"][1]], "emptied": 4}
    )
    np.testing.assert_allclose(mean_volumes(own, table)[0], volume_of(table.shape, table.size)[0])


@pytest.mark.parametrize("level", with_nightly(("nominal_plain", "waste_plain"), ["waste_plain"]))
def test_drawn_fills_leave_all_else_as_it_is(level):
    """The objects to the last bit; throws that clear the bottom fly the same."""
    plain = make_core(vary(level, bins=PAIR if level == "nominal_plain" else {}), 40, seed=6)
    full = make_core(filling(12, level), 40, seed=6)
    for name, values in parts_of(plain.context.objects).items():
        assert name == "fill" or same_bits(values, parts_of(full.context.objects)[name])
    assert same_bits(plain.observe(), full.observe())
    depth = full.context.bin_depth
    assert len(np.unique(depth)) > 5
    infos = [core.step(np.zeros((40, 2))).info for core in (plain, full)]
    assert (infos[0]["bin_depth"] == 0.30).all()
    assert same_bits(infos[1]["bin_depth"], depth)
    assert same_bits(infos[0]["cycle_time"], infos[1]["cycle_time"])
    np.testing.assert_allclose(infos[0]["landing_error"], infos[1]["landing_error"], atol=1e-3)


def test_shallow_bins_hold_less():
    """As the facts of the flat fill say: deep ones all the same, few objects stay in one of 2 cm."""
    config = filling(1000)
    core = make_core(config, 60, seed=2)
    kept = {}
    for depth in (0.30, 0.15, 0.02):
        core.cell.context = core.context.replace(depth=np.full((60, 2), depth))
        kept[depth] = core.preview(np.zeros((60, 2))).in_bin.mean()
    assert abs(kept[0.30] - kept[0.15]) < 0.06
    assert kept[0.02] < kept[0.15] - 0.2


def test_asking_for_a_first_throw_leaves_the_bins_of_others_alone():
    env = gym.make_vec("PnTConveyor-v0", num_envs=2, level=filling(60))
    env.reset(seed=1)
    for _ in range(3):
        env.step(np.zeros((2, 2)))
    env.reset(options={"reset_mask": np.array([True, False]), "item": "paper"})
    depth = env.step(np.zeros((2, 2)))[4]["bin_depth"]
    assert depth[0] == 0.30
    assert depth[1] < 0.30
