"""A benchmark of lines: whole shifts instead of throws, worked by whoever decides what comes next.

Shift k of a level has the same stream for all, so controllers are compared shift by shift.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.chances import needed, written
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.reading import MOST_NUMBERS, bytes_of

from ..controllers.protocol import Controller
from ..dispatchers.registry import GUIDED, line_controller, the_line
from ..dispatchers.scored import Scored
from ..dispatchers.settings import PLANNERS, rate, settings
from ..ground import metrics
from ..ground.cli import UsageError
from ..ground.environments import Env, stream_seed
from ..ground.files import jsonable
from ..ground.places import at
from ..judging.work_shifts import LISTS, MEANS, Shifts, mean
from ..learning.runs import CHOOSING, POLICY
from ..lessons.search import SEARCHED, Bench, best
from ..policies.scorer import Scorer

SHIFTS: Final = 100
"""Of a plan that does not say how many."""
COMPARED: Final = ("value_per_min", "sorted_per_min", "recovery", "value_recovery")
"""Figures of shifts by which controllers are compared."""
FOUND: Final = "index"
"""The controller that is searched for where its entry has decisions to learn from, and is else the one that ships."""
ENDS: Final = 64
"""Shifts by which such a search compares its end with its beginning, as in `agents.line tune`."""
SLOW: Final = 20
"""Decisions of a rule that take as long as one of a planner."""
DIGITS: Final = 5
"""To which figures of shifts are kept."""


def is_learned(name: str) -> bool:
    """Whether an entry names what was learned before, a scorer's file or the path of a run folder."""
    return ":" not in name and (name.endswith(".npz") or "/" in name)


def controller(label: str, name: str, env: Env, options: Mapping[str, Any]) -> Controller:
    """The controller of an entry at some lines.

    Raises:
        UsageError: there is none of that name, or it has other settings than those.
    """
    try:
        return line_controller(name, the_line(env), **options)
    except TypeError:
        raise UsageError(f"entry {label!r}: controller {name!r} has no settings {', '.join(options)}") from None


def searched(level: LineConfig, decisions: int, seed: int) -> Controller:
    """The index that a search from the ATC rule ends with, after whole generations of about so many decisions."""
    from ..lessons import scores as searching  # noqa: PLC0415 - needs a library that only it does

    first = stream_seed("practice", seed)
    bench = Bench(level, np.arange(first, first + ENDS))
    generations = -(-decisions // _decisions(level, SEARCHED))
    tried = searching.searched(bench, settings(level.name, "atc")["patience"], generations, seed)
    return Scored(FOUND, Scorer.linear(**best(tried).settings))


def depends(name: str, levels: Sequence[LineConfig], options: Mapping[str, Any]) -> dict[str, Any]:
    """What figures depend on beside code and levels: settings that were tuned, tables of throws, what was learned.

    Args:
        name: the controller.
        levels: that it learns and works on.
        options: settings that its entry gives it.
    """
    tuned: list[Any] = [settings(level.name, name, len(level.robots)) for level in levels]
    if name == FOUND:
        tuned += [settings(level.name, "atc") for level in levels]
    if name in CHOOSING:
        tuned = [(settings(level.name, "atc"), rate(level.name)) for level in levels]
    tables = [hashlib.sha256(written(needed(level)).encode()).hexdigest() for level in levels]
    learned = [_learned(name)] if is_learned(name) else []
    learned += [depends(guide, levels, {}) for guide in guides(name, levels, options)]
    return {"tuned": tuned, "tables": tables, "learned": learned}


def guides(name: str, levels: Sequence[LineConfig], options: Mapping[str, Any]) -> list[str]:
    """Whose scores guide a controller on each level, if it is guided."""
    if name != GUIDED:
        return []
    told = [settings(level.name, name, len(level.robots)) for level in levels]
    return [str({**own, **options}.get("guide", FOUND)) for own in told]


def _learned(name: str) -> str:
    """Digest of what was learned."""
    place = at(name)
    return hashlib.sha256(bytes_of(place / POLICY if place.is_dir() else place, MOST_NUMBERS)).hexdigest()


def effort(name: str, level: LineConfig, shifts: int, rows: int) -> int:
    """Decisions in some shifts; of planners as many as rules take in their time.

    Args:
        name: the controller.
        level: where it works.
        shifts: at least so many.
        rows: lines side by side, all of which work until all are done.
    """
    return _decisions(level, -(-shifts // rows) * rows) * (SLOW if name in PLANNERS else 1)


def _decisions(level: LineConfig, shifts: int) -> int:
    """In some shifts, about one a second by each robot."""
    return int(level.duration) * len(level.robots) * shifts


def columns(found: Shifts, core: LineCore) -> dict[str, Any]:
    """Shifts as columns, and what all of their decisions have in common."""
    told, picked = found.told, found.decisions["picked"].astype(bool)
    success = found.decisions["is_success"].astype(bool)
    return {
        **{name: jsonable(np.round(told[key], DIGITS)) for name, key in {**MEANS, **LISTS}.items()},
        "items": list(core.item_names),
        "robots": [robot.name for robot in core.config.robots],
        "picks": len(picked),
        "picked": int(picked.sum()),
        "success": int(success.sum()),
        "invalid": found.invalid,
        "ms_per_decision": round(1e3 * found.seconds / found.taken, 4),
    }


def figure(result: Mapping[str, Any], name: str) -> Floats:
    """A figure of each shift (S,), or of each by item or robot (S, K); NaN where there is none."""
    return np.array(result["columns"][name], dtype=np.float64)


def summarise(results: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Figures of one controller over its seeds, each of which has worked the same shifts.

    The interval of the value is bootstrapped over shifts, averaged over the seeds.
    """
    first, all_of = results[0]["columns"], [result["columns"] for result in results]
    value = _shiftwise(results, "value_per_min")
    each = metrics.mean_interval(value.mean(axis=0))
    picks, picked = (sum(one[name] for one in all_of) for name in ("picks", "picked"))
    return {
        "seeds": [result["seed"] for result in results],
        "shifts": value.shape[1],
        **{name: jsonable(mean(np.concatenate(_shiftwise(results, name)))) for name in (*MEANS, *LISTS)},
        "value_per_min_low": each.low,
        "value_per_min_high": each.high,
        "value_per_min_by_seed": value.mean(axis=1).tolist(),
        "by_shift": {name: jsonable(_shiftwise(results, name).mean(axis=0)) for name in COMPARED},
        "items": first["items"],
        "robots": first["robots"],
        "pick_rate": picked / picks,
        "success_rate": sum(one["success"] for one in all_of) / picks,
        "invalid_actions": sum(one["invalid"] for one in all_of),
        "ms_per_decision": float(np.mean([one["ms_per_decision"] for one in all_of])),
        "learn_seconds": float(np.mean([result["learn_seconds"] for result in results])),
    }


def compared(results: Sequence[Mapping[str, Any]], shifts: int) -> dict[str, tuple[Floats]]:
    """What is compared with others that have worked so many of these shifts, each (seeds, shifts)."""
    return {name: (_shiftwise(results, name)[:, :shifts],) for name in COMPARED}


def _shiftwise(results: Sequence[Mapping[str, Any]], name: str) -> Floats:
    """A figure of each seed and shift (seeds, S), or of each by item or robot (seeds, S, K)."""
    return np.array([figure(result, name) for result in results])
