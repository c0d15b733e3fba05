"""Import of the command modules: inside the installed package, or next to the package in a checkout."""

from __future__ import annotations

import importlib
import importlib.util
from pathlib import Path
from typing import Any, cast


def command_module(name: str) -> Any:
    """The module `agents.NAME`, for instance "judging.evaluation"."""
    inside = importlib.util.find_spec("pnt_gym.agents") is not None
    return importlib.import_module(f"{'pnt_gym.' if inside else ''}agents.{name}")


def evaluate(policy: Any, env: Any, picks: int = 200, seed: int = 0, **options: Any) -> dict[str, Any]:
    """Evaluate a policy on held-out throws; every argument as for `agents.judging.evaluation.evaluate`.

    Args:
        policy: a function of observations as the vector environment gives them, an array (N, D) or a mapping of arrays,
            that returns actions (N, A) within [-1, 1]; a controller, a model of stable-baselines3, or a controller's
            name.
        env: an id, or an environment.
        picks: throws to count, at least 1.
        seed: of the evaluation's objects; no training or practice with any seed sees these objects.
        options: practice, online and progress; level, action_mode, num_envs and threads of an id.

    Returns:
        Figures by name, and `throws`, a mapping for each throw.

    Raises:
        PntGymError: the policy or the environment is unknown, the two do not fit, or no throws are asked for.
    """
    return command_module("judging.evaluation").evaluate(policy, env, picks, seed, **options)


def compare(a: Any, b: Any, env: Any, budget: int | None = None, seed: int = 0, **options: Any) -> dict[str, Any]:
    """Compare two policies on the same held-out throws until their order is settled.

    Every argument is as for `agents.judging.comparison.compare`.

    Args:
        a: a policy as `evaluate` takes it.
        b: a policy with another name.
        env: an id, or an environment.
        budget: largest number of throws of each policy; None for the default of the environment.
        seed: of the objects; no training, practice or evaluation with any seed sees these objects.
        options: others, figures, margin, cap, practice, trust and progress; level, action_mode, num_envs and threads of
            an id.

    Returns:
        `sentences`, and for each of `pairs` the difference a - b of each figure with its interval.

    Raises:
        PntGymError: a policy, the environment or a figure is unknown, or a number has no meaning.
    """
    return command_module("judging.comparison").compare(a, b, env, seed, budget=budget, **options)


def sb3_vec_env(env: Any, **options: Any) -> Any:
    """The fast vector form of an environment as a VecEnv of stable-baselines3.

    Args:
        env: an id, or a vector environment in the autoreset mode `SameStep`.
        options: of an id: level, num_envs, threads and action_mode.

    Returns:
        A `VecEnv`, whose `infos` also have `is_success`, `landing_error` and `cycle_time` of every throw, and of every
        episode that ends `episode` and `terminal_observation`. sb3-contrib finds the masks of `PnTLine-v0` in it.

    Raises:
        PntGymError: the id or an option is unknown, or the environment is no such vector environment.
    """
    return command_module("learning.vec_env").open_cells(env, **options)


def fit(log: str | Path, level: str | Path = "waste", **options: Any) -> dict[str, Any]:
    """Fit a conveyor level to a log of throws.

    Every argument is as for `agents.fit.report.fit`.

    Args:
        log: CSV file with a row for each throw.
        level: name or file of the level about whose values the priors lie.
        options: free, names of the unknown parameters; prior, standard deviations by name.

    Returns:
        Estimates with intervals, tests of the model, sentences, and `differences`, a level's sections that differ.

    Raises:
        PntGymError: the log or the level does not describe throws of one cell.
    """
    return command_module("fit.report").fit(log, level, **options)


def plan_line(level: str | Path = "skills3", **options: Any) -> dict[str, Any]:
    """Judge plans of a line of robots over one stream of objects.

    Every argument is as for `agents.line.verdict.plan_line`.

    Args:
        level: name or file of a level of the line.
        options: recovery, release, robots, speeds, percents, skills, minutes, burst and down; controller, shifts, seed,
            throws, tables, check and threads.

    Returns:
        `plans`, the figures of each plan; and `sentences`: the plan that is enough or the best one, some of its shifts
        in the full physics, and the reason why it does not sort more.

    Raises:
        PntGymError: the level, a plan or an option is unknown or impossible.
    """
    return command_module("line.verdict").plan_line(level, **options)


def shipped_policy(name: str) -> Path:
    """The folder, or the file of a scorer, of a policy that ships.

    Args:
        name: name that `pnt-gym controllers` lists, such as "waste-sac".

    Raises:
        PntGymError: no shipped policy has this name.
    """
    shipped = command_module("ground.shipped")
    return cast("Path", shipped.place(f"{shipped.PREFIX}{str(name).removeprefix(shipped.PREFIX)}"))
