"""Cells that differ: every episode draws its own, nobody sees how it differs, and a fixed range is a level's number."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.drift import Cells
from pnt_gym.cells.conveyor.observation import CELL
from pnt_gym.cells.conveyor.shift import draw_cells
from pnt_gym.errors import ConfigError
from tests.tools.drifting import actions, cells
from tests.tools.throws import same_bits, vary

NAMES = tuple(Cells.model_fields)
IDS = ("PnTConveyor-v0", "PnTRelease-v0", "PnTAdapt-v0")


def drawn(seeds: list[int], level: str = "cells", **changes: Any) -> dict[str, np.ndarray]:
    rows = draw_cells(vary(level, **changes), [np.random.default_rng(seed) for seed in seeds])
    return {name: getattr(rows, name) for name in NAMES}


@pytest.mark.parametrize("level", ["cells", "cells_far"])
def test_every_number_is_drawn_evenly_from_its_range(level: str) -> None:
    ranges, values = vary(level).cells.ranges, drawn([*range(2000)], level)
    assert set(ranges) == set(NAMES)
    for name, (low, high) in ranges.items():
        ends = np.log([low, high]) if name == "stiffness" else np.array([low, high])
        share = ((np.log(values[name]) if name == "stiffness" else values[name]) - ends[0]) / (ends[1] - ends[0])
        assert share.min() >= -1e-9 and share.max() <= 1.0 + 1e-9, name
        # A mean of 2,000 uniform draws is within 4 standard deviations of a half.
        assert abs(share.mean() - 0.5) < 4.0 * np.sqrt(1.0 / 12.0 / 2000), name
    shares = np.corrcoef(np.stack([values[name] for name in NAMES]))
    assert np.abs(shares - np.eye(len(NAMES))).max() < 0.1


def test_cells_far_lies_outside_of_cells_in_every_number() -> None:
    near, far = (vary(level).cells.ranges for level in ("cells", "cells_far"))
    for name, (low, high) in far.items():
        assert low >= near[name][1] or high <= near[name][0], name


def test_a_cell_is_a_function_of_its_rows_generator_which_stays_where_it_is() -> None:
    generators = [np.random.default_rng(seed) for seed in range(5)]
    together = draw_cells(vary("cells"), generators)
    assert [g.random() for g in generators] == [np.random.default_rng(seed).random() for seed in range(5)]
    for row in range(5):
        assert same_bits(drawn([row])["tau"], together.tau[row : row + 1])


def test_ranges_are_drawn_apart() -> None:
    """A range that is not given changes no other number."""
    whole, part = drawn([*range(20)]), drawn([*range(20)], "waste", cells={"tau": (0.005, 0.020)})
    assert same_bits(whole["tau"], part["tau"])
    assert (part["valve"] == 0.004).all()


def test_objects_are_those_of_the_level_without_cells_and_no_sensor_tells_of_the_cell() -> None:
    for env_id in IDS:
        envs: list[Any] = [gym.make_vec(env_id, num_envs=6, level=level) for level in ("waste", "cells")]
        assert same_bits(*(env.reset(seed=4)[0] for env in envs)), env_id
        plain, differ = (env.unwrapped.core.context.objects for env in envs)
        for name in ("mass", "size", "seal", "jitter", "pick_draw"):
            assert same_bits(getattr(plain, name), getattr(differ, name)), name
        for name in ("delay", "spin", "drag", "restitution", "pick_chance"):
            assert (getattr(plain, name) != getattr(differ, name)).any(), name


def test_a_cell_stays_for_its_shift_and_another_one_follows() -> None:
    env: Any = gym.make_vec("PnTAdapt-v0", num_envs=4, level=vary("cells", picks_per_shift=3, fidelity="flight"))
    env.reset(seed=0)
    seen = []
    for action in actions(4, 5):
        seen.append(env.unwrapped.core.context.cell.tau)
        env.step(action)
    assert same_bits(seen[0], seen[1]) and same_bits(seen[0], seen[2])
    assert (seen[-1] != seen[0]).all()


FIXED = {"valve": 0.007, "tau": 0.016, "blow_off": 0.2, "stiffness": 0.4, "drag": 1.2, "encoder": 0.01}
"""Numbers of a cell that a level's other sections can say as well."""


def test_a_fixed_range_is_the_number_of_the_level() -> None:
    level: dict[str, Any] = {
        "suction": {"valve": 0.007, "tau": 0.016}, "cup": {"blow_off": 0.2, "stiffness": 0.4},
        "bias": {"drag": 0.2, "encoder": 0.01},
    }  # fmt: skip
    fixed, told = (
        cells(16, cells={name: (x, x) for name, x in FIXED.items()}, fidelity="flight"),
        cells(16, **level, fidelity="flight"),
    )
    zero = np.zeros((16, 2))
    for _ in range(3):
        for name in ("delay", "spin", "drag", "blow_off", "stiffness"):
            one, two = (getattr(core.context.objects, name) for core in (fixed, told))
            np.testing.assert_allclose(one, two, rtol=1e-9, atol=1e-12, err_msg=name)
        np.testing.assert_allclose(fixed.context.grasp, told.context.grasp, atol=1e-12)
        one, two = fixed.step(zero), told.step(zero)
        landed = np.isfinite(one.info["landing_along"])
        np.testing.assert_allclose(one.info["landing_along"][landed], two.info["landing_along"][landed], atol=1e-6)


