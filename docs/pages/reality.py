"""What was held against measurement, and what to measure at a cell of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from statistics import NormalDist
from typing import Any, Final

import numpy as np

from agents.ground.places import SHIPPED as ROOT
from agents.report import contents
from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.conveyor.config import ConveyorConfig

from .marks import table

RESULTS: Final = ROOT / "results"
POLICY: Final = "waste-sac"
"""Controller of the study `assumed` that does not learn at the cell."""
PICKS, DROPS = 20, 10
"""Picks at rest and drops of each kind that the page proposes."""


def measured_table(_: str) -> str:
    """A table of numbers of this project, of what measurements say, and of where the measurements come from."""
    waste, items = ConveyorConfig.load("waste"), CATALOGUE
    fitted = next(row for row in _rows("reality") if row["contact"] == "fitted on other tosses")
    scatter = _rows("reality", part="scatter")[0]
    rises = [row for row in _rows("reality", part="rises") if row["restitution"] == 0.5]
    planner, learned = _judged("analytic", 0), _judged("sac", 10_000)
    can, pet, cup, carton = items["can"], items["pet_05"], items["yoghurt_cup"], items["tetra_1l"]
    rows = [
        (
            "vacuum's decay (`suction.tau`)",
            f"{1000 * waste.suction.tau:g} ms, **assumed**",
            "nothing published",
            "[what it decides](../results/cells.md)",
        ),
        (
            "push of the cup at the release (`cup.blow_off`)",
            f"{waste.cup.blow_off:g} m/s, **assumed**",
            "nothing published; valves that blow off are usual",
            "makers of ejectors; [what it decides](../results/cells.md)",
        ),
        (
            "a tossed cube followed to rest, share of its side",
            f"{100 * fitted['path']['value']:.1f} %",
            "other engines 13.5 to 25 %",
            "below; arXiv 2110.00541, second hand",
        ),
        (
            "an impact rises 5 mm above the bound that ends a fall",
            "never, by the bound",
            " and ".join(f"{100 * row['above_by_margin']['value']:.1f} % ({row['body']})" for row in rises),
            "below, restitution 0.5",
        ),
        (
            "spread of restitution, of its logarithm",
            f"{waste.spread.restitution:g} each throw",
            f"{scatter['spread']:.2f}, drop by drop",
            "drops of a square, `DAIRLab/ImpactModeling`",
        ),
        (
            "friction of PET, PP",
            f"{pet.friction:g}, {cup.friction:g}",
            "0.26, 0.28 on wood",
            "notes of `utiasDSL/upright`",
        ),
        (
            "drag of a lying can, a bottle",
            f"{can.drag:g}, {pet.drag:g}",
            "0.66 to 0.70",
            "tables of short cylinders, not read again",
        ),
        (
            "chance that a cup seals: carton, PET, PP",
            f"{carton.pick_chance:.2f}, {pet.pick_chance:.2f}, {cup.pick_chance:.2f}",
            "0.861 carton, 0.90 plastic",
            "Kim et al. 2019, SCITEPRESS paper 78399, abstract",
        ),
        (
            "residue of a PET bottle, a carton, in empty masses",
            f"{pet.residue:g}, {carton.residue:g}",
            "0.07, 0.23",
            "Schinkel et al. 2023; Belle et al. 2025",
        ),
        ("mass of an empty 1 l carton", f"{1000 * carton.mass:g} g", "29.2 g, mean of 949", "Belle et al. 2025"),
        (
            "picks that are tried a minute",
            f"{planner['picks_per_min']:.0f}",
            "60 to 65; claims of 80",
            "reports of plants and makers, 2017 to 2023",
        ),
        (
            "landing error: planner, learned",
            f"{_mm(planner)} mm, {_mm(learned)} mm",
            "within 50 mm after dozens of throws of one object; **nothing finer was found**",
            "Liu et al. 2025, arXiv 2510.10357, abstract",
        ),
    ]
    return table(("what", "ours", "measured", "source"), rows)


def advice_table(_: str) -> str:
    """A table of measurements at a cell of one's own, with what each tells and what that is worth."""
    usual = _pace("as assumed")
    per_ms = max(usual - _pace(f"tau {tau} ms") for tau in (5, 14)) / 5.0
    push = (usual - _pace("blow-off 0.15 m/s")) / 0.15
    seal = abs(_pace("seals 5 points better") - _pace("seals 5 points worse")) / 10.0
    bounce = _pace("restitution x 0.6") - _pace("restitution x 1.6")
    kinds = ConveyorConfig.load("waste").item_list()
    chance = float(np.mean([item.pick_chance for item in kinds]))
    wide = NormalDist().inv_cdf(0.975) * 100.0 * sqrt(chance * (1.0 - chance) / (PICKS * len(kinds)))
    spread = ConveyorConfig.load("waste").spread.restitution / sqrt(DROPS)
    planner, fitted = _judged("analytic", 0), _judged("fitted_planner", 40)
    rows = [
        (
            "a rig with one cup, its valve and hose, a gauge at 1 kHz and a camera at 240 pictures a second",
            "10 objects, 10 releases each",
            "delay of the valve, tau, blow-off, jitter",
            f"a policy that does not learn at the cell loses up to {per_ms:.1f} sorted/min a millisecond of tau, and "
            f"{push / 20.0:.1f} for each 0.05 m/s of blow-off",
        ),
        (
            "picks of objects at rest",
            f"{len(kinds)} kinds, {PICKS} picks each",
            f"the chance to seal, over all kinds to {wide:.0f} points",
            f"{seal:.1f} sorted/min a point, so {wide * seal:.1f}",
        ),
        (
            "drops from 0.5 m into a bin, filmed",
            f"{len(kinds)} kinds, {DROPS} drops each",
            f"restitution of a kind to {100 * spread:.0f} %, and whether it stays",
            f"{bounce:.1f} sorted/min between 0.6 and 1.6 times the assumed restitution",
        ),
        (
            "a log of throws for [`fit`](fit.md)",
            "40 throws",
            f"success foretold to {_verdict('success by the fitted level, off by [points]'):.1f} points instead of "
            f"{_verdict('success by the default level, off by [points]'):.1f}, landing to "
            f"{_verdict('landing by the fitted level, off by [mm]'):.1f} mm instead of "
            f"{_verdict('landing by the default level, off by [mm]'):.1f} mm",
            f"the planner that [fits the log](controllers.md#a-planner-that-fits-the-cell) sorts "
            f"{fitted['sorted_per_min']:.1f} a minute instead of {planner['sorted_per_min']:.1f}",
        ),
    ]
    return table(("measure", "how much", "what it tells", "what it is worth"), rows)


def _rows(study: str, **labels: Any) -> list[Mapping[str, Any]]:
    """Rows of a study with some labels."""
    rows: list[Mapping[str, Any]] = contents.read(RESULTS / f"{study}.json")["rows"]
    return [row for row in rows if all(row.get(name) == label for name, label in labels.items())]


def _judged(label: str, throws: int) -> Mapping[str, Any]:
    """Figures of a controller on `waste` in the benchmark."""
    rows = contents.read(RESULTS / "benchmark.json")["table"]
    return next(row for row in rows if (row["label"], row["throws"], row["level"]) == (label, throws, "waste"))


def _mm(row: Mapping[str, Any]) -> str:
    return f"{1000 * row['landing_error_mean_m']:.0f}"


def _pace(number: str) -> float:
    """Sorted objects a minute of the policy that does not learn, with one number of the cell changed."""
    return _rows("assumed", number=number, controller=POLICY)[0]["sorted_per_min"]


def _verdict(figure: str) -> float:
    """A figure of fits, mean of all sets of twins."""
    return float(np.mean([row["value"] for row in _rows("fit", part="fit", figure=figure)]))
