"""Options of a reset ask for the first throw: it comes, nothing else changes, and what cannot be is refused."""

from collections.abc import Callable
from functools import partial
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv

from pnt_gym.errors import ConfigError
from tests.tools.nightly import with_nightly
from tests.tools.throws import CONVEYOR, THROWS, same_bits, same_step, zeros

LEFT = {"name": "left", "x": -0.25, "y": 0.45, "accepts": ["paper", "metal_can"]}
RIGHT = {"name": "right", "x": 0.25, "y": 0.45, "accepts": ["metal_can", "plastic_package"]}
TWO_BINS = {"name": "two", "bins": {"fixed": [LEFT, RIGHT]}, "picks_per_shift": 2}
DRIFTS = {"delay": {"even": 0.005, "step": 0.002}, "camera": {"normal": 0.008}, "encoder": {"walk": 0.002}}
LEVELS = dict.fromkeys(CONVEYOR, TWO_BINS) | {
    "PnTAdapt-v0": {**TWO_BINS, "drift": DRIFTS},
    "OneJointThrow-v0": "contact",
    "GripperToss-v0": "belt",
    "PnTLine-v0": "single",
}
WISHES: list[tuple[str, dict[str, Any]]] = [
    *((env_id, wish) for env_id in CONVEYOR for wish in (
        {"item": "paper"}, {"target": "right"}, {"item": "metal_can", "target": "left"}, {"item": 2, "target": 1},
    )),
    ("OneJointThrow-v0", {"target": "c"}),
    ("OneJointSort-v0", {"target": "pallet_3"}),
    ("OneJointSort-v0", {"item": np.int64(1), "target": "pallet_2"}),
    ("OneJointAssembly-v0", {"item": "aitch"}),
    ("GripperToss-v0", {"item": "yoghurt_cup"}),
    ("GripperToss-v0", {"target": 2}),
]  # fmt: skip
OF_EACH = list(dict(WISHES).items())
"""The last wish of every environment."""
N, STEPS = 2, 2


def single(env_id: str, **changes: Any) -> Any:
    return gym.make(env_id, **{"level": LEVELS.get(env_id, "nominal"), **changes}).unwrapped


def vector(env_id: str, count: int = N) -> Any:
    return gym.make_vec(env_id, num_envs=count, level=LEVELS.get(env_id, "nominal"))


def is_granted(core: Any, wish: dict[str, Any], row: int = 0) -> bool:
    """Whether the coming throw is what was asked for, by what the cell itself calls it."""
    kind = core.context.kind[row]
    aimed = core.context.bin[row] if hasattr(core.context, "bin") else kind
    came = {"item": (kind, core.item_names[kind])}
    if "target" in wish:
        came["target"] = (aimed, core.cell.target_names[aimed])
    return all(value in came[what] for what, value in wish.items())


@pytest.mark.parametrize(("env_id", "wish"), WISHES, ids=str)
def test_the_first_throw_is_what_was_asked_for(env_id: str, wish: dict[str, Any]) -> None:
    env, seen = single(env_id), set()
    for seed in (0, 1, None):
        observation, info = env.reset(seed=seed, options=wish)
        assert is_granted(env.core, wish)
        assert info["kind"] == env.core.context.kind[0]
        seen.add(observation.tobytes())
        *_, told = env.step(zeros(env_id))
        assert told["item"] == info["kind"]
        assert (
            "bin" not in told or "target" not in wish or wish["target"] in (told["bin"], ("left", "right")[told["bin"]])
        )
    assert len(seen) == 3 or env_id.startswith("OneJoint")  # where throws of one kind look the same


