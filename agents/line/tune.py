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
from ..dispatchers.search import Bench, Tried
from ..dispatchers.settings import FILE, rate, settings
from ..ground.cli import UsageError, at_least, option
from ..ground.environments import stream_seed
from ..ground.files import read_yaml
from ..ground.outputs import check_writable, deliver_json, deliver_text
from ..ground.tables import console, throws_bar, tuned_table
from ..ground.versions import versions

What = Literal["atc", "price", "beam", "price_beam", "joint_beam", "index", "guided_beam"]
ORDER: Final[tuple[What, ...]] = get_args(What)
"""Controllers in the order of tuning; each uses the settings of the first one."""
ENOUGH: Final = 32
"""Least number of shifts from which settings are kept; with fewer shifts settings are only shown."""
HEAD: Final = (
    "# Settings with which rules and planners of a line ship, by level: what `pnt-gym line tune` has found on seeds of "
    "its own.\n# `rate` is the value that the tuned ATC rule brings in a second.\n"
)


@dataclass(frozen=True)
class Arguments:
    """Tune the settings of rules and planners of a line, on shifts that no evaluation sees."""

    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "single"
    """A shipped level's name or a YAML file; throws succeed by the level's table of chances."""
    what: tuple[What, ...] = field(default=("atc", "price"))
    """Controllers to tune: patience of atc, patience and share of price, price of time of the beams, also the share of
    price_beam, the weights of an index by evolution, or the trust of guided_beam in its plans."""
    shifts: int = 64
    """Shifts for every setting; settings are kept only from 32 shifts on."""
    generations: int = 40
    """Generations of the search for an index."""
    go_on: bool = False
    """Begin the search for an index at the level's shipped index instead of the ATC rule; give another --seed for other
    shifts."""
    seed: int = 0
    """Seed of the shifts."""
    out: Annotated[Path | None, option("configs/line_rules.yaml", "FILE.yaml")] = None
    """File of the settings by level; settings of other levels in the file stay."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write every tried setting, and its value per minute in each shift, to this file."""


def main(arguments: Arguments) -> None:
    """Try the settings, print the table, and keep the best ones."""
    at_least(vars(arguments), shifts=1, generations=1, seed=0)
    place = FILE if arguments.out is None else arguments.out
    check_writable(place, arguments.json)
    level, known = LineConfig.load(arguments.level, throws="table"), kept_in(place)
    told = found(level, arguments)
    enough = arguments.shifts >= ENOUGH
    if enough:
        keep(place, known, level, told)
    if arguments.json is not None:
        deliver_json(arguments.json, as_json(level, arguments, told))
    console().print(
        tuned_table(f"level {level.name}, {arguments.shifts} shifts each, seed {arguments.seed}", rows(told))
    )
    few = f"{arguments.shifts} shifts are too few to keep what they say; {ENOUGH} are enough"
    console().print(f"kept in {place}" if enough else few)
    if arguments.json is not None:
        console().print(f"all that was tried is in {arguments.json}")


def found(level: LineConfig, arguments: Arguments) -> dict[str, list[Tried]]:
    """All tried settings and their values, by controller."""
    first = stream_seed("practice", arguments.seed)
    told: dict[str, list[Tried]] = {}
    with throws_bar() as bar:
        wanted: list[What] = [what for what in ORDER if what in arguments.what]
        for what in wanted:
            task = bar.add_task(f"shifts for {what}", total=most(what, level, arguments))
            bench = Bench(level, np.arange(first, first + arguments.shifts), partial(bar.advance, task))
            told[what] = tried(what, bench, arguments, told)
            bar.update(task, total=bar.tasks[task].completed)
    return told


def most(what: What, level: LineConfig, arguments: Arguments) -> int:
    """Largest number of shifts for tuning a controller."""
    grid = (1 + len(tuning.COARSE[0])) * len(tuning.COARSE[1])
    share = 1 if len(level.robots) == 1 else grid + len(tuning.SHARE) + len(tuning.PATIENCE)
    both = len(tuning.AROUND) + len(tuning.SHARES)
    counts = {
        "atc": len(tuning.PATIENCE), "price": share, "price_beam": both, "index": 2, "guided_beam": len(tuning.TRUST),
    }  # fmt: skip
    each = counts.get(what, len(tuning.PRICE))
    return each * arguments.shifts + (arguments.generations * tuning.SEARCHED_SHIFTS if what == "index" else 0)


def tried(what: What, bench: Bench, arguments: Arguments, told: dict[str, list[Tried]]) -> list[Tried]:
    """Tried settings of one controller, starting from the tuned ATC rule of this run, or from the shipped one."""
    if what == "atc":
        return tuning.atc(bench)
    name, robots = bench.level.name, len(bench.level.robots)
    patience = (tuning.best(told["atc"]).settings if "atc" in told else settings(name, "atc"))["patience"]
    if what == "price":
        return tuning.price(bench, patience)
    if what == "index":
        from ..dispatchers.scores import searched  # noqa: PLC0415 - needs a library that only it does

        begin = settings(name, what).get("weights") if arguments.go_on else None
        return searched(bench, patience, arguments.generations, arguments.seed, begin)
    brings = a_second(told["atc"]) if "atc" in told else rate(name)
    brings = a_second(bench.rules("atc", [{"patience": patience}])) if brings is None else brings
    return tuning.planner(bench, what, brings / robots)


def a_second(values: list[Tried]) -> float:
    """Value per second with the best settings."""
    return float(tuning.best(values).value.mean()) / 60.0


def rows(told: dict[str, list[Tried]]) -> list[tuple[str, dict[str, Any], Any, Any]]:
    """Controllers, best settings, values per minute, and values of the best ATC rule, if it was tuned too."""
    base = tuning.best(told["atc"]).value if "atc" in told else None
    ends = {what: tuning.best(values) for what, values in told.items()}
    return [(what, end.settings, end.value, base) for what, end in ends.items()]


def kept_in(place: Path) -> dict[str, Any]:
    """Settings in an existing file, by level.

    Raises:
        UsageError: the file holds other data.
    """
    known: Any = (read_yaml(place, "settings of rules") or {}) if place.is_file() else {}
    if not (isinstance(known, dict) and all(isinstance(own, dict) for own in known.values())):
        raise UsageError(f"{str(place)!r} holds no settings of rules by level")
    return known


def keep(place: Path, known: dict[str, Any], level: LineConfig, told: dict[str, list[Tried]]) -> None:
    """Write the best settings to the file, keeping the settings of other levels and controllers."""
    own: dict[str, Any] = dict(known.get(level.name, {}))
    if "atc" in told:
        own["rate"] = round(a_second(told["atc"]), 3)
    own |= {what: tuning.best(values).settings for what, values in told.items()}
    deliver_text(place, HEAD + yaml_text({**known, level.name: own}, default_flow_style=None, width=110))


def as_json(level: LineConfig, arguments: Arguments, told: dict[str, list[Tried]]) -> dict[str, Any]:
    """All tried settings and their values, as JSON values."""
    each = {
        what: [{**one.settings, "value_per_min": one.value.tolist()} for one in values] for what, values in told.items()
    }
    return {"level": level.name, "shifts": arguments.shifts, "seed": arguments.seed, **each, "versions": versions()}
