"""The values of the sentences with which pages of results begin; the sentences are templates in `questions.yaml`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import itemgetter
from typing import Any, Final

import numpy as np

from ..controllers.named import CHEATS
from ..dispatchers.settings import PLANNERS
from ..ground import metrics
from ..ground.looks import reader_name
from ..judging.throw_record import ThrowRecord
from ..reproduce.record import verdicts
from ..results.study import shipped_study
from . import line
from .headline import FITTED, LOGGED
from .tables import first_level, name_of, rows_of
from .templates import NoFigure, mm, number

Data = Mapping[str, Any]

KEYS: Final = ("label", "throws")
"""What names a controller in a benchmark."""
STUDY: Final = ("rows", "throws")
"""Keys of a study's results."""


def difference(data: Data, level: str, learner: Data, reference: Data) -> str:
    """The difference in sorted objects per minute, with its paired interval where the two had the same objects."""
    pace = interval(data, level, learner, reference)
    if pace is None:
        return f"{learner['sorted_per_min'] - reference['sorted_per_min']:+z.1f}"
    text = f"{pace.value:+z.1f}, 95 % interval {pace.low:+.1f} to {pace.high:+.1f}"
    return text if pace.excludes_zero else f"{text}, not distinguishable"


def interval(data: Data, level: str, learner: Data, reference: Data) -> metrics.Interval | None:
    """The paired difference in sorted objects per minute, of plan or throws; None where the objects differ."""
    for row in data["comparisons"]:
        sides = (row["learned"], learner), (row["reference"], reference)
        if row["level"] == level and all(side[name] == whole[name] for side, whole in sides for name in KEYS):
            return metrics.Interval(*(row["sorted_per_min"][name] for name in ("value", "low", "high")))
    results = [result for result in data.get("results", ()) if result["level"] == level]
    one, other = ([r for r in results if all(r[k] == row[k] for k in KEYS)] for row in (learner, reference))
    objects = [ThrowRecord.objects(side[0]["columns"]) for side in (one, other) if side]
    if len(objects) < 2 or objects[0] != objects[1]:
        return None
    columns = (ThrowRecord.paired_columns(side, (one, other), data["plan"]["num_envs"]) for side in (one, other))
    means = [[np.mean(column, axis=0) for column in side["sorted_per_min"]] for side in columns]
    return metrics.rate_difference(*means[0], *means[1])


Results = Mapping[str, Any]
Values = dict[str, Any]
PLANNER: Final = "analytic planner"
EFFECTS: Final = ("picks fail", "classes wrong", "bins fill", "all three")
"""Cases of the study `judged` that add one effect, or three, to the plain cell."""
METHODS_AT: Final = ("waste", 40)
"""Level and percentage of the limits at which methods are compared in a sentence."""
SAFETY: Final = 1.5
"""Grip margin whose price is told."""
LOSSES: Final = {
    "share_unpicked": "failed picks",
    "share_missed": "throws beside the opening",
    "share_rim": "objects that did not stay in the bin",
    "share_dropped": "objects that the cup lost",
    "share_astray": "objects in a bin of another kind",
}
"""Outcomes of a pick that is not sorted."""


def learning(results: Results) -> Values:
    """The best learner, the first that adds anything to the planner, and the planner that was fitted to a log."""
    data = _read(results, "benchmark")
    level, rows = first_level(data)
    planner = _row(rows, "analytic")
    fitted = [row for row in rows if row["label"] == FITTED]
    learned = sorted((row for row in _rows(rows) if row not in fitted), key=lambda row: (row["throws"], -_pace(row)))
    winner = max(learned, key=_pace)
    ahead = ((row, interval(data, level, row, planner)) for row in learned)
    return {
        "level": level,
        "planner": planner,
        "oracle": _row(rows, "oracle"),
        "winner": winner,
        "first": next((row for row, gain in ahead if gain is not None and gain.low > 0.0), None),
        "fitted": next((row for row in fitted if row["throws"] == LOGGED), None),
        "gain": lambda one, other: difference(data, one["level"], one, other),
    }


