"""`python -m agents.play` through a subprocess: a picture, a video, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import pytest
from commands import call

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
        "agents.play", "--env", "PnTRelease-v0", "--level", "ideal", "--video", path, "--picks", "2", folder=tmp_path
    )
    assert done.returncode == 0, done.stderr
    frames = iio.imread(path)
    # Two throws of 0.7 to 1.5 s at 30 frames per second.
    assert 2 * 0.7 * 30 <= len(frames) <= 2 * 1.5 * 30


def test_it_wants_exactly_one_way_to_show(tmp_path: Path) -> None:
    for arguments in ((), ("--video", str(tmp_path / "a.mp4"), "--picture", str(tmp_path / "a.png"))):
        done = call("agents.play", *arguments, folder=tmp_path)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
        assert "--video FILE.mp4" in done.stderr
