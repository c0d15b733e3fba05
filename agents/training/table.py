"""The table at the end of a training: the policy and other controllers on the same held-out units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.files import write_json
from ..ground.tables import console
from ..judging.evaluation import evaluate_all
from ..judging.trial import Trial
from ..learning.runs import RunFolder

SEED: Final = 0
"""Seed of the held-out units."""
TABLE: Final = "evaluation.json"
"""File of the table in the run folder."""


def show_table(trial: Trial, folder: RunFolder, steps: int, run_args: Mapping[str, Any]) -> None:
    """Evaluate the policy and its peers, print the table, and write the table to the run folder.

    Args:
        trial: trial of the training.
        folder: folder of the run.
        steps: number of steps that the policy has learned from.
        run_args: arguments of the training; `eval_picks` is the number of units of each controller, None for the
            default of the kind of trial.
    """
    asked = run_args["eval_picks"]
    count = trial.usual_table if asked is None else asked
    learned = trial.policy(folder, None, run_args, f"learned ({run_args['algo']})")
    entries = [(trial.controller(name), practice) for name, practice in trial.peers(run_args).items()]
    for controller, _ in [*entries, (learned, 0)]:
        controller.reset(run_args["seed"])
    rows = evaluate_all(
        trial, [(controller.name, controller, practice) for controller, practice in entries], count, SEED,
        practice_seed=run_args["seed"],
    )  # fmt: skip
    rows += evaluate_all(trial, [(learned.name, learned, steps)], count, SEED)
    title = f"{count} held-out {trial.unit} each, level {trial.core.config.name}; run folder {folder.path}"
    console().print(trial.record.comparison(title, rows, trial.reference))
    table = [{"controller": name, "throws": learned_from, **summary} for name, learned_from, summary in rows]
    write_json(folder.path / TABLE, table)
