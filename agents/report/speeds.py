"""What `make perf` measured of speeds as tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.tables import Grid

Data = Mapping[str, Any]


def planner_table(data: Data) -> Grid:
    """Timings of the exact planner beside the paper's two methods, from one run."""
    kinds = {"free": "no ceiling", "ceiling_active": "the ceiling moves the release", "infeasible": "no throw"}
    single, batch, cells = (data[name] for name in ("plan_release_us", "batch_plans_per_s", "batch_of_64_us"))
    rows = [
        [case, f"{single[kind]:.0f} us", f"{cells[kind]:.0f} us", f"{batch[kind]:,.0f}"] for kind, case in kinds.items()
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
        "its step in the same physics, so a vector of environments gains further cores and shared planning alone."
    )
    return Grid("Throws per second", header, rows, note)


TABLES: Final = (
    ({"plan_release_us", "batch_plans_per_s"}, planner_table),
    ({"envs", "cpus"}, environment_table),
)
"""By what the files that `make perf` writes are known, and their tables."""
