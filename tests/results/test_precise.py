"""Guards of committed numbers: the level `precise` is what its study chose, and separates good controllers."""

from typing import Any

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT
from agents.results.study import shipped_study
from pnt_gym.cells.conveyor.config import ConveyorConfig

ROWS = read_json(ROOT / "results" / "precise.json")["rows"]


def best_above(figure: str) -> dict[str, Any]:
    """The case in which errors differ most, of those whose oracle is above 98 % by its share or its interval's end."""
    fair = [row for row in ROWS if row["part"] == "choice" and row["oracle"][figure] > 0.98]
    return max(fair, key=lambda row: row["difference"]["value"])


def test_the_level_is_the_case_that_differs_most_with_an_oracle_above_98_percent() -> None:
    best = best_above("value")
    (settings,) = [
        case.settings for case in shipped_study("precise").cases("choice") if case.labels.items() <= best.items()
    ]
    chosen = ConveyorConfig.load({**settings["level"], "name": "precise", "fidelity": "full"})
    assert ConveyorConfig.load("precise") == chosen


def test_the_rule_of_world_1_would_choose_another_case_now() -> None:
    """That rule asked for the whole interval; docs/levels.md says what it would choose."""
    other = best_above("low")
    assert (other["rim"], other["item_clearance"]) == (-1.1, 0.05)
    assert other["difference"]["value"] < 0.5 * best_above("value")["difference"]["value"]


def test_in_full_physics_five_points_lie_between_the_errors_and_the_oracle_is_not_told_apart_from_98_percent() -> None:
    rows = {row["level"]: row for row in ROWS if row["part"] == "full"}
    precise = rows["precise"]
    assert precise["oracle"]["low"] < 0.98 < precise["oracle"]["high"]
    assert precise["difference"]["value"] >= 0.05
    assert precise["difference"]["value"] > 2 * rows["waste"]["difference"]["value"]
