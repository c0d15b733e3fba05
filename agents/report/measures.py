"""What `make perf` measured as tables: honesty of the physics, speed of planner and environments."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from ..tables import Grid
from .methods import throwable_table

Data = Mapping[str, Any]
_LADDER_NAMES = {"analytic": "analytic planner", "oracle": "oracle (knows the hidden values)"}


def physics_table(data: Data) -> Grid:
    """The levels under the analytic planner and the oracle, and the mismatch dial."""
    header = ["level", "release by", "landing error", "success (95 % interval)", "missed", "rim", "touched again"]
    rows = [_physics_row("ideal", "analytic", data["ideal"]["analytic"])]
    for name, figures in data["ladder"].items():
        level, controller = name.split("/")
        rows.append(_physics_row(level, controller, figures))
    for mismatch, figures in data["dial"].items():
        rows.append(_physics_row(f"waste, mismatch {float(mismatch):g}", "analytic", figures))
    note = (
        f"{data['throws']} throws per row, seed {data['seed']}, steps of {1000 * data['timestep']:g} ms. "
        "Rim: crossed the opening and does not lie in the bin. Touched again: by the cup after the release, sorted or "
        "not."
    )
    return Grid("Levels and mismatch, without learning", header, rows, note)


def planner_table(data: Data) -> Grid:
    """Timings of the exact planner beside the paper's two methods, from one run."""
    kinds = {"free": "no ceiling", "ceiling_active": "the ceiling moves the release", "infeasible": "no throw"}
    one, many, cells = (data[name] for name in ("plan_release_us", "batch_plans_per_s", "batch_of_64_us"))
    rows = [
        [said, f"{one[kind]:.0f} us", f"{cells[kind]:.0f} us", f"{many[kind]:,.0f}"] for kind, said in kinds.items()
    ]
    rows += [
        ["Method 1 of the paper (SLSQP), no ceiling", f"{data['method_1_slsqp_median_us']:.0f} us", "", ""],
        ["Method 2 of the paper, no ceiling", f"{data['method_2_median_us']:.0f} us", "", ""],
    ]
    first = data["first_plan_s"]
    note = (
        f"Throws off the belt, medians of one run on one core; Method 1 takes {data['slsqp_over_exact']:.0f} times as "
        f"long as `plan_release`. The first plan of a process takes {first['of_a_process']:.1f} s, and the first after "
        f"an installation {first['after_installation']:.1f} s, because it is compiled then."
    )
    header = ["planner", "`plan_release`", "`plan_release_batch` of 64", "plans/s in large batches"]
    return Grid("The planner's speed", header, rows, note)


def environment_table(data: Data) -> Grid:
    """Throws per second of the vector environments against bare physics and against single environments."""
    counts = ["cells", "threads", "throws/s"]
    header = ["environment", "level", *counts, "share of bare physics", "over single environments"]
    rows = [
        [
            f"`{env}`",
            line["level"],
            str(line["cells"]),
            str(line["threads"]),
            f"{line['env_throws_per_s']:.0f}",
            f"{100 * line['env_over_bare']:.0f} %",
            f"{line['env_over_singles']:.1f} x",
        ]
        for env, figures in data["envs"].items()
        for line in figures["vector"]
    ]
    note = (
        f"Steps of {1000 * data['timestep']:g} ms, {data['cpus']} cores. Bare physics is "
        "`Batch.rollout` of the same steps with the same controls in the same run. A single environment spends most of "
        "its step in the same physics, so what a vector of them can gain is the cores plus the planning shared."
    )
    return Grid("Throws per second", header, rows, note)


