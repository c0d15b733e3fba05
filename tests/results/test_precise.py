"""Guards of committed numbers: the level `precise` is what its study chose, and separates good controllers."""

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT
from agents.results.study import shipped_study
from pnt_gym.cells.conveyor.config import ConveyorConfig

ROWS = read_json(ROOT / "results" / "precise.json")["rows"]


def test_the_level_is_the_case_that_the_rule_chooses() -> None:
    cases = [row for row in ROWS if row["part"] == "choice"]
    fair = [row for row in cases if row["oracle"]["value"] > 0.98]
    best = max(fair, key=lambda row: row["difference"]["value"])
    (settings,) = [
        case.settings for case in shipped_study("precise").cases("choice") if case.labels.items() <= best.items()
    ]
    chosen = ConveyorConfig.load({**settings["level"], "name": "precise", "fidelity": "full"})
    assert ConveyorConfig.load("precise") == chosen


def test_in_full_physics_the_oracle_succeeds_and_five_points_lie_between_the_errors() -> None:
    rows = {row["level"]: row for row in ROWS if row["part"] == "full"}
    precise = rows["precise"]
    assert precise["oracle"]["high"] > 0.98
    assert precise["difference"]["value"] >= 0.05
    assert precise["difference"]["value"] > 2 * rows["waste"]["difference"]["value"]
