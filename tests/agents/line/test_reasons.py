"""Ten plants whose main loss is known by construction, and what mends each: the reason names both."""

from typing import Any

import pytest

from agents.line import reasons
from agents.line.changes import possible_changes, try_changes
from agents.line.estimate import estimate
from agents.line.plans import Conditions
from pnt_gym.cells.line.config import LineConfig
from tests.tools.nightly import with_nightly

BOTTLE = {"name": "bottle", "shape": "cylinder", "size": [0.21, 0.065, 0.065], "mass": 0.025, "pick_chance": 0.97}
CARTON = {"name": "carton", "shape": "box", "size": [0.12, 0.08, 0.05], "mass": 0.03, "pick_chance": 0.97}
CONFUSED = {"bottle": {"bottle": 0.6, "carton": 0.4}, "carton": {"carton": 0.6, "bottle": 0.4}}
CONDITIONS = Conditions(shifts=3, throws=200, threads=1)
DECOYS = ("cups that always seal", "a swap of bins")


def bins(bottles: tuple[float, float] = (-0.15, 0.2), cartons: tuple[float, float] = (0.2, 0.2)) -> dict[str, Any]:
    """Bins for bottles and cartons at two places."""
    places = {"bottle": bottles, "carton": cartons}
    return {
        "fixed": [
            {"name": f"{item}s", "x": x, "y": y, "size": [0.3, 0.3], "accepts": [item]}
            for item, (x, y) in places.items()
        ]
    }


def plant(robots: int = 2, rate: float = 0.8, regularity: float = 1.0, **cell: Any) -> dict[str, Any]:
    """A plant that sorts nearly all of its bottles and cartons, with some values of its cell changed."""
    usual = {
        "items": ["bottle", "carton"],
        "extra_items": [BOTTLE, CARTON],
        "mix": {"bottle": 1, "carton": 1},
        "limits": {"percent": [40]},
        "belt": {"speed": 0.3, "lane_y": [-0.40, -0.14]},
        "bins": bins(),
    }
    return {
        "name": "plant",
        "cell": usual | cell,
        "robots": [{"name": f"robot{place}", "x": 1.4 * place} for place in range(robots)],
        "arrivals": {"rate": rate, "regularity": regularity},
        "duration": 60.0,
    }


def with_items(**values: Any) -> dict[str, Any]:
    """Both items with other values."""
    return {"extra_items": [BOTTLE | values, CARTON | values]}


SKILLED = plant(rate=1.8, mix={"bottle": 9, "carton": 1})
SKILLED["robots"] = [{"name": "a", "x": 0.0, "skills": ["bottle"]}, {"name": "b", "x": 1.4, "skills": ["carton"]}]
FAR = {"belt": {"speed": 0.3, "lane_y": [-0.62, -0.14]}, "bins": bins((-0.45, 0.55), (0.45, 0.55))}
FULL = {"bins": {**bins(), "emptied": 40, "depth": 0.15}}
PLANTS = {
    "reach": (plant(**FAR), "out_of_reach", "bins nearer to the belt by"),
    "swap": (plant(mix={"bottle": 9, "carton": 1}, bins=bins((-0.9, 0.9))), "out_of_reach", "a swap of bins"),
    "speed": (plant(1, 0.5, belt={"speed": 1.3, "lane_y": [-0.40, -0.14]}), "passed", "a belt at"),
    "robots": (plant(1, 2.5), "passed", "one more robot"),
    "seal": (plant(1, 0.4, **with_items(pick_chance=0.35)), "unsealed", "cups that always seal"),
    "weight": (plant(limits={"percent": [100]}, **with_items(mass=0.1)), "lost", "limits of"),
    "mix": (SKILLED, "passed", "all skills for every robot"),
    "class": (plant(classifier={"confusion": CONFUSED}), "misplaced", "a camera that never errs"),
    "burst": (plant(1, 1.0, 0.1), "passed", "an even stream"),
    "full": (plant(**FULL), "missed", "bins that are never full"),
}
"""Each plant with its main loss, and with the change that mends it."""
DAILY = ("reach", "seal", "class")


@pytest.mark.filterwarnings("ignore::pnt_gym.errors.ReachWarning", "ignore:.* stays empty")
@pytest.mark.parametrize("name", with_nightly(PLANTS, DAILY))
def test_the_reason_names_the_main_loss_and_what_mends_it(name: str) -> None:
    level, loss, mend = PLANTS[name]
    line = LineConfig.load(level)
    plan = estimate(line, CONDITIONS, CONDITIONS.throws).planned
    assert reasons.main_losses(plan)[0][0] == loss
    changes = possible_changes(line, reasons.worst_item(plan))
    gains = try_changes(line, [change for change in changes if change.what in (mend, *DECOYS)], CONDITIONS)
    assert (gains[0].what, gains[0].points.low > 0.0) == (mend, True)
    said = reasons.reason(plan, gains)
    assert said.startswith("the reason: ") and reasons.VERBS[loss] in said.split(";")[0]
    assert f"points ({100 * gains[0].points.low:.1f}..{100 * gains[0].points.high:.1f}) with {mend}" in said


def test_a_plant_that_sorts_nearly_all_gains_nothing() -> None:
    line = LineConfig.load(plant())
    plan = estimate(line, CONDITIONS, CONDITIONS.throws).planned
    assert plan.row["recovery"] > 0.95
    changes = [change for change in possible_changes(line, "bottle") if change.what in DECOYS]
    gains = try_changes(line, changes, CONDITIONS)
    assert "no change that was tried brings more; no difference with" in reasons.reason(plan, gains)