def fidelity_table(data: Data) -> Grid:
    """Flights against the full physics, level by level."""
    header = [
        "level",
        "landings apart",
        "95th percentile",
        "success, full",
        "flight",
        "differs",
        "touched again",
        "flight",
    ]
    rows = [
        [
            level,
            *(f"{1000 * found[name]:.2f} mm" for name in ("landing_mean_m", "landing_p95_m")),
            *(f"{100 * found[name]:.1f} %" for name in ("success_full", "success_flight", "success_differs")),
            *(f"{100 * found[name]:.1f} %" for name in ("recontact_full", "recontact_flight")),
        ]
        for level, found in data["fidelity"].items()
    ]
    note = (
        f"{data['throws']} throws per row, seed {data['seed']}, the same objects, targets and actions in both. "
        "Landings where the cup touches nothing again."
    )
    return Grid("`fidelity: flight` against the full physics", header, rows, note)


def oracle_table(data: Data) -> Grid:
    """What the oracle leaves, case by case, beside the planner and a fixed point."""
    names = {"analytic": "analytic planner", "fixed_point": "fixed point, gain 1", "oracle": "oracle"}
    header = [
        "throws",
        "release by",
        "landing, simulated before",
        "thrown",
        "95th percentile",
        "success",
        "at the edge",
    ]
    lengths = ("previewed_mean_m", "landing_error_mean_m", "landing_error_p95_m")
    rows = [
        [
            case,
            said,
            *(f"{1000 * found[name][length]:.1f} mm" for length in lengths),
            *(f"{100 * found[name][share]:.1f} %" for share in ("success_rate", "at_bound")),
        ]
        for case, found in data["oracle"].items()
        for name, said in names.items()
    ]
    note = (
        f"{data['throws']} throws per row, seed {data['seed']}, the same objects in all three. What the throw adds to "
        "its own simulation is drawn anew in every throw: the scatter of the release. At the edge: the action ends at "
        "the end of its range. The fixed point simulates each throw 4 times, the oracle up to 25 times."
    )
    return Grid("What the oracle leaves", header, rows, note)


def training_table(data: Data) -> Grid:
    """What learning from flights costs and saves, after equal throws and in equal time."""
    throws, seconds = (2000, 10_000), (10, 30, 90)
    seeds = {row["seed"] for ways in data["training"].values() for found in ways.values() for row in found}
    header = ["learner", "learns in", *(f"{n:,} throws" for n in throws), *(f"{t} s" for t in seconds)]
    rows = [
        [
            learner,
            way,
            *(_error([row for row in found if row["throws"] == count]) for count in throws),
            *(_error(_latest([row for row in found if row["seconds"] <= limit], len(seeds))) for limit in seconds),
        ]
        for learner, ways in data["training"].items()
        for way, found in ways.items()
    ]
    note = (
        f"Level `{data['level']}`, landing error in the full physics of {data['picks']} held-out throws, mean of seeds "
        f"{', '.join(map(str, sorted(seeds)))}; in brackets the seconds of learning. After equal throws, and the last "
        "policy done within equal time, 2 threads, of those judged: SAC every 2,000 throws up to 10,000, from flights "
        "20,000; MLP after 500, 2,000, 10,000 and 20,000. Flight then full: the last fifth in full."
    )
    return Grid("Learning from flights", header, rows, note)


def grip_table(data: Data) -> Grid:
    """What the cup loses, and what care costs."""
    header = ["level", "safety", "margin below 2", "below 1.5", "lost", "success", "cycle", "sorted/min"]
    rows = [
        [
            level,
            "none" if found["safety"] is None else f"{found['safety']}",
            *(f"{100 * found[name]:.1f} %" for name in ("below_2", "below_1.5", "dropped", "success")),
            f"{found['cycle_time']:.3f} s",
            f"{found['sorted_per_min']:.1f}",
        ]
        for level, entries in data["grip"].items()
        for found in entries
    ]
    note = (
        f"Analytic planner, {data['throws']} throws per row, seed {data['seed']}, full physics, "
        "`grip: {limit: true}`. Heavy: cans of 360 g and jars of 200 g at F0 = 20 N in the cell of `nominal`; its "
        "rows do not meet the same objects, since some ride on that cannot be held with the safety asked for."
    )
    return Grid("What the cup loses", header, rows, note)


