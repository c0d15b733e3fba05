"""What a user gets wrong: one sentence that names the value, and an environment that still works afterwards."""

import warnings
from contextlib import contextmanager
from functools import partial

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from pnt_gym.envs.conveyor import PnTConveyorEnv, PnTConveyorVectorEnv
from pnt_gym.errors import ActionError, ConfigError, OrderError
from tests.tools.throws import MODES, same_bits, same_step, zeros


def named(value):
    """What a test is called by: the value, but for where it happens to lie in memory."""
    return "object()" if type(value) is object else repr(value)


@contextmanager
def refusal(*parts, error=ConfigError):
    """What is done within is refused in one sentence that has these parts."""
    with pytest.raises(error) as caught:
        yield caught
    assert isinstance(caught.value, ValueError)
    assert all(line.startswith("- ") for line in str(caught.value).split("\n")[1:])
    assert [part for part in parts if part not in str(caught.value)] == []


BAD_ACTIONS = [
    np.array([np.nan, 0.0]), np.array([0.0, np.inf]), np.array([-np.inf, 0.0]), np.zeros(5), np.zeros((1, 2)), 0.5,
    np.zeros(0), [[1.0], [1.0, 2.0]], [True, False], np.array([1j, 0]), np.array(["2020-01-01"] * 2, "datetime64[D]"),
    ["0.1", "0.2"], [10**400, 0.0], np.ma.masked_array([0.1, 0.2], [True, False]), None, "ab", {}, object(),
    # What might be taken for a choice of a line:
    np.nan, np.inf, 0.0, 3.0, 16, -1, True, "3", 10**400, 1j, np.ma.masked_array(3, True), np.datetime64("2020-01-01"),
]  # fmt: skip


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_a_rejected_action_changes_nothing(env_id):
    hurt, unhurt = (gym.make(env_id).unwrapped for _ in range(2))
    hurt.reset(seed=1)
    unhurt.reset(seed=1)
    for action in BAD_ACTIONS:
        with refusal("action", error=ActionError):
            hurt.step(action)
    assert same_step(hurt.step(zeros(env_id)), unhurt.step(zeros(env_id)))


@pytest.mark.parametrize("env_id", ["PnTConveyor-v0", "OneJointThrow-v0", "GripperToss-v0", "PnTGrasp-v0"])
def test_the_sentence_about_numbers_says_what_becomes_of_large_ones(env_id):
    one, other = (gym.make(env_id).unwrapped for _ in range(2))
    for env in (one, other):
        env.reset(seed=1)
    with refusal("it must have finite numbers; numbers beyond [-1, 1] are clipped", error=ActionError):
        one.step(np.full(one.action_space.shape, np.nan))
    beyond, bound = np.full(one.action_space.shape, 1e30), np.ones(one.action_space.shape)
    assert same_step(one.step(beyond), other.step(bound))


@pytest.mark.parametrize(
    ("keyword", "meant"),
    [
        ("levle", "level"),
        ("action_mod", "action_mode"),
        ("thread", "threads"),
        ("Camera", "camera"),
        ("nonesuch", None),
    ],
)
@pytest.mark.parametrize("make", [gym.make, partial(gym.make_vec, num_envs=2)], ids=("one", "several"))
@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_an_unknown_argument_names_those_that_there_are(env_id, make, keyword, meant):
    hint = "; known are" if meant is None else f"; did you mean {meant!r}? known are"
    with refusal(f"unknown argument {keyword!r}{hint} ", "level, action_mode, threads, render_mode"):
        make(env_id, **{keyword: "waste"})


def test_a_misspelled_number_of_cells_is_named():
    with refusal("unknown argument 'num_env'; did you mean 'num_envs'?"):
        gym.make_vec("PnTConveyor-v0", num_env=3)


BAD_ROWS = [
    np.full((2, 2), np.nan), np.zeros((3, 2)), np.zeros(2), np.zeros((2, 3)), np.zeros((2, 2, 1)), None,
    [[0.0], [0.0, 1.0]], np.ones((2, 2), dtype=bool), np.ones((2, 2), dtype=complex), np.full((2, 2), 10**400),
    np.zeros((2, 2), "datetime64[D]"), np.ma.masked_all((2, 2)), [["0", "0"]] * 2,
]  # fmt: skip


