import mujoco
import numpy as np
import pytest
from pydantic import ValidationError

from pnt_gym.cells.base.bodies import contact_solref
from pnt_gym.cells.base.catalogue import CATALOGUE, CLAW_ITEMS, HELD_OUT_ITEMS, LIGHT_ITEMS, PAPER_ITEMS, SEEN_ITEMS
from pnt_gym.cells.base.items import SHAPES, Item, item_arrays, shape_index
from tests.tools import throws

# name, shape, L W H in mm as it lies, mass in g, Cd, centre of mass, F0 in N, residue over mass.
SEEN_TABLE = """
paper_ball  ellipsoid  80 80 75   5.0  .55 .50  4   0
can         cylinder  115 66 66  13.5  .67 .50 18   0.10
can_crushed box        95 75 35  13.5 1.00 .50 10   0
pet_05      cylinder  205 65 65  22    .72 .52 16   0.07
pet_crushed box       190 85 45  30   1.00 .55 12   0.07
yoghurt_cup cylinder   80 70 70   6.0  .67 .50 14   0.25
tetra_1l    box       195 70 70  29   1.05 .52 14   0.23
tetra_200   box       115 60 40   9.5 1.05 .52 12   0.23
carton      box       125 85 30  24   1.10 .50  7   0
jar_lid     box        70 70 12  11   1.10 .40 18   0
cap         cylinder   52 45 40   9    .67 .45 14   0
cork        cylinder   45 24 24   4    .67 .50  3.5 0
foil_ball   ellipsoid  48 45 42   6    .50 .50  4.5 0
tray        box       140 105 35 17   1.15 .40 14   0
steel_tin   cylinder  108 73 73  52    .67 .50 20   0.10
"""
HELD_OUT_TABLE = """
detergent   box       215 90 60  55   1.00 .58 16   0.10
coffee_cup  cylinder   95 78 78   9.5  .67 .50  9   0.25
egg_box     box       150 100 60 22   1.10 .50  5   0
shampoo     box       185 65 42  31   1.00 .56 16   0.10
foil_tray   box       120 95 35  11   1.15 .45 10   0
napkin_ball ellipsoid  65 62 58   3.5  .60 .50  3   0
"""
VALID = throws.item("brick", shape="box", size=(0.2, 0.1, 0.05), mass=0.1)


@pytest.mark.parametrize(("table", "names"), [(SEEN_TABLE, SEEN_ITEMS), (HELD_OUT_TABLE, HELD_OUT_ITEMS)])
def test_catalogue_is_the_table(table, names):
    rows = [line.split() for line in table.strip().splitlines()]
    assert tuple(row[0] for row in rows) == names
    for name, shape, length, width, height, mass, drag, com, seal, residue in rows:
        item = CATALOGUE[name]
        extents = np.array([float(length), float(width), float(height)]) / 1e3
        if shape == "cylinder":
            extents[1:] = extents[1:].mean()
        assert item.shape == shape
        np.testing.assert_allclose(item.size, extents, rtol=1e-12)
        np.testing.assert_allclose(item.mass, float(mass) / 1e3, rtol=1e-12)
        assert (item.drag, item.com_depth, item.seal_force) == (float(drag), float(com), float(seal))
        assert item.residue == float(residue)


def test_the_papers_objects_have_the_published_masses():
    assert {name: CATALOGUE[name].mass for name in PAPER_ITEMS} == {
        "paper": 0.007,
        "metal_can": 0.016,
        "plastic_package": 0.049,
    }


def test_sets_are_disjoint_and_fill_the_catalogue():
    names = [*PAPER_ITEMS, *SEEN_ITEMS, *HELD_OUT_ITEMS, *LIGHT_ITEMS]
    assert len(names) == len(set(names)) == 27
    assert set(CATALOGUE) == {*names, *CLAW_ITEMS}
    assert set(names) & set(CLAW_ITEMS) == {"cork"}  # both robots' cork is the same one
    assert all(item.name == name for name, item in CATALOGUE.items())


def test_air_carries_away_what_is_light_and_nothing_else():
    for item in (i for i in CATALOGUE.values() if i.name not in CLAW_ITEMS):
        drag_area = item.drag * item.size[0] * item.size[1] / item.mass
        assert (drag_area > 4.0) == (item.name in LIGHT_ITEMS)
        assert drag_area < (12.0 if item.name in LIGHT_ITEMS else 1.3)


def test_every_item_says_where_it_comes_from_and_is_light_enough_to_be_real():
    for item in CATALOGUE.values():
        assert "assumed" in item.source
        assert "\n" not in item.source
        density = item.mass / np.prod(item.size)
        # Crumpled, hollow or porous: far below water, above expanded foam. Only the paper's block is of solid rubber.
        low, high = (1000.0, 1500.0) if item.name == "rubber_block" else (10.0, 250.0)
        assert low < density < high


def test_the_claws_objects_are_the_papers():
    cork, cap, block = (CATALOGUE[name] for name in CLAW_ITEMS)
    assert (cork.size, cork.shape, cork.mass, cork.drag) == ((0.045, 0.024, 0.024), "cylinder", 0.004, 0.67)
    assert (cap.shape, cap.upright, block.shape) == ("cylinder", True, "box")
    assert cap.height == cap.size[0] < cap.size[1]
    assert cork.height == cork.size[2]


