"""What a user gets wrong: one sentence that names the value, and an environment that still works afterwards."""

import warnings

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from pnt_gym.envs.conveyor import PnTConveyorEnv, PnTConveyorVectorEnv
from pnt_gym.errors import ActionError, ConfigError, OrderError
from tests.tools.throws import LINE, MODES, same_bits, same_step, zeros


def named(value):
    """What a test is called by: the value, but for where it happens to lie in memory."""
    return "object()" if type(value) is object else repr(value)


def sentence(caught, *parts):
    text = str(caught.value)
    assert isinstance(caught.value, ValueError)
    assert "\n" not in text
    for part in parts:
        assert part in text
    return text


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
        with pytest.raises(ActionError) as caught:
            hurt.step(action)
        sentence(caught, "action")
    assert same_step(hurt.step(zeros(env_id)), unhurt.step(zeros(env_id)))


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
        with pytest.raises(ActionError) as caught:
            hurt.step(actions)
        sentence(caught, "action")
    a, b = hurt.step(zeros(env_id, 2)), unhurt.step(zeros(env_id, 2))
    assert same_bits(a[0], b[0])
    assert same_bits(a[1], b[1])


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_unknown_settings(env_id):
    with pytest.raises(ConfigError) as caught:
        gym.make(env_id, level="nowhere")
    sentence(caught, "unknown level 'nowhere'", "nominal")
    with pytest.raises(ConfigError) as caught:
        gym.make(env_id, action_mode="telepathy")
    sentence(caught, "action_mode is 'telepathy'", *MODES[env_id])
    with pytest.raises(ConfigError) as caught:
        gym.make_vec(env_id, num_envs=2, action_mode="telepathy")
    sentence(caught, "action_mode is 'telepathy'")


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
@pytest.mark.parametrize("count", [0, -1])
def test_an_environment_needs_a_cell(env_id, count):
    with pytest.raises(ConfigError) as caught:
        gym.make_vec(env_id, num_envs=count)
    sentence(caught, str(count))


@pytest.mark.parametrize("value", [0, -2, "2", 1.5, None, True, [], 10**6, np.nan])
@pytest.mark.parametrize("name", ["num_envs", "threads"])
@pytest.mark.parametrize("env_id", ["PnTRelease-v0", "PnTAdapt-v0", "OneJointThrow-v0", "GripperToss-v0", *LINE])
def test_cells_and_threads_are_whole_numbers(env_id, name, value):
    with pytest.raises(ConfigError) as caught:
        gym.make_vec(env_id, **{"num_envs": 1, name: 10**9 if value == 10**6 and name == "num_envs" else value})
    sentence(caught, f"{name} is ", "it must be a whole number from 1 to")


@pytest.mark.parametrize(
    "level", [None, 5, [], b"", 1.5, object(), ("a", "b"), "x" * 300, "x" * 300 + ".yaml", "a\0b.yaml"]
)
@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_what_no_level_can_be(env_id, level):
    with pytest.raises(ConfigError) as caught:
        gym.make(env_id, level=level)
    sentence(caught, "level")


def test_a_message_stays_a_sentence_whatever_is_given():
    for level in ({"mismatch": 10**400}, {"mismatch": "x" * 10_000}, {"x" * 10_000: 1}, {"bins": [1] * 10_000}):
        with pytest.raises(ConfigError) as caught:
            gym.make("PnTConveyor-v0", level=level)
        assert len(sentence(caught)) < 300


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
    ],
)
def test_numbers_of_which_nothing_can_be_built(env_id, level):
    with pytest.raises(ConfigError) as caught:
        gym.make(env_id, level=level)
    assert len(sentence(caught)) <= 500


@pytest.mark.parametrize("mode", [[], 5, {}, b"release_point", ("release_point",)], ids=named)
@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_what_no_action_mode_can_be(env_id, mode):
    with pytest.raises(ConfigError) as caught:
        gym.make(env_id, action_mode=mode)
    sentence(caught, "action_mode is ", *MODES[env_id])


def test_unknown_render_modes():
    with pytest.raises(ConfigError) as caught:
        PnTConveyorEnv(render_mode="hologram")
    sentence(caught, "render_mode is 'hologram'", "rgb_array", "rgb_array_list", "human")
    with pytest.raises(ConfigError) as caught:
        PnTConveyorVectorEnv(2, render_mode="human")
    sentence(caught, "render_mode is 'human'", "rgb_array")


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
    with pytest.raises(ConfigError) as caught:
        make("PnTRelease-v0", **wrong)
    sentence(caught, said)


def test_a_window_needs_a_display(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    env = gym.make("PnTConveyor-v0", render_mode="human").unwrapped
    with pytest.raises(ConfigError) as caught:
        env.reset(seed=0)
    sentence(caught, "needs a display", "rgb_array")
    env.close()


@pytest.fixture(scope="module")
def both():
    return gym.make("PnTRelease-v0").unwrapped, gym.make_vec("PnTRelease-v0", num_envs=3).unwrapped


@pytest.mark.parametrize("seed", [1.5, -1, "5", True, object(), {}, np.nan], ids=named)
def test_a_seed_is_a_whole_number(both, seed):
    for env in both:
        with pytest.raises(ConfigError) as caught:
            env.reset(seed=seed)
        sentence(caught, "seed is ", "it must be a whole number, at least 0")
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
        with pytest.raises(ConfigError) as caught:
            env.reset(options=options)
        sentence(caught, "options is", "mapping")


@pytest.mark.parametrize("mask", [[True], "x", [1, 0, 1], [[True], [True, False]], None], ids=named)
def test_a_mask_has_a_truth_for_every_cell(both, mask):
    with pytest.raises(ConfigError) as caught:
        both[1].reset(options={"reset_mask": mask})
    sentence(caught, "reset_mask")


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


def test_unknown_arguments_are_named():
    with pytest.raises(TypeError, match="colour"):
        gym.make("PnTConveyor-v0", colour="red")
