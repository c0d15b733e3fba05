"""`python -m agents.play` through a subprocess: a picture, a video, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import pytest

from tests.tools.commands import call

pytestmark = pytest.mark.usefixtures("opengl")


def test_a_picture_shows_the_cell(tmp_path: Path) -> None:
    path = tmp_path / "throw.png"
    done = call("agents.play", "--picture", path, "--seed", "3", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    frame = iio.imread(path)
    assert frame.shape == (720, 1280, 3)
    assert frame.std() > 20.0


def test_a_video_lasts_as_long_as_the_throws(tmp_path: Path) -> None:
    path = tmp_path / "throws.mp4"
    done = call(
        "agents.play", "--env", "OneJointThrow-v0", "--level", "ideal", "--video", path, "--picks", "2", folder=tmp_path
    )
    assert done.returncode == 0, done.stderr
    frames = iio.imread(path)
    # Two throws of 0.4 to 0.7 s at 30 frames per second.
    assert 2 * 0.4 * 30 <= len(frames) <= 2 * 0.7 * 30


def test_a_picture_is_of_the_moment_asked_for(tmp_path: Path) -> None:
    frames = []
    for moment in ("0.0", "0.5", "99"):
        path = tmp_path / f"{moment}.png"
        done = call("agents.play", "--env", "GripperToss-v0", "--picture", path, "--at", moment, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        frames.append(iio.imread(path).astype(int))
    for one, other in ((0, 1), (1, 2)):
        assert (abs(frames[one] - frames[other]).max(axis=2) > 40).sum() > 500


@pytest.mark.parametrize(("option", "value"), [("--at", "-1"), ("--at", "inf"), ("--slow", "0")])
def test_impossible_moments_and_rates_are_refused(tmp_path: Path, option: str, value: str) -> None:
    done = call("agents.play", "--picture", tmp_path / "a.png", option, value, folder=tmp_path)
    assert done.returncode == 2
    assert option.removeprefix("--") in done.stderr
    assert "Traceback" not in done.stderr


def test_it_wants_exactly_one_way_to_show(tmp_path: Path) -> None:
    for arguments in ((), ("--video", str(tmp_path / "a.mp4"), "--picture", str(tmp_path / "a.png"))):
        done = call("agents.play", *arguments, folder=tmp_path)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
        assert "--video FILE.mp4" in done.stderr
