"""The sentences that pages of results begin with; every number in them is computed from the files of results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

from ..dispatchers.settings import PLANNERS
from ..grasping.scenes import HELD, PERCENT
from ..reproduce.record import verdicts
from ..results.study import shipped_study
from .line import CLASS_BLIND, FIRST, best, gain, learners, value
from .paired import difference, interval
from .tables import first_level, name_of, rows_of

Data = Mapping[str, Any]
Results = Mapping[str, Any]
PLANNER: Final = "analytic planner"
EFFECTS: Final = ("picks fail", "classes wrong", "bins fill", "all three")
"""Cases of the study `judged` that add one effect, or three, to the plain cell."""
METHODS_AT: Final = ("waste", 40)
"""Level and percentage of the limits at which methods are compared in a sentence."""
SAFETY: Final = 1.5
"""Grip margin whose price is told."""
NEARLY_ALL: Final = 0.9
"""Share of the gain of the best learner at which a learner has learned nearly all."""
LOSSES: Final = {
    "share_unpicked": "failed picks",
    "share_missed": "throws beside the opening",
    "share_rim": "objects that did not stay in the bin",
    "share_dropped": "objects that the cup lost",
    "share_astray": "objects in a bin of another kind",
}
"""Outcomes of a pick that is not sorted."""


class NoAnswer(LookupError):
    """The results lack a controller, a level or a case that an answer needs: they are of another plan."""


def learning(results: Results) -> str:
    """What the best learner adds to the analytic planner, the fewest throws that add anything and nearly as much."""
    data = _benchmark(results, "benchmark")
    level, rows = first_level(data)
    planner, oracle = _row(rows, "analytic"), _row(rows, "oracle")
    learned = _learner_rows(rows)
    winner = max(learned, key=_pace)
    enough = _pace(planner) + NEARLY_ALL * (_pace(winner) - _pace(planner))
    soonest = min((row for row in learned if _pace(row) >= enough), key=lambda row: (row["throws"], -_pace(row)))
    return (
        f"On `{level}`, {_after(winner)} sorts {_pace(winner):.1f} objects a minute and the analytic planner "
        f"{_pace(planner):.1f}: {difference(data, level, winner, planner)}. "
        f"{_first_ahead(data, level, learned, planner)} {_after(soonest)} reaches {_pace(soonest):.1f}. An oracle that "
        f"simulates each throw beforehand reaches {_pace(oracle):.1f}; `{winner['label']}` less the oracle is "
        f"{difference(data, level, winner, oracle)}."
    )


def _first_ahead(data: Data, level: str, learned: Sequence[Data], planner: Data) -> str:
    """Sentence about the learner that is surely ahead of the planner after the fewest throws."""
    for row in sorted(learned, key=lambda row: (row["throws"], -_pace(row))):
        ahead = interval(data, level, row, planner)
        if ahead is not None and ahead.low > 0.0:
            return f"{_after(row)} already adds {difference(data, level, row, planner)}."
    return "No learner is sure to beat the planner."


def drift(results: Results) -> str:
    """What drift adds to the landing error of a static policy, and which share of it the best controller removes."""
    data = _benchmark(results, "benchmark_adapt")
    level, rows = first_level(data)
    static, oracle = _row(rows, "static"), _row(rows, "oracle_drift")
    calm = next((row for row in data["table"] if row["label"] == "static" and row["level"] != level), None)
    adapting = [row for row in _learner_rows(rows) if row["controller"] not in ("static", "oracle_drift")]
    if not adapting:
        raise NoAnswer("no controller adapts")
    winner = min(adapting, key=_error)
    share = (_error(static) - _error(winner)) / (_error(static) - _error(oracle))
    without = "" if calm is None else f", against {1000 * _error(calm):.1f} mm without drift"
    return (
        f"On `{level}`, a policy that does not adapt lands {1000 * _error(static):.1f} mm off on average{without}. "
        f"`{winner['label']}` lands {1000 * _error(winner):.1f} mm off, and a controller that is told the drift "
        f"{1000 * _error(oracle):.1f} mm: adapting wins back {100 * share:.0f} % of what that controller wins back."
    )


def grasp(results: Results) -> str:
    """What the cup's place is worth: the middle, a tuned rule, networks and an oracle, on seen and on unseen kinds."""
    data = _benchmark(results, "benchmark_grasp")
    level, rows = first_level(data)
    middle, rule, network, oracle = (_row(rows, name) for name in ("centre", "flattest", "local_mlp", "oracle_grasp"))
    sentence = (
        f"On `{level}`, cups sent to the outline's middle sort {_pace(middle):.1f} objects a minute. A tuned rule, the "
        f"flattest place, sorts {_pace(rule):.1f}; a network that learned from tries sorts {_pace(network):.1f}: "
        f"{difference(data, level, network, rule)}, on the rule."
    )
    rewarded = next((row for row in rows if row["label"] == "fitted_q"), None)
    if rewarded is not None:
        sentence += (
            f" `fitted_q`, which learns places and paces from rewards alone, sorts {_pace(rewarded):.1f}: "
            f"{difference(data, level, rewarded, rule)}, on the rule."
        )
    sentence += f" {_of_the_oracle(data, level, rows, oracle)}"
    for unseen in [name for name in data["plan"]["levels"] if name != level]:
        on_unseen = [row for row in data["table"] if row["level"] == unseen]
        seen, blind, best_known = (_row(on_unseen, name) for name in ("local_mlp", "local_mlp_depth", "flattest"))
        sentence += (
            f" On `{unseen}`, whose kinds no network saw, the rule sorts {_pace(best_known):.1f}; the network sorts "
            f"{_pace(seen):.1f} ({difference(data, unseen, seen, best_known)}), a network of depths alone "
            f"{_pace(blind):.1f} ({difference(data, unseen, blind, best_known)})."
        )
    return sentence


