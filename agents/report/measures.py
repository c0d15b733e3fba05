"""What `make perf` and two studies measured as tables: physics, speed, the oracle, learning from flights."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.tables import Grid
from .adaptation import camera_table, newcomers_table
from .cell import cup_table, dispatch_table, grip_table, judged_table, neighbours_table
from .methods import throwable_table
from .thrown import release_table, thrown_table

Data = Mapping[str, Any]
_LADDER_NAMES = {"analytic": "analytic planner", "oracle": "oracle (knows the hidden values)"}


def physics_table(data: Data) -> Grid:
    """The levels under the analytic planner and the oracle, and the mismatch dial."""
    shares = ["not picked", "lost", "missed", "rim", "touched again"]
    header = ["level", "release by", "landing error", "under 30 mm", "success (95 % interval)", *shares]
    rows = [_physics_row("ideal", "analytic", data["ideal"]["analytic"])]
    for name, figures in data["ladder"].items():
        level, controller = name.split("/")
        rows.append(_physics_row(level, controller, figures))
    for mismatch, figures in data["dial"].items():
        rows.append(_physics_row(f"waste, mismatch {float(mismatch):g}", "analytic", figures))
    note = (
        f"{data['throws']} throws per row, seed {data['seed']}, steps of {1000 * data['timestep']:g} ms. "
        "Errors are of what was thrown. Lost: on the way to the release. Rim: crossed the opening and does not lie in "
        "the bin. Touched again: by the cup after the release, sorted or not."
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
            f"{100 * line['env_over_bare']:.0f} %" if line["physics_steps_per_throw"] else "none is simulated",
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
    throws, seconds = (2000, 10_000), (10, 30, 90, 270)
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
        f"{', '.join(map(str, sorted(seeds)))}; in brackets the seconds of learning on one core. After equal throws, "
        "and the last policy done within equal time, of those judged: SAC every 2,000 throws up to 10,000, from "
        "flights 20,000; MLP after 500, 2,000, 10,000 and 20,000. Flight then full: the last fifth in full."
    )
    return Grid("Learning from flights", header, rows, note)


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
    ({"thrown", "release"}, thrown_table),
    ({"thrown", "release"}, release_table),
    ({"camera", "newcomers"}, camera_table),
    ({"camera", "newcomers"}, newcomers_table),
)
"""By what the files that `make perf` and `make studies` write are known, and their tables."""


def _physics_row(level: str, controller: str, figures: Data) -> list[str]:
    success, landing = figures["success"], figures["landing"]
    return [
        level,
        _LADDER_NAMES[controller],
        f"{1000 * landing['mean']:.1f} mm",
        f"{100 * landing['near']:.1f} %",
        f"{100 * success['value']:.1f} % ({100 * success['low']:.1f}..{100 * success['high']:.1f})",
        *(f"{100 * figures[name]:.1f} %" for name in ("unpicked", "dropped", "missed_opening", "rim", "recontact")),
    ]