@pytest.mark.parametrize(("env_id", "wish"), with_nightly(OF_EACH, [OF_EACH[1], OF_EACH[3], *OF_EACH[5:]]))
def test_a_row_is_the_single_environment_and_a_repetition_the_same(env_id: str, wish: dict[str, Any]) -> None:
    """Throws, later episodes and a second request without a seed included."""
    actions = 0.3 * np.random.default_rng(0).uniform(-1, 1, (STEPS, *zeros(env_id, N).shape)).astype(np.float32)

    def observed(env: Any) -> list[np.ndarray]:
        seen = [env.reset(seed=5, options=wish)[0], *(env.step(action)[0] for action in actions)]
        return [*seen, env.reset(options=wish)[0], env.step(actions[0])[0]]

    makers = [partial(gym.make, env_id, level=LEVELS.get(env_id, "nominal"), disable_env_checker=True)] * N
    same_step = gym.vector.AutoresetMode.SAME_STEP
    ours = observed(vector(env_id))
    for others in (observed(vector(env_id)), observed(SyncVectorEnv(makers, autoreset_mode=same_step))):
        for one, other in zip(ours, others, strict=True):
            assert same_bits(one, other)


@pytest.mark.parametrize("env_id", THROWS)
def test_what_comes_anyway_may_be_asked_for_and_changes_nothing(env_id: str) -> None:
    free, asked = single(env_id), single(env_id)
    for seed in range(3):
        observation, info = free.reset(seed=seed)
        again, told = asked.reset(seed=seed, options={"item": info["kind"]})
        assert same_bits(observation, again)
        assert info == told
        a, b = (env.step(zeros(env_id)) for env in (free, asked))
        assert same_step(a, b)


@pytest.mark.parametrize("env_id", THROWS)
def test_a_request_is_forgotten_by_the_next_reset(env_id: str) -> None:
    fresh, used = single(env_id), single(env_id)
    used.reset(seed=1, options={"item": 0})
    used.step(zeros(env_id))
    for options in (None, {}):
        assert same_bits(fresh.reset(seed=8)[0], used.reset(seed=8, options=options)[0])


@pytest.mark.parametrize("env_id", ["PnTConveyor-v0", "PnTAdapt-v0"])
def test_later_throws_come_as_always(env_id: str) -> None:
    env = single(env_id, level={**LEVELS[env_id], "picks_per_shift": 40, "fidelity": "flight"})
    env.reset(seed=0, options={"item": "paper", "target": "left"})
    later = [env.step(zeros(env_id))[4]["kind"] for _ in range(30)]
    assert set(later) == {0, 1, 2}


@pytest.mark.parametrize("env_id", [*CONVEYOR, "GripperToss-v0"])
def test_a_mask_says_of_which_cells_it_is_asked(env_id: str) -> None:
    env = vector(env_id, 8)
    before, _ = env.reset(seed=0)
    mask = np.arange(8) % 2 == 1
    after, info = env.reset(options={"reset_mask": mask, "item": 2})
    assert same_bits(before[~mask], after[~mask])
    assert (info["kind"][mask] == 2).all()
    assert all((before[mask] != after[mask]).any(axis=1))


def test_items_that_a_level_lists_twice_are_one() -> None:
    env = single("PnTRelease-v0", level={"items": ["can", "can", "cork"]})
    assert {env.reset(seed=seed, options={"item": "can"})[1]["kind"] for seed in range(12)} == {0, 1}


