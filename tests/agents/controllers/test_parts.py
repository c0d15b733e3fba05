"""Parts of controllers that grasp: any place, pace and release fit together."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.controllers import Observation, make_controller
from agents.controllers.parts import FixedPace, GaugePace, GraspController, fitted_values, local_mlp
from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import observed
from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.grasp.observation import TABLE
from tests.tools.throws import same_bits

LEVEL: dict[str, Any] = {"base": "grasp", "fidelity": "flight"}
ROWS = 32


@pytest.fixture(scope="module")
def cells() -> Iterator[tuple[Any, Observation]]:
    """Cells of which some hold an object, and what controllers see of them."""
    with closing(make_vector("PnTGrasp-v0", LEVEL, ROWS, 1)) as env:
        env.reset(seed=9)
        features, *_, info = env.step(np.zeros((ROWS, 6), dtype=np.float32))
        yield env, observed(features, info["kind"])


class GivesUp:
    """Lets every object ride on."""

    def places(self, observation: Observation, rows: Ints) -> Floats:
        """NaN (K, 2)."""
        return np.full((len(rows), 2), np.nan)


def test_a_controller_takes_places_of_one_row_and_paces_of_another(cells: Any) -> None:
    env, seen = cells
    core: Any = core_of(env)
    mixed = GraspController("mixed", core, local_mlp(core), pace=fitted_values(core)).act(seen)
    places, paces = (make_controller(name, env).act(seen) for name in ("local_mlp", "fitted_q"))
    held = TABLE.decode(seen.features)["holds"] > 0.5
    assert 4 < held.sum() < ROWS - 4
    assert same_bits(mixed[:, :3], places[:, :3])
    assert same_bits(mixed[held, 3:], paces[held, 3:])
    assert not same_bits(mixed[held, 3], places[held, 3])


def test_paces_by_the_gauge_do_not_depend_on_an_objects_class(cells: Any) -> None:
    env, seen = cells
    pace = GaugePace(core_of(env))  # type: ignore[arg-type]
    other = replace(seen, kind=(seen.kind + 5) % 14)
    assert same_bits(pace.shares(seen), pace.shares(other))
    held = TABLE.decode(seen.features)["holds"] > 0.5
    slower = GaugePace(core_of(env), safety=2.0)  # type: ignore[arg-type]
    assert (slower.shares(seen)[held] <= pace.shares(seen)[held]).all()


def test_an_object_is_given_up_before_a_try_where_the_level_allows_it() -> None:
    for skip in (True, False):
        with closing(make_vector("PnTGrasp-v0", {**LEVEL, "grasp": {"skip": skip}}, 4, 1)) as env:
            features, info = env.reset(seed=1)
            controller = GraspController("mine", core_of(env), GivesUp())  # type: ignore[arg-type]
            if not skip:
                with pytest.raises(UsageError, match="gave up an object before its first try"):
                    controller.act(observed(features, info["kind"]))
                continue
            *_, info = env.step(controller.act(observed(features, info["kind"])))
            assert (info["tries"] == 0).all()
            assert np.isfinite(info["cycle_time"]).all()


def test_what_does_not_fit_is_refused(cells: Any) -> None:
    core: Any = core_of(cells[0])
    with pytest.raises(UsageError, match=r"pace is 0.9; it must be 'gauge' or from 0.18 to 0.6"):
        FixedPace(core, 0.9)
    with pytest.raises(UsageError, match="pace is 'fast'; it must be 'gauge' or a share"):
        GraspController("mine", core, GivesUp(), pace="fast")  # type: ignore[arg-type]
    with closing(make_vector("PnTRelease-v0", "waste", 2, 1)) as env, pytest.raises(UsageError, match="PnTGrasp-v0"):
        GraspController("mine", core_of(env), GivesUp())  # type: ignore[arg-type]
