"""Metadata of a dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from pnt_gym.cells.base.features import merge_numbered

from ..ground.versions import git_state, versions
from .crew import Crew
from .offline import Facts
from .tally import Scores

NEEDED: Final = ("pnt_gym", "mujoco", "gymnasium", "numpy", "scipy")
"""Packages whose versions decide whether throws are equal bit for bit."""


def facts_of(
    crew: Crew, scores: Scores, columns: Mapping[str, Sequence[str]], authorship: Mapping[str, str | None]
) -> Facts:
    """Metadata of a dataset, for Minari and of our own.

    Args:
        crew: the controllers of the dataset.
        scores: mean returns of random actions and of the expert.
        columns: names of the columns of the arrays in `infos`.
        authorship: `author`, `author_email` and `code_permalink` of Minari's metadata.
    """
    core = crew.trial.core
    minari = {
        "algorithm_name": crew.algorithm,
        **authorship,
        "ref_min_score": scores.lowest,
        "ref_max_score": scores.highest,
        "num_episodes_average_score": scores.episodes,
        "description": description(crew, scores, columns),
        "requirements": [f"{name}=={versions()[name]}" for name in NEEDED],
    }
    ours = {
        "seed": crew.seed,
        "num_envs": crew.trial.env.num_envs,
        "practice": crew.practice(crew.thrower),
        "noise": list(crew.noise),
        "expert": crew.expert,
        "items": list(core.item_names),
        "level": core.config.model_dump(mode="json"),
        "versions": versions(),
        "commit": (git_state() or "").partition("\n")[0] or None,
    }
    return Facts(minari, {"columns": columns, "pnt_gym": ours})


def description(crew: Crew, scores: Scores, columns: Mapping[str, Sequence[str]]) -> str:
    """Description of the dataset in words, for its metadata."""
    core = crew.trial.core
    quantities = merge_numbered(getattr(core.cell, "hidden", ()))
    hidden = "; ".join(f"{quantity.name} [{quantity.unit}], {quantity.meaning}" for quantity in quantities)
    parts = [
        f"Throws of {crew.env_id}, level {core.config.name}, action mode {core.action_mode}, by {crew.algorithm}"
        f"{_noise_text(crew)}.",
        "Reset the recovered environment with the seed of an episode and give it its actions: with the packages of "
        "`requirements`, observations and rewards are the same bit for bit.",
        "In `infos`, entry k + 1 is of throw k, and entry 0, of the reset, NaN or False; what a reset tells too is of "
        "the throw that follows: entry k belongs to observation k. `landing_error` is in metres.",
        f"Columns of `outcome`, as in the manual of the environment: {', '.join(columns['outcome'])}.",
        f"Columns of `hidden`, which no observation tells: {hidden}." if hidden else "",
        f"Score 0 is the mean return of random actions, score 1 that of {crew.expert}, on {scores.episodes} other "
        "episodes.",
    ]
    return " ".join(filter(None, parts))


def _noise_text(crew: Crew) -> str:
    """Noise on the actions in words; empty without noise."""
    deviations = ", ".join(f"{deviation:g}" for deviation in crew.noise)
    in_turn = ", in turn" if len(crew.noise) > 1 else ""
    return f" with normal noise on the actions (standard deviation {deviations}{in_turn})" if crew.noise else ""