def _of_the_oracle(data: Data, level: str, rows: Sequence[Data], oracle: Data) -> str:
    """What the oracle of places knows and maximises, what it sorts, and who sorts more."""
    above = [row for row in rows if _pace(row) > _pace(oracle)]
    text = (
        f"`{oracle['label']}` knows the true surface and not the error of the cup. It takes the place where a try is "
        f"expected to be worth most: 1 where the hold survives a throw at {PERCENT:g} % of the robot's acceleration, "
        f"{HELD:g} where the cup merely holds. It sorts {_pace(oracle):.1f}"
    )
    if not above:
        return f"{text}, more than all others."
    names, top = ", ".join(f"`{row['label']}`" for row in above), max(above, key=_pace)
    most = difference(data, level, top, oracle)
    return f"{text} and is no bound: more is sorted by {names}, and most by `{top['label']}` ({most})."


def order(results: Results) -> str:
    """What the best order is worth over first in, first out, where the gain is least and largest, and who is ahead."""
    data = _benchmark(results, "benchmark_line")
    gains = [level_gain for level in data["plan"]["levels"] if (level_gain := _gain_on(data, level)) is not None]
    if not gains:
        raise NoAnswer("no level has first in, first out and a rule to compare with")
    least, most = min(gains), max(gains)
    return (
        "Over first in, first out, the best order gains in value per minute, with 95 % intervals, between "
        f"{least.text} and {most.text}. On the latter level, the best rule that ignores what other robots can take "
        f"gains {most.blind}.{_planned_or_learned(data)}"
    )


def _planned_or_learned(data: Data) -> str:
    """Sentence about the levels of lines on which a learner earns more than every planner; nothing without the two."""
    rows = {level: rows_of(data, [level]) for level in data["plan"]["levels"]}
    both = {level: (best(learners(of)), best(of, PLANNERS)) for level, of in rows.items()}
    pairs = {level: (won, plan) for level, (won, plan) in both.items() if won is not None and plan is not None}
    if not pairs:
        return ""
    names = sorted({f"`{plan['label']}`" for _, plan in pairs.values()})
    planner = f"the planner {names[0]}" if len(names) == 1 else "the best planner"
    ahead = {level: _lead(*pair) for level, pair in pairs.items()}
    beaten = [f"`{level}`" for level, share in ahead.items() if share > 0.0]
    top = max(ahead, key=lambda level: ahead[level])
    lead = f"`{name_of(pairs[top][0])}` on `{top}`, with {gain(*map(value, pairs[top]))}"
    if beaten:
        return f" What was learned or searched beats {planner} on {', '.join(beaten)}, by most {lead}."
    return f" Nothing learned or searched beats {planner} on any of the {len(pairs)} levels; nearest is {lead}."


def _lead(one: Data, other: Data) -> float:
    """Share by which one earns more than another on the shifts that both have worked."""
    shared = min(len(value(one)), len(value(other)))
    return float(value(one)[:shared].mean() / value(other)[:shared].mean() - 1.0)