def drift(results: Results) -> Values:
    """A static policy with and without drift, the best controller that adapts, and the share that it wins back."""
    data = _read(results, "benchmark_adapt")
    level, rows = first_level(data)
    static, oracle = _row(rows, "static"), _row(rows, "oracle_drift")
    adapting = [row for row in _rows(rows) if row["controller"] not in ("static", "oracle_drift")]
    if not adapting:
        raise NoFigure("no controller adapts")
    winner = min(adapting, key=_error)
    return {
        "level": level,
        "static": static,
        "calm": next((row for row in data["table"] if row["label"] == "static" and row["level"] != level), None),
        "winner": winner,
        "oracle": oracle,
        "share": (_error(static) - _error(winner)) / (_error(static) - _error(oracle)),
    }


def grasp(results: Results) -> Values:
    """The middle, a tuned rule, networks and an oracle of grasps, on seen and on unseen kinds."""
    data = _read(results, "benchmark_grasp")
    level, rows = first_level(data)
    names = {"rule": "flattest", "network": "local_mlp", "depth": "local_mlp_depth"}
    unseen = {name: rows_of(data, [name]) for name in data["plan"]["levels"] if name != level}
    return {
        "level": level,
        "middle": _row(rows, "centre"),
        "rule": _row(rows, "flattest"),
        "network": _row(rows, "local_mlp"),
        "rewarded": next((row for row in rows if row["label"] == "fitted_q"), None),
        "ceiling": _ceiling(rows),
        "unseen": [
            {"level": name, **{role: _row(of, label) for role, label in names.items()}, "ceiling": _ceiling(of)}
            for name, of in unseen.items()
        ],
        "gain": lambda one, other: difference(data, one["level"], one, other),
    }


def _ceiling(rows: Sequence[Data]) -> Values:
    """The oracle of grasps, the best of all others, and its share of what the oracle gains on the middle."""
    oracle, middle = _row(rows, "oracle_grasp"), _row(rows, "centre")
    best = max((row for row in rows if row["controller"] not in CHEATS), key=_pace)
    share = (_pace(best) - _pace(middle)) / (_pace(oracle) - _pace(middle))
    return {"oracle": oracle, "best": best, "share": share}


def order(results: Results) -> Values:
    """Where the gain of the best order over first in, first out is least and most, and who leads the planners."""
    data = _read(results, "benchmark_line")
    levels = {level: rows_of(data, [level]) for level in data["plan"]["levels"]}
    found = [best for rows in levels.values() if (best := _best(rows)) is not None]
    gains = sorted(found, key=lambda best: line.interval(line.value(best["top"]), line.value(best["first"])).value)
    if not gains:
        raise NoFigure("no level has first in, first out and a rule to compare with")
    pairs = [
        {
            "level": level,
            "won": won,
            "plan": plan,
            "share": line.interval(line.value(won), line.value(plan)).value / 100.0,
        }
        for level, rows in levels.items()
        if (won := line.best(line.learners(rows))) is not None and (plan := line.best(rows, PLANNERS)) is not None
    ]
    planners = sorted({f"`{pair['plan']['label']}`" for pair in pairs})
    return {
        "least": gains[0],
        "most": gains[-1],
        "gain": lambda one, other: line.gain(line.value(one), line.value(other)),
        "planner": f"the planner {planners[0]}" if len(planners) == 1 else "the best planner",
        "beaten": [pair["level"] for pair in pairs if pair["share"] > 0.0],
        "lead": max(pairs, key=lambda pair: pair["share"], default=None),
        "count": len(pairs),
    }


def _best(rows: Sequence[Data]) -> Values | None:
    """First in, first out, the best class-blind rule and the best of all on a level; None where one is missing."""
    rows = [row for row in rows if "shifts" in row]
    sorts = {"first": (line.FIRST,), "blind": line.CLASS_BLIND, "top": None}
    best = {sort: line.best(rows, names) for sort, names in sorts.items()}
    return None if None in best.values() else {"level": rows[0]["level"], **best}


def losses(results: Results) -> Values:
    """The planner and the best learner, of which it is told how many picks end where."""
    level, rows = first_level(_read(results, "benchmark"))
    return {"level": level, "planner": _row(rows, "analytic"), "winner": max(_rows(rows), key=_pace)}