BAD_CHOICES = [
    np.full(2, np.nan), np.zeros(2), [0, 16], [-1, 0], np.zeros(3, dtype=int), np.zeros((2, 1), dtype=int), 0, None,
    [[0], [0, 1]], [True, False], np.zeros(2, dtype=complex), [10**400, 0], np.zeros(2, "datetime64[D]"),
    np.ma.masked_all(2, dtype=int), ["0", "0"],
]  # fmt: skip


@pytest.mark.parametrize(("env_id", "bad"), [("PnTConveyor-v0", BAD_ROWS), ("PnTLine-v0", BAD_CHOICES)])
def test_a_vector_environment_rejects_and_goes_on(env_id, bad):
    hurt, unhurt = (gym.make_vec(env_id, num_envs=2) for _ in range(2))
    hurt.reset(seed=1)
    unhurt.reset(seed=1)
    for actions in bad:
        with refusal("action", error=ActionError):
            hurt.step(actions)
    a, b = hurt.step(zeros(env_id, 2)), unhurt.step(zeros(env_id, 2))
    assert same_bits(a[0], b[0])
    assert same_bits(a[1], b[1])


@pytest.mark.parametrize("value", [0, -1, "2", 1.5, None, True, [], 10**6, np.nan])
@pytest.mark.parametrize("name", ["num_envs", "threads"])
@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_cells_and_threads_are_whole_numbers(env_id, name, value):
    with refusal(f"{name} is ", "it must be a whole number from 1 to"):
        gym.make_vec(env_id, **{"num_envs": 1, name: 10**9 if value == 10**6 and name == "num_envs" else value})


@pytest.mark.parametrize(
    "level", [None, 5, [], b"", 1.5, object(), ("a", "b"), "x" * 300, "x" * 300 + ".yaml", "a\0b.yaml"]
)
@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_what_no_level_can_be(env_id, level):
    with refusal("level"):
        gym.make(env_id, level=level)


def test_a_message_stays_a_sentence_whatever_is_given():
    for level in ({"mismatch": 10**400}, {"mismatch": "x" * 10_000}, {"x" * 10_000: 1}, {"bins": [1] * 10_000}):
        with refusal() as caught:
            gym.make("PnTConveyor-v0", level=level)
        assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("env_id", "level"),
    [
        ("OneJointThrow-v0", {"arm": {"thickness": 1e300}}),
        ("GripperToss-v0", {"tray": {"settle": 1e9}}),
        ("PnTRelease-v0", {"suction": {"tau": 1e9}}),
        ("OneJointThrow-v0", {"block": {"mass": 1e-300}}),
        ("OneJointSort-v0", {"block": {"half_height": 1e9}}),
        ("OneJointSort-v0", {"arm": {"thickness": 1e300}}),
        ("GripperToss-v0", {"table": {"y": [0, 0]}}),
        ("PnTRelease-v0", {"bins": {"fixed": [{"name": "b", "x": 0.1, "y": 0.4, "size": [1e300, 1e300]}]}}),
        ("PnTLine-v0", {"arrivals": {"rate": 1e300}}),
        ("PnTLine-v0", {"cell": {"belt": {"speed": 1e-300}}}),
        ("PnTLine-v0", {"throws": "flight", "cell": {"suction": {"tau": 1e9}}}),
        ("PnTLine-v0", {"duration": 1e300}),
        ("PnTRelease-v0", {"limits": {"percent": [2.5e-9]}}),
        ("PnTRelease-v0", {"motion": {"clearance": 5e298}}),
        ("PnTRelease-v0", {"spread": {"size": 80.0}}),
        ("PnTRelease-v0", {"spread": {"seal": 6.0}}),
        ("PnTConveyor-v0", {"belt": {"speed": 1e7}}),
        ("GripperToss-v0", {"errors": {"width": 3.0}}),
        ("GripperToss-v0", {"base": "belt", "items": 5}),
        ("GripperToss-v0", {"base": "belt", "items": [[1], None]}),
    ],
)
def test_a_level_in_which_nothing_can_be_thrown(env_id, level):
    with refusal() as caught:
        gym.make(env_id, level=level)
    assert len(str(caught.value)) <= 500


@pytest.mark.parametrize("make", [gym.make, partial(gym.make_vec, num_envs=2)], ids=("one", "several"))
@pytest.mark.parametrize("mode", ["telepathy", [], 5, {}, b"release_point", ("release_point",)], ids=named)
@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_what_no_action_mode_can_be(env_id, mode, make):
    with refusal(f"unknown action_mode {mode!r}", *MODES[env_id]):
        make(env_id, action_mode=mode)


