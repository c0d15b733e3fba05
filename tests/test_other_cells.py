"""The study of cells that nobody measured: practice is in the cell of each shift, and all throw in the same shifts."""

from contextlib import closing
from typing import Any

import numpy as np
import pytest

from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector
from agents.report import templates
from agents.results.study import Amount
from benchmarks.studies import other_cells
from benchmarks.studies.other_cells import drawn_cells, shifts

LEVEL = {"base": "cells", "fidelity": "flight", "picks_per_shift": 22}


def test_a_level_with_the_drawn_numbers_is_that_cell() -> None:
    with closing(make_vector("PnTAdapt-v0", LEVEL, 3, 1)) as env:
        env.reset(seed=1)
        cells, drawn = drawn_cells(core_of(env)), core_of(env).context.cell
    for row, cell in enumerate(cells):
        with closing(make_vector("PnTRelease-v0", {**LEVEL, "cells": cell}, 2, 1)) as env:
            env.reset(seed=9)
            fixed = core_of(env).context.cell
        for name in drawn.dtype.names:
            np.testing.assert_array_equal(getattr(fixed, name), getattr(drawn, name)[row])


def _settings(**changes: Any) -> dict[str, Any]:
    controllers = {"analytic": {"controller": "analytic"}, "static": {"controller": "static"}}
    return {
        "level": LEVEL, "block": 0, "controllers": controllers, "practised": {"ridge there": "ridge"}, "practice": 200,
        "least": "analytic", "most": "ridge there", "windows": [0, 5, 20], **changes,
    }  # fmt: skip


@pytest.mark.nightly
def test_practice_in_the_very_cell_is_worth_more_than_a_policy_from_elsewhere() -> None:
    rows = list(shifts(_settings(), Amount(4, 0)))
    assert [(row["controller"], row["window"]) for row in rows] == [
        (name, window) for name in ("analytic", "static", "ridge there") for window in (0, 5, 20)
    ]
    errors = {row["controller"]: templates.landing(row["cells"])["value"] for row in rows if row["window"] == 0}
    assert errors["ridge there"] < errors["static"] < errors["analytic"]
    whole = {row["controller"]: row for row in rows if row["window"] == 0}
    late = {row["controller"]: row for row in rows if row["window"] == 20}
    assert (np.array(late["static"]["cells"]) < np.array(whole["static"]["cells"]) + 1e-9).all()
    ridge = whole["ridge there"]
    assert templates.won(ridge["cells"], ridge["least"], ridge["most"])["value"] == pytest.approx(1.0)
    again = list(shifts(_settings(practised={}, most="static"), Amount(4, 0)))
    np.testing.assert_array_equal(again[0]["cells"], rows[0]["cells"])  # whatever others do


def test_cells_that_are_alike_are_practised_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    def practise(level: Any, name: str, throws: int, seed: int) -> Any:
        made.append(str(level["cells"]))
        return other_cells.make_controller("ridge", env)

    with closing(make_vector("PnTRelease-v0", LEVEL, 1, 1)) as env:
        monkeypatch.setattr(other_cells, "_practised", practise)
        one, two = {"tau": [0.01, 0.01]}, {"tau": [0.02, 0.02]}
        other_cells.Practised(LEVEL, "ridge", [one, two, one, one], 10, 0)
    assert len(made) == 2


def test_a_file_for_what_learns_nothing_is_refused() -> None:
    controllers = {"posterior": {"controller": "posterior", "load": "x.npz"}}
    with pytest.raises(UsageError, match="learns nothing that could be loaded"):
        list(shifts(_settings(controllers=controllers), Amount(1, 0)))
