"""Class errors: as often as the level says, into the bin of what was seen, and visible to nobody but the judge."""

import numpy as np
import pytest

from agents.ground.metrics import wilson
from agents.judging.throw_record import purity_by_bin, summary
from agents.judging.throws import Throws
from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.errors import ConfigError
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core, parts_of, same_bits, vary, with_part

BINS = {
    "fixed": [
        {"name": "paper", "x": -0.25, "y": 0.35, "size": [0.2, 0.2], "accepts": ["paper"]},
        {"name": "metal", "x": 0.0, "y": 0.35, "size": [0.2, 0.2], "accepts": ["metal_can"]},
        {"name": "plastic", "x": 0.25, "y": 0.35, "size": [0.2, 0.2], "accepts": ["plastic_package"]},
    ]
}
CONFUSION = {"paper": {"paper": 0.7, "metal_can": 0.3}, "metal_can": {"plastic_package": 0.4, "metal_can": 0.6}}
PAPER, CAN, PACKAGE = range(3)


def confused(**changes):
    return vary("nominal_plain", bins=BINS, classifier={"confusion": CONFUSION}, **changes)


@pytest.mark.parametrize("mismatch", [0.0, 0.5, 1.0, 3.0])
def test_things_are_taken_for_others_as_often_as_the_level_says(mismatch):
    config = confused(mismatch=mismatch)
    objects = take(PickPlanner(config).draw([np.random.default_rng(0)], np.arange(1), 20_000), 0)
    wrong = {(PAPER, CAN): 0.3, (CAN, PACKAGE): 0.4}
    for true in range(3):
        seen = objects.measured.kind[objects.kind == true]
        for other in set(range(3)) - {true}:
            share = min(mismatch * wrong.get((true, other), 0.0), 1.0)
            found = wilson(int((seen == other).sum()), len(seen))
            assert found.low - 0.005 <= share <= found.high + 0.005
            assert (found.value == 0.0) == (share == 0.0)


def test_confusion_of_several_kinds_is_brought_below_one():
    shares = ConveyorConfig.load(confused(mismatch=3.0).model_copy()).confusion()
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, rtol=1e-12)
    assert (shares >= 0.0).all()
    np.testing.assert_allclose(confused().confusion(), [[0.7, 0.3, 0.0], [0.0, 0.6, 0.4], [0.0, 0.0, 1.0]])


def test_all_but_the_class_stays_as_it_is():
    """The objects, and where all goes into one bin observations and throws as well, to the last bit."""
    one = {"fixed": [{"name": "all", "x": 0.2, "y": 0.4}]}
    plain, wrong = (
        make_core(vary("nominal_plain", bins=one, **more), 60, seed=3)
        for more in ({}, {"classifier": {"confusion": CONFUSION}})
    )
    different = wrong.context.objects.measured.kind != plain.context.objects.kind
    assert different.any()
    for name, values in parts_of(plain.context.objects).items():
        changes = name in ("measured.kind", "measured.friction")
        assert changes or same_bits(values, parts_of(wrong.context.objects)[name]), name
    assert same_bits(plain.observe(), wrong.observe())
    infos = [core.step(np.zeros((60, 2))).info for core in (plain, wrong)]
    for name in set(infos[0]) - {"item", "kind"}:
        assert same_bits(infos[0][name], infos[1][name]), name
    assert same_bits(infos[1]["item"] != infos[1]["true_kind"], different)
    assert same_bits(infos[0]["item"], infos[1]["true_kind"])


@pytest.fixture(scope="module", params=with_nightly(("full", "flight"), ["flight"]))
def told(request):
    core = make_core(confused(fidelity=request.param), 150, seed=5)
    seen = core.context.kind.copy()
    return core, seen, core.step(np.zeros((150, 2)))


def test_the_bin_is_that_of_what_is_seen(told):
    _, seen, step = told
    info = step.info
    assert same_bits(info["item"], seen)
    assert same_bits(info["bin"], seen)  # bins stand in the order of the items
    success = info["is_success"]
    assert same_bits(info["ended_in"][success], info["bin"][success])
    right = info["true_kind"] == info["item"]
    assert (success & ~right).any()
    assert same_bits(info["sorted"], success & right)
    inside = info["ended_in"] >= 0
    assert same_bits(info["belongs"], inside & (info["true_kind"] == info["ended_in"]))


