"""Fit a level to measured throws: `python -m agents.fit LOG.csv --level mine.yaml --out fitted.yaml`."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import tyro

from .ground.cli import UsageError, at_least, option, read_settings, run
from .ground.outputs import check_ending, check_writable, deliver_json, deliver_text
from .ground.tables import console, throws_bar

if TYPE_CHECKING:
    from pnt_gym.cells.conveyor.config import ConveyorConfig

    from .fitting.parameters import Parameter

MISFIT: Final = 1
"""Exit code where the model does not fit the log."""


@dataclass(frozen=True)
class Arguments:
    """Fit a conveyor level to logged throws: valve, vacuum, drag, camera, encoder and lip, with intervals.

    Exit code 1 says that the model does not fit the log; the results are written all the same.
    """

    log: Annotated[Path | None, tyro.conf.Positional, tyro.conf.arg(metavar="LOG.csv", name="log")] = None
    """Log of throws, one row a throw; none for --design or --twins alone."""
    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "waste"
    """The level that describes the cell so far; priors lie about its values."""
    out: Annotated[Path | None, option("none", "FILE.yaml")] = None
    """Write the fitted level, with intervals in comments."""
    page: Annotated[Path | None, option("none", "FILE.html")] = None
    """Write a page with predicted and measured landings."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write all figures to this file."""
    free: Annotated[tuple[str, ...] | None, option("all", "NAME")] = None
    """Parameters that are not known: valve, tau, drag, camera_x, camera_y, encoder, stiffness."""
    prior: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, option("see docs/fit.md", "NAME=SD")] = ()
    """Standard deviation of a prior, such as camera_x=0.003 [m]; of the logarithm for tau, drag and stiffness."""
    design: Annotated[int | None, option("none", "N")] = None
    """Choose the next N throws that tell most, beside what the log tells already."""
    plan: Annotated[Path | None, option("none", "FILE.csv")] = None
    """Write the throws of --design to this file, in the form of a log without results."""
    twins: Annotated[int | None, option("none", "N")] = None
    """Fit N simulated cells with hidden parameters, and print how often intervals hold the truth."""
    landings: int = 40
    """Landings of each twin's log."""
    seed: int = 0
    """Seed of --design and --twins."""


def main(arguments: Arguments) -> None:
    """Fit the log, print what it tells, and write the files asked for."""
    from pnt_gym.cells.conveyor.config import ConveyorConfig

    from .fitting.parameters import priors

    at_least(vars(arguments), design=1, twins=1, seed=0, landings=10)
    check_writable(arguments.out, arguments.page, arguments.json, arguments.plan)
    check_ending("out", arguments.out, (".yaml", ".yml"))
    if arguments.log is None and arguments.design is None and arguments.twins is None:
        raise UsageError("give a log, or --design N, or --twins N")
    config = ConveyorConfig.load(arguments.level).model_copy(update={"fidelity": "flight"})
    parameters = priors(config, arguments.free, read_settings(arguments.prior))
    found = None if arguments.log is None else _fit(arguments, config, parameters)
    if arguments.design is not None:
        _design(arguments, config, parameters, found)
    if arguments.twins is not None:
        _twins(arguments, config)
    if found is not None and not found.fits:
        sys.exit(MISFIT)


def _fit(arguments: Arguments, config: ConveyorConfig, parameters: tuple[Parameter, ...]) -> Any:
    """Fit a log, print what it tells, and write the files asked for."""
    from .fitting.fitted import fit_log
    from .fitting.reading import read_log
    from .fitting.report import report
    from .fitting.words import sentences, tables
    from .fitting.writing import level_text, page

    assert arguments.log is not None
    found = fit_log(read_log(arguments.log, config), config, parameters)
    samples = found.posterior.samples()
    for grid in tables(found, samples):
        console().print(grid.terminal())
    for sentence in sentences(found, samples):
        console().print(sentence, highlight=False, markup=False, soft_wrap=True)
    source = f"pnt-gym fit {arguments.log.name} --level {arguments.level}"
    if arguments.out is not None:
        base = arguments.level
        if Path(base).suffix:
            base = os.path.relpath(base, arguments.out.parent)
        deliver_text(arguments.out, level_text(found, samples, base, arguments.out.stem, source))
    if arguments.page is not None:
        deliver_text(arguments.page, page(found, samples, source))
    if arguments.json is not None:
        deliver_json(arguments.json, {"level": arguments.level, **report(found, samples)})
    return found


def _design(arguments: Arguments, config: ConveyorConfig, parameters: tuple[Parameter, ...], found: Any) -> None:
    """Print and write the next throws."""
    from .fitting.design import plan_throws
    from .fitting.report import plan_grid

    assert arguments.design is not None
    log = plan_throws(config, parameters, arguments.design, arguments.seed, found)
    console().print(plan_grid(log, config).terminal())
    if arguments.plan is not None:
        deliver_text(arguments.plan, log.text(config.items))


def _twins(arguments: Arguments, config: ConveyorConfig) -> None:
    """Fit twins and print how good the fits are."""
    from .fitting.report import twins_grid
    from .fitting.twins import judge_fit, study_twin

    judged: list[tuple[dict[str, Any], bool]] = []
    with throws_bar() as bar:
        task = bar.add_task("twins", total=arguments.twins)
        for twin in range(arguments.twins or 0):
            planned = arguments.design is not None
            cell, found, _ = study_twin(config, arguments.seed + twin, arguments.landings, planned=planned)
            judged.append((judge_fit(cell, found), found.fits))
            bar.advance(task)
    console().print(twins_grid(judged).terminal())


if __name__ == "__main__":
    run(main, Arguments, "agents.fit")
