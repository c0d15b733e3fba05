"""The tables in the environments' docstrings say what the code does; more of the line is in `envs/test_line.py`."""

import inspect
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import yaml

from pnt_gym.cells.base.canvas import RENDER_MODES, Picture
from pnt_gym.cells.base.cell import Cell
from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.base.request import MOST_DRAWS, REQUEST_OPTIONS
from pnt_gym.cells.base.sorting import Belt, SortingReward
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ActionScale, ConveyorConfig, Motion
from pnt_gym.cells.conveyor.observation import FEATURES as PICK_FEATURES
from pnt_gym.cells.conveyor.observation import FEEDBACK
from pnt_gym.cells.gripper import config as gripper
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.observation import FEATURES as TOSS_FEATURES
from pnt_gym.cells.one_joint import config as one_joint
from pnt_gym.cells.one_joint.cell import OneJointCell
from pnt_gym.cells.one_joint.observation import FEATURES as GOAL_FEATURES
from pnt_gym.envs.conveyor import PnTAdaptEnv, PnTConveyorEnv, PnTReleaseEnv
from pnt_gym.envs.gripper import GripperTossEnv
from pnt_gym.envs.line import PnTLineEnv
from pnt_gym.envs.one_joint import OneJointAssemblyEnv, OneJointSortEnv, OneJointThrowEnv
from pnt_gym.envs.vector import ThrowVectorEnv
from pnt_gym.names import keywords


@dataclass(frozen=True)
class Family:
    """Environments on one kind of cell."""

    cell: type[Cell[Any, Any, Any, Any]]
    envs: tuple[type, ...]
    features: tuple[Any, ...]
    reward: Any
    amounts: tuple[str, ...]
    """What each number of the default action moves at most."""
    raw: str
    """What the numbers of a raw action move."""
    scales: Mapping[str, str]
    """How terms of the reward read their errors."""

    @property
    def modes(self) -> dict[str, int]:
        return {name: len(mode.numbers) for name, mode in self.cell.modes.items()}


OFFSET, GOAL, TOSS = ActionScale(), one_joint.Action(), gripper.Action()
SORTING, AIMING, TOSSING = SortingReward(), one_joint.Reward(), gripper.Reward()
OF_THE_BELT: dict[str, Any] = {
    "cell": ConveyorCell,
    "reward": SORTING,
    "amounts": (f"{OFFSET.along:.2f} m", f"{OFFSET.across:.2f} m"),
    "raw": "{:g} along, {:g} sideways, {:g} up".format(*OFFSET.xyz),
    "scales": {
        "landing": f"landing error / {SORTING.landing_scale:g} m",
        "time": f"cycle time / {SORTING.time_scale:g} s",
    },
}
BELT = Family(envs=(PnTConveyorEnv, PnTReleaseEnv), features=PICK_FEATURES, **OF_THE_BELT)
DRIFTS = Family(envs=(PnTAdaptEnv,), features=(*PICK_FEATURES, *FEEDBACK), **OF_THE_BELT)
ARM = Family(
    OneJointCell,
    (OneJointThrowEnv, OneJointSortEnv, OneJointAssemblyEnv),
    GOAL_FEATURES,
    AIMING,
    (f"{GOAL.position:.2f} m", f"{GOAL.position:.2f} m", f"{GOAL.angle_deg:g} deg", f"{GOAL.speed:g} m/s"),
    f"{GOAL.release_angle_deg:g} deg of the arm, {GOAL.release_speed:g} rad/s of its speed, {GOAL.release_radius:g} m",
    {
        "position": f"landing error / {AIMING.position_scale:g} m",
        "angle": f"angle error / {AIMING.angle_scale_deg:g} deg",
        "speed": f"speed error / {AIMING.speed_scale:g} m/s",
    },
)
GRIPPER = Family(
    GripperCell,
    (GripperTossEnv,),
    TOSS_FEATURES,
    TOSSING,
    (f"{TOSS.along:.3f} m", f"{TOSS.across:.3f} m", f"{TOSS.opening:.3f} s"),
    "",
    {
        "landing": f"landing error / {TOSSING.landing_scale:g} m",
        "time": f"cycle time / {TOSSING.time_scale:g} s",
    },
)
FAMILY = {env: family for family in (BELT, DRIFTS, ARM, GRIPPER) for env in family.envs}
CONVEYOR = (*BELT.envs, *DRIFTS.envs)


