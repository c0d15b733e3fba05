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


def shares_table(data: Data) -> Grid:
    """Parts of a step by their shares of the processor's time, step by step beside each other."""
    steps = data["steps"]
    forms = {1: "single", **{step["cells"]: f"{step['cells']} cells" for step in steps if step["cells"] > 1}}
    header = ["part of a step", *(f"`{step['env']}`, {step['level']}, {forms[step['cells']]}" for step in steps)]
    parts = dict.fromkeys(part for step in steps for part in step["parts"])
    rest = "everything else"
    names = [*(part for part in parts if part != rest), *([rest] if rest in parts else [])]
    rows = [[part, *(_percent(step["parts"].get(part)) for step in steps)] for part in names]
    note = (
        "Samples of one thread's processor time every millisecond, each with the time that machine code took before. "
        "All on one thread."
    )
    return Grid("Where the time of a step goes", header, rows, note)


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100 * share:.1f} %"


def training_table(data: Data) -> Grid:
    """Parts of a training by their shares of the processor's time, and its seconds beside those of older code."""
    rows = [[part, _percent(share)] for part, share in data["parts"].items()]
    note = f"{data['throws']:,} throws of SAC on `PnTConveyor-v0`, without the table at the end."
    if seeds := data.get("seeds"):
        pairs = [(seed["before"]["seconds"], seed["now"]["seconds"]) for seed in seeds]
        same = all(seed["before"]["landing_error_m"] == seed["now"]["landing_error_m"] for seed in seeds)
        error = "with the same landing errors" if same else "with other landing errors"
        before, now = (", ".join(f"{seconds:.0f}" for seconds in column) for column in zip(*pairs, strict=True))
        share = sum(now for _, now in pairs) / sum(before for before, _ in pairs)
        note += (
            f" Seconds of learning, seed by seed in turn: {before} with older code and {now} with this code, {error}: "
            f"{100 * share:.0f} % of the time."
        )
    return Grid("Where the time of a training goes", ["part of a training", "share"], rows, note)


TABLES: Final = (
    ({"plan_release_us", "batch_plans_per_s"}, planner_table),
    ({"envs", "cpus"}, environment_table),
    ({"steps", "cpus"}, shares_table),
    ({"parts", "throws"}, training_table),
)
"""By what the files that `make perf` writes are known, and their tables."""