def test_purity_by_counting_objects_one_by_one(told):
    core, _, step = told
    throws = Throws.of(step.info, step.reward, ())
    held: dict[str, list[bool]] = {b.name: [] for b in core.config.bins.fixed}
    for fixed, name in zip(core.config.bins.fixed, held, strict=True):
        for row in range(150):
            if step.info["ended_in"][row] == list(held).index(name):
                held[name].append(core.config.items[step.info["true_kind"][row]] in fixed.accepts)
    everything = [own for found in held.values() for own in found]
    assert summary(throws)["purity"] == pytest.approx(np.mean(everything))
    assert purity_by_bin(throws, core.cell.target_names) == pytest.approx({n: np.mean(v) for n, v in held.items()})
    assert 0.5 < summary(throws)["purity"] < 0.95
    assert summary(throws)["sorted_per_min"] < 60.0 * 150 * throws.is_success.mean() / throws.cycle_time.sum()


def test_a_bin_that_is_drawn_for_a_throw_is_for_what_was_seen():
    core = make_core(vary("waste_plain", classifier={"confusion": {"can": {"steel_tin": 1.0}}}), 60, seed=1)
    info = core.step(np.zeros((60, 2))).info
    wrong = info["true_kind"] != info["item"]
    assert wrong.any()
    assert same_bits(info["sorted"], info["is_success"] & ~wrong)
    assert same_bits(info["belongs"], info["in_bin"] & ~wrong)


NEIGHBOURS = {"fixed": [{"name": "near", "x": 0.0, "y": 0.30}, {"name": "far", "x": 0.0, "y": 0.53}]}


def strays(fidelity):
    """How many objects lie in the bin that they were not thrown for, when all are thrown too far."""
    core = make_core(vary("nominal_plain", items=["metal_can"], bins=NEIGHBOURS, fidelity=fidelity), 40)
    target, flown, fly = core.context.bin, [], core.cell.plant.fly
    core.cell.plant.fly = lambda *picks: flown.append(fly(*picks)) or flown[0]
    info = core.step(np.tile([1.0, 0.0], (40, 1))).info
    (x, y, z), rise = flown[0].touchdown.position.T, flown[0].touchdown.velocity[:, 2] ** 2 / 19.62
    found = np.stack(
        [(np.abs(x) <= 0.11) & (np.abs(y - fixed.y) <= 0.11) & (z + rise < -0.85) for fixed in core.config.bins.fixed]
    )
    assert (found.sum(axis=0) <= 1).all()
    assert same_bits(info["ended_in"], np.where(found.any(axis=0), found.argmax(axis=0), -1))
    stray = (info["ended_in"] >= 0) & (info["ended_in"] != target)
    assert not (info["is_success"] & stray).any()
    return int(stray.sum())


def test_an_object_in_a_strangers_bin_is_found_there():
    """By its last position and speed, in both fidelities, and never in two places."""
    full, flight = strays("full"), strays("flight")
    assert full > 3
    assert abs(full - flight) <= 2


def test_a_sum_may_be_off_by_what_rounding_leaves():
    assert vary("nominal_plain", classifier={"confusion": {"paper": {"paper": 0.7, "metal_can": 0.3 + 5e-7}}})
    with pytest.raises(ConfigError, match="must sum to 1"):
        vary("nominal_plain", classifier={"confusion": {"paper": {"paper": 0.7, "metal_can": 0.3 + 2e-6}}})


def test_what_is_careful_goes_by_what_is_seen():
    """A wet thing that is taken for a dry one is thrown as fast as a dry one."""
    own = {"shape": "box", "size": [0.1, 0.08, 0.05], "drag": 1.0, "seal_force": 9.0, "friction": 0.4, "mass": 0.06,
           "rolling_friction": 0.001, "restitution": 0.2, "source": "a test object"}  # fmt: skip
    items = [{**own, "name": "dry"}, {**own, "name": "wet_one", "surface": "wet"}]
    level = {
        "items": ["dry", "wet_one"],
        "bins": {"fixed": [{"name": "all", "x": 0.2, "y": 0.4}]},
        "extra_items": items,
        "grip": {"safety": 1.5},
    }
    right = make_core(vary("nominal_plain", **level), 30, seed=1).context
    wrong = make_core(
        vary("nominal_plain", **level, classifier={"confusion": {"wet_one": {"dry": 1.0}}}), 30, seed=1
    ).context
    wet = right.objects.kind == 1
    assert (wrong.objects.measured.friction == 0.5).all()
    same = with_part(right.objects, "measured.kind", wrong.objects.measured.kind)
    assert same_bits(same.cup_friction[wet], np.full(wet.sum(), 0.25))
    assert wrong.throw_limits.acceleration[wrong.objects.kind == 1].mean() > right.throw_limits.acceleration[wet].mean()