def test_no_cup_holds_what_has_no_seal_force():
    assert [name for name, item in CATALOGUE.items() if item.seal_force is None] == ["bottle_cap", "rubber_block"]
    table = item_arrays([CATALOGUE["rubber_block"], CATALOGUE["cork"]])
    np.testing.assert_array_equal(np.isnan(table.seal_force), [True, False])
    assert Item(**(VALID | {"seal_force": None})).seal_force is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"colour": "red"}, "colour"),
        ({"mass": 0.0}, "mass"),
        ({"mass": float("nan")}, "mass"),
        ({"size": (0.2, -0.1, 0.05)}, "size"),
        ({"size": (0.2, 0.1)}, "size"),
        ({"shape": "sphere"}, "shape"),
        ({"restitution": 1.2}, "restitution"),
        ({"com_depth": 1.0}, "com_depth"),
        ({"source": " "}, "source"),
        ({"source": "two\nlines"}, "source"),
        ({"seal_force": 0.9}, r"0\.9 N, but must exceed its weight of 0\.981 N"),
        ({"shape": "cylinder"}, "needs one diameter, but W = 0.1 m and H = 0.05 m"),
    ],
)
def test_a_wrong_item_is_refused_by_name(change, message):
    Item(**VALID)
    with pytest.raises(ValidationError, match=message):
        Item(**(VALID | change))


def test_arrays_hold_the_items_row_by_row():
    items = [CATALOGUE[name] for name in ("cork", "tray", "cork", "napkin_ball")]
    table = item_arrays(items)
    assert table.names == ("cork", "tray", "cork", "napkin_ball")
    for k, item in enumerate(items):
        assert SHAPES[table.shape[k]] == item.shape
        assert tuple(table.size[k]) == item.size
        for column in ("mass", "drag", "com_depth", "seal_force", "residue"):
            assert getattr(table, column)[k] == getattr(item, column)
        for column in ("friction", "rolling_friction"):
            assert getattr(table, column)[k] == getattr(item, column)
    with pytest.raises(ValueError, match="read-only"):
        table.mass[0] = 1.0
    with pytest.raises(ValueError, match="at least 1"):
        item_arrays([])


def test_shape_index_knows_its_shapes_only():
    assert [shape_index(shape) for shape in SHAPES] == [0, 1, 2]
    with pytest.raises(ValueError, match="unknown shape 'sphere'; known are ellipsoid, cylinder, box"):
        shape_index("sphere")


def dropped(solref, timestep, geom, size):
    """Rebound speed over impact speed, and the greatest depth, of a fall from 0.3 m on a plane."""
    spec = mujoco.MjSpec()
    spec.option.timestep = timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(1, 1, 0.1))
    half = size[0] if geom == mujoco.mjtGeom.mjGEOM_SPHERE else size[2]
    body = spec.worldbody.add_body(pos=(0, 0, 0.3 + half))
    body.add_freejoint()
    body.add_geom(type=geom, size=size, mass=0.02, solref=solref, priority=1)
    model = spec.compile()
    data = mujoco.MjData(model)
    speeds, depths = [], []
    for _ in range(int(0.35 / timestep)):  # the fall takes 0.247 s, the contact at most 15 ms
        mujoco.mj_step(model, data)
        speeds.append(data.qvel[2])
        depths.append(half - data.qpos[2])
    return max(speeds) / -min(speeds), max(depths)


@pytest.mark.parametrize("timestep", [0.0004, 0.001])
@pytest.mark.parametrize(
    ("geom", "size"),
    [(mujoco.mjtGeom.mjGEOM_SPHERE, (0.03, 0, 0)), (mujoco.mjtGeom.mjGEOM_BOX, (0.05, 0.04, 0.02))],
    ids=["sphere", "box"],
)
def test_a_dropped_body_rebounds_with_its_restitution(timestep, geom, size):
    wanted = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9])
    got = np.array([dropped(solref, timestep, geom, size) for solref in contact_solref(wanted)])
    np.testing.assert_allclose(got[:, 0], wanted, atol=0.1)
    assert np.all(np.diff(got[1:, 0]) > 0.0)
    assert got[:, 1].max() < 0.004
    dead, _ = dropped(contact_solref(0.0), timestep, geom, size)
    assert dead < np.exp(-2.0)


def test_solref_of_a_dead_contact_and_continuity_above_it():
    np.testing.assert_array_equal(contact_solref([0.0, 0.1, 0.135]), [[0.003, 1.0]] * 3)
    e = np.linspace(0.0, 1.0, 2001)
    solref = contact_solref(e)
    assert solref.shape == (2001, 2)
    assert np.all(solref[:, 0] >= 0.0029)
    assert np.all(np.diff(solref[:, 1]) <= 0.0)
    assert np.abs(np.diff(solref[e < 0.9], axis=0)[:, 0]).max() < 5e-4
    np.testing.assert_array_equal(contact_solref(e[700]), solref[700])


def test_damping_ratio_solves_the_oscillator():
    """Follow the free spring-damper until its force vanishes: it leaves with e times the impact speed."""
    for e in (0.2, 0.35, 0.5, 0.8):
        time_constant, damping = contact_solref(e)
        omega = 1.0 / (time_constant * damping)
        t = np.linspace(0.0, np.pi / omega / np.sqrt(1.0 - damping**2), 400_001)
        root = -damping * omega + 1j * omega * np.sqrt(1.0 - damping**2)
        speed = (np.exp(root * t) * root).imag / root.imag
        acceleration = (np.exp(root * t) * root * root).imag / root.imag
        leaves = int(np.argmax(acceleration > 0.0))
        assert -speed[leaves] == pytest.approx(e, abs=1e-4)


@pytest.mark.parametrize("bad", [-0.1, 1.01, float("nan")])
def test_solref_refuses_impossible_restitution(bad):
    with pytest.raises(ValueError, match="must be from 0 to 1"):
        contact_solref([0.3, bad])