def cup_table(data: Data) -> Grid:
    """What a cup that yields does to landings, and what a learner sees of it."""
    header = ["cup", "leaves with", "moves landings along, across", "analytic", "MLP", "oracle", "flights", "in full"]
    rows = [
        [
            name,
            _leaving(data["swings"].get(name)),
            f"{1000 * found['moved_along_mean']:+.1f} ± {1000 * found['moved_along_sd']:.1f}, "
            f"± {1000 * found['moved_across_sd']:.1f} mm",
            _learnt([found]),
            *(
                _learnt([row for key, row in data["learning"].items() if key.startswith(f"{name}: {who} ")])
                for who in ("mlp", "oracle")
            ),
            f"{1000 * found['flight_p95']:.1f} mm",
            f"{100 * data['swings'][name]['simulated_in_full']:.0f} %" if name in data["swings"] else "-",
        ]
        for name, found in data["effects"].items()
    ]
    note = (
        f"Level `{data['level']}`, {data['throws']} throws per row, full physics, the same objects in all; each effect "
        "alone. Leaves with: tilt and speed of the swing at release that 5 % exceed. Moves: mean and standard "
        "deviation of where the same throws land against the rigid cup, without those that the cup touched again. "
        "Analytic, MLP, oracle: landing error and success, of held-out objects for the last two; the MLP from "
        f"{data['practice']:,} flights from that cup, mean of 2 seeds, the oracle on {data['oracle_throws']} throws. "
        "Flights: 95 % of them land within this of the full physics. In full: flights whose object meets belt or cup "
        "as it swings, simulated with the robot."
    )
    return Grid("A cup that yields", header, rows, note)


def _leaving(swing: dict[str, float] | None) -> str:
    if swing is None:
        return "-"
    return f"{math.degrees(swing['tilt_p95_rad']):.1f} deg, {swing['speed_p95']:.2f} m/s"


def _learnt(rows: list[dict[str, float]]) -> str:
    if not rows:
        return "-"
    error, success = (sum(row[name] for row in rows) / len(rows) for name in ("landing_error", "success"))
    return f"{1000 * error:.1f} mm, {100 * success:.1f} %"


def dispatch_table(data: Data) -> Grid:
    """What the order of picks is worth."""
    header = ["level", "dispatch", "picks/min", "over first", "sorted/min", "over first", "recovery", "success"]
    rows = [
        [
            level,
            rule,
            f"{found['picks_per_min']['value']:.1f}",
            _gain(found["picks_per_min_gain"], rule),
            f"{found['sorted_per_min']['value']:.1f}",
            _gain(found["sorted_per_min_gain"], rule),
            *(f"{100 * found[name]['value']:.1f} %" for name in ("recovery", "success")),
        ]
        for level, entries in data["dispatch"].items()
        for rule, found in entries.items()
    ]
    note = (
        f"Analytic planner, full physics, {data['shifts']} shifts of {data['throws']} throws per row, seed "
        f"{data['seed']}; every rule meets the same objects in the same places, and gains are means over shifts of "
        "their own ratios, with 95 % intervals. `nominal` and `waste` with `gap: edge` and 0.02 to 0.18 m between "
        f"objects. Patience of `atc`: {data['best_patience']:g} s, the best of "
        f"{', '.join(next(iter(data['tuning'].values())))} s on streams of other seeds. Recovery: sorted objects over "
        "all that were thrown or let go."
    )
    return Grid("Which object next", header, rows, note)


