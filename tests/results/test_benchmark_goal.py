"""Guards of committed numbers: what results/learning.md says of the virtual goal."""

import pytest

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT

DATA = read_json(ROOT / "results" / "benchmark_goal.json")
ERRORS = {row["label"]: row["landing_error_mean_m"] for row in DATA["table"]}


@pytest.mark.parametrize("label", ["K_0.5", "planned_anew_K_0.5"])
def test_many_cells_side_by_side_cost_the_virtual_goal_precision(label: str) -> None:
    assert 0.0005 < ERRORS[f"{label}_in_64_cells"] - ERRORS[label] < 0.003


def test_the_chosen_gain_is_as_good_as_the_best_and_the_literal_form_as_good_as_the_usual_one() -> None:
    gains = {label: error for label, error in ERRORS.items() if label.removeprefix("K_").replace(".", "").isdigit()}
    assert len(gains) == 5
    assert ERRORS["K_chosen"] < min(gains.values()) + 0.0005
    for gain in ("0.1", "0.5"):
        assert abs(ERRORS[f"planned_anew_K_{gain}"] - ERRORS[f"K_{gain}"]) < 0.001