def losses(results: Results) -> str:
    """How many picks of the planner and of the best learner end in their bin, and where the others end."""
    data = _benchmark(results, "benchmark")
    level, rows = first_level(data)
    winner = max(_learner_rows(rows), key=_pace)
    return (
        f"On `{level}`, {_after(winner)} sorts {100 * winner['success_rate']:.1f} % of all picks. The losses are "
        f"{_shares(winner)}. The analytic planner sorts {100 * _row(rows, 'analytic')['success_rate']:.1f} %. Its "
        f"losses are {_shares(_row(rows, 'analytic'))}."
    )


def sorter(results: Results) -> str:
    """What failed picks, wrong classes and full bins cost the shipped policy in sorted objects per minute."""
    data = _study(results, "judged")
    rows = [row for row in data["rows"] if row.get("controller") != PLANNER and row.get("level") == "boxes"]
    cases = {row.get("case"): row for row in rows}
    whole, honest = _case(cases, "nothing fails"), _case(cases, "the honest cell")
    costs = [f"{_pace(row) - _pace(whole):+.1f} ({case})" for case, row in cases.items() if case in EFFECTS]
    return (
        f"With six fixed bins by material, the shipped policy sorts {_pace(whole):.1f} objects a minute where nothing "
        f"fails. Effects change this pace by {', '.join(costs)}. With every effect of `waste` the policy sorts "
        f"{_pace(honest):.1f}, with a purity of {100 * honest['purity']:.1f} % and a recovery of "
        f"{100 * honest['recovery']:.1f} %."
    )


def cup(results: Results) -> str:
    """What the cup loses without care on each level, and what a safety of the grip costs."""
    data = _study(results, "grip")
    rows = [row for row in data["rows"] if "safety" in row]
    waste = {row["safety"]: row for row in rows if row.get("level") == "waste"}
    plain, careful = _case(waste, None), _case(waste, SAFETY)
    lost = [f"{100 * row['dropped_of_picked']:.1f} % on `{row['level']}`" for row in rows if row["safety"] is None]
    return (
        f"Of the objects that were picked, the cup loses {', '.join(lost)} when the planner takes no care. On `waste`, "
        f"throws that keep a grip margin of {SAFETY} lose {100 * careful['dropped_of_picked']:.1f} % and sort "
        f"{_pace(careful):.1f} objects a minute; throws without care sort {_pace(plain):.1f}."
    )


def methods(results: Results) -> str:
    """What each way to the bin sorts per minute on one level at one share of the robot's limits."""
    data = _study(results, "methods")
    rows = [row for row in data["rows"] if (row.get("level"), row.get("percent")) == METHODS_AT]
    rows = [row for row in rows if row["part"] == "belt"]
    if not rows:
        raise NoAnswer("no method at these limits")
    ordered = sorted((row for row in rows if "sorted_per_min" in row), key=_pace, reverse=True)
    titles = shipped_study("methods").names["planner"]
    paces = [f"{titles.get(row['planner'], row['planner'])} {_pace(row):.1f}" for row in ordered]
    level, percent = METHODS_AT
    return (
        f"Sorted objects per minute of the analytic planner on `{level}` at {percent} % of the robot's limits: "
        f"{', '.join(paces)}."
    )