def reality(results: Results) -> Values:
    """The fitted cube and square, the cube of another material, and two bounds on the rises of the square."""
    rows = _read(results, "reality", STUDY)["rows"]
    contacts = {(row.get("part"), row.get("contact")): row for row in rows}
    bounds = {row.get("restitution"): row for row in rows if row.get("body") == "square"}
    return {
        "cube": _case(contacts, ("cube", "fitted on other tosses")),
        "other": _case(contacts, ("cube", "of a box in the catalogue")),
        "square": _case(contacts, ("square", "fitted on other drops")),
        "bound": _case(bounds, max(bounds)),
        "low": _case(bounds, 0.35),
    }


def cells(results: Results) -> Values:
    """The paces of the shipped policy and of a learner over the values of assumed numbers, and what adapting wins."""
    paces = controller_paces(_read(results, "assumed", STUDY)["rows"])
    shipped, learned = (_case(paces, name) for name in ("waste-sac", "MLP"))
    worst = min(shipped, key=lambda number: shipped[number])
    drawn = _read(results, "cells", STUDY)["rows"]
    return {
        "shipped": shipped,
        "learned": learned,
        "worst": worst,
        "usual": _case(shipped, "as assumed"),
        "won": {part: _won_by_adapting(drawn, part) for part in ("cells", "cells_far")},
    }


def _won_by_adapting(rows: Sequence[Data], part: str) -> Data:
    """Share of what practice in each cell wins that the filter wins from the 11th throw on, with its interval."""
    found = [row for row in rows if (row["part"], row["controller"], row["window"]) == (part, "posterior", 10)]
    if not found:
        raise NoFigure(f"no row of the filter in {part}")
    cells, least, most = (np.concatenate([row[name] for row in found]) for name in ("cells", "least", "most"))
    return vars(metrics.share_won(cells[:, :2], least, most))


def controller_paces(rows: Sequence[Data]) -> dict[str, dict[str, float]]:
    """Mean pace over seeds by controller, and by the number of the cell that is another."""
    paces: dict[str, dict[str, list[float]]] = {}
    for row in rows:
        paces.setdefault(str(row.get("controller")), {}).setdefault(str(row.get("number")), []).append(_pace(row))
    return {name: {number: float(np.mean(pace)) for number, pace in of.items()} for name, of in paces.items()}


def sorter(results: Results) -> Values:
    """The shipped policy in the cell of boxes: where nothing fails, with each effect, and with all of them."""
    data = _read(results, "judged", STUDY)
    rows = [row for row in data["rows"] if row.get("controller") != PLANNER and row.get("level") == "boxes"]
    cases = {row.get("case"): row for row in rows}
    effects = [row for case, row in cases.items() if case in EFFECTS]
    return {"whole": _case(cases, "nothing fails"), "honest": _case(cases, "the honest cell"), "effects": effects}


def cup(results: Results) -> Values:
    """What the cup loses without care on each level, and with a safety of the grip on one."""
    data = _read(results, "grip", STUDY)
    rows = [row for row in data["rows"] if "safety" in row]
    waste = {row["safety"]: row for row in rows if row.get("level") == "waste"}
    careless = [row for row in rows if row["safety"] is None]
    return {"careless": careless, "plain": _case(waste, None), "careful": _case(waste, SAFETY), "safety": SAFETY}


def methods(results: Results) -> Values:
    """The ways to the bin by what each sorts per minute, on one level at one share of the robot's limits."""
    rows = [row for row in _read(results, "methods", STUDY)["rows"] if row["part"] == "belt"]
    rows = [row for row in rows if (row["level"], row["percent"]) == METHODS_AT]
    if not rows:
        raise NoFigure("no method at these limits")
    level, percent = METHODS_AT
    ordered = sorted((row for row in rows if "sorted_per_min" in row), key=_pace, reverse=True)
    return {"level": level, "percent": percent, "rows": ordered, "titles": shipped_study("methods").names["planner"]}