REFUSED: list[tuple[str, Any, str]] = [
    ("PnTRelease-v0", {"itme": "paper"}, "unknown option 'itme'; did you mean 'item'. known are item, target"),
    ("PnTRelease-v0", {3: "paper"}, "unknown option 3"),
    ("PnTRelease-v0", {"item": "stone"}, "unknown item 'stone'; known are paper, metal_can, plastic_package, or an"),
    ("PnTRelease-v0", {"item": 3}, "unknown item 3; known are .* index from 0 to 2"),
    ("PnTRelease-v0", {"item": -1}, "unknown item -1"),
    ("PnTRelease-v0", {"item": True}, "unknown item True"),
    ("PnTRelease-v0", {"item": None}, "unknown item None"),
    ("PnTRelease-v0", {"item": 1.0}, "unknown item 1.0"),
    ("PnTRelease-v0", {"item": ["paper"]}, r"unknown item \['paper'\]"),
    ("PnTRelease-v0", {"item": "x" * 9999}, "unknown item 'xxx"),
    ("PnTRelease-v0", {"target": "middle"}, "unknown target 'middle'; known are left, right, or an index"),
    ("PnTRelease-v0", {"item": "paper", "target": "right"}, "item 'paper' and target 'right' did not come in 64 draws"
     " of level 'two', which has items paper, metal_can, plastic_package and targets left, right$"),
    ("PnTConveyor-v0", {"target": "left", "item": 2}, "item 'plastic_package' and target 'left' did not come"),
    ("PnTAdapt-v0", {"target": "left", "item": 2}, "item 'plastic_package' and target 'left' did not come"),
    ("OneJointSort-v0", {"target": "pallet_4"}, "unknown target 'pallet_4'; known are pallet_1, pallet_2, pallet_3"),
    ("OneJointAssembly-v0", {"item": "tee"}, "item 'tee' did not come in .*, which has items aitch, tee"),
    ("GripperToss-v0", {"item": "cork"}, "unknown item 'cork'; known are paper_ball, yoghurt_cup, can_crushed"),
    ("PnTLine-v0", {"item": "tray"}, "options ask for item; a line takes no requests for objects or bins"),
    ("PnTLine-v0", {"item": 1}, "options ask for item; a line takes no requests for objects or bins"),
    ("PnTLine-v0", {"item": "stone"}, "unknown item 'stone'; known are tray, can, paper_ball, yoghurt_cup"),
    ("PnTLine-v0", {"target": "cans"}, "unknown target 'cans'; there is none with a name on level 'single'"),
    ("PnTLine-v0", {"seed": 1}, "unknown option 'seed'; known are item, target"),
]  # fmt: skip


@pytest.mark.parametrize("env_id", dict.fromkeys(env_id for env_id, *_ in REFUSED))
@pytest.mark.parametrize("make", [single, vector])
def test_what_cannot_be_asked_for_is_refused_and_changes_nothing(
    env_id: str, make: Callable[[str], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """After so few draws, that is; how many there are else is the next test's."""
    monkeypatch.setattr("pnt_gym.cells.base.request.MOST_DRAWS", 64)
    hurt, unhurt = make(env_id), make(env_id)
    still = np.zeros(hurt.action_space.shape, hurt.action_space.dtype)
    for env in (hurt, unhurt):
        env.reset(seed=1)
        env.step(still)
    wrong = [(options, said) for refusing, options, said in REFUSED if refusing == env_id]
    for (options, said), seed in product(wrong, (None, 7)):
        with pytest.raises(ConfigError, match=said) as caught:
            hurt.reset(seed=seed, options=options)
        assert "\n" not in str(caught.value)
    for _ in range(2):
        a, b = (env.step(still) for env in (hurt, unhurt))
        for one, other in zip(a[:4], b[:4], strict=True):
            assert same_bits(one, other)
    assert same_bits(hurt.reset()[0], unhurt.reset()[0])


def test_what_does_not_come_in_4096_draws_is_refused() -> None:
    env = single("PnTRelease-v0")
    with pytest.raises(ConfigError, match="did not come in 4096 draws of level 'two'"):
        env.reset(seed=1, options={"item": "paper", "target": "right"})


def test_bins_that_are_drawn_cannot_be_asked_for() -> None:
    with pytest.raises(ConfigError, match="unknown target 'left'; there is none with a name on level 'waste'"):
        single("PnTRelease-v0", level="waste").reset(options={"target": "left"})


def test_nothing_is_reset_where_one_cell_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two cells one finds what is asked for in the draws that are allowed, the other does not."""
    monkeypatch.setattr("pnt_gym.cells.base.request.MOST_DRAWS", 1)
    hurt, unhurt = vector("PnTRelease-v0", 8), vector("PnTRelease-v0", 8)
    _, info = hurt.reset(seed=0)
    unhurt.reset(seed=0)
    assert 0 < (info["kind"] == 0).sum() < 8
    with pytest.raises(ConfigError, match="did not come in 1 draws"):
        hurt.reset(seed=0, options={"item": 0})
    for _ in range(2):
        assert same_bits(*(env.step(zeros("PnTRelease-v0", 8))[0] for env in (hurt, unhurt)))