@pytest.mark.parametrize("env_id", ["PnTConveyor-v0", "OneJointThrow-v0", "GripperToss-v0"])
def test_no_action_mode_but_a_known_one_corrects_errors(env_id):
    with refusal("unknown action_mode 'telepathy'", *MODES[env_id]):
        gym.make(env_id).unwrapped.core.cell.correction("telepathy")


def test_unknown_render_modes():
    with refusal("unknown render_mode 'hologram'", "rgb_array", "rgb_array_list", "human"):
        PnTConveyorEnv(render_mode="hologram")
    with refusal("unknown render_mode 'human'", "rgb_array"):
        PnTConveyorVectorEnv(2, render_mode="human")


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"width": 0}, "width is 0"),
        ({"height": 1081}, "height is 1081"),
        ({"width": True}, "width is True"),
        ({"width": 64.0}, "width is 64.0"),
        ({"camera": {"zoom": 2.0}}, "camera.zoom"),
        ({"camera": {"distance": 0.0}}, "camera.distance is 0.0"),
        ({"camera": {"lookat": (0.0, float("nan"), 0.0)}}, "camera.lookat.1 is nan"),
        ({"camera": "top"}, "camera is 'top'"),
    ],
    ids=str,
)
@pytest.mark.parametrize("make", [gym.make, gym.make_vec])
def test_impossible_pictures(make, wrong, said):
    with refusal(said):
        make("PnTRelease-v0", **wrong)


def test_a_window_needs_a_display(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    env = gym.make("PnTConveyor-v0", render_mode="human").unwrapped
    with refusal("needs a display", "rgb_array"):
        env.reset(seed=0)
    env.close()


@pytest.fixture(scope="module")
def both():
    return gym.make("PnTRelease-v0").unwrapped, gym.make_vec("PnTRelease-v0", num_envs=3).unwrapped


@pytest.mark.parametrize("seed", [1.5, -1, "5", True, object(), {}, np.nan], ids=named)
def test_a_seed_is_a_whole_number(both, seed):
    for env in both:
        with refusal("seed is ", "it must be a whole number, at least 0"):
            env.reset(seed=seed)
    with pytest.raises(ConfigError, match="seed is"):
        both[1].reset(seed=[1, 2, seed])


def test_a_seed_may_be_a_number_of_numpy(both):
    for env in both:
        assert np.array_equal(env.reset(seed=np.int64(5))[0], env.reset(seed=5)[0])
    assert np.array_equal(both[1].reset(seed=np.array([5, 6, 7]))[0], both[1].reset(seed=5)[0])


def test_a_list_of_seeds_of_another_length(both):
    with pytest.raises(ConfigError, match="seed has 2 entries; this environment has 3 cells"):
        both[1].reset(seed=[1, 2])


@pytest.mark.parametrize("options", ["x", 5, [1], True])
def test_options_are_a_mapping(both, options):
    for env in both:
        with refusal("options is", "mapping"):
            env.reset(options=options)


@pytest.mark.parametrize("mask", [[True], "x", [1, 0, 1], [[True], [True, False]], None], ids=named)
def test_a_mask_has_a_truth_for_every_cell(both, mask):
    with refusal("reset_mask"):
        both[1].reset(options={"reset_mask": mask})


def test_calls_out_of_order_are_refused():
    with pytest.raises(gym.error.ResetNeeded):
        gym.make("PnTConveyor-v0").step(np.zeros(2, dtype=np.float32))
    env = gym.make_vec("PnTRelease-v0", num_envs=2)
    with pytest.raises(OrderError, match="was not reset; call reset before step"):
        env.step(np.zeros((2, 2)))
    env.reset()
    env.step(np.zeros((2, 2)))
    env.close()
    for call in (lambda: env.step(np.zeros((2, 2))), env.reset):
        with pytest.raises(OrderError, match="is closed; make another one"):
            call()


def test_a_bin_that_no_throw_reaches_is_told():
    near, far = {"name": "near", "x": 0.1, "y": 0.4}, {"name": "far", "x": 0.0, "y": 3.5}
    with pytest.warns(UserWarning, match=r"bin 'far' at x 0.0 m, y 3.5 m stays empty: none of 50 trial throws"):
        PnTConveyorEnv(level={"bins": {"fixed": [near, far]}})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        PnTConveyorEnv(level={"bins": {"fixed": [near]}})
