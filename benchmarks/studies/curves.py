"""What learners are worth after numbers of throws, and against the mismatch: through the pieces of a benchmark."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from agents.benchmark.run import run_piece
from agents.results.compare import assemble
from agents.results.plan import Plan, pieces
from agents.results.study import Amount, Figures, Settings

JUDGED: Final = "judged"
"""Name of the level on which controllers are judged, in full physics."""
LEARNED: Final = "learned"
"""Name of the level on which they learn, in flights."""
KEPT: Final = ("landing_error_mean_m", "success_rate", "sorted_per_min", "learn_seconds")


def figures(settings: Settings, amount: Amount) -> list[Figures]:
    """What a controller is worth in full physics after each number of throws, of which it learned in flights.

    Args:
        settings: `level`; `seed` of the learning; and the keys of a benchmark's entry: `controller`, `throws`, ...
        amount: held-out throws.
    """
    table = _measure(settings, [_entry(settings, "learner")], amount)["table"]
    return [{"throws": row["throws"], **{name: row[name] for name in KEPT}} for row in table]


def gain(settings: Settings, amount: Amount) -> Figures:
    """What a learner gains on the analytic planner, throw by throw, with intervals.

    Args:
        settings: as for `figures`, with one number of throws and `seeds` instead of `seed`.
        amount: held-out throws.
    """
    entries = [_entry(settings, "learner"), {"label": "analytic", "controller": "analytic", "levels": [JUDGED]}]
    (throws,) = settings["throws"]
    pairs = {"learned": [{"label": "learner", "throws": throws}], "references": [{"label": "analytic"}]}
    data = _measure(settings, entries, amount, **pairs)
    rows = {row["label"]: row for row in data["table"]}
    (pair,) = data["comparisons"]
    return {
        "analytic_m": rows["analytic"]["landing_error_mean_m"],
        "learned_m": rows["learner"]["landing_error_mean_m"],
        **{name: {end: pair[name][end] for end in ("value", "low", "high")} for name in data["figures"]},
    }


def _entry(settings: Settings, label: str) -> dict[str, Any]:
    """The entry of a benchmark's plan that the settings describe."""
    own = {"env", "level", "seed", "seeds"}
    return {"label": label, "levels": [JUDGED], **{name: value for name, value in settings.items() if name not in own}}


def _measure(settings: Settings, entries: list[dict[str, Any]], amount: Amount, **pairs: Any) -> dict[str, Any]:
    """Table and comparisons of a plan of one level."""
    level = settings["level"]
    plan = Plan.model_validate(
        {
            "name": "curves",
            "env": settings["env"],
            "train_level": LEARNED,
            "levels": [JUDGED],
            "inline": {JUDGED: level, LEARNED: {**level, "fidelity": "flight"}},
            "picks": amount.throws,
            "seed": amount.seed,
            "seeds": settings.get("seeds") or [settings.get("seed", 0)],
            "entries": entries,
            **pairs,
        }
    )
    with TemporaryDirectory() as folder:
        results = [result for piece in pieces(plan) for result in run_piece(piece, Path(folder))["results"]]
    return assemble(plan, results)
