"""Pictures of shifts at a line."""

from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from agents.dispatchers import registry
from agents.dispatchers.registry import line_core
from agents.ground.environments import make_vector, stream_seed
from agents.judging import trials
from agents.judging.shift_record import gantt
from agents.judging.shifts import run_shifts
from agents.judging.trials import open_trial
from pnt_gym.cells.line.view import LineView
from tests.tools.commands import output_of

LEVEL = {"base": "skills3", "duration": 8.0}


def test_who_took_what_has_a_row_for_each_robot():
    env = make_vector("PnTLine-v0", LEVEL, 2, 1)
    told = trials.of(env).run(registry.make("price", line_core(env)), 2, 0).report()
    drawn = gantt(told, shift=1, span=(0.0, 8.0))
    assert drawn.startswith("<?xml")
    assert drawn == gantt(told, shift=1, span=(0.0, 8.0))


def test_the_filmed_decisions_are_those_of_the_first_shift_that_is_judged():
    many, one = make_vector("PnTLine-v0", LEVEL, 3, 1), open_trial("PnTLine-v0", LEVEL, 1, 1)
    told = run_shifts(registry.make("price", line_core(many)), many, 3, stream_seed("evaluate", 7)).decisions
    core = one.core
    core.view()
    times, taken = [], dict[int, float]()
    for time in one.steps(one.controller("price"), 7):
        times.append(time)
        taken |= {act.number: act.start for act in core.cell.acts.cycles}
        if time >= 5.0:
            break
    assert times == sorted(times)
    assert times[-2] < 5.0 <= times[-1]
    judged_ones = (told["shift"] == 0) & (told["start"] < 5.0)
    last = dict(zip(told["object"][judged_ones].tolist(), told["start"][judged_ones].tolist(), strict=True))
    assert last == pytest.approx(taken)


def test_without_a_bound_a_shift_is_worked_to_its_end():
    trial = open_trial("PnTLine-v0", LEVEL, 1, 1)
    times = list(trial.steps(trial.controller("fifo"), 0))
    assert len(times) > 5
    assert times[-2] <= 8.0


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Films of a second, in small frames, and pictures that are means of two drawings."""
    monkeypatch.setattr("agents.pictures.stage.SAMPLES", 2)
    monkeypatch.setattr("agents.judging.shift_trial.SECONDS", 1.0)
    monkeypatch.setattr(LineView.__init__, "__defaults__", ((64, 128),))


@pytest.mark.nightly
@pytest.mark.usefixtures("opengl", "quick")
@pytest.mark.parametrize("command", ["evaluate", "play"])
def test_a_line_is_filmed(tmp_path: Path, command: str) -> None:
    more = "--shifts 1 --num-envs 2" if command == "evaluate" else ""
    line = "--env PnTLine-v0 --level skills3 --controller fifo --throws flight --video a.mp4"
    output_of(f"{command} {line} {more}", tmp_path)
    frames = iio.imread(tmp_path / "a.mp4")
    assert frames.shape[1:] == (64, 128, 3)
    assert 0.5 * 30 <= len(frames) <= 2.0 * 30
    assert np.abs(frames[0].astype(int) - frames[-1]).max() > 40
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


@pytest.mark.usefixtures("opengl", "quick")
def test_a_picture_is_of_a_moment_of_the_shift(tmp_path: Path) -> None:
    for moment in ("0", "1.5"):
        output_of(f"play --env PnTLine-v0 --controller fifo --picture {moment}.png --at {moment}", tmp_path)
    one, other = (iio.imread(tmp_path / f"{moment}.png").astype(int) for moment in ("0", "1.5"))
    assert (np.abs(one - other).max(axis=2) > 40).any()