def flight(results: Results) -> str:
    """How far the same throws land apart in flights and in full physics, and how often their success differs."""
    data = _study(results, "fidelity")
    rows = [row for row in data["rows"] if {"landing_p95_m", "success_differs"} <= set(row)]
    if not rows:
        raise NoAnswer("no flights beside full physics")
    farthest = max(rows, key=lambda row: row["landing_p95_m"])
    differs = max(rows, key=lambda row: row["success_differs"])
    near = sorted(row["landing_p95_m"] for row in rows)[len(rows) // 2]
    return (
        f"In flights and in full physics, 95 % of the throws land less than {1000 * near:.1f} mm apart on half of the "
        f"levels, and less than {1000 * farthest['landing_p95_m']:.1f} mm on `{farthest['level']}`, where the two "
        f"differ most. Success differs in at most {100 * differs['success_differs']:.1f} % of the throws "
        f"(`{differs['level']}`)."
    )


def papers(results: Results) -> str:
    """How many of the papers' published figures the project finds again."""
    record = results["reproduction"]
    if not {"papers", "titles"} <= set(record):
        raise NoAnswer("no papers, only rows of published figures")
    sentences = [
        f"{counts.get('reproduced', 0)} of {sum(counts.values())} of {record['titles'][paper]}"
        for paper, counts in verdict_counts(record).items()
    ]
    return (
        f"Published figures that are reproduced, each within its tolerance: {', '.join(sentences)}; every other figure "
        "is listed with its verdict."
    )


def verdict_counts(record: Data) -> dict[str, dict[str, int]]:
    """Verdicts on published figures by paper; figures of the project's own conditions are not counted."""
    tables = {paper: verdicts(record, paper) for paper in record["papers"]}
    return {
        paper: {name: int(count) for name, count in table.rows if not name.startswith("ours")}
        for paper, table in tables.items()
    }


def speed(results: Results) -> str:
    """Throws per second of the main environment, single and vector, beside the bare physics; time of a plan."""
    figures = results["perf_envs"]["envs"]["PnTConveyor-v0"]
    vector = max(figures["vector"], key=lambda row: (row["level"] == "waste", row["threads"]))
    planner = results["perf_planner"]
    return (
        f"`PnTConveyor-v0` simulates {vector['env_throws_per_s']:.0f} throws per second with {vector['cells']} cells "
        f"on {vector['threads']} threads, {100 * vector['env_over_bare']:.0f} % of what the bare physics reaches. "
        f"A single environment simulates {vector['singles_throws_per_s']:.0f}. The exact planner plans a throw in "
        f"{planner['plan_release_us']['free']:.0f} us, {planner['slsqp_over_exact']:.0f} times as fast as the paper's "
        "nonlinear programme on the same machine."
    )


class _Gain(NamedTuple):
    """What the best controller of a level of lines gains on first in, first out; sorted by the gain.

    Attributes:
        share: the gain [%].
        text: gain with interval, level and controller.
        blind: the gain of the best rule that ignores what other robots can take, with its interval.
    """

    share: float
    text: str
    blind: str


def _gain_on(data: Data, level: str) -> _Gain | None:
    """The gain on one level; None where the plan has no first in, first out, or no work shifts."""
    rows = [row for row in rows_of(data, [level]) if "shifts" in row]
    first, blind, top = best(rows, (FIRST,)), best(rows, CLASS_BLIND), best(rows)
    if first is None or blind is None or top is None:
        return None
    share = value(top).mean() / value(first).mean() - 1.0
    text = f"{gain(value(top), value(first))} on `{level}` (`{name_of(top)}`)"
    return _Gain(float(share), text, f"{gain(value(blind), value(first))} (`{blind['label']}`)")


def _benchmark(results: Results, name: str) -> Data:
    """A benchmark's results.

    Raises:
        NoAnswer: the file of this name holds other results, such as those of a study.
    """
    return _with_keys(results[name], "plan", "table", "comparisons")


def _study(results: Results, name: str) -> Data:
    """A study's results.

    Raises:
        NoAnswer: the file of this name holds other results, such as those of a benchmark.
    """
    return _with_keys(results[name], "rows", "throws")


def _with_keys(data: Data, *names: str) -> Data:
    if not set(names) <= set(data):
        raise NoAnswer(f"no keys {', '.join(names)}")
    return data


def _case(rows: Mapping[Any, Data], case: object) -> Data:
    """The row of a case of a study.

    Raises:
        NoAnswer: the study lacks the case.
    """
    if case not in rows:
        raise NoAnswer(f"no case {case!r}")
    return rows[case]


def _row(rows: Sequence[Data], label: str) -> Data:
    """The last row of a controller: the one that has learned from the most throws.

    Raises:
        NoAnswer: the controller has no row.
    """
    matches = [row for row in rows if row["label"] == label]
    if not matches:
        raise NoAnswer(f"no row of {label!r}")
    return matches[-1]


def _learner_rows(rows: Sequence[Data]) -> list[Data]:
    """Rows of controllers that have learned from throws, without noise floors.

    Raises:
        NoAnswer: there are none.
    """
    learned = [row for row in rows if row["throws"] > 0 and not row["label"].startswith("floor")]
    if not learned:
        raise NoAnswer("no controller has learned")
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
        NoAnswer: the plan does not measure the figure.
    """
    if name not in row:
        raise NoAnswer(f"no figure {name!r}")
    return float(row[name])


def _after(row: Data) -> str:
    """A controller with the throws that it has learned from."""
    return f"`{row['label']}` after {row['throws']:,} throws"


def _shares(row: Data) -> str:
    """Where the picks of a controller end that are not sorted, the largest share first."""
    shares = {name: 100 * row[key] for key, name in LOSSES.items() if row.get(key)}
    ordered = sorted(shares.items(), key=lambda share: -share[1])
    return ", ".join(f"{share:.1f} % {name}" for name, share in ordered)
