"""Simulated tosses by the gripper robot of Leveziel et al.: the planner, an oracle, and learners of the release time.

The paper shows tosses by the robot without measurements, so every figure here is `ours`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from typing import Any, Final, NamedTuple, cast

import numpy as np

from agents.controllers import make_controller
from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots, svg
from agents.ground.environments import Env, core_of, make_vector
from agents.ground.metrics import wilson
from agents.ground.tables import Grid
from agents.judging.loop import practise, throw_held_out
from agents.judging.throw_record import summary
from agents.judging.throws import Throws
from agents.reproduce.finding import Findings, Overview, Row
from agents.reproduce.grids import JsonRow, Rows, below, number, plain
from pnt_gym.arrays import Floats, concatenate_records
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.planner import TossPlanner
from pnt_gym.planning.motion.ballistics import landing_point

from .cases import item_label

ENV: Final = "GripperToss-v0"
ROWS: Final = 16
"""Number of cells in the batch."""
SEEDS: Final = (0, 1, 2)
"""Seeds of practice and of the held-out objects."""
HELD: Final = 64
"""Number of held-out throws of each seed."""
LEVELS: Final = ("nominal", "late", "patient", "drop", "belt")
"""Levels of the planner's part; `belt` is the up-scaled robot at the conveyor cell's belt."""
STAGES: Final = (10, 100, 1000)
"""Numbers of practice throws after which a learner is evaluated."""
LEARNERS: Final[Mapping[str, Mapping[str, Sequence[int]]]] = {
    "virtual_goal": {"nominal": STAGES, "late": STAGES[:2], "belt": STAGES[:2]},
    "ridge": {"nominal": STAGES, "late": STAGES[:2], "belt": STAGES[:2]},
    "mlp": {"nominal": STAGES},
}
"""Learners by name: their levels, and the numbers of practice throws after which each is evaluated."""
PREVIEWS: Final = 8
"""Simulations of each throw by the oracle; 25 of them land no nearer."""
PLANNERS: Final = {
    "analytic": "the planner alone, which opens the claws at one fixed time before the release",
    "oracle": f"a controller that simulates each throw {PREVIEWS} times beforehand, with its hidden values, all but "
    "the scatter of the opening",
}
DRAWN: Final = ("nominal", "virtual_goal", 100)
"""Level, controller and throws of practice whose releases are drawn."""
CURVES: Final = ("nominal", "late", "belt")
"""Levels whose learning curves are drawn."""
LINES: Final = {"analytic": "the planner alone", "oracle": "oracle"}
"""Controllers that do not learn."""
MILLI: Final = 1e3
RANGE: Final = (-0.012, 0.050)
"""Range of release times that is drawn, after the planned release time [s]."""


class HeldOutThrows(NamedTuple):
    """Held-out throws of one controller after a number of practice throws, seed by seed."""

    level: str
    controller: str
    practice: int
    by_seed: list[Throws]


def planner_findings(levels: Sequence[str] = LEVELS, seeds: Sequence[int] = SEEDS, throws: int = HELD) -> Findings:
    """Success of the planner and of the oracle, which do not learn, on every level."""
    cycles, rows = list[int](), list[Row]()
    for level in levels:
        with closing(make_vector(ENV, level, ROWS, threads=1)) as env:
            for name, description in PLANNERS.items():
                rows += [
                    _toss_row(result, seeds, env, description)
                    for result in _evaluate(name, env, level, (0,), seeds, throws, cycles)
                ]
    return Findings((*rows, _endurance_row("planner", cycles)))


def learner_findings(
    name: str, stages: Mapping[str, Sequence[int]], seeds: Sequence[int] = SEEDS, throws: int = HELD
) -> Findings:
    """Success of a learner at each stage of its practice on every level, and a drawing of its releases."""
    cycles, rows, figures = list[int](), list[Row](), dict[str, str]()
    for level, counts in stages.items():
        with closing(make_vector(ENV, level, ROWS, threads=1)) as env:
            for result in _evaluate(name, env, level, counts, seeds, throws, cycles):
                rows.append(_toss_row(result, seeds, env, f"{name} after {result.practice:,} throws of practice"))
                if (result.level, result.controller, result.practice) == DRAWN:
                    (before,) = _evaluate("analytic", env, level, (0,), seeds, throws, cycles)
                    title = f"{name.replace('_', ' ')}, {result.practice} throws"
                    panels = {
                        "the planner alone": concatenate_records(before.by_seed),
                        title: concatenate_records(result.by_seed),
                    }
                    figures["leveziel_release.svg"] = svg(release_figure(panels, core_of(env).config))
    return Findings((*rows, _endurance_row(name, cycles)), {}, figures)


def _evaluate(
    name: str, env: Env, level: str, counts: Sequence[int], seeds: Sequence[int], throws: int, cycles: list[int]
) -> list[HeldOutThrows]:
    results = [HeldOutThrows(level, name, count, []) for count in counts]
    options: dict[str, Any] = {"previews": PREVIEWS} if name == "oracle" else {}
    controller = make_controller(name, env, **options)
    for seed in seeds:
        controller.reset(seed)
        completed = 0
        for result in results:
            practise(controller, env, result.practice - completed, seed, start=completed, progress=cycles.append)
            completed = result.practice
            result.by_seed.append(throw_held_out(controller, env, throws, seed, progress=cycles.append))
    return results


def _toss_row(result: HeldOutThrows, seeds: Sequence[int], env: Env, description: str) -> Row:
    """Row with the success of one controller, and with landing errors and release times as details."""
    throws, names = concatenate_records(result.by_seed), map(item_label, core_of(env).item_names)
    figures = summary(throws)
    miss = cast(float, figures["landing_error_mean_m"])
    rate = wilson(int(throws.is_success.sum()), len(throws))
    by_item = {name: throws.item == k for k, name in enumerate(names)}
    delay = {name: throws.error[is_item, 2] for name, is_item in by_item.items() if is_item.any()}
    late = ", ".join(f"{name} {1e3 * times.mean():.1f} +- {1e3 * times.std():.1f} ms" for name, times in delay.items())
    stage = f"{result.controller}-{result.practice}" if result.practice > 0 else result.controller
    return Row.ours(
        f"leveziel/toss/{result.level}/{stage}",
        100.0 * rate.value,
        "%",
        note=f"of {len(throws)} held-out throws cross their compartment's opening and come to lie in it, by "
        f"{description}; level {result.level}, seeds {', '.join(map(str, seeds))}, 95 % interval "
        f"{100.0 * rate.low:.1f} to {100.0 * rate.high:.1f} %. Landing error {1e3 * miss:.1f} mm on average; objects "
        f"come free against the plan: {late}",
        level=result.level,
        controller=result.controller,
        practice=result.practice,
        throws=len(throws),
        success_low=100.0 * rate.low,
        success_high=100.0 * rate.high,
        success_by_seed=[100.0 * float(t.is_success.mean()) for t in result.by_seed],
        success_by_item={n: 100.0 * float(throws.is_success[m].mean()) for n, m in by_item.items() if m.any()},
        landing_error_m=figures["landing_error_mean_m"],
        landing_error_p95_m=figures["landing_error_p95_m"],
        landing_error_by_seed_m=[float(np.nanmean(t.landing_error)) for t in result.by_seed],
        release_delay_s={name: float(times.mean()) for name, times in delay.items()},
        release_delay_spread_s={name: float(times.std()) for name, times in delay.items()},
        release_delay_error_s=float(np.abs(throws.error[:, 2]).mean()),
        cycle_time_s=figures["cycle_time_mean_s"],
        recontact=figures["recontact_rate"],
    )


def _endurance_row(part: str, cycles: Sequence[int]) -> Row:
    note = (
        "cycles of grip, lift, toss and landing without a single warning of the physics engine, which would have "
        "stopped the reproduction; counted are the throws of practice and evaluation of this part, not the previews of "
        "the oracle"
    )
    return Row.ours(f"leveziel/endurance/{part}", float(sum(cycles)), "-", note=note, warnings=0)


def toss_overview(rows: Rows) -> Overview:
    """Table of all tosses, and learning curves of the levels on which a controller learned."""
    tosses = list(below(rows, "leveziel/toss").values())
    cycles = below(rows, "leveziel/endurance").values()
    endurance = plain("Cycles without a warning", cycles, verdict=False, drop="leveziel/")
    curves = {level: [row for row in tosses if row["level"] == level] for level in CURVES}
    curves = {
        level: level_rows for level, level_rows in curves.items() if any(row["practice"] > 0 for row in level_rows)
    }
    figures = {"leveziel_toss.svg": svg(learning_figure(curves))} if curves else {}
    return Overview({"tosses": _toss_grid(tosses), "endurance": endurance}, figures=figures)


def _toss_grid(tosses: Sequence[JsonRow]) -> Grid:
    """Table with one text line per level, controller and number of practice throws."""
    lines = [
        [
            row["level"],
            row["controller"],
            str(row["practice"] or "-"),
            f"{row['reproduced']:.1f} %",
            f"{row['success_low']:.1f} to {row['success_high']:.1f} %",
            f"{MILLI * row['landing_error_m']:.1f} mm",
            f"{MILLI * row['release_delay_error_s']:.1f} ms",
            f"{number(row, 'cycle_time_s', 2)} s",
        ]
        for row in tosses
    ]
    header = (
        "level", "controller", "throws of practice", "success", "95 % interval", "landing error", "off the plan",
        "cycle",
    )  # fmt: skip
    return Grid("Tosses into the tray's compartments, held-out throws", header, lines)


def release_figure(panels: Mapping[str, Throws], config: GripperConfig) -> Figure:
    """Drawing of the landing along the throw over the release time; ``panels`` holds throws by panel title."""
    figure, axes = subplots(len(panels), 1, (WIDTH, 3.8 * len(panels)), sharex=True, sharey=True)
    times, landings = free_landings(config)
    for panel, (name, throws) in zip(axes, panels.items(), strict=True):
        for k, item in enumerate(config.items):
            panel.plot(MILLI * times, MILLI * landings[k], color="gray", linewidth=1)
            _draw_dots(panel, throws, k, item_label(item))
        for side in (-0.5, 0.5):
            panel.axhline(side * MILLI * config.tray.opening[0], color="black", linestyle="--", linewidth=1)
        brake = MILLI * config.motion.after
        panel.axvline(brake, color="gray", linestyle=":", linewidth=1)
        panel.text(brake + 0.5, 0.02, "robot brakes", fontsize=8, color="gray", transform=panel.get_xaxis_transform())
        title = f"{name}: {100.0 * float(throws.is_success.mean()):.0f} % succeed"
        across = "object comes free after the planned moment [ms]" if panel is axes[-1] else ""
        dress(panel, across, "landing from the target along the throw [mm]", title)
    axes[0].plot([], [], color="gray", linewidth=1, label="let go on the planned path, no air")
    axes[0].plot([], [], color="black", linestyle="--", linewidth=1, label="edges of the compartment")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=2, loc="outside lower center")
    return figure


def _draw_dots(panel: Axes, throws: Throws, item: int, name: str) -> None:
    for success, marker, line, label in ((True, "o", 0, name), (False, "x", 1, f"{name}, missed")):
        rows = (throws.item == item) & (throws.is_success == success)
        if rows.any():
            x, y = MILLI * throws.error[rows, 2], MILLI * throws.info["landing_along"][rows]
            panel.scatter(x, y, s=14, marker=marker, color=COLOURS[item], linewidths=line, label=label)


def free_landings(config: GripperConfig) -> tuple[Floats, Floats]:
    """Release times (M,) [s], and landings of K items along the throw (K, M) [m] if the planned path releases then.

    Landings are without air and without a push of the claws; the pick is the middle of the pick area.
    """
    kinds = np.arange(len(config.items), dtype=np.int64)
    middle: Floats = np.array([config.table.pick_x, config.table.pick_y], dtype=np.float64).mean(axis=1)
    place = np.tile(middle, (kinds.size, 1))
    plans = TossPlanner(config).plan(kinds, place)
    step = config.timestep
    times = np.arange(RANGE[0] - step, RANGE[1] + step, step)
    position = plans.pose(plans.release_time[:, None] + times)[..., :3]
    velocity = np.asarray(np.gradient(position, step, axis=1), dtype=np.float64)
    position[..., 2] -= plans.hang[:, None]
    miss = landing_point(position, velocity, config.tray.rim) - plans.target[:, None]
    # `np.gradient` is not central at the ends.
    return times[1:-1], (miss * plans.heading[:, None]).sum(axis=-1)[:, 1:-1]


def learning_figure(levels: dict[str, list[JsonRow]]) -> Figure:
    """Drawing of success and landing error over practice throws, one row per level, mean and range over seeds."""
    figure, axes = subplots(len(levels), 2, (WIDTH, 2.8 * len(levels)), sharex=True, sharey="col")
    learners = sorted({row["controller"] for rows in levels.values() for row in rows if row["practice"] > 0})
    colours = dict(zip((*LINES, *learners), ("black", "gray", *COLOURS), strict=False))
    for row, (level, results) in enumerate(levels.items()):
        shares, errors = axes[2 * row], axes[2 * row + 1]
        for name, colour in colours.items():
            own = [result for result in results if result["controller"] == name]
            curve = sorted(own, key=lambda result: result["practice"])
            if curve:
                _draw_curve(shares, curve, "success_by_seed", 1.0, colour)
                _draw_curve(errors, curve, "landing_error_by_seed_m", 1e3, colour)
        across = "throws of practice" if row == len(levels) - 1 else ""
        dress(shares, across, "throws that succeed [%]", f"level {level}")
        dress(errors, across, "landing error, mean [mm]", f"level {level}", xscale="log", yscale="log")
    ticks = sorted({row["practice"] for rows in levels.values() for row in rows if row["practice"] > 0})
    for panel in axes:
        panel.set_xticks(ticks, [f"{tick:,}" for tick in ticks])
        panel.minorticks_off()
    axes[1].set_yticks([2, 5, 10, 20, 50], ["2", "5", "10", "20", "50"])
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=3, loc="outside lower center")
    return figure


def _draw_curve(panel: Axes, rows: list[JsonRow], entry: str, unit: float, colour: str) -> None:
    """Draw mean and range over the seeds; a horizontal line for a controller that does not learn."""
    values = [unit * np.array(row[entry], dtype=float) for row in rows]
    name = str(rows[0]["controller"])
    if name in LINES:
        panel.axhline(float(values[0].mean()), color=colour, linestyle="--", linewidth=1.2, label=LINES[name])
        return
    throws = [row["practice"] for row in rows]
    panel.plot(throws, [v.mean() for v in values], "o-", color=colour, label=name.replace("_", " "))
    panel.fill_between(throws, [v.min() for v in values], [v.max() for v in values], color=colour, alpha=0.15, lw=0)
