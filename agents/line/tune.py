"""Tune the settings of a line's rules and planners on separate shifts: `pnt-gym line tune --level value`."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final, Literal, get_args

import numpy as np
import tyro

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.reading import yaml_text

from ..dispatchers import search as tuning
from ..dispatchers.search import Bench, SettingsResult
from ..dispatchers.settings import FILE, MADE, rate, settings, settings_in
from ..ground.cli import UsageError, at_least, check_libraries, option
from ..ground.environments import stream_seed
from ..ground.outputs import check_writable, deliver_json, deliver_text
from ..ground.tables import console, settings_table, throws_bar
from ..ground.versions import versions

Tunable = Literal["atc", "price", "beam", "price_beam", "index", "guided_beam"]
ORDER: Final[tuple[Tunable, ...]] = get_args(Tunable)
"""Controllers in the order of tuning; each controller uses the settings of the first controller."""
ENOUGH: Final = 32
"""Least number of shifts from which settings are kept; with fewer shifts settings are only shown."""
HEAD: Final = (
    "# Settings with which rules and planners of a line ship, by level: what `pnt-gym line tune` has found on seeds of "
    "its own.\n# `rate` is the value that the tuned ATC rule brings in a second.\n"
)


TUNABLE = (
    "Controllers, and the settings to tune: atc (patience), price (patience, share), beam (price of time), "
    "price_beam (price of time, share), index (weights, by evolution), guided_beam (trust in plans)."
)


@dataclass(frozen=True)
class Arguments:
    """Tune the settings of rules and planners of a line, on shifts that no evaluation sees."""

    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "single"
    """A shipped level's name or a YAML file; throws succeed by the level's table of chances."""
    what: Annotated[tuple[Tunable, ...], tyro.conf.arg(metavar="NAME ...", help=TUNABLE)] = field(
        default=("atc", "price")
    )
    shifts: int = 64
    """Shifts for every setting; settings are kept only from 32 shifts on."""
    generations: int = 40
    """Generations of the search for an index."""
    go_on: bool = False
    """Begin the search at the level's shipped index, not at the ATC rule; give another --seed for other shifts."""
    seed: int = 0
    """Seed of the shifts."""
    out: Annotated[Path | None, option("runs/line_rules.yaml, where rules and planners find them", "FILE.yaml")] = None
    """File of the settings by level; settings of other levels in the file stay."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write every tried setting, and its value per minute in each shift, to this file."""


def main(arguments: Arguments) -> None:
    """Try the settings, print the table, and keep the best ones."""
    at_least(vars(arguments), shifts=1, generations=1, seed=0)
    check_libraries(*(["cma"] if "index" in arguments.what else []))
    if arguments.out is not None and arguments.shifts < ENOUGH:
        raise UsageError(f"--shifts is {arguments.shifts}; settings are saved to --out from {ENOUGH} shifts on")
    place = MADE if arguments.out is None else arguments.out
    check_writable(place, arguments.json)
    level, by_level = LineConfig.load(arguments.level, throws="table"), settings_in(place)
    results = try_settings(level, arguments)
    enough = arguments.shifts >= ENOUGH
    if enough:
        level_settings: dict[str, Any] = dict(by_level.get(level.name, {}))
        if "atc" in results:
            level_settings["rate"] = round(_rate(results["atc"]), 3)
        level_settings |= {controller: tuning.best(values).settings for controller, values in results.items()}
        deliver_text(
            place, HEAD + yaml_text({**by_level, level.name: level_settings}, default_flow_style=None, width=110)
        )
    if arguments.json is not None:
        deliver_json(arguments.json, as_json(level, arguments, results))
    console().print(
        settings_table(f"level {level.name}, {arguments.shifts} shifts each, seed {arguments.seed}", rows(results))
    )
    message = f"{arguments.shifts} shifts are too few, so no settings were saved; set --shifts to {ENOUGH} or more"
    console().print(f"the best settings are in {place}" if enough else message)
    if enough and arguments.out is None and level.name in settings_in(FILE):
        console().print(f"level {level.name} has shipped settings, which stay in force")
    if arguments.json is not None:
        console().print(f"all tried settings are in {arguments.json}")


def try_settings(level: LineConfig, arguments: Arguments) -> dict[str, list[SettingsResult]]:
    """All tried settings and their values, by controller."""
    first = stream_seed("practice", arguments.seed)
    results: dict[str, list[SettingsResult]] = {}
    with throws_bar() as bar:
        controllers: list[Tunable] = [controller for controller in ORDER if controller in arguments.what]
        for controller in controllers:
            task = bar.add_task(f"shifts for {controller}", total=max_shifts(controller, level, arguments))
            bench = Bench(level, np.arange(first, first + arguments.shifts), partial(bar.advance, task))
            results[controller] = tune(controller, bench, arguments, results)
            bar.update(task, total=bar.tasks[task].completed)
    return results


def max_shifts(controller: Tunable, level: LineConfig, arguments: Arguments) -> int:
    """Largest number of shifts for tuning a controller."""
    grid = (1 + len(tuning.COARSE[0])) * len(tuning.COARSE[1])
    share = 1 if len(level.robots) == 1 else grid + len(tuning.SHARE) + len(tuning.PATIENCE)
    pairs = len(tuning.AROUND) + len(tuning.SHARES)
    counts = {
        "atc": len(tuning.PATIENCE), "price": share, "price_beam": pairs, "index": 2, "guided_beam": len(tuning.TRUST),
    }  # fmt: skip
    settings_count = counts.get(controller, len(tuning.PRICE))
    return settings_count * arguments.shifts + (
        arguments.generations * tuning.SEARCHED_SHIFTS if controller == "index" else 0
    )


def tune(
    controller: Tunable, bench: Bench, arguments: Arguments, results: dict[str, list[SettingsResult]]
) -> list[SettingsResult]:
    """Tried settings of one controller, starting from the tuned ATC rule of this run, or from the shipped one."""
    if controller == "atc":
        return tuning.atc(bench)
    name, robots = bench.level.name, len(bench.level.robots)
    patience = (tuning.best(results["atc"]).settings if "atc" in results else settings(name, "atc"))["patience"]
    if controller == "price":
        return tuning.price(bench, patience)
    if controller == "index":
        begin = settings(name, controller).get("weights") if arguments.go_on else None
        return tuning.weights(bench, patience, arguments.generations, arguments.seed, begin)
    brings = _rate(results["atc"]) if "atc" in results else rate(name)
    brings = _rate(bench.try_rule("atc", [{"patience": patience}])) if brings is None else brings
    return tuning.planner(bench, controller, brings / robots)


def _rate(values: list[SettingsResult]) -> float:
    """Value per second with the best settings."""
    return float(tuning.best(values).value.mean()) / 60.0


def rows(results: dict[str, list[SettingsResult]]) -> list[tuple[str, dict[str, Any], Any, Any]]:
    """Controllers, best settings, values per minute, and values of the best ATC rule, if it was tuned too."""
    base = tuning.best(results["atc"]).value if "atc" in results else None
    ends = {controller: tuning.best(values) for controller, values in results.items()}
    return [(controller, end.settings, end.value, base) for controller, end in ends.items()]


def as_json(level: LineConfig, arguments: Arguments, results: dict[str, list[SettingsResult]]) -> dict[str, Any]:
    """All tried settings and their values, as JSON values."""
    by_controller = {
        controller: [{**setting.settings, "value_per_min": setting.value.tolist()} for setting in values]
        for controller, values in results.items()
    }
    return {
        "level": level.name,
        "shifts": arguments.shifts,
        "seed": arguments.seed,
        **by_controller,
        "versions": versions(),
    }
