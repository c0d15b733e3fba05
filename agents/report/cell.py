"""What `make studies` measured of the conveyor cell as tables: grip, cup, order, neighbours, what a sorter is worth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..ground.tables import Grid

Data = Mapping[str, Any]


def grip_table(data: Data) -> Grid:
    """What the cup loses, and what care costs."""
    header = ["level", "safety", "margin below 2", "below 1.5", "lost", "most of all", "success", "cycle", "sorted/min"]
    rows = [
        [
            level,
            "none" if found["safety"] is None else f"{found['safety']}",
            *(f"{100 * found[name]:.1f} %" for name in ("below_2", "below_1.5", "dropped")),
            _worst(found["dropped_by_item"]),
            f"{100 * found['success']:.1f} %",
            f"{found['cycle_time']:.3f} s",
            f"{found['sorted_per_min']:.1f}",
        ]
        for level, entries in data["grip"].items()
        for found in entries
    ]
    note = (
        f"Analytic planner, {data['throws']} picks per row, seed {data['seed']}, full physics. Margins and losses "
        "are of what was picked; the file has the loss of every kind. Heavy: cans of 360 g and jars of 200 g at "
        "F0 = 20 N in the cell of `nominal`; its rows do not meet the same objects, since some ride on that cannot be "
        "held with the safety asked for."
    )
    return Grid("What the cup loses", header, rows, note)


def _worst(rates: Data) -> str:
    """The kind that is lost most often."""
    kind = max(rates, key=lambda name: float(rates[name]))
    return f"{kind} {100 * rates[kind]:.0f} %" if rates[kind] > 0.0 else "-"


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
    patience = ", ".join(f"{100 * gain:.1f} % at {k} s" for k, gain in data["tuning"]["dense"].items())
    note = (
        f"Analytic planner, full physics, {data['shifts']} shifts of {data['throws']} throws per row, seed "
        f"{data['seed']}; every rule meets the same objects in the same places, and gains are means over shifts of "
        "their own ratios, with 95 % intervals. Honest: with picks that fail, a hand that rides, "
        f"solid neighbours and the rest of `waste`. By plans alone, on streams of other seeds, `atc` gains on `dense` "
        f"{patience} by its patience; the default is 8 s. Recovery: sorted objects over "
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
        f"Analytic planner, `waste_plain`, {data['shifts']} shifts of {data['throws']} throws per row, seed "
        f"{data['seed']}. Gaps: 0.10 to 0.30 m between centres, or 0.02 to 0.18 m between edges. Swept: throws whose "
        "object sweeps through another one on the belt (`disturbed`). Passed: objects let go, knocked ones among them."
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
        f"`PnTConveyor-v0`, {data['throws']} picks per row, seed {data['seed']}, full physics. `waste` is "
        "`waste_plain`, but for the last row of each controller; `boxes` sorts its kinds into six fixed bins by "
        f"material. Classes wrong: {100 * data['wrong']:g} % of every kind is seen "
        f"as one of another material. Bins are emptied after so many objects: {emptied}."
    )
    return Grid("What a sorter is judged by", header, rows, note)
