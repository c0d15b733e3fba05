"""Find how many robots and which belt speed a line needs: `python -m agents.line plan --level my_line.yaml`."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from pnt_gym.cells.line.config import MADE_TABLES
from pnt_gym.errors import ReachWarning

from ..ground import levels
from ..ground.cli import option
from ..ground.outputs import check_drawing, check_writable, deliver_json, deliver_text
from ..ground.tables import console
from . import placing, reasons, sensitivity, verdict
from .goal import USUAL, Goal
from .plan_picture import plan_picture


@dataclass(frozen=True)
class Arguments:
    """Sweep robots, belt speeds and speed limits over one stream of objects, and report plans that reach a recovery."""

    level: Annotated[str, tyro.conf.arg(metavar="NAME|FILE.yaml")] = "skills3"
    """A shipped level's name or a YAML file; all plans have its stream, items, bins and values."""
    recovery: float = USUAL
    """Recovery to reach: share of all objects that are sorted."""
    want: Annotated[str | None, option("the recovery", "95%|90/min")] = None
    """What to reach instead, a recovery or sorted objects a minute; the cheapest plan that reaches it is chosen."""
    robots: Annotated[tuple[int, ...], tyro.conf.arg(metavar="N ...")] = (1, 2, 3, 4)
    """Numbers of robots to try; further robots than the level has are copies of its last robot, at equal distances."""
    speeds: Annotated[tuple[float, ...] | None, option("that of the level", "M/S ...")] = None
    """Belt speeds to try [m/s]; the number of objects per minute stays the same."""
    percents: Annotated[tuple[float, ...] | None, option("those of the level", "PERCENT ...")] = None
    """Limits of the robots to try [% of V, A and J]."""
    skills: Annotated[tuple[Literal["level", "all"], ...], tyro.conf.arg(metavar="level|all ...")] = ("level",)
    """Skills to try: the skills of the level, or for every robot all items that its bins accept."""
    minutes: float = 2.0
    """Length of a shift [min]."""
    shifts: int = 16
    """Work shifts for each plan, at least 2."""
    burst: Annotated[float | None, option("the level's own", "SHAPE")] = None
    """Shape of the gamma distribution of the gaps between objects: 1 is a Poisson process, less means bursts."""
    down: Annotated[str | None, option("no robot", "ROBOT:MINUTES")] = None
    """Robot that stands still from the middle of the shift on, by its name or counted from 1 upstream, and the minutes
    for which the robot stands; plans without this robot have no standstill."""
    controller: str = "price"
    """The controller: one of fifo, spt, value_rate, atc, price, beam, price_beam, guided_beam."""
    release: Annotated[str | None, option("analytic", "NAME|shipped:NAME|RUN_DIR")] = None
    """Controller that corrects the throws of all plans: a controller or a policy of PnTRelease-v0."""
    throws: int = 1000
    """Throws to count for a table of chances that does not exist yet."""
    fidelity: Literal["flight", "full"] = "full"
    """Where throws are counted: in the full physics, or in flights, which take a second a plan and write no table."""
    check: int = 4
    """Shifts that the chosen plan works in the full physics as well, at least 2; 0 for none."""
    mend: bool = True
    """Try what could mend the chosen plan, one thing changed at a time, by flights."""
    sensitivity: bool = False
    """Try each assumed number of the chosen plan at both ends of its plausible range, by flights: which one decides?"""
    seed: int = 0
    """Seed of the objects."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write all plans to this file."""
    picture: Annotated[Path | None, option("none", "FILE.svg")] = None
    """Draw the line to scale, the fates of objects and the energy of all plans, and where each item lands."""
    place: Annotated[Literal["bins", "robots", "all"] | None, option("nothing", "bins|robots|all")] = None
    """Search for better places of the level's bins, of its robots along the belt, or of both, and judge these places
    in the full physics instead of a sweep."""
    keep_out: Annotated[tuple[tuple[float, float, float, float], ...], option("none", "X0 X1 Y0 Y1 ...")] = ()
    """Rectangles in which --place puts no bin, from the line's origin [m]."""
    tries: int = 100
    """Layouts that --place tries, at most."""
    write: Annotated[Path | None, option("none", "FILE.yaml")] = None
    """Write the level with the places found by --place to this file."""
    tables: Path = MADE_TABLES
    """Folder of the tables of chances that do not ship; other commands look for tables in the default folder."""
    threads: int = 2
    """Threads of the simulation."""


def main(arguments: Arguments) -> None:
    """Judge every plan, and report the smallest one that reaches the recovery, and the reason."""
    # The table has a column for what is out of reach, for every plan.
    warnings.simplefilter("ignore", ReachWarning)
    if arguments.place is not None:
        placing.place(arguments.place, vars(arguments))
        return
    placing.check_absent(vars(arguments))
    sweep, conditions = verdict.read(vars(arguments))
    check_writable(arguments.json, arguments.picture)
    check_drawing(picture=arguments.picture)
    goal = Goal.of(arguments.recovery, arguments.want)
    level = verdict.load(arguments.level, arguments.release)
    levels.show(level)
    judged = verdict.judge(level, sweep, conditions, goal, arguments.release, console().print)
    shifts = f"{arguments.shifts} shifts of {arguments.minutes:g} min each"
    title = f"shares in %; level {arguments.level}, {shifts}, {arguments.controller}, release {judged.verdict.release}"
    console().print(reasons.table(title, judged.plans, goal).terminal())
    for sentence in judged.verdict.sentences:
        console().print(sentence)
    if arguments.sensitivity:
        plan = judged.verdict.plan
        title = f"assumed numbers of {reasons.plan_text(plan.row)}"
        console().print(sensitivity.table(title, plan, judged.verdict.swings).terminal())
    if arguments.json is not None:
        deliver_json(arguments.json, judged.entries)
    if arguments.picture is not None:
        deliver_text(arguments.picture, plan_picture(judged.plans, judged.verdict, goal))
