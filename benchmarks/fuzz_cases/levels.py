"""Levels some of whose values were changed."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from dataclasses import asdict
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import gymnasium as gym
import numpy as np
import yaml

import pnt_gym
from agents.ground.environments import config_of
from benchmarks.fuzz_cases.basis import JUNK, Draws, Find, Refused, finite, refusable
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import PhysicsError
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD
from pnt_gym.robots.gripper.geometry import PROTOTYPE

MILD: Final = (0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 2.0, 3.0)
WILD: Final = (0.0, -1.0, 0.1, 5.0, 10.0, 30.0, 100.0, 1e3, 1e6, 1e12, 1e300, 1e-3, 1e-9)
OWN_ITEM: Final = {
    "name": "own", "shape": "box", "size": [0.05, 0.03, 0.03], "mass": 0.01, "drag": 0.9, "seal_force": 10.0,
    "com_depth": 0.5, "friction": 0.5, "rolling_friction": 1e-4, "restitution": 0.3, "opening_delay": 0.01,
    "source": "ours",
}  # fmt: skip
"""An item of a user's."""


def level_case(draws: Draws) -> str:
    """A level one to three of whose values were changed, thrown in twice."""
    env_id = draws.pick(pnt_gym.ENV_IDS)
    config: Any = type(config_of(env_id))
    level: dict[str, Any] = {"base": draws.pick(config.level_names())}
    full_level = whole_level(config, level["base"])
    for _ in range(draws.pick((1, 1, 2, 3))):
        change(draws, full_level, level)
    if "items" in full_level and draws.chance(0.1):
        item = change_value(draws, OWN_ITEM)
        level |= {"items": ["own"], "extra_items": [{**OWN_ITEM, **item} if isinstance(item, dict) else item]}
    if config is LineConfig and draws.chance(0.8):  # what goes by a table is refused as soon as the cell is another
        level["throws"] = "flight"
    subject = f"{env_id} level {level!r}"
    with contextlib.suppress(Refused), refusable(subject), level_source(draws, level) as level_argument:
        env = gym.make_vec(env_id, num_envs=2, level=level_argument, threads=1)
        try:
            throw_twice(subject, env, draws)
        except (
            PhysicsError
        ) as error:  # a ConfigError may come late: whether a goal is in reach is known when it is drawn
            raise Find(f"{subject}: taken, then {type(error).__name__}: {error}") from error
        finally:
            env.close()
    return subject


def hours_case(draws: Draws) -> str:
    """A line whose shift takes hours, with robots far from the origin, or so far that it must be refused."""
    base = draws.pick(LineConfig.level_names())
    robots, count = LineConfig.load(base).model_dump(mode="json")["robots"], 0
    where = float(draws.pick((-1.0, 1.0)) * 10.0 ** draws.number(0.0, 5.0))
    apart = 10.0 ** draws.number(0.3, 5.5)
    places = [where + k * apart for k in range(len(robots))]
    level = {
        "base": base,
        "name": "hours",
        "duration": draws.number(60.0, 4 * 3600.0),
        "robots": [{**robot, "x": x} for robot, x in zip(robots, places, strict=True)],
        **draws.pick(({}, {}, {"arrivals": {"rate": 0.1}})),
    }
    subject = f"PnTLine-v0 {base} duration {level['duration']} x {places}"
    with contextlib.suppress(Refused), refusable(subject):
        env = gym.make("PnTLine-v0", level=level)
        finite(subject, env.reset(seed=draws.integer(1000))[0])
        over = False
        while count < 20 and not over:
            choices = np.flatnonzero(env.unwrapped.action_masks())
            observation, reward, _, over, _ = env.step(int(draws.pick(choices)) if choices.size else 0)
            finite(subject, observation, reward)
            count += 1
        env.close()
    return subject


def throw_twice(subject: str, env: Any, draws: Draws) -> None:
    """Two throws in every cell, with numbers for results."""
    finite(subject, env.reset(seed=draws.integer(1000))[0])
    random = draws.generator()
    for scale in (0.3, 1.5):
        action = scale * random.uniform(-1.0, 1.0, env.action_space.shape)
        if env.action_space.dtype.kind == "i":
            action = random.integers(env.single_action_space.n, size=env.num_envs)
        observation, reward, *_ = env.step(action)
        finite(subject, observation, reward)


@contextlib.contextmanager
def level_source(draws: Draws, level: dict[str, Any]) -> Iterator[Any]:
    """A level as it is, or in a file of YAML, which may have been torn."""
    if draws.chance(0.7):
        yield level
        return
    try:
        text = yaml.safe_dump(level, allow_unicode=True)
    except yaml.YAMLError:
        yield level
        return
    if draws.chance(0.3):
        at = draws.integer(len(text))
        text = text[:at] + draws.pick(("", ":", "\t", "- ", "{", "!!int ", "&a ", "\0", "é", "#")) + text[at + 1 :]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "level.yaml"
        path.write_text(text, encoding="utf-8")
        yield path


@cache
def whole_level(config: Any, name: str) -> dict[str, Any]:
    """Every value of a shipped level, and those that it leaves to the prototype."""
    level = config.load(name).model_dump(mode="json")
    if config is GripperConfig:
        parts = {"dimensions": PROTOTYPE, "servo": PROTOTYPE_BUILD.servo, "claws": PROTOTYPE_BUILD.claws}
        level["robot"] |= {part: json.loads(json.dumps(asdict(part_values))) for part, part_values in parts.items()}
        level["robot"]["masses"] = {field: 0.02 for field in ("arm_mass", "rod_mass", "platform_mass", "half_mass")}
    return level


def change(draws: Draws, full_level: dict[str, Any], level: dict[str, Any]) -> None:
    """Change one value anywhere in a level: a number by a factor, or anything for anything else."""
    key = draws.pick([k for k in full_level if k != "name"])
    if draws.chance(0.03):
        level[draws.pick(("gravity", "", "BINS", 5, key + "s"))] = 1.0
    level[key] = change_value(draws, full_level[key])


def change_value(draws: Draws, value: Any) -> Any:
    """A value that is a little or altogether another."""
    if isinstance(value, dict) and value and draws.chance(0.95):
        key = draws.pick(value)
        new = {key: change_value(draws, value[key])}
        return {**new, "typo": 1.0} if draws.chance(0.03) else new
    if isinstance(value, list) and value and draws.chance(0.9):
        place = draws.integer(len(value))
        new_list = [*value[:place], change_value(draws, value[place]), *value[place + 1 :]]
        return draws.pick((new_list, new_list, new_list, new_list[:-1], [*new_list, new_list[0]], new_list[::-1]))
    if isinstance(value, int | float) and not isinstance(value, bool) and draws.chance(0.92):
        by = draws.pick(MILD if draws.chance(0.6) else WILD)
        return value * by if value else by
    return draws.pick(JUNK)
