"""Records are not overwritten in place: what is kept of a cell before a step is the same after it."""

import pickle
from dataclasses import fields, is_dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from tests.tools.throws import SHORT_LINE, THROWS, some_actions, zeros


def arrays(record: Any, path: str = "") -> dict[str, np.ndarray]:
    """Every array in a record of records, and every column of rows in it, copied, by the way to it."""
    if isinstance(record, np.ndarray):
        columns = record.dtype.names or ()
        parts = [arrays(record[name], f"{path}.{name}") for name in columns] or [{path: record.copy()}]
        return {name: values for part in parts for name, values in part.items()}
    names = [field.name for field in fields(record)] if is_dataclass(record) else getattr(record, "_fields", ())
    found: dict[str, np.ndarray] = {}
    for name in names:
        found |= arrays(getattr(record, name), f"{path}.{name}")
    return found


@pytest.mark.parametrize("env_id", THROWS)
def test_a_context_kept_before_a_step_is_the_same_after_it_and_after_a_reset(env_id):
    env = gym.make_vec(env_id, num_envs=3)
    env.reset(seed=3)
    core = env.unwrapped.core
    kept = core.context
    before = arrays(kept)
    assert len(before) > 5
    action = zeros(env_id, 3) + np.float32(0.1)
    seen = core.preview(action)
    shown = arrays(seen)
    env.step(action)
    env.reset(options={"reset_mask": np.array([True, False, True])}, seed=9)
    for name, values in arrays(kept).items():
        np.testing.assert_array_equal(values, before[name], err_msg=name)
    for name, values in arrays(seen).items():
        np.testing.assert_array_equal(values, shown[name], err_msg=name)
    assert core.context is not kept


def test_a_copy_of_a_lines_state_stays_what_it_was_and_the_books_of_the_state_go_on():
    env = gym.make_vec("PnTLine-v0", num_envs=3, level=SHORT_LINE)
    env.reset(seed=3)
    cell = env.unwrapped.core.cell
    kept, copied = cell.state, cell.state.copy()
    before = [repr(rows.tolist()) for rows in copied]
    env.step(zeros("PnTLine-v0", 3))
    env.reset(options={"reset_mask": np.array([True, False, True])}, seed=9)
    assert [repr(rows.tolist()) for rows in copied] == before
    assert [repr(rows.tolist()) for rows in kept][:3] == before[:3]
    assert kept.accounts is cell.state.accounts
    assert repr(cell.state.accounts.tolist()) != before[3]


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_an_info_kept_is_not_written_to_by_later_steps(env_id):
    env = gym.make_vec(env_id, num_envs=2)
    env.reset(seed=3)
    *_, info = env.step(zeros(env_id, 2))
    kept = pickle.dumps(info)
    env.step(some_actions(env_id, np.random.default_rng(0), 2, share=0.05))
    assert pickle.dumps(info) == kept