@pytest.fixture(params=FAMILY, ids=lambda env: env.__name__)
def env_class(request):
    return request.param


def doc(env_class):
    return inspect.getdoc(env_class)


def section(env_class, title):
    found = re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", doc(env_class), flags=re.MULTILINE | re.DOTALL)
    assert found, f"no section {title!r}"
    return found[1]


def table(text):
    """Cells of the first Markdown table in a text, without its head."""
    lines = re.search(r"(?:^\|.*\n)+", text, flags=re.MULTILINE)[0].splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    assert set("".join(rows[1])) <= set("-: ")
    return rows[2:]


def words(env_class, title):
    """A section on one line, so that a sentence may be broken anywhere."""
    return " ".join(section(env_class, title).split())


@pytest.mark.parametrize("env_class", [*FAMILY, PnTLineEnv])
def test_the_sections_are_gymnasiums(env_class):
    titles = re.findall(r"^## (.*)$", doc(env_class), flags=re.MULTILINE)
    assert titles == [
        "Description", "Action Space", "Observation Space", "Rewards", "Starting State", "Episode End", "Arguments",
        "Version History",
    ]  # fmt: skip


def test_observation_rows_are_the_declared_ones(env_class):
    rows = table(section(env_class, "Observation Space"))
    features = FAMILY[env_class].features
    assert [row[1] for row in rows] == [feature.name for feature in features]
    for index, (row, feature) in enumerate(zip(rows, features, strict=True)):
        number, _, unit, meaning, centre, scale, low, high = row
        assert (int(number), unit, meaning) == (index, feature.unit, feature.meaning)
        assert (float(low), float(high)) == (-CLIP, CLIP)
        assert (float(centre), float(scale)) == (feature.centre, feature.scale)


def test_observation_rows_read_an_observation_back(env_class):
    """With no more than what the manual prints, an observation gives what the cell saw."""
    rows = table(section(env_class, "Observation Space"))
    env = env_class()
    observation, _ = env.reset(seed=0)
    centre, scale = np.array([[float(number) for number in row[4:6]] for row in rows]).T
    seen = np.array([float(feature.value(env.core.context)[0]) for feature in FAMILY[env_class].features])
    inside = np.abs(observation) < CLIP
    assert inside.sum() > 0.8 * len(rows)
    np.testing.assert_allclose(observation[inside], ((seen - centre) / scale)[inside], rtol=0, atol=1e-6)


@pytest.mark.parametrize("env_class", [*FAMILY, PnTLineEnv])
def test_the_observation_space_is_the_written_one(env_class):
    env = env_class()
    box = re.match(r"\s*`Box\((.*?), (.*?), \((\d+),\), (\w+)\)`", section(env_class, "Observation Space"))
    low, high, size, dtype = box.groups()
    assert env.observation_space == gym.spaces.Box(float(low), float(high), (int(size),), np.dtype(dtype).type)


def test_the_action_spaces_are_the_written_ones(env_class):
    """The first sentence gives a box for some modes, and after a semicolon one for the others."""
    clauses = words(env_class, "Action Space").split(". ")[0].split("; ")
    written = {}
    for clause in clauses:
        (box,) = re.findall(r"`Box\((\S+), (\S+), \((\d),\), (\w+)\)`", clause)
        written |= {mode: box for mode in re.findall(r"`(\w+)`", clause)}
    sizes = FAMILY[env_class].modes
    assert set(written) == set(sizes)
    for mode, (low, high, size, dtype) in written.items():
        space = gym.spaces.Box(float(low), float(high), (int(size),), np.dtype(dtype).type)
        assert env_class(action_mode=mode).action_space == space
        assert sizes[mode] == int(size)


