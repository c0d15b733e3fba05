"""Controllers with a memory of a shift of grasps."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from agents.controllers import make_controller
from agents.controllers.protocol import State
from agents.controllers.state import write_state
from agents.grasping.foretelling import networks_foretell
from agents.grasping.memory import NoMemory, ShiftMemory
from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import observed, throw_held_out
from agents.training.grasp_shifts import practise_attention, practise_shifts, read_gauge
from tests.tools.nightly import with_nightly

LEVEL = {"base": "grasp_shift", "picks_per_shift": 20, "drawn": {"kinds": 40, "seed": 1}}


def cells(count: int, **level: Any) -> Any:
    return make_vector("PnTGrasp-v0", {**LEVEL, **level}, count, 1)


@pytest.mark.parametrize("name", with_nightly(["remembering", "shift_values"], ["shift_values"]))
def test_a_memory_finds_the_error_of_the_cup_within_a_shift(name: str) -> None:
    env = cells(16)
    controller: Any = make_controller(name, env)
    seen, info = env.reset(seed=3)
    for _ in range(30):
        seen, _, _, _, info = env.step(controller.act(observed(seen, info["kind"])))
    controller.act(observed(seen, info["kind"]))
    true, core = -core_of(env).context.drift.camera, core_of(env)  # type: ignore[attr-defined]
    goes_on = core.context.before.gone > 0.3  # type: ignore[attr-defined]
    found = controller._watcher.memory.error(np.arange(16))
    before, after = (np.hypot(*(true - guess)[goes_on].T).mean() for guess in (np.zeros((16, 2)), found))
    assert goes_on.sum() > 8
    assert after < 0.75 * before


@pytest.mark.parametrize("name", with_nightly(["remembering", "shift_values"], ["shift_values"]))
def test_a_new_shift_has_nothing_of_the_last(name: str) -> None:
    env = cells(4)
    controller = make_controller(name, env)
    first = throw_held_out(controller, env, 80, 2)
    again = throw_held_out(controller, env, 80, 2)  # the memory is of other shifts, until these begin
    np.testing.assert_array_equal(first.cycle_time, again.cycle_time)
    alone = make_vector("PnTGrasp-v0", LEVEL, 1, 1)
    one = throw_held_out(make_controller(name, alone), alone, 20, 2)
    np.testing.assert_allclose(one.cycle_time, first.cycle_time[::4], rtol=1e-9)


def test_a_memory_sorts_more_than_a_rule_without_one() -> None:
    env = cells(32)
    throws = {name: throw_held_out(make_controller(name, env), env, 640, 1) for name in ("flattest", "remembering")}
    rates = {name: one.sorted.sum() / one.cycle_time.sum() for name, one in throws.items()}
    assert rates["remembering"] > 1.15 * rates["flattest"]


@pytest.mark.parametrize("level", ["grasp", {"base": "grasp_shift", "grasp": {"stages": 1, "tries": 1}}])
def test_levels_without_a_last_try_are_refused(level: Any) -> None:
    env = make_vector("PnTGrasp-v0", level, 2, 1)
    with pytest.raises(UsageError, match="remembers what a shift of grasps has shown"):
        make_controller("remembering", env)


@pytest.fixture(scope="module")
def quick() -> Iterator[State]:
    """What foretells the gauge after a very short practice, as all fits are in the tests that ask for it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("agents.training.grasp_shifts.OBJECTS", 100)
        patch.setattr("agents.controllers.shift_values.RELEASE_STEPS", 20)
        for name in ("STEPS", "QUICK_STEPS", "ATTENTION_STEPS"):
            patch.setattr(f"agents.training.grasp_shifts.{name}", 20)
            patch.setattr(f"agents.grasping.foretelling.{name}", 20, raising=False)
        yield practise_attention(networks_foretell(), 400, 1)


@pytest.mark.parametrize("memory", with_nightly([ShiftMemory, NoMemory], [ShiftMemory]))
def test_practice_makes_networks_that_a_file_keeps(memory: type[ShiftMemory], quick: State, tmp_path: Any) -> None:
    learned = practise_shifts(0, memory, 200, quick)
    file = tmp_path / "values.npz"
    write_state(learned.name, learned.state(), file)
    env = cells(8)
    controller: Any = make_controller("shift_values", env, file=file)
    assert np.isfinite(throw_held_out(controller, env, 80, 1).cycle_time).all()
    assert read_gauge(file).keys() == learned.state().keys()
    assert isinstance(controller._watcher.memory, memory)
    state = controller.state()
    assert all(np.array_equal(state[name], array) for name, array in learned.state().items())


def test_files_of_other_networks_are_refused_in_a_sentence(tmp_path: Any) -> None:
    env, file = cells(2), tmp_path / "former.npz"
    write_state("shift_values", {"gauge weight_0": np.zeros((2, 2))}, file)
    with pytest.raises(UsageError, match="holds no state of 'shift_values' that this version can read"):
        make_controller("shift_values", env, file=file)
    with pytest.raises(UsageError, match="that foretell the gauge"):
        read_gauge(file)
    with pytest.raises(UsageError, match="was saved by 'shift_values', not by 'remembering'"):
        make_controller("remembering", env, file=file)
