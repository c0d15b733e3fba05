"""Contacts, blown air and residues that differ from throw to throw: their draws, and where the drawn values count."""

import numpy as np
import pytest

from pnt_gym.cells.base.bodies import contact_solref
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor import free
from pnt_gym.cells.conveyor.hand import ThrowClock
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.errors import ConfigError
from tests.tools.throws import item, make_core, parts_of, same_bits, vary, whole_cycle

COUNT = 4000
STEADY = {"restitution": 0.0, "friction": 0.0, "blow_off": 0.0}
LOOSE = {"restitution": 0.35, "friction": 0.3, "blow_off": 0.2}
DRAWN = tuple(LOOSE)


def drawn(spread, rows=1):
    """The table of items, and objects of `waste` whose cups blow."""
    config = vary("waste", spread=spread, cup={"blow_off": 0.2, "peel": False})
    generators = [np.random.default_rng(seed) for seed in range(rows)]
    return item_arrays(config.item_list()), PickPlanner(config).draw(generators, np.arange(rows), COUNT // rows)


def test_the_mean_residue_is_the_items():
    config = vary("waste", spread={"mass": 0.0})
    table, many = (
        item_arrays(config.item_list()),
        PickPlanner(config).draw([np.random.default_rng(0)], np.zeros(1, int), 40000),
    )
    kind, residue = many.kind[0], many.mass[0] / table.mass[many.kind[0]] - 1.0
    means = np.array([residue[kind == k].mean() for k in range(len(table.mass))])
    np.testing.assert_allclose(means, table.residue, rtol=0.06, atol=1e-12)
    logs = np.log(residue[table.residue[kind] > 0.0])
    spread = logs - np.log(table.residue[kind][table.residue[kind] > 0.0])
    assert spread.std() == pytest.approx(0.7, rel=0.02)
    assert {name for name, mean in zip(table.names, table.residue, strict=True) if mean > 0.0} >= {"can", "tetra_1l"}


def test_without_a_spread_all_objects_of_an_item_are_alike():
    table, o = drawn(STEADY)
    assert same_bits(o.restitution, table.restitution[o.kind])
    assert same_bits(o.friction, table.friction[o.kind])
    assert (o.blow_off == 0.2).all()


def test_factors_are_lognormal_about_the_catalogue_and_independent():
    table, o = drawn(LOOSE)
    middle = {"restitution": table.restitution[o.kind], "friction": table.friction[o.kind], "blow_off": 0.2}
    logs = np.stack([np.log(getattr(o, name) / middle[name])[0] for name in DRAWN])
    assert (o.restitution <= 1.0).all()
    np.testing.assert_allclose(np.median(logs, axis=1), 0.0, atol=0.02)
    np.testing.assert_allclose(logs.std(axis=1), [LOOSE[name] for name in DRAWN], rtol=0.05)
    assert np.abs(np.corrcoef(logs) - np.eye(3)).max() < 0.06


def test_in_the_planners_own_world_contacts_are_the_catalogues():
    config = vary("waste", mismatch=0.0)
    table, o = (
        item_arrays(config.item_list()),
        PickPlanner(config).draw([np.random.default_rng(0)], np.zeros(1, int), 50),
    )
    assert same_bits(o.restitution, table.restitution[o.kind])
    assert same_bits(o.friction, table.friction[o.kind])


def test_a_restitution_is_at_most_one():
    _, o = drawn({"restitution": 1.0})
    assert (o.restitution == 1.0).mean() > 0.05
    assert (o.restitution <= 1.0).all()


def test_what_is_drawn_beside_contacts_stays():
    (_, before), (_, after) = drawn(STEADY, 3), drawn(LOOSE, 3)
    before, after = parts_of(before), parts_of(after)
    changed = {name for name, values in before.items() if not same_bits(values, after[name])}
    assert changed == {*DRAWN, "spin"}  # air that blows beside the centre of mass turns an object


def test_the_drawn_restitution_is_that_of_the_engine_and_of_the_bound(monkeypatch):
    core = make_core(
        {"base": "waste", "fidelity": "flight", "spread": {**STEADY, "restitution": 0.6}, "pick": {"fails": False}}, 60
    )
    judged, ends, settle = list[np.ndarray](), free.settle, free.FreeObjects.settle

    def judge(objects, rows, context, *rest):
        judged.append(context.objects.restitution)
        return settle(objects, rows, context, *rest)

    def watch(batch, motion, rows, objects, *rest):
        judged.append(objects[1].solid["rebound"].copy())
        return ends(batch, motion, rows, objects, *rest)

    monkeypatch.setattr(free.FreeObjects, "settle", judge)
    monkeypatch.setattr(free, "settle", watch)
    own = {tuple(solref) for solref in contact_solref(core.context.objects.restitution)}
    core.step(np.zeros((60, 2)))
    e, rebound = judged
    assert (len(e) > 30) & (np.ptp(e) > 0.4)
    # In steps of 1 ms the strongest rebound is up to a quarter greater than the restitution; 0.135 is the least.
    assert (rebound > np.maximum(e, 0.135) - 0.01).all()
    assert (rebound < 1.25 * np.maximum(e, 0.135)).all()
    scene = core.cell.plant.free._scene
    simulated = core.cell.plant.free.batch.expand("geom_solref")[:, scene.object_geom]
    written = {tuple(solref) for solref in simulated} - {tuple(scene.model.geom_solref[scene.object_geom])}
    assert len(written) > 15
    assert written <= own


def test_blown_air_pushes_as_drawn():
    core = make_core(
        {"base": "waste", "cup": {"blow_off": 0.2, "stiffness": None}, "spread": LOOSE, "mismatch": 0.5}, 30
    )
    clock, o = ThrowClock.of(core.context, whole_cycle(core)[1], core.config), core.context.objects
    thrown = ~clock.grips.unthrown
    assert np.ptp(o.blow_off[thrown]) > 0.05
    np.testing.assert_allclose(clock.parting.velocity[thrown, 2], -0.5 * o.blow_off[thrown])


@pytest.mark.parametrize("name", [*DRAWN, "residue"])
@pytest.mark.parametrize("value", [-0.1, 1.5, float("nan")])
def test_impossible_spreads_are_refused(name, value):
    with pytest.raises(ConfigError, match=name):
        vary("waste", spread={name: value})


@pytest.mark.parametrize(
    ("level", "words"),
    [
        (
            {"spread": {"residue_chance": 0.4}},
            "'spread.residue_chance' is of an earlier version; each item has a mean `residue`",
        ),
        ({"spread": {"residue": 1.5}}, "spread.residue is 1.5: input should be less than or equal to 1"),
        (
            {"items": ["mine"], "extra_items": [item("mine", container=True)]},
            "'extra_items.0.container' is of an earlier version; give the mean `residue`",
        ),
    ],
    ids=["chance", "largest", "container"],
)
def test_keys_of_earlier_versions_are_refused_with_what_replaces_them(level, words):
    with pytest.raises(ConfigError) as error:
        vary("waste", **level)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
