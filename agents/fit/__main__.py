"""Fit a level to measured throws: `python -m agents.fit LOG.csv --level mine.yaml --out fitted.yaml`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import tyro

from ..ground.cli import Exit, UsageError, at_least, at_most, check_effects, option, read_settings, run
from ..ground.outputs import check_ending, check_writable, deliver_json, deliver_text
from ..ground.tables import console

if TYPE_CHECKING:
    from pnt_gym.cells.conveyor.config import ConveyorConfig

    from .fitted import Fitted
    from .parameters import Parameter

MISFIT: Final = 1
"""Exit code where the model does not fit the log."""
MOST_TWINS: Final = 10_000
"""Largest number of --twins, the work of a day."""
NEEDS: Final = {"out": "log", "page": "log", "json": "log", "free_motion": "log", "plan": "design", "landings": "twins"}
"""By the name of an option, the name of that without which the option has no effect."""


@dataclass(frozen=True)
class Arguments:
    """Fit a conveyor level to logged throws: valve, vacuum, blow-off, drag, camera, encoder and lip, with intervals.

    Exit code 1 says that the model does not fit the log; the results are written all the same.
    """

    log: Annotated[Path | None, tyro.conf.Positional, option("none", "LOG.csv")] = None
    """Log of throws, a file with one row a throw; no log is needed for --design or --twins alone."""
    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "waste"
    """The level that describes the cell so far; priors are centred on the values of this level. Of a line's level, the
    cell of the line."""
    free_motion: bool = False
    """Take releases as logged, of a robot that moves otherwise than the level's planner; without swing and grip."""
    out: Annotated[Path | None, option("none", "FILE.yaml")] = None
    """Write the fitted level, with intervals in comments."""
    page: Annotated[Path | None, option("none", "FILE.html")] = None
    """Write a page with predicted and measured landings."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write all figures to this file."""
    free: Annotated[tuple[str, ...] | None, option("all", "NAME ...")] = None
    """Parameters that are not known: valve, tau, blow_off, drag, camera_x, camera_y, encoder, stiffness."""
    prior: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, option("see docs/fit.md", "NAME=SD")] = ()
    """Standard deviation of a prior, such as camera_x=0.003 [m]; of the logarithm for tau, drag and stiffness."""
    design: Annotated[int | None, option("none", "N")] = None
    """Choose the next N throws, those that add most to the knowledge from the log."""
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
    from . import report
    from .design import POOL, plan_throws
    from .parameters import priors, read_level
    from .reading import FEWEST, MOST
    from .report import plan_grid

    at_least(vars(arguments), design=1, twins=1, seed=0, landings=FEWEST)
    at_most(vars(arguments), design=POOL, twins=MOST_TWINS, landings=MOST)
    check_effects(arguments, NEEDS, positional="log")
    check_writable(arguments.out, arguments.page, arguments.json, arguments.plan)
    check_ending("out", arguments.out, (".yaml", ".yml"))
    design, twins, seed = arguments.design, arguments.twins, arguments.seed
    if arguments.log is None and design is None and twins is None:
        raise UsageError("give a log, or --design N, or --twins N")
    if arguments.free_motion and not (design is twins is None):
        raise UsageError(
            "--design and --twins throw with the level's planner, not with a --free-motion; leave them out"
        )
    config, is_line = read_level(arguments.level)
    parameters = priors(config, arguments.free, read_settings(arguments.prior), arguments.free_motion)
    fitted = None if arguments.log is None else _fit(arguments, config, parameters, is_line)
    if design is not None:
        plan = plan_throws(config, parameters, design, seed, fitted)
        console().print(plan_grid(plan.throws, config).terminal())
        for sentence in plan.absent:
            console().print(sentence, highlight=False, markup=False, soft_wrap=True)
        if arguments.plan is not None:
            deliver_text(arguments.plan, plan.throws.text(config.items))
    if twins is not None:
        grid = report.grid(config, parameters, twins, seed, arguments.landings, planned=design is not None)
        console().print(grid.terminal())
    if fitted is not None and not fitted.fits:
        raise Exit(MISFIT)


def _fit(arguments: Arguments, config: ConveyorConfig, parameters: tuple[Parameter, ...], is_line: bool) -> Fitted:
    """Fit a log, print what it tells, and write the files asked for."""
    from . import reading, writing
    from .fitted import fit_log
    from .report import report
    from .words import sentences, tables
    from .writing import page

    path = arguments.log
    assert path is not None
    fitted = fit_log(reading.read(path, config, arguments.free_motion), config, parameters)
    samples = fitted.posterior.samples()
    for grid in tables(fitted, samples):
        console().print(grid.terminal())
    for sentence in sentences(fitted, samples):
        console().print(sentence, highlight=False, markup=False, soft_wrap=True)
    motion = " --free-motion" if arguments.free_motion else ""
    source = f"pnt-gym fit {path.name} --level {arguments.level}{motion}"
    if arguments.out is not None:
        base = "" if is_line else arguments.level
        deliver_text(arguments.out, writing.text(fitted, samples, base, arguments.out, source))
    if arguments.page is not None:
        deliver_text(arguments.page, page(fitted, samples, source))
    if arguments.json is not None:
        deliver_json(arguments.json, {"level": arguments.level, **report(fitted, samples)})
    return fitted


if __name__ == "__main__":
    run(main, Arguments, "agents.fit")
