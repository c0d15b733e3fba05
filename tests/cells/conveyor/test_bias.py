"""Constants by which a cell is off its data sheet: applied as a drift is, and nothing by default."""

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.drift import Bias
from pnt_gym.cells.conveyor.shift import apply_drift
from pnt_gym.errors import ConfigError
from tests.tools.drifting import QUICK, cells
from tests.tools.throws import same_bits

OFF = {"camera": [0.006, -0.004], "encoder": 0.01, "drag": 0.2, "delay": 0.003}
IDS = ("PnTConveyor-v0", "PnTRelease-v0", "PnTAdapt-v0")


@pytest.mark.parametrize("env_id", IDS)
def test_every_conveyor_environment_has_the_constants(env_id: str) -> None:
    still, off = (gym.make_vec(env_id, num_envs=6, level={"base": "waste", "bias": section}) for section in ({}, OFF))
    seen = [env.reset(seed=4)[0] for env in (still, off)]
    assert same_bits(*seen)  # no sensor measures a constant
    before, after = (env.unwrapped.core.context for env in (still, off))
    o, p = before.objects, after.objects
    np.testing.assert_allclose(p.drag, 1.2 * o.drag)
    np.testing.assert_allclose(p.delay, o.delay + 0.003)
    moved = after.grasp - before.grasp
    np.testing.assert_allclose(moved[:, 0], 0.006 + 0.01 * (before.pick[:, 0] + 0.8))
    np.testing.assert_allclose(moved[:, 1], -0.004)
    actions = np.zeros((6, 2), dtype=np.float32)
    still.step(actions)
    off.step(actions)
    np.testing.assert_allclose(off.unwrapped.core.context.unseen[:, 1], -0.004)  # and so has the next pick


def test_constants_are_the_drift_that_stays() -> None:
    """A cell with constants throws as a cell that drifts by as much, which is not clipped by the valve's zero."""
    level = {"camera": [0.006, -0.004], "encoder": 0.01, "delay": 0.003}
    still, off = cells(12, **QUICK), cells(12, bias=level, **QUICK)
    context, now = still.context, off.context.drift
    drifted = apply_drift(context, now, still.config)
    for name in ("delay", "spin"):
        assert same_bits(getattr(drifted.objects, name), getattr(off.context.objects, name)), name
    assert same_bits(drifted.grasp, off.context.grasp)
    still.cell.context = drifted
    zero = np.zeros((12, 2))
    assert same_bits(still.preview(zero).landing_along, off.preview(zero).landing_along)


def test_drift_adds_to_the_constants() -> None:
    drift = {"camera": {"normal": 0.008}, "delay": {"even": 0.005}}
    alone, both = cells(12, drift=drift, **QUICK), cells(12, drift=drift, bias=OFF, **QUICK)
    np.testing.assert_allclose(both.context.drift.camera - alone.context.drift.camera, np.tile(OFF["camera"], (12, 1)))
    np.testing.assert_allclose(both.context.unseen[:, 1] - alone.context.unseen[:, 1], -0.004)
    assert (both.context.objects.delay >= alone.context.objects.delay).all()


def test_constants_scale_with_the_mismatch_and_are_nothing_at_zero() -> None:
    half, none = (cells(8, mismatch=share, bias=OFF, **QUICK).context for share in (0.5, 0.0))
    np.testing.assert_allclose(half.unseen[:, 1], -0.002)
    assert not none.unseen.any()
    plain = cells(8, mismatch=0.5, **QUICK).context
    np.testing.assert_allclose(half.objects.drag, 1.1 * plain.objects.drag)


def test_no_constants_are_nothing() -> None:
    assert not Bias().applies
    plain, zero = cells(8, **QUICK), cells(8, bias={"camera": [0.0, 0.0], "drag": 0.0}, **QUICK)
    assert same_bits(plain.context.objects.spin, zero.context.objects.spin)
    for section in ({"camera": [0.06, 0.0]}, {"drag": -1.0}, {"delay": 0.2}, {"air": 1.0}):
        with pytest.raises(ConfigError, match="bias"):
            ConveyorConfig.load({"base": "waste", "bias": section})
