"""What was held against measurement, and what to measure at a cell of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from statistics import NormalDist, fmean
from typing import Any, Final

from agents.ground.places import SHIPPED as ROOT
from agents.report import contents
from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.conveyor.config import ConveyorConfig

from .marks import table

RESULTS: Final = ROOT / "results"
POLICY: Final = "waste-sac"
"""Controller of the study `assumed` that does not learn at the cell."""
TAUS: Final = (5, 14)
"""Time constants of the vacuum on both sides of the assumed one, of that study [ms]."""
PICKS, DROPS = 20, 10
"""Picks at rest and drops of each kind that the page proposes."""
Row = tuple[str, str, str, str]
MEASURED: Final[tuple[Row, ...]] = (
    (
        "vacuum's decay (`suction.tau`)",
        "{tau:g} ms, **assumed**",
        "nothing published",
        "[what it decides](../results/cells.md)",
    ),
    (
        "push of the cup at the release (`cup.blow_off`)",
        "{waste.cup.blow_off:g} m/s, **assumed**",
        "nothing published; valves that blow off are usual",
        "makers of ejectors; [what it decides](../results/cells.md)",
    ),
    (
        "a tossed cube followed to rest, share of its side",
        "{cube:.1f} %",
        "other engines 13.5 to 25 %",
        "below; arXiv 2110.00541, second hand",
    ),
    (
        "an impact rises 5 mm above the bound that ends a fall",
        "never, by the bound",
        "{rises[cube]:.1f} % (cube) and {rises[square]:.1f} % (square)",
        "below, restitution 0.5",
    ),
    (
        "spread of restitution, of its logarithm",
        "{waste.spread.restitution:g} each throw",
        "{spread:.2f}, drop by drop",
        "drops of a square, `DAIRLab/ImpactModeling`",
    ),
    ("friction of PET, PP", "{pet.friction:g}, {cup.friction:g}", "0.26, 0.28 on wood", "notes of `utiasDSL/upright`"),
    (
        "drag of a lying can, a bottle",
        "{can.drag:g}, {pet.drag:g}",
        "0.66 to 0.70",
        "tables of short cylinders, not read again",
    ),
    (
        "chance that a cup seals: carton, PET, PP",
        "{carton.pick_chance:.2f}, {pet.pick_chance:.2f}, {cup.pick_chance:.2f}",
        "0.861 carton, 0.90 plastic",
        "Kim et al. 2019, SCITEPRESS paper 78399, abstract",
    ),
    (
        "residue of a PET bottle, a carton, in empty masses",
        "{pet.residue:g}, {carton.residue:g}",
        "0.07, 0.23",
        "Schinkel et al. 2023; Belle et al. 2025",
    ),
    ("mass of an empty 1 l carton", "{carton_grams:g} g", "29.2 g, mean of 949", "Belle et al. 2025"),
    (
        "picks that are tried a minute",
        "{planner[picks_per_min]:.0f}",
        "60 to 65; claims of 80",
        "reports of plants and makers, 2017 to 2023",
    ),
    (
        "landing error: planner, learned",
        "{planner[mm]:.0f} mm, {learned[mm]:.0f} mm",
        "within 50 mm after dozens of throws of one object; **nothing finer was found**",
        "Liu et al. 2025, arXiv 2510.10357, abstract",
    ),
)
"""Rows of the table of what was measured: what, ours, measured, source."""
ADVICE: Final[tuple[Row, ...]] = (
    (
        "a rig with one cup, its valve and hose, a gauge at 1 kHz and a camera at 240 pictures a second",
        "10 objects, 10 releases each",
        "delay of the valve, tau, blow-off, jitter",
        "a policy that does not learn at the cell loses up to {per_ms:.1f} sorted/min a millisecond of tau, and "
        "{push:.1f} for each 0.05 m/s of blow-off",
    ),
    (
        "picks of objects at rest",
        "{kinds} kinds, {picks} picks each",
        "the chance to seal, over all kinds to {points:.0f} points",
        "{seal:.1f} sorted/min a point, so {sealed:.1f}",
    ),
    (
        "drops from 0.5 m into a bin, filmed",
        "{kinds} kinds, {drops} drops each",
        "restitution of a kind to {restitution:.0f} %, and whether it stays",
        "{bounce:.1f} sorted/min between 0.6 and 1.6 times the assumed restitution",
    ),
    (
        "a log of throws for [`fit`](fit.md)",
        "40 throws",
        "success foretold to {fit[success]:.1f} points instead of {usual[success]:.1f}, landing to {fit[landing]:.1f} "
        "mm instead of {usual[landing]:.1f} mm",
        "the planner that [fits the log](controllers.md#a-planner-that-fits-the-cell) sorts "
        "{fitted[sorted_per_min]:.1f} a minute instead of {planner[sorted_per_min]:.1f}",
    ),
)
"""Rows of the table of what to measure: what, how much, what it tells, what it is worth."""


def measured_table(_: str) -> str:
    """A table of numbers of this project, of what measurements say, and of where the measurements come from."""
    waste = ConveyorConfig.load("waste")
    carton = CATALOGUE["tetra_1l"]
    rises = _rows("reality", part="rises", restitution=0.5)
    values = {
        "waste": waste,
        "tau": 1000 * waste.suction.tau,
        "can": CATALOGUE["can"],
        "pet": CATALOGUE["pet_05"],
        "cup": CATALOGUE["yoghurt_cup"],
        "carton": carton,
        "carton_grams": 1000 * carton.mass,
        "cube": 100 * _rows("reality", contact="fitted on other tosses")[0]["path"]["value"],
        "rises": {row["body"]: 100 * row["above_by_margin"]["value"] for row in rises},
        "spread": _rows("reality", part="scatter")[0]["spread"],
        "planner": _judged("analytic", 0),
        "learned": _judged("sac", 10_000),
    }
    return table(("what", "ours", "measured", "source"), _filled(MEASURED, values))


def advice_table(_: str) -> str:
    """A table of measurements at a cell of one's own, with what each tells and what that is worth."""
    waste, usual = ConveyorConfig.load("waste"), _pace("as assumed")
    kinds = waste.item_list()
    chance = fmean(item.pick_chance for item in kinds)
    points = NormalDist().inv_cdf(0.975) * 100.0 * sqrt(chance * (1.0 - chance) / (PICKS * len(kinds)))
    seal = (_pace("seals 5 points better") - _pace("seals 5 points worse")) / 10.0
    values = {
        "per_ms": max((usual - _pace(f"tau {tau} ms")) / abs(tau - 1000 * waste.suction.tau) for tau in TAUS),
        "push": (usual - _pace("blow-off 0.15 m/s")) / 3.0,
        "kinds": len(kinds),
        "picks": PICKS,
        "drops": DROPS,
        "points": points,
        "seal": seal,
        "sealed": points * seal,
        "restitution": 100 * waste.spread.restitution / sqrt(DROPS),
        "bounce": _pace("restitution x 0.6") - _pace("restitution x 1.6"),
        "fit": _forecast("fitted"),
        "usual": _forecast("default"),
        "planner": _judged("analytic", 0),
        "fitted": _judged("fitted_planner", 40),
    }
    return table(("measure", "how much", "what it tells", "what it is worth"), _filled(ADVICE, values))