def test_action_rows_have_the_amounts_of_the_config(env_class):
    family, rows = FAMILY[env_class], table(section(env_class, "Action Space"))
    assert [int(row[0]) for row in rows] == list(range(len(family.amounts)))
    for row, amount in zip(rows, family.amounts, strict=True):
        assert (float(row[2]), float(row[3])) == (-1.0, 1.0)
        assert amount in row[4]
    assert family.raw in words(env_class, "Action Space")


def test_reward_rows(env_class):
    rows = {row[0]: row for row in table(section(env_class, "Rewards"))}
    family = FAMILY[env_class]
    assert tuple(rows) == family.cell.reward_terms
    for name, (_, _, weight) in rows.items():
        assert float(weight) == getattr(family.reward, name)
    assert all(scale in rows[name][1] for name, scale in family.scales.items())


def expected_terms(info, weights):
    """What the tables of the manuals say, with the weights and scales of a level."""
    scaled = {
        "landing": ("landing_error", "landing_scale", 1.0),
        "time": ("cycle_time", "time_scale", 1.0),
        "position": ("landing_error", "position_scale", 1.0),
        "angle": ("angle_error", "angle_scale_deg", 180.0 / np.pi),
        "speed": ("speed_error", "speed_scale", 1.0),
    }
    terms = {"success": weights["success"] * info["is_success"]}
    for name, (error, scale, unit) in scaled.items():
        if name in weights:
            terms[name] = weights[name] * max(0.0, 1.0 - abs(info[error]) * unit / weights[scale])
    return terms


def test_the_shown_reward_is_a_level_that_does_what_is_said(env_class, tmp_path):
    (shown,) = re.findall(r"```yaml\n(.*?)```", section(env_class, "Rewards"), flags=re.DOTALL)
    assert len(shown.splitlines()) == 3
    (tmp_path / "mine.yaml").write_text(shown)
    changed, seen = yaml.safe_load(shown)["reward"], []
    default = FAMILY[env_class].reward.model_dump()
    assert all(changed[name] != default[name] for name in changed)
    for level, weights in (("nominal", default), (tmp_path / "mine.yaml", default | changed)):
        env, random = env_class(level=level), np.random.default_rng(0)
        env.reset(seed=2)
        for share in (0.0, 0.2, 0.2):
            *_, reward, _, _, info = env.step(share * random.uniform(-1.0, 1.0, env.action_space.shape))
            terms = expected_terms(info, weights)
            assert set(terms) == set(FAMILY[env_class].cell.reward_terms)
            assert {name: info[f"reward_{name}"] for name in terms} == pytest.approx(terms, abs=1e-12)
            assert reward == pytest.approx(sum(terms.values()), abs=1e-12)
            seen.append(info)
            env.reset()
    terms = [f"reward_{name}" for name in FAMILY[env_class].cell.reward_terms]
    assert any(seen[0][name] != seen[3][name] for name in terms)
    assert all(seen[0][name] == seen[3][name] for name in seen[0] if name not in terms)


def test_settings_of_the_reward_are_all_named(env_class):
    text = section(env_class, "Rewards")
    assert all(name in text for name in type(FAMILY[env_class].reward).model_fields)


def test_what_can_be_asked_for_is_named(env_class):
    text = words(env_class, "Arguments").partition("`reset(options=")[2]
    assert all(f'"{name}"' in text for name in REQUEST_OPTIONS)
    assert "`reset_mask`" in text
    if env_class in CONVEYOR:
        assert f"no throw meets in {MOST_DRAWS} draws" in text
    named = set(re.findall(r"`(\w+)`", text))
    if env_class not in (OneJointThrowEnv, GripperTossEnv):
        assert named & set(env_class().core.cell.target_names)


