"""Levels and config files: the shipped ones work, and a wrong one is refused in one sentence."""

import numpy as np
import pytest
import yaml

from pnt_gym.cells.base.catalogue import CATALOGUE, HELD_OUT_ITEMS, PAPER_ITEMS, SEEN_ITEMS
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.errors import ConfigError
from tests.tools.throws import item, make_core

PLAIN = tuple(f"{name}_plain" for name in ("fast", "nominal", "tight", "unseen", "waste"))
DRIFTING = ("day", "steps", "drift_mix", "day_far", "steps_far", "drift_mix_far")
PEERS = ("boxes", "cubes")
DIFFERING = ("cells", "cells_far")
ALONE = ("dense", "fast", "ideal", "light", "newcomers", "nominal", "plant", "precise", "tight", "unseen", "waste")
LEVELS = tuple(sorted((*PLAIN, *DRIFTING, *PEERS, *DIFFERING, *ALONE)))
BIN = {"name": "box", "x": 0.3, "y": 0.4}
SMALLEST = {"bins": {"fixed": [BIN]}}


def test_the_shipped_levels_are_the_documented_ones():
    assert ConveyorConfig.level_names() == LEVELS


@pytest.mark.parametrize("name", LEVELS)
def test_nothing_is_hidden_in_the_planners_own_world_and_in_no_other_level(name):
    assert ConveyorConfig.load(name).mismatch == (0.0 if name == "ideal" else 1.0)


def test_levels_use_the_items_they_are_meant_for():
    assert ConveyorConfig.load("nominal").items == ConveyorConfig.load("ideal").items == PAPER_ITEMS
    assert set(ConveyorConfig.load("waste").items) == set(ConveyorConfig.load("tight").items) == set(SEEN_ITEMS)
    assert set(ConveyorConfig.load("unseen").items) == set(HELD_OUT_ITEMS)
    assert not set(ConveyorConfig.load("waste").items) & set(ConveyorConfig.load("unseen").items)


def test_cells_of_peers_have_their_openings_and_objects():
    cubes, boxes = (ConveyorConfig.load(name) for name in ("cubes", "boxes"))
    assert {b.size for b in cubes.bins.fixed} == {(0.21, 0.72)}
    assert {b.size for b in boxes.bins.fixed} == {(0.25, 0.15)}
    assert len(boxes.bins.fixed) == 12
    edges = [item.size for item in cubes.extra_items]
    assert all(len(set(size)) == 1 for size in edges)
    assert [size[0] for size in edges] == pytest.approx([0.040, 0.045, 0.050, 0.055, 0.060])
    assert cubes.belt.speed <= 0.02


def test_unseen_and_tight_differ_from_waste_in_one_respect_each():
    waste = ConveyorConfig.load("waste").model_dump(exclude={"name"})
    unseen = ConveyorConfig.load("unseen").model_dump(exclude={"name"})
    tight = ConveyorConfig.load("tight").model_dump(exclude={"name"})
    assert {key for key in waste if waste[key] != unseen[key]} == {"items"}
    assert {key for key in waste if waste[key] != tight[key]} == {"bins"}
    assert ConveyorConfig.load("tight").bins.random.side[1] < ConveyorConfig.load("waste").bins.random.side[0]


# What a shipped level says, and its plain twin instead.
HONEST = {
    "belt.gap": ("edge", "centre"),
    "belt.spacing": ((0.02, 0.18), (0.10, 0.30)),
    "belt.tracking": (True, False),
    "belt.neighbours": ("solid", "ghosts"),
    "grip.limit": (True, False),
    "cup.stiffness": (1.0, None),
    "cup.peel": (True, False),
    "cup.fitted": (True, False),
    "pick.fails": (True, False),
    "dispatch": ("atc", "first"),
}
EMPTIED = {"nominal": 10, "fast": 10, "waste": 4, "tight": 4, "unseen": 4}


def entries(values, path=""):
    """Every single value of a dumped level, by the way to it."""
    if not isinstance(values, dict):
        return {path: values}
    return {name: v for key, inner in values.items() for name, v in entries(inner, f"{path}.{key}".strip(".")).items()}


@pytest.mark.parametrize("plain", PLAIN)
def test_a_plain_level_switches_off_the_honest_sections_and_nothing_else(plain):
    base = plain.removesuffix("_plain")
    honest, off = (entries(ConveyorConfig.load(name).model_dump(exclude={"name"})) for name in (base, plain))
    assert honest.keys() == off.keys()
    found = {key: (honest[key], off[key]) for key in honest if honest[key] != off[key]}
    assert found == {**HONEST, "bins.emptied": (EMPTIED[base], None)}