def _filled(rows: tuple[Row, ...], values: Mapping[str, Any]) -> list[list[str]]:
    """Rows with their numbers."""
    return [[cell.format(**values) for cell in row] for row in rows]


def _rows(study: str, **labels: Any) -> list[Mapping[str, Any]]:
    """Rows of a study with some labels."""
    rows: list[Mapping[str, Any]] = contents.read(RESULTS / f"{study}.json")["rows"]
    return [row for row in rows if all(row.get(name) == label for name, label in labels.items())]


def _judged(label: str, throws: int) -> dict[str, Any]:
    """Figures of a controller on `waste` in the benchmark, and its landing error in mm."""
    rows = contents.read(RESULTS / "benchmark.json")["table"]
    found = next(row for row in rows if (row["label"], row["throws"], row["level"]) == (label, throws, "waste"))
    return {**found, "mm": 1000 * found["landing_error_mean_m"]}


def _pace(number: str) -> float:
    """Sorted objects a minute of the policy that does not learn, with one number of the cell changed."""
    return _rows("assumed", number=number, controller=POLICY)[0]["sorted_per_min"]


def _forecast(level: str) -> dict[str, float]:
    """Errors of forecasts by the fitted or the default level, means of all sets of twins [points, mm]."""
    figures = {"success": f"success by the {level} level, off by [points]"}
    figures["landing"] = f"landing by the {level} level, off by [mm]"
    return {
        name: fmean(row["value"] for row in _rows("fit", part="fit", figure=text)) for name, text in figures.items()
    }
