"""Objects that are not thrown: what the sensors say of them decides, and nothing else."""

import numpy as np
import pytest

from pnt_gym.cells.base.catalogue import CATALOGUE, LIGHT_ITEMS
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.cup.hold import measured_hold, smallest_margin
from pnt_gym.errors import ConfigError
from tests.tools.nightly import with_nightly
from tests.tools.throws import untried

COUNT = 60
MIXED = {
    "base": "nominal_plain",
    "items": ["metal_can", "plastic_package", *LIGHT_ITEMS],
    "bins": {"fixed": [{"name": "inside", "x": 0.30, "y": 0.40, "size": [0.34, 0.34]}]},
}


def core_of(level, picks="independent", **rule):
    config = ConveyorConfig.load({**level, "throwable": rule} if rule else level)
    core = untried(ConveyorCell(config, COUNT, picks, 2))
    core.reset(np.arange(COUNT), [np.random.default_rng([5, row]) for row in range(COUNT)], seeded=True)
    return core


def names(core):
    return {core.item_names[kind] for kind in core.context.kind}


def test_without_a_rule_everything_is_thrown():
    assert names(core_of(MIXED)) == set(MIXED["items"])


@pytest.mark.parametrize("picks", with_nightly(["independent", "belt"], ["belt"]))
def test_what_air_carries_away_rides_on(picks):
    core = core_of(MIXED, picks, drag_area=2.0)
    for _ in range(3):
        assert names(core) == {"metal_can", "plastic_package"}
        core.step(np.zeros((COUNT, 2)))


def test_the_bound_is_of_measured_outline_and_mass():
    core = core_of(MIXED, drag_area=5.0)
    context = core.context
    seen = context.objects.measured
    drag = np.array([CATALOGUE[core.item_names[kind]].drag for kind in context.kind])
    ratio = drag * seen.size[:, 0] * seen.size[:, 1] / seen.mass
    assert ratio.max() <= 5.0
    assert names(core) & set(LIGHT_ITEMS)  # near the bound, some are taken and some are not


def test_a_bound_on_the_foreseen_shift_keeps_the_misses_small():
    bold, careful = core_of(MIXED), core_of(MIXED, drag_shift=0.05)
    wide, near = (core.step(np.zeros((COUNT, 2))).info["landing_error"] for core in (bold, careful))
    assert np.nanmax(wide) > 0.2
    assert np.nanmax(near) < 0.15


def test_a_bound_on_the_margin_is_kept_in_the_worst_direction():
    core = core_of({"base": "waste_plain"}, margin=1.5)
    context = core.context
    hold, push = measured_hold(context.objects, context.belt_shift), context.throw_limits.acceleration
    turns = np.random.default_rng(0).normal(size=(COUNT, 500, 3))
    turns *= (push[:, None] / np.linalg.norm(turns, axis=2))[..., None]
    assert smallest_margin(hold, turns, np.full(COUNT, 500), 1.0)[0].min() >= 1.5
    loose = core_of({"base": "waste_plain"}).context
    assert (measured_hold(loose.objects, loose.belt_shift).least_margin(loose.throw_limits.acceleration) < 1.5).any()


def test_a_level_of_nothing_to_throw_says_so():
    with pytest.raises(ConfigError, match="no object has a feasible throw"):
        core_of({**MIXED, "items": ["bag"]}, drag_area=2.0)
