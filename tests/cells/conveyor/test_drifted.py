"""What the physics makes of a drift, by finite differences."""

import numpy as np
import pytest

from agents.controllers.trackers import drift_effects
from pnt_gym.cells.conveyor.context import HiddenDrift
from pnt_gym.cells.conveyor.observation import decode
from pnt_gym.cells.conveyor.shift import apply_drift
from tests.tools.drifting import ALL, QUICK, cells
from tests.tools.throws import same_bits


def previewed(core, context, **off):
    """Landings (N, 2) in the throw's frame of cells that are off, and which were thrown untouched."""
    now = HiddenDrift.of(core.count, **off)
    core.cell.context = apply_drift(context, now, core.config)
    seen = core.preview(np.zeros((core.count, 2)))
    landing = np.stack([seen.landing_along, seen.landing_across], axis=1)
    return landing, np.isfinite(landing).all(axis=1) & ~seen.dropped & ~seen.recontact


COUNT = 144
LITTLE = {
    "delay": (0.002, np.full(COUNT, 0.002)),
    "camera x": (0.004, np.tile([0.004, 0.0], (COUNT, 1))),
    "camera y": (0.004, np.tile([0.0, 0.004], (COUNT, 1))),
    "encoder": (0.004, np.full(COUNT, 0.004)),
}


@pytest.mark.nightly
def test_trackers_know_what_a_drift_does_to_a_landing_from_first_principles():
    """Finite differences in the full physics against `drift_effects`, which is fitted to nothing."""
    core = cells(COUNT, drift=ALL)
    context = core.context
    expected = drift_effects(core.observe()[:, :26], core.config.belt.camera_x)
    still, fine = previewed(core, context)
    for column, (name, (size, values)) in enumerate(LITTLE.items()):
        landing, good = previewed(core, context, **{name.split()[0]: values})
        rows = fine & good
        assert rows.sum() >= 0.9 * COUNT
        found, foreseen = ((landing - still) / size)[rows], expected[rows, :, column]
        share = (found * foreseen).sum() / (foreseen**2).sum()
        # Objects swing under soft lips, which takes a fifth of what an offset across the belt does to rigid throws.
        assert share == pytest.approx(1.0, abs=0.25 if name == "camera y" else 0.15), name
        assert np.abs(found).mean() == pytest.approx(np.abs(foreseen).mean(), rel=0.15), name
        left = np.square(found - foreseen).sum() / np.square(found).sum()
        assert left < 0.3, name


WINDY = {"draught": {"even": 1.0, "most": 1.5}}


def windy(level, fidelity, count=80):
    """A first throw in cells with a draught, each another one."""
    core = cells(count, level, drift=WINDY, fidelity=fidelity)
    draught = core.context.drift.draught
    return draught, core.step(np.random.default_rng(0).uniform(-0.4, 0.4, (count, 2))).info


@pytest.mark.parametrize(("level", "bound"), [("waste_plain", 0.0025), ("waste", 0.003)])
def test_flights_in_a_draught_are_those_of_the_full_physics(level, bound):
    (wind, flight), (same, full) = (windy(level, fidelity) for fidelity in ("flight", "full"))
    assert same_bits(wind, same)
    assert np.abs(wind).max() > 0.9
    thrown = full["picked"] & ~full["dropped"] & ~flight["recontact"] & ~full["recontact"]
    assert thrown.sum() > 50
    for name in ("landing_along", "landing_across"):
        assert np.quantile(np.abs(flight[name] - full[name])[thrown], 0.95) < bound
    assert (flight["is_success"] != full["is_success"]).mean() <= 0.06


def test_a_draught_carries_light_things_down_wind():
    core = cells(COUNT, drift=WINDY, **QUICK)
    context = core.context
    still, fine = previewed(core, context)
    for axis in (0, 1):
        wind = np.zeros((COUNT, 2))
        wind[:, axis] = 0.5
        landing, good = previewed(core, context, draught=wind)
        rows = fine & good
        carried = context.from_throw_frame(*(landing - still).T)[rows, axis]
        assert (carried > 0.0).mean() > 0.95
        light = (decode(core.observe())["plan_area_per_mass"])[rows]
        heavy = light < np.median(light)
        assert carried[~heavy].mean() > 2.0 * carried[heavy].mean()
        assert 0.003 < carried.mean() < 0.03
        against, good = previewed(core, context, draught=-wind)
        both = rows & good
        back = context.from_throw_frame(*(against - still).T)[both, axis]
        assert (back < 0.0).mean() > 0.95


def test_no_draught_of_one_pick_is_left_for_the_next():
    """The engine keeps a wind until it is told another."""
    core = cells(8, drift=WINDY)
    context = core.context
    before, _ = previewed(core, context)
    previewed(core, context, draught=np.full((8, 2), 1.0))
    after, _ = previewed(core, context)
    assert same_bits(before, after)


def test_a_drift_that_is_not_corrected_shows_in_the_landings():
    """A valve that is late by 7.5 ms lands about 20 mm further along; a camera 10 mm off lands 10 mm off."""
    core = cells(COUNT, drift=ALL, **QUICK)
    context = core.context
    still, fine = previewed(core, context)
    late, good = previewed(core, context, delay=np.full(COUNT, 0.0075))
    along, across = (late - still)[fine & good].mean(axis=0)
    assert 0.017 < along < 0.025
    assert abs(across) < 0.002
    seen, good = previewed(core, context, camera=np.tile([0.006, 0.008], (COUNT, 1)))
    assert np.hypot(*(seen - still)[fine & good].T).mean() == pytest.approx(0.010, abs=0.0015)
    assert same_bits(previewed(core, context)[0], still)
