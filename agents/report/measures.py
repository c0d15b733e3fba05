"""What `make perf` measured as Markdown tables: honesty of the physics, speed of planner and environments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from agents.report.tables import markdown

Data = Mapping[str, Any]
_LADDER_NAMES = {"analytic": "analytic planner", "oracle": "oracle (knows the hidden values)"}


def is_physics(data: Data) -> bool:
    """Whether a file of results is that of benchmarks/study_physics.py."""
    return {"ideal", "ladder", "dial"} <= set(data)


def is_planner(data: Data) -> bool:
    """Whether a file of results is that of benchmarks/bench_planner.py."""
    return "plan_release_median_us" in data


def is_environments(data: Data) -> bool:
    """Whether a file of results is that of benchmarks/bench_envs.py."""
    return isinstance(data.get("envs"), Mapping) and "cpus" in data


def physics_table(data: Data) -> str:
    """The levels under the analytic planner and the oracle, and the mismatch dial."""
    header = ["level", "release by", "landing error", "success (95 % interval)", "missed", "rim", "touched again"]
    rows = [_physics_row("ideal", "analytic", data["ideal"]["analytic"])]
    for name, figures in data["ladder"].items():
        level, controller = name.split("/")
        rows.append(_physics_row(level, controller, figures))
    for mismatch, figures in data["dial"].items():
        rows.append(_physics_row(f"waste, mismatch {float(mismatch):g}", "analytic", figures))
    return markdown(header, rows)


def physics_note(data: Data) -> str:
    """Throw count and seed behind the table, and what its columns mean."""
    return (
        f"{data['throws']} throws per row, seed {data['seed']}, steps of {1000 * data['timestep']:g} ms. "
        "Rim: crossed the opening and does not lie in the bin. Touched again: by the cup after the release, sorted or "
        "not."
    )


def planner_table(data: Data) -> str:
    """Timings of the exact planner beside the paper's two methods, from one run."""
    rows = [
        ["`plan_release`, one throw, median", f"{data['plan_release_median_us']:.0f} us"],
        ["`plan_release` under a release ceiling, median", f"{data['plan_release_ceiling_median_us']:.0f} us"],
        ["`plan_release_batch`, one core", f"{data['batch_plans_per_s']:,.0f} plans/s"],
        [
            "`plan_release_batch` under a ceiling, one core",
            f"{data['batch_ceiling_plans_per_s']:,.0f} plans/s",
        ],
        ["Method 1 of the paper (SLSQP), median", f"{data['method_1_slsqp_median_us']:.0f} us"],
        ["Method 2 of the paper, median", f"{data['method_2_median_us']:.0f} us"],
    ]
    return markdown(["planner", "measured"], rows)


def planner_note(data: Data) -> str:
    """How much faster the exact planner is, from the same run."""
    return f"All in one run on one core; Method 1 takes {data['slsqp_over_exact']:.0f} times as long as `plan_release`."


def environment_table(data: Data) -> str:
    """Throws per second of the vector environments against bare physics and against single environments."""
    header = ["environment", "level", "cells", "threads", "throws/s"]
    header += ["share of bare physics", "over single environments"]
    rows = [
        [
            f"`{env}`",
            figures["level"],
            str(line["cells"]),
            str(line["threads"]),
            f"{line['env_throws_per_s']:.0f}",
            f"{100 * line['env_over_bare']:.0f} %",
            f"{line['env_over_singles']:.1f} x",
        ]
        for env, figures in data["envs"].items()
        for line in figures["vector"]
    ]
    return markdown(header, rows)


def environment_note(data: Data) -> str:
    """What was measured on what, and why the last column cannot be larger."""
    return (
        f"Steps of {1000 * data['timestep']:g} ms, {data['cpus']} cores. Bare physics is "
        "`Batch.rollout` of the same steps with the same controls in the same run. A single environment spends most of "
        "its step in the same physics, so what a vector of them can gain is the cores plus the planning shared."
    )


def _physics_row(level: str, controller: str, figures: Data) -> list[str]:
    success, landing = figures["success"], figures["landing"]
    return [
        level,
        _LADDER_NAMES[controller],
        f"{1000 * landing['mean']:.1f} mm",
        f"{100 * success['value']:.1f} % ({100 * success['low']:.1f}..{100 * success['high']:.1f})",
        *(f"{100 * figures[name]:.1f} %" for name in ("missed_opening", "rim", "recontact")),
    ]