def test_the_levels_own_numbers_as_ranges_change_nothing() -> None:
    own = {"valve": (0.004, 0.004), "tau": (0.009, 0.009), "blow_off": (0.0, 0.0), "stiffness": (1.0, 1.0)}
    factors = {"drag": (1.0, 1.0), "restitution": (1.0, 1.0), "seal": (0.0, 0.0), "camera": (0.0, 0.0)}
    plain, same = cells(8, fidelity="flight"), cells(8, cells={**own, **factors}, fidelity="flight")
    for action in actions(8, 3):
        one, two = plain.step(action), same.step(action)
        assert same_bits(one.info["landing_along"], two.info["landing_along"])


def test_camera_and_seal_and_restitution_do_what_their_keys_say() -> None:
    plain = cells(64, fidelity="flight")
    other = cells(
        64, cells={"camera": (0.05, 0.05), "seal": (-0.2, -0.2), "restitution": (1.5, 1.5)}, fidelity="flight"
    )
    across = plain.context.pick[:, 1] + 0.325  # from the middle of the lane
    np.testing.assert_allclose(other.context.unseen[:, 1], 0.05 * across, atol=1e-12)
    o, p = plain.context.objects, other.context.objects
    np.testing.assert_allclose(p.pick_chance, np.clip(o.pick_chance - 0.2, 0.0, 1.0))
    np.testing.assert_allclose(p.restitution, np.minimum(1.5 * o.restitution, 1.0))


def test_differences_scale_with_the_mismatch_and_are_nothing_in_the_planners_own_world() -> None:
    still, differ = cells(8, mismatch=0.0, fidelity="flight"), cells(8, "cells", mismatch=0.0, fidelity="flight")
    for action in actions(8, 2):
        one, two = still.step(action), differ.step(action)
        np.testing.assert_allclose(one.info["landing_along"], two.info["landing_along"], atol=1e-12)


def test_cells_alone_and_together_are_the_same_to_the_bit() -> None:
    together = cells(5, "cells", seed=3, fidelity="flight")
    alone = [cells(1, "cells", seed=3 + row, fidelity="flight") for row in range(5)]
    action = actions(5, 2)
    for step in range(2):
        whole = together.step(action[step])
        for row, core in enumerate(alone):
            part = core.step(action[step, row : row + 1])
            assert same_bits(whole.info["landing_along"][row : row + 1], part.info["landing_along"]), row


def test_the_hidden_values_name_the_cell() -> None:
    core = cells(3, "cells", fidelity="flight")
    values = {quantity.name: quantity.value(core.context) for quantity in core.cell.hidden}
    for name in NAMES:
        assert same_bits(values[f"cell_{name}"], getattr(core.context.cell, name))
    assert not {quantity.name for quantity in CELL} & {quantity.name for quantity in cells(1).cell.hidden}


@pytest.mark.parametrize(
    ("section", "named"),
    [
        ({"tau": [0.02, 0.005]}, "cells.tau"), ({"tau": [-0.001, 0.02]}, "cells.tau"),
        ({"stiffness": [0.0, 1.0]}, "cells.stiffness"), ({"seal": [-0.9, 0.0]}, "cells.seal"),
        ({"blow_off": [0.0, 3.0]}, "cells.blow_off"), ({"hose": [0.0, 1.0]}, "hose"),
    ],
)  # fmt: skip
def test_impossible_ranges_are_refused(section: dict[str, list[float]], named: str) -> None:
    with pytest.raises(ConfigError, match=named):
        ConveyorConfig.load({"base": "waste", "cells": section})


def test_a_rigid_cup_has_no_range_of_stiffness() -> None:
    with pytest.raises(ConfigError, match=r"cells\.stiffness is a range"):
        ConveyorConfig.load({"base": "cells", "cup": {"stiffness": None}})


@pytest.mark.parametrize(
    ("env_id", "level"),
    [
        ("PnTGrasp-v0", {"base": "grasp", "cells": {"tau": [0.01, 0.02]}}),
        ("PnTLine-v0", {"base": "single", "cell": {"cells": {"tau": [0.01, 0.02]}}}),
    ],
)
def test_cells_are_refused_where_no_landing_tells_of_them(env_id: str, level: dict[str, Any]) -> None:
    with pytest.raises(ConfigError, match="cells"):
        gym.make(env_id, level=level)
