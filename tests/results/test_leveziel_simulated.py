"""Guards of committed numbers: what the simulated rows of Leveziel et al. in results/reproduction.json reach."""

from __future__ import annotations

from typing import Any

import pytest

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT

ROWS: dict[str, dict[str, Any]] = {
    row["quantity"]: row
    for row in read_json(ROOT / "results" / "reproduction.json")["rows"]
    if row["paper"] == "leveziel"
}
LEARNERS = ("virtual_goal", "ridge", "mlp")


def row(name: str) -> dict[str, Any]:
    return ROWS[f"leveziel/{name}"]


def value(name: str) -> Any:
    return row(name)["reproduced"]


def test_the_cork_cycle_is_carried_out() -> None:
    assert value("cycle/rise") == pytest.approx(0.050, abs=0.001)
    assert value("cycle/across") == pytest.approx(0.070, abs=0.001)
    assert value("cycle/held") == 100.0
    assert value("cycle/success") >= 97.0
    assert row("cycle/lift-time")["on_axis_s"] == pytest.approx(0.078, abs=1e-3)


@pytest.mark.parametrize("name", ["cork", "cap", "block"])
def test_objects_are_lifted_without_slip(name: str) -> None:
    assert row(f"grasps/{name}")["grasps"] >= 200
    assert value(f"grasps/{name}") >= 98.0


@pytest.mark.parametrize("level", ["nominal", "late", "patient", "drop", "belt"])
def test_an_oracle_tosses_reliably(level: str) -> None:
    assert row(f"toss/{level}/oracle")["throws"] >= 192
    assert value(f"toss/{level}/oracle") >= 97.0


@pytest.mark.parametrize("name", LEARNERS)
def test_learners_find_out_when_to_let_go(name: str) -> None:
    for practice in (10, 100, 1000):
        assert len(row(f"toss/nominal/{name}-{practice}")["success_by_seed"]) >= 3
    assert value("toss/nominal/analytic") + 10.0 < value(f"toss/nominal/{name}-10") < value(f"toss/nominal/{name}-100")
    assert value(f"toss/nominal/{name}-1000") >= 97.0


def test_ten_thousand_cycles_pass_without_a_warning() -> None:
    counted = [found for name, found in ROWS.items() if name.startswith("leveziel/endurance/")]
    assert sum(found["reproduced"] for found in counted) >= 10_000
    assert all(found["warnings"] == 0 for found in counted)
