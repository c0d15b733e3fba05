"""What `make perf` measured of speeds as tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.tables import Grid, percent

Data = Mapping[str, Any]


def planner_table(data: Data) -> Grid:
    """Timings of the exact planner beside the paper's two methods, from one run."""
    kinds = {"free": "no ceiling", "ceiling_active": "the ceiling moves the release", "infeasible": "no throw"}
    single, batch, cells = (data[name] for name in ("plan_release_us", "batch_plans_per_s", "batch_of_64_us"))
    rows = [
        [case, f"{single[kind]:.0f} us", f"{cells[kind]:.0f} us", f"{batch[kind]:,.0f}"] for kind, case in kinds.items()
    ]
    rows += [
        ["Method 1 of the paper (SLSQP), no ceiling", f"{data['method_1_slsqp_median_us']:.0f} us", "-", "-"],
        ["Method 2 of the paper, no ceiling", f"{data['method_2_median_us']:.0f} us", "-", "-"],
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


def goals_table(data: Data) -> Grid:
    """What the speeds should be, what they are, and by how much they fall short."""
    conveyor, line = (
        {row["threads"]: row for row in data["envs"][env]["vector"] if row["level"] == level}
        for env, level in (("PnTConveyor-v0", "waste"), ("PnTLine-v0", "single"))
    )
    decisions = {threads: row["env_throws_per_s"] for threads, row in line.items()}
    single = conveyor[1]["singles_throws_per_s"] / conveyor[1]["bare_throws_per_s"]
    goals = (
        ("`PnTConveyor-v0`, waste, single, share of bare physics", 0.60, single),
        ("`PnTConveyor-v0`, waste, 64 cells, one thread, share of bare physics", 0.92, conveyor[1]["env_over_bare"]),
        ("`PnTConveyor-v0`, waste, 64 cells, two threads, share of bare physics", 0.88, conveyor[2]["env_over_bare"]),
        ("`PnTLine-v0`, single, by table, two threads over one", 1.7, decisions[2] / decisions[1]),
    )
    rows = [
        [goal, f"{asked:.2f}", f"{value:.2f}", "-" if value >= asked else f"{100 * (1 - value / asked):.0f} %"]
        for goal, asked, value in goals
    ]
    return Grid("Goals of the steps", ["speed", "asked", "measured", "short by"], rows, "From the same runs.")


def shares_table(data: Data) -> Grid:
    """Parts of a step by their shares of the processor's time, step by step beside each other."""
    steps = data["steps"]
    forms = {1: "single", **{step["cells"]: f"{step['cells']} cells" for step in steps if step["cells"] > 1}}
    header = ["part of a step", *(f"`{step['env']}`, {step['level']}, {forms[step['cells']]}" for step in steps)]
    parts = dict.fromkeys(part for step in steps for part in step["parts"])
    rest = "everything else"
    names = [*(part for part in parts if part != rest), *([rest] if rest in parts else [])]
    rows = [[part, *(percent(step["parts"].get(part)) for step in steps)] for part in names]
    note = (
        "Samples of one thread's processor time every millisecond; time in machine code counts for the next sample. "
        "All on one thread. A dash: the step has no such part."
    )
    return Grid("Where the time of a step goes", header, rows, note)


def training_table(data: Data) -> Grid:
    """Parts of a training by their shares of the processor's time."""
    rows = [[part, percent(share)] for part, share in data["parts"].items()]
    note = f"{data['throws']:,} throws of SAC on `PnTConveyor-v0`, without the table at the end."
    return Grid("Where the time of a training goes", ["part of a training", "share"], rows, note)


def before_table(data: Data) -> Grid:
    """Seconds and landing errors of trainings, beside those of older code."""
    training = data["training"]
    rows = [
        [str(seed), *(f"{turns[code]['seconds']:.1f} s" for code in ("before", "now")), *_errors(turns)]
        for seed, turns in enumerate(training["seeds"])
    ]
    header = ["seed", "older code", "this code", "landing error, older code", "landing error, this code"]
    note = (
        f"{training['throws']:,} throws of SAC on `PnTConveyor-v0`, by both codes in turn; the error is the mean of "
        "the training's last throws."
    )
    return Grid("A training beside that of older code", header, rows, note)


def paired_steps_table(data: Data) -> Grid:
    """Throws/s, or decisions/s of lines by table, beside those of older code."""
    rows = [
        [
            f"`{row['env']}`",
            row["level"],
            str(row["cells"]),
            str(row["threads"]),
            *(f"{row[code]:,.0f}" for code in ("before", "now")),
            f"{row['ratio']:.2f}",
            "-" if row["asked"] is None else f"{row['asked']:.2f}",
        ]
        for row in data["steps"]["rows"]
    ]
    header = ["environment", "level", "cells", "threads", "older code, per s", "this code, per s", "ratio", "asked"]
    note = (
        f"Throws of the conveyor and decisions of lines by table per second, with random actions; medians of "
        f"{data['steps']['turns']} turns of both codes. *Ratio*: this code over the older code."
    )
    return Grid("Steps beside those of older code", header, rows, note)


def _errors(turns: Data) -> list[str]:
    return [f"{1000 * turns[code]['landing_error_m']:.2f} mm" for code in ("before", "now")]


TABLES: Final = (
    ({"plan_release_us", "batch_plans_per_s"}, planner_table),
    ({"envs", "cpus"}, environment_table),
    ({"steps", "cpus"}, shares_table),
    ({"parts", "throws"}, training_table),
    ({"training", "steps"}, before_table),
    ({"training", "steps"}, paired_steps_table),
)
"""By what the files that `make perf` writes are known, and their tables."""
