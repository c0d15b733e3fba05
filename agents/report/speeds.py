"""Rows of the tables of what `make perf` measured of speeds; `speeds.yaml` declares the tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final

from ..ground.files import read_yaml
from ..ground.tables import Grid
from ..results.study import Table
from .templates import make_grid

Data = Mapping[str, Any]
Rows = list[dict[str, Any]]
KINDS: Final = {"free": "no ceiling", "ceiling_active": "the ceiling moves the release", "infeasible": "no throw"}
"""Cases of a plan, and what tables call them."""
CELLS: Final = 64
"""Cells of the vectors for which goals are set."""
REST: Final = "everything else"
"""The part of a step that stands last."""
TABLES: Final = {
    name: Table.model_validate(entry)
    for name, entry in read_yaml(Path(__file__).with_name("speeds.yaml"), "speeds").items()
}


def _planner(data: Data) -> Rows:
    """Timings of the exact planner beside the paper's two methods, from one run."""
    names = ("plan_release_us", "batch_of_64_us", "batch_plans_per_s")
    rows: Rows = [{"planner": case, **{name: data[name][kind] for name in names}} for kind, case in KINDS.items()]
    methods = {
        "Method 1 of the paper (SLSQP)": "method_1_slsqp_median_us",
        "Method 2 of the paper": "method_2_median_us",
    }
    return [*rows, *({"planner": f"{name}, no ceiling", names[0]: data[key]} for name, key in methods.items())]


def _goals(data: Data) -> Rows:
    """What the speeds should be, and what they are."""
    conveyor, line = (
        {(row["cells"], row["threads"]): row for row in data["envs"][env]["rows"] if row["level"] == level}
        for env, level in (("PnTConveyor-v0", "waste"), ("PnTLine-v0", "single"))
    )
    gain = line[CELLS, 2]["env_throws_per_s"] / line[CELLS, 1]["env_throws_per_s"]
    shares = {form: row["env_over_bare"] for form, row in conveyor.items()}
    goals = (
        ("`PnTConveyor-v0`, waste, single, share of bare physics", 0.60, shares[1, 1]),
        ("`PnTConveyor-v0`, waste, 64 cells, one thread, share of bare physics", 0.92, shares[CELLS, 1]),
        ("`PnTConveyor-v0`, waste, 64 cells, two threads, share of bare physics", 0.88, shares[CELLS, 2]),
        ("`PnTLine-v0`, single, by table, two threads over one", 1.7, gain),
    )
    return [{"speed": speed, "asked": asked, "measured": measured} for speed, asked, measured in goals]


def _shares(data: Data) -> Rows:
    """Parts of a step by their shares of the processor's time, step by step."""
    forms = {1: "single"}
    steps = [
        (f"`{step['env']}`, {step['level']}, {forms.get(step['cells'], str(step['cells']) + ' cells')}", step["parts"])
        for step in data["steps"]
    ]
    names = sorted(dict.fromkeys(part for _, parts in steps for part in parts), key=lambda part: part == REST)
    return [{"part": part, "step": step, "share": parts.get(part)} for part in names for step, parts in steps]


ROWS: Final[Mapping[str, Callable[[Data], Rows]]] = {
    "planner": _planner,
    # Throws per second against bare physics and against a single environment.
    "environments": lambda data: [
        {"env": env, **row} for env, figures in data["envs"].items() for row in figures["rows"]
    ],
    "speed-goals": _goals,
    "shares": _shares,
    "training-shares": lambda data: [{"part": part, "share": share} for part, share in data["parts"].items()],
    "training-before": lambda data: [{"seed": k, **turns} for k, turns in enumerate(data["training"]["seeds"])],
    "steps-before": lambda data: data["steps"]["rows"],
}
"""By the name of a table, the function that makes its rows from a file."""


def grid(name: str, data: Data) -> Grid:
    """A table of speeds by its name."""
    return make_grid(TABLES[name], ROWS[name](data), data)


KNOWN: Final = (
    ({"plan_release_us", "batch_plans_per_s"}, partial(grid, "planner")),
    ({"envs", "cpus"}, partial(grid, "environments")),
    ({"steps", "cpus"}, partial(grid, "shares")),
    ({"parts", "throws"}, partial(grid, "training-shares")),
    ({"training", "steps"}, partial(grid, "training-before")),
    ({"training", "steps"}, partial(grid, "steps-before")),
)
"""By what the files that `make perf` writes are known, and their tables."""
