"""The planner that fits the cell: what it knows, what it must not know, and what its throws come to."""

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.controllers import load_state, make_controller, save_state
from agents.controllers.fitted_planner import GUESS, FittedPlanner
from agents.controllers.protocol import Actions
from agents.fit.parameters import PARAMETERS
from agents.ground.cli import UsageError
from agents.ground.environments import Env, core_of, make_vector
from agents.judging.loop import observed, practise, throw_held_out
from pnt_gym.cells.conveyor.config import ConveyorConfig
from tests.tools.fitting import QUIET, WASTE, level
from tests.tools.toy_cell import ToyVectorEnv

ENV = "PnTRelease-v0"
TRUTH = {
    "valve": 0.003, "tau": 0.015, "blow_off": 0.0, "drag": 1.15, "camera_x": 0.012, "camera_y": -0.008,
    "encoder": 0.005,
}  # fmt: skip
"""Numbers of a cell that are far from the guess; its lip has a stiffness of 2 N m/rad."""
OTHER: dict[str, Any] = {
    "suction": {"valve": TRUTH["valve"], "tau": TRUTH["tau"]},
    "bias": {"camera": [TRUTH["camera_x"], TRUTH["camera_y"]], "encoder": TRUTH["encoder"], "drag": 0.15},
    "cup": {"stiffness": 2.0},
}


def cells(config: ConveyorConfig, count: int = 8) -> Env:
    return make_vector(ENV, config, count, 1)


def planner_of(env: Env) -> FittedPlanner:
    planner = make_controller("fitted_planner", env)
    assert isinstance(planner, FittedPlanner)
    planner.reset(0)
    return planner


def first_actions(env: Env, controller: Any, seed: int = 3) -> Actions:
    features, info = env.reset(seed=seed)
    return controller.act(observed(features, info["kind"]))


def test_numbers_of_the_guess_are_those_of_the_fit() -> None:
    assert set(GUESS) == {parameter.name for parameter in PARAMETERS}


def test_a_planner_that_knows_the_cell_throws_onto_the_target() -> None:
    """In a cell without scatter the simulated throw of each action, which knows all, ends at the target."""
    with closing(cells(level(**{**QUIET, **OTHER, "suction": {**QUIET["suction"], **OTHER["suction"]}}), 32)) as env:
        knowing, core = planner_of(env), core_of(env)
        knowing.restore({**{name: np.array(value) for name, value in TRUTH.items()}, "stiffness": np.array(2.0)})
        action = first_actions(env, knowing)
        thrown, blind = core.preview(action), core.preview(np.zeros_like(action))
        miss = np.hypot(thrown.landing_along, thrown.landing_across)
        assert np.nanmedian(miss) < 2e-3
        assert np.nanmedian(np.hypot(blind.landing_along, blind.landing_across)) > 20.0 * np.nanmedian(miss)


def test_some_throws_tell_what_another_cell_is_like() -> None:
    config = level(**OTHER)
    with closing(cells(config, 16)) as env:
        planner = planner_of(env)
        before = throw_held_out(planner, env, 96, 1).error
        practise(planner, env, 16, 0)
        after = throw_held_out(planner, env, 96, 1).error
        planner.restore({**{name: np.array(value) for name, value in TRUTH.items()}, "stiffness": np.array(2.0)})
        knowing = throw_held_out(planner, env, 96, 1).error
    miss = [np.nanmedian(np.hypot(*error.T)) for error in (before, after, knowing)]
    assert miss[1] < 0.55 * miss[0]
    assert miss[1] < 1.5 * miss[2]


def test_the_true_numbers_of_the_cell_are_not_read() -> None:
    actions = []
    for config in (WASTE, level(**OTHER)):
        with closing(cells(config)) as env:
            actions.append(first_actions(env, planner_of(env)))
    np.testing.assert_array_equal(*actions)


def test_hidden_values_of_objects_are_not_read() -> None:
    with closing(cells(WASTE)) as env:
        planner, core = planner_of(env), core_of(env)
        features, info = env.reset(seed=3)
        before = planner.act(observed(features, info["kind"]))
        context, objects = core.cell.context, core.cell.context.objects
        hidden = {name: 1.5 * getattr(objects, name) for name in ("mass", "drag", "seal", "delay", "com_depth", "spin")}
        core.cell.context = context.replace(objects=objects.replace(**hidden))
        np.testing.assert_array_equal(planner.act(observed(features, info["kind"])), before)


def test_what_was_learned_is_saved_and_read_on_another_level(tmp_path: Path) -> None:
    with closing(cells(WASTE)) as env:
        planner = planner_of(env)
        practise(planner, env, 3, 0)
        save_state(planner, tmp_path / "state.npz")
        learned = {name: float(value) for name, value in planner.state().items()}
    assert learned.keys() == GUESS.keys()
    assert learned != dict(GUESS)
    with closing(cells(level(base="unseen"))) as env:
        other = planner_of(env)
        load_state(other, tmp_path / "state.npz")
        assert {name: float(value) for name, value in other.state().items()} == learned
        assert (first_actions(env, other) != first_actions(env, planner_of(env))).any()


@pytest.mark.parametrize(
    ("name", "value"), [("tau", -0.01), ("tau", np.nan), ("drag", 1e6), ("valve", np.zeros(2)), ("camera_x", None)]
)
def test_numbers_that_no_cell_has_are_refused(name: str, value: Any) -> None:
    with closing(cells(WASTE, 1)) as env:
        planner = planner_of(env)
        state = {key: part for key, part in planner.state().items() if key != name}
        state |= {} if value is None else {name: np.array(value)}
        with pytest.raises(UsageError, match=f"the saved state of 'fitted_planner' has {name} .*; it must be a number"):
            planner.restore(state)


@pytest.mark.parametrize(
    ("env", "said"),
    [
        (lambda: make_vector(ENV, {"base": "waste", "planner": "free_direction"}, 1, 1), "planner straight or"),
        (lambda: make_vector("GripperToss-v0", None, 1, 1), "planner straight or"),
        (lambda: make_vector(ENV, {"base": "waste", "mismatch": 0.0}, 1, 1), "has mismatch 0"),
        (lambda: ToyVectorEnv(2), "planner straight or"),
    ],
)
def test_other_cells_are_refused_in_a_sentence(env: Any, said: str) -> None:
    with closing(env()) as opened, pytest.raises(UsageError, match=said):
        make_controller("fitted_planner", opened)


def test_a_part_of_the_cells_is_refused() -> None:
    with closing(cells(WASTE, 2)) as env:
        features, info = env.reset(seed=0)
        with pytest.raises(UsageError, match="plans the throws of all 2 cells at once"):
            planner_of(env).act(observed(features[:1], info["kind"][:1]))