def test_a_level_is_honest_unless_it_says_otherwise():
    smallest, light = (entries(ConveyorConfig.load(level).model_dump()) for level in (SMALLEST, "light"))
    for key, (on, _) in HONEST.items():
        assert smallest[key] == light[key] == on, key


def test_the_planners_own_world_and_the_order_alone_are_plain_too():
    ideal, dense = (entries(ConveyorConfig.load(name).model_dump()) for name in ("ideal", "dense"))
    assert all(ideal[key] == off for key, (_, off) in HONEST.items())
    assert {key for key, (_, off) in HONEST.items() if dense[key] != off} == {"belt.gap", "belt.spacing", "dispatch"}
    assert ideal["bins.emptied"] is dense["bins.emptied"] is None


WRONG = {
    "no percent": ({"limits": {"percent": []}}, r"limits.percent is \[\]: input should have at least 1 item, not 0"),
    "valve in ms": ({"suction": {"valve": 4}}, "suction.valve is 4: input should be less than or equal to 1 s"),
    "range reversed": ({"belt": {"pick_x": [0.3, -0.3]}}, "belt.pick_x runs from 0.3 to -0.3"),
    "window off the belt": ({"belt": {"pick_x": [-0.3, 0.9]}}, "belt.pick_x .* leaves the belt"),
    "lane off the belt": ({"belt": {"lane_y": [-0.45, 0.0]}}, "belt.lane_y .* leaves the belt"),
    "no gaps": ({"belt": {"spacing": [0.0, 0.3]}}, "belt.spacing starts at 0.0"),
    "unknown rule": ({"dispatch": "last"}, "dispatch is 'last': input should be 'first', 'soonest' or 'atc'"),
    "unknown item": ({"items": ["sofa"]}, "unknown item 'sofa'"),
    "item that no cup holds": ({"items": ["rubber_block"]},
     "'rubber_block' has no seal_force; a suction cup cannot hold it"),
    "no items": ({"items": []}, "items is"),
    "bin on the belt": ({"bins": {"fixed": [{**BIN, "y": -0.3}]}}, "bin 'box' .* lies on the belt"),
    "wall on the belt": ({"bins": {"fixed": [{**BIN, "y": 0.0399}]}}, "bin 'box' .* lies on the belt"),
    "random on the belt": ({"bins": {"random": {"y": [-0.2, 0.5]}}}, "bins.random .* lies on the belt"),
    "overlap": ({"bins": {"fixed": [BIN, {**BIN, "name": "b", "x": 0.45}]}}, "bin 'b' overlaps bin 'box'"),
    "same name": ({"bins": {"fixed": [BIN, {**BIN, "x": -0.3}]}}, "names .* must differ"),
    "both kinds": ({"bins": {"fixed": [BIN], "random": {}}}, "`fixed` or a section `random`"),
    "neither kind": ({"bins": {"fixed": []}}, "`fixed` or a section `random`"),
    "no bins": ({"bins": None}, "bins is None"),
    "bin for a stranger": ({"bins": {"fixed": [{**BIN, "accepts": ["sofa"]}]}}, "bin 'box': unknown item 'sofa'"),
    "item without a bin": ({"bins": {"fixed": [{**BIN, "accepts": ["paper"]}]}}, "no bin accepts items 'metal"),
    "item too heavy for its seal": ({"extra_items": [item("rock", mass=2.0)]}, "seal_force of 'rock'"),
    "misspelled planner": ({"planner": "strait"}, "'ellipse' or 'auto'; did you mean 'straight'?"),
    "unknown planner": ({"planner": "curved"}, "planner is 'curved': input should be 'straight', 'straight_flying', "
     "'free_direction', 'horizontal', 'pick_and_place', 'ellipse' or 'auto'"),
    "safety below one": ({"grip": {"safety": 0.5}}, "grip.safety is 0.5: .* equal to 1, or input should be 'surface'"),
    **{
        f"confusion: {case}": ({"classifier": {"confusion": confusion}}, message)
        for case, confusion, message in (
            ("less than all", {"paper": {"paper": 0.9}}, "of 'paper' sums to 0.9; the shares of an item must sum to 1"),
            ("more than all", {"paper": {"paper": 0.9, "metal_can": 0.2}}, "sums to 1.1; the shares"),
            ("a stranger", {"sofa": {"sofa": 1.0}}, "unknown item 'sofa'"),
            ("taken for a stranger", {"paper": {"sofa": 1.0}}, "of 'paper': unknown item 'sofa'"),
        )
    },
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_value_is_named(case):
    changes, message = WRONG[case]
    with pytest.raises(ConfigError, match=message) as caught:
        ConveyorConfig.load({**SMALLEST, **changes})
    assert isinstance(caught.value, ValueError)
    assert len(str(caught.value)) < 400
    assert caught.value.__suppress_context__  # no pydantic traceback in front of the sentence


def test_bins_are_fixed_or_random_whatever_the_base_has():
    """Where a level gives one kind, the other kind of its base goes; what both share stays."""
    fixed = ConveyorConfig.load({"base": "waste", "bins": {"fixed": [BIN]}})
    assert [b.name for b in fixed.bins.fixed] == ["box"]
    assert fixed.bins.random is None
    rim = ConveyorConfig.load({"bins": {"rim": -0.9, "random": {"side": [0.2, 0.2]}}}).bins
    assert rim.random.side == (0.2, 0.2)
    assert rim.fixed == ()
    assert rim.rim == -0.9
    wall = ConveyorConfig.load({"base": "tight", "bins": {"wall": 0.006}}).bins
    assert wall.random == ConveyorConfig.load("tight").bins.random
    assert wall.wall == 0.006
    narrow = ConveyorConfig.load({"base": "waste", "bins": {"random": {"side": [0.10, 0.11]}}}).bins.random
    assert narrow == ConveyorConfig.load("waste").bins.random.model_copy(update={"side": (0.10, 0.11)})


def test_neighbouring_bins_may_share_a_wall():
    width = 0.22 + 0.010
    config = ConveyorConfig.load({"bins": {"fixed": [BIN, {**BIN, "name": "next", "x": BIN["x"] + width}]}})
    assert len(config.bins.fixed) == 2


def test_a_users_own_cell_throws(tmp_path):
    """Own belt, bins, limits and items from one file, through to a measured throw."""
    cell = {
        "mismatch": 0.0,
        "items": ["ball", "cork"],
        "extra_items": [{**item("ball"), "size": [0.06, 0.06, 0.06]}],
        "limits": {"percent": [35]},
        "belt": {"speed": 0.3},
        "bins": {
            "fixed": [
                {"name": "left", "x": -0.3, "y": 0.4, "size": [0.3, 0.3], "accepts": ["ball"]},
                {"name": "right", "x": 0.3, "y": 0.4, "size": [0.3, 0.3], "accepts": ["cork"]},
            ]
        },
    }
    path = tmp_path / "my_cell.yaml"
    path.write_text(yaml.safe_dump(cell))
    core = make_core(str(path), 6)
    assert core.config.name == "my_cell"
    info = core.step(np.zeros((6, 2))).info
    assert set(info["item"]) == {0, 1}
    np.testing.assert_array_equal(info["bin"], info["item"])
    np.testing.assert_array_equal(np.sign(info["target_x"]), np.where(info["item"] == 0, -1.0, 1.0))
    assert info["in_opening"][info["picked"]].all()  # and what rebounds may leave its bin
    assert info["landing_error"].max() < 0.01


def test_an_own_item_may_replace_one_of_the_catalogue():
    heavy = item("cork", mass=0.5)
    config = ConveyorConfig.load({**SMALLEST, "items": ["cork"], "extra_items": [heavy]})
    assert config.item_list()[0].mass == 0.5
    assert CATALOGUE["cork"].mass < 0.01


def test_the_plant_has_the_shares_by_mass_of_its_sorting_analysis():
    """Of Kuhn et al. 2023: PET 40 %, PP 17 %, cartons 15 %, others but PE 17 %; and no kind falls through a screen."""
    config = ConveyorConfig.load("plant")
    table = item_arrays(config.item_list())
    mass = dict(zip(config.items, config.shares() * table.mass, strict=True))
    groups = {"pet": ("pet_05", "pet_crushed", "tray"), "pp": ("yoghurt_cup",), "cartons": ("tetra_1l", "tetra_200")}
    shares = {name: sum(mass[item] for item in items) for name, items in groups.items()}
    others = sum(mass.values()) - sum(shares.values())
    found = np.array([*shares.values(), others])
    np.testing.assert_allclose(found / found.sum(), np.array([40, 17, 15, 17]) / 89, rtol=0.005)
    assert (np.sort(table.size, axis=1)[:, 1] >= 0.05).all()
    assert set(ConveyorConfig.load("waste").items) - set(config.items) == {"cap", "cork", "foil_ball"}
