"""Pages of the environments: facts from Gymnasium's registry, a moving picture, and the docstring as a manual."""

from __future__ import annotations

import contextlib
import inspect
import re
from functools import cache
from typing import Any, Final

import gymnasium as gym
from gymnasium.envs.registration import load_env_creator

import pnt_gym
from pnt_gym.cells.base.features import merge_numbered
from pnt_gym.errors import ConfigError

from .marks import table

BANDIT: Final = "contextual bandit"
SEQUENTIAL: Final = "sequential"
TIMED: Final = ("PnTLine-v0",)
"""Environments whose episodes last a time, and not a number of throws."""
STAGED: Final = ("PnTGrasp-v0",)
"""Environments in which a throw takes several steps."""

CAPTIONS: Final = {
    "PnTConveyor-v0": "waste off a moving belt",
    "PnTAdapt-v0": "the same in a cell that drifts",
    "PnTRelease-v0": "one throw of that robot",
    "OneJointThrow-v0": "a block through a state in the air",
    "OneJointSort-v0": "the block into one of three pallets",
    "OneJointAssembly-v0": "two parts that join",
    "PnTLine-v0": "several robots along one belt",
    "GripperToss-v0": "a gripper inside the platform",
    "PnTGrasp-v0": "see, grasp, throw",
}
"""Words under the pictures of the gallery."""
SHORT: Final = 200
"""Length of a section that is repeated rather than linked [characters]."""
COLUMNS: Final = 3
"""Number of columns of the gallery."""


@cache
def default_env(env_id: str) -> Any:
    """An environment at its defaults."""
    return gym.make(env_id).unwrapped


def kind(env_id: str) -> str:
    """Whether an episode is one decision, or decisions that follow from one another."""
    is_long = env_id in (*TIMED, *STAGED) or default_env(env_id).core.cell.episode > 1
    return SEQUENTIAL if is_long else BANDIT


def episode(env_id: str) -> str:
    """Length of an environment's episode, and how the episode ends."""
    core = default_env(env_id).core
    if env_id in TIMED:
        return f"{core.config.duration:g} s, then truncation"
    if env_id in STAGED:
        return f"1 object in up to {core.config.grasp.tries + 1} steps, then termination"
    throws = core.cell.episode
    ending = "termination" if core.terminates else "truncation"
    return f"{throws} throw{'s' * (throws > 1)}, then {ending}"


@cache
def levels(env_id: str) -> tuple[str, ...]:
    """Names of the shipped levels that an environment takes."""
    env, names = default_env(env_id), list[str]()
    for name in env.core.config.level_names():
        with contextlib.suppress(ConfigError):
            env.make_core(name, None, 1, 1)
            names.append(name)
    return tuple(names)


def summary(env_id: str) -> str:
    """The first line of an environment's manual."""
    return _manual(env_id).split("\n", 1)[0]


def _manual(env_id: str) -> str:
    return inspect.getdoc(load_env_creator(str(gym.spec(env_id).entry_point))) or ""


def page(env_id: str) -> str:
    """All of one environment."""
    env = default_env(env_id)
    facts = [
        ("Kind of task", f"{kind(env_id)}; an episode is {episode(env_id)}"),
        ("Actions", f"`{env.action_space}`, mode `{env.core.action_mode}`"),
        ("Observations", f"`{env.observation_space}`"),
        ("Levels", ", ".join(f"`{name}`" for name in levels(env_id))),
        ("One cell", f'`gymnasium.make("{env_id}")`'),
        ("Many", f'`gymnasium.make_vec("{env_id}", num_envs=64)`'),
    ]
    first = summary(env_id)
    caption = "a line at work, every throw simulated" if env_id in TIMED else "throws of a controller that has learned"
    picture = f"![{env_id}: {caption}](../pictures/{env_id}.webp)"
    return "\n\n".join([f"# {env_id}", first, picture, table(("", ""), facts), _sections(env_id)])


def _sections(env_id: str) -> str:
    """The sections of a manual; what the manual of an earlier environment says word by word is a link to it."""
    earlier = pnt_gym.ENV_IDS[: pnt_gym.ENV_IDS.index(env_id)]
    parts = _by_title(env_id)
    shown = [parts[""]]
    for title, text in ((title, text) for title, text in parts.items() if title):
        said = ((other, _by_title(other).get(title, "")) for other in earlier)
        other, known = next(((i, t) for i, t in said if len(t) > SHORT and text.startswith(t)), ("", ""))
        link = f"As in [{other}]({other}.md#{title.lower().replace(' ', '-')})." if other else ""
        shown.append("\n\n".join(part for part in (f"## {title}", link, text.removeprefix(known).strip()) if part))
    return "\n\n".join(part for part in shown if part)


@cache
def _by_title(env_id: str) -> dict[str, str]:
    """The sections of a manual by their titles; what stands before them has none."""
    before, *sections = re.split(r"^## ", _manual(env_id).partition("\n")[2], flags=re.MULTILINE)
    titled = (section.split("\n", 1) for section in sections)
    return {"": before.strip(), **{title: text.strip() for title, text in titled}}


def environment_table(folder: str) -> str:
    """A table of all environments; `folder` is where their pages lie, seen from the page of the table."""
    rows = [(f"[{i}]({folder}{i}.md)", kind(i), episode(i), summary(i)) for i in pnt_gym.ENV_IDS]
    return table(("environment", "kind", "episode", "task"), rows)


def hidden_table(env_id: str) -> str:
    """A table of the hidden values of a throw or a decision, which no observation contains."""
    rows = [
        (f"`{quantity.name}`", quantity.unit, quantity.meaning)
        for quantity in merge_numbered(default_env(env_id).core.cell.hidden)
    ]
    return table(("column", "unit", "what is true"), rows)


def gallery(_: str) -> str:
    """A moving picture of each environment, which leads to its page."""
    cells = [
        f"[![{i}](pictures/{i}.webp)](environments/{i}.md)<br>[{i}](environments/{i}.md)<br>{CAPTIONS[i]}"
        for i in pnt_gym.ENV_IDS
    ]
    return table([""] * COLUMNS, [cells[k : k + COLUMNS] for k in range(0, len(cells), COLUMNS)])