def flight(results: Results) -> Values:
    """The levels on which flights and full physics differ most, in landings and in success, and half of the levels."""
    rows = [
        row for row in _read(results, "fidelity", STUDY)["rows"] if {"landing_p95_m", "success_differs"} <= set(row)
    ]
    if not rows:
        raise NoFigure("no flights beside full physics")
    farthest, differs = (max(rows, key=lambda row: row[name]) for name in ("landing_p95_m", "success_differs"))
    near = sorted(row["landing_p95_m"] for row in rows)[len(rows) // 2]
    return {"near": near, "farthest": farthest, "differs": differs}


def papers(results: Results) -> Values:
    """The papers by their titles, and how many of their published figures came out with which verdict."""
    record = results["reproduction"]
    if not {"papers", "titles"} <= set(record):
        raise NoFigure("no papers, only rows of published figures")
    return {"papers": [(record["titles"][paper], counts) for paper, counts in verdict_counts(record).items()]}


def verdict_counts(record: Data) -> dict[str, dict[str, int]]:
    """Verdicts on published figures by paper; figures of the project's own conditions are not counted."""
    tables = {paper: verdicts(record, paper) for paper in record["papers"]}
    return {
        paper: {name: int(count) for name, count in table.rows if not name.startswith("ours")}
        for paper, table in tables.items()
    }


def single_and_vector(rows: Iterable[Data]) -> tuple[Data, Data]:
    """Speeds of a level with a single environment, and with the most cells and threads."""
    by_size = sorted(rows, key=itemgetter("cells", "threads"))
    return by_size[0], by_size[-1]


def speed(results: Results) -> Values:
    """The main environment on the level of waste, a single one and a vector with most threads; the planner's times."""
    rows = results["perf_envs"]["envs"]["PnTConveyor-v0"]["rows"]
    single, vector = single_and_vector(row for row in rows if row["level"] == "waste")
    return {"single": single, "vector": vector, "planner": results["perf_planner"]}


def _read(results: Results, name: str, keys: Sequence[str] = ("plan", "table", "comparisons")) -> Data:
    """Results of a benchmark, or with the keys of a study those of a study.

    Raises:
        NoFigure: the file of this name holds other results.
    """
    if not set(keys) <= set(results[name]):
        raise NoFigure(f"no keys {', '.join(keys)}")
    return results[name]


def _case(rows: Mapping[Any, Data], case: object) -> Data:
    """The row of a case of a study.

    Raises:
        NoFigure: the study lacks the case.
    """
    if case not in rows:
        raise NoFigure(f"no case {case!r}")
    return rows[case]


def _row(rows: Sequence[Data], label: str) -> Data:
    """The last row of a controller: the one that has learned from the most throws.

    Raises:
        NoFigure: the controller has no row.
    """
    matches = [row for row in rows if row["label"] == label]
    if not matches:
        raise NoFigure(f"no row of {label!r}")
    return matches[-1]


def _rows(rows: Sequence[Data]) -> list[Data]:
    """Rows of controllers that have learned from throws, without noise floors.

    Raises:
        NoFigure: there are none.
    """
    learned = [row for row in rows if row["throws"] > 0 and not row["label"].startswith("floor")]
    if not learned:
        raise NoFigure("no controller has learned")
    return learned


def _pace(row: Data) -> float:
    """Sorted objects per minute."""
    return _number(row, "sorted_per_min")


def _error(row: Data) -> float:
    """Mean landing error [m]."""
    return _number(row, "landing_error_mean_m")


def _number(row: Data, name: str) -> float:
    """A figure of a row.

    Raises:
        NoFigure: the plan does not measure the figure.
    """
    if name not in row:
        raise NoFigure(f"no figure {name!r}")
    return float(row[name])


def _losses(row: Data) -> str:
    """Where the picks of a controller end that are not sorted, the largest share first."""
    shares = {name: 100 * row[key] for key, name in LOSSES.items() if row.get(key)}
    ordered = sorted(shares.items(), key=lambda share: -share[1])
    return ", ".join(f"{share:.1f} % {name}" for name, share in ordered)


def _named(label: str) -> str:
    """The identifier of a controller, with the name that a reader knows in brackets."""
    name = reader_name(label)
    return f"`{label}` ({name})" if name else f"`{label}`"


WORDS: Final[Mapping[str, Callable[[Data], str]]] = {
    "pace": lambda row: number(_pace(row)),
    "error": lambda row: mm(_error(row)),
    "after": lambda row: f"{_named(row['label'])} after {row['throws']:,} throws",
    "name": name_of,
    "losses": _losses,
}
"""What the templates of all answers call to write about a row."""