def neighbours_table(data: Data) -> Grid:
    """What a hand that rides with the belt costs, and what solid neighbours do."""
    header = ["gap", "belt", "hand", "neighbours", "picks/min", "swept", "slip, mean", "under 1 mm", "passed a pick"]
    rows = [
        [
            found["gap"],
            f"{found['speed']:g} m/s",
            "rides" if found["tracking"] else "stands",
            found["neighbours"],
            f"{found['picks_per_min']['value']:.1f}",
            f"{100 * found['disturbed']['value']:.1f} %",
            f"{1000 * found['slip_mean_m']:.2f} mm",
            f"{100 * found['slip_below_1mm']:.1f} %",
            f"{found['passed_per_pick']['value']:.2f}",
        ]
        for found in data["neighbours"]
    ]
    note = (
        f"Analytic planner, `waste`, {data['shifts']} shifts of {data['throws']} throws per row, seed {data['seed']}. "
        "Gaps: 0.10 to 0.30 m between centres, or 0.02 to 0.18 m between edges. Swept: throws whose object sweeps "
        "through another one on the belt (`disturbed`). Passed: objects let go, knocked ones among them."
    )
    return Grid("A hand that rides, and neighbours", header, rows, note)


def _gain(found: Data, rule: str) -> str:
    """A share in percent with its interval; none of the rule that it is over."""
    if rule == "first":
        return "-"
    return f"{100 * found['value']:+.1f} % ({100 * found['low']:+.1f}..{100 * found['high']:+.1f})"


def judged_table(data: Data) -> Grid:
    """What failed picks, wrong classes and filling bins cost at the belt."""
    header = ["cell", "thrown by", "with", "picks/min", "sorted/min", "recovery", "purity", "picks that held", "energy"]
    rows = [
        [
            level,
            found["controller"],
            found["case"],
            *(f"{found[name]:.1f}" for name in ("picks_per_min", "sorted_per_min")),
            *(f"{100 * found[name]:.1f} %" for name in ("recovery", "purity", "pick_rate")),
            f"{found['energy_per_pick_j']:.1f} J",
        ]
        for level, entries in data["judged"].items()
        for found in entries
    ]
    emptied = " and ".join(f"{count} in `{level}`" for level, count in data["emptied"].items())
    note = (
        f"`PnTConveyor-v0`, {data['throws']} picks per row, seed {data['seed']}, full physics. `boxes` sorts the kinds "
        f"of `waste` into six fixed bins by material. Classes wrong: {100 * data['wrong']:g} % of every kind is seen "
        f"as one of another material. Bins are emptied after so many objects: {emptied}."
    )
    return Grid("What a sorter is judged by", header, rows, note)


def _latest(rows: list[dict[str, float]], seeds: int) -> list[dict[str, float]]:
    """The last row of each seed; none where a seed has none, which a mean over the others would hide."""
    last = {row["seed"]: row for row in sorted(rows, key=lambda row: row["throws"])}
    return list(last.values()) if len(last) == seeds else []


def _error(rows: list[dict[str, float]]) -> str:
    if not rows:
        return "-"
    error, seconds = (sum(row[name] for row in rows) / len(rows) for name in ("landing_error_mean_m", "seconds"))
    return f"{1000 * error:.1f} mm ({seconds:.0f} s)"


TABLES: Final = (
    ({"ideal", "ladder", "dial"}, physics_table),
    ({"plan_release_us", "batch_plans_per_s"}, planner_table),
    ({"envs", "cpus"}, environment_table),
    ({"fidelity", "throws"}, fidelity_table),
    ({"oracle", "throws"}, oracle_table),
    ({"training", "picks"}, training_table),
    ({"grip", "throws"}, grip_table),
    ({"effects", "learning"}, cup_table),
    ({"dispatch", "shifts"}, dispatch_table),
    ({"judged", "wrong"}, judged_table),
    ({"throwable", "throws"}, throwable_table),
    ({"neighbours", "shifts"}, neighbours_table),
)
"""By what the files that `make perf` and `make studies` write are known, and their tables."""


def _physics_row(level: str, controller: str, figures: Data) -> list[str]:
    success, landing = figures["success"], figures["landing"]
    return [
        level,
        _LADDER_NAMES[controller],
        f"{1000 * landing['mean']:.1f} mm",
        f"{100 * success['value']:.1f} % ({100 * success['low']:.1f}..{100 * success['high']:.1f})",
        *(f"{100 * figures[name]:.1f} %" for name in ("missed_opening", "rim", "recontact")),
    ]
