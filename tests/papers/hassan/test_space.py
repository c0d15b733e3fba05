"""The experiments of Hassan et al. 2022 in space: from P_initial over three picks and back."""

from types import SimpleNamespace

import numpy as np
import pytest

from papers.hassan import figures
from papers.hassan.cases import INITIAL, METHODS, PICKS, cell_cycle
from papers.hassan.space import experiment, segments_figure, space_findings
from pnt_gym.planning.motion.trajectory import JerkTrajectory


@pytest.mark.parametrize("method", METHODS)
def test_the_hand_leaves_p_initial_visits_the_picks_and_comes_back(method):
    run = experiment(method)
    np.testing.assert_allclose(run.first_leg.start[0], INITIAL)
    np.testing.assert_allclose(run.first_leg.end[0], PICKS[0], atol=1e-9)
    for k in (0, 1):
        np.testing.assert_allclose(run.cycles.path.end[k], PICKS[k + 1], atol=1e-9)
    last = run.cycles.path.sample([run.last_end])
    np.testing.assert_allclose(last.position[2, 0], INITIAL, atol=1e-9)
    assert np.abs(last.velocity[2, 0]).max() < 1e-9
    legs = [run.first_leg.duration[0], *run.cycles.duration[:2], run.last_end]
    assert run.duration == pytest.approx(sum(legs))


def test_the_throws_take_less_time_than_pick_and_place_and_the_drawings_have_all_parts():
    found = space_findings()
    place, level, quickest = (row.reproduced for row in found.rows)
    assert place > level > quickest > 0.0
    assert set(found.figures) == {"hassan_segments.svg", "hassan_space.svg"}
    # Seven segments: eight borders in each of the four panels, beside the curve itself.
    assert [len(panel.lines) for panel in segments_figure().axes] == [9] * 4


def test_a_step_of_the_acceleration_is_no_continuous_acceleration():
    right = cell_cycle("constant-jerk-overlap", "min-time-throw", "inside", 30)
    assert figures._continuity_row(right, "").verdict == "reproduced"
    jerks = right.path.jerks.copy()
    # The same path with a hand that is stopped while it still accelerates.
    stopped = JerkTrajectory(right.path.start, right.path.durations[:, :4], jerks[:, :4])
    cut = JerkTrajectory(stopped.start, np.minimum(stopped.durations, 1e-3), stopped.jerks)
    assert figures._continuity_row(SimpleNamespace(path=cut), "").verdict == "differs"