def test_the_infos_are_the_written_ones(env_class):
    """Both ways: what is named exists, and what exists is named."""
    text = words(env_class, "Rewards")
    terms = set(re.findall(r"`(reward_\w+)`", text))
    listed = text[text.index("`info` also has") :]
    named = set(re.findall(r"`(\w+)`", listed)) - {"info", "items"} | terms
    env = env_class()
    _, first = env.reset(seed=0)
    *_, info = env.step(np.zeros(env.action_space.shape))
    assert named == set(info)
    assert set(first) <= named


def defaults(form):
    """Defaults of the arguments of a class of environments, by name; a camera that is None changes nothing."""
    given = inspect.signature(form.__init__).parameters
    picture = {name: getattr(Picture(), name) for name in ("width", "height")} | {"camera": None}
    return {name: given[name].default if name in given else picture[name] for name in keywords(form.__init__)}


def test_arguments_are_those_of_the_constructors(env_class):
    rows = {row[0].strip("`"): row for row in table(section(env_class, "Arguments"))}
    single, vector = (defaults(form) for form in (env_class, ThrowVectorEnv))
    assert set(rows) == set(single) | set(vector)
    for name, (_, _, default, _) in rows.items():
        own = (single if name in single else vector)[name]
        if name == "threads":
            assert default == f"{own} (vector: {vector[name]})"
        else:
            assert default.strip("`") == (f'"{own}"' if isinstance(own, str) else str(own))
    for name in set(single) & set(vector) - {"threads"}:
        assert single[name] == vector[name]


def test_modes_and_views_are_all_named(env_class):
    rows = {row[0].strip("`"): row[3] for row in table(section(env_class, "Arguments"))}
    assert set(re.findall(r"`(\w+)`", rows["action_mode"])) == set(FAMILY[env_class].modes)
    assert set(re.findall(r"`(\w+)`", rows["render_mode"])) == set(RENDER_MODES)


def test_numbers_in_the_text_are_the_configs():
    belt, motion = Belt(), Motion()
    start = words(PnTConveyorEnv, "Starting State")
    assert f"{belt.spacing[0]:.2f} to {belt.spacing[1]:.2f} m apart" in start
    picks = ConveyorConfig.model_fields["picks_per_shift"].default
    assert f"`picks_per_shift` throws ({picks})" in words(PnTConveyorEnv, "Episode End")
    start = words(PnTReleaseEnv, "Starting State")
    assert f"x in [{belt.pick_x[0]:.2f}, {belt.pick_x[1]:.2f}] m" in start
    assert f"one {motion.reserve:.2f} m longer or shorter" in start
    near = one_joint.Tolerance()
    said = f"{1000 * near.position:g} mm, {near.angle_deg:g} deg and {near.speed:g} m/s"
    assert said in words(OneJointThrowEnv, "Rewards")


@pytest.mark.parametrize("env_class", [*ARM.envs, *GRIPPER.envs])
def test_the_shipped_levels_are_named(env_class):
    (named,) = re.findall(r"shipped level \(([^)]*)\)", section(env_class, "Arguments"))
    assert set(named.split(", ")) == set(env_class().core.config.level_names())


def test_nothing_is_said_of_a_mode_twice_differently():
    """The shared sections are the same text in both environments."""
    for title in ("Action Space", "Observation Space", "Rewards", "Arguments"):
        assert words(PnTConveyorEnv, title) == words(PnTReleaseEnv, title)
    assert words(PnTAdaptEnv, "Action Space") == words(PnTConveyorEnv, "Action Space")
    for title in ("Rewards", "Arguments"):
        assert words(PnTAdaptEnv, title).startswith(words(PnTConveyorEnv, title))
    for title in ("Action Space", "Observation Space"):
        assert len({words(env, title) for env in ARM.envs}) == 1
