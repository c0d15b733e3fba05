"""`python -m agents.play` through a subprocess: a picture, a video, and what it refuses."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import imageio.v3 as iio
import pytest

pytestmark = pytest.mark.usefixtures("opengl")

ROOT = Path(__file__).resolve().parents[2]


def play(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "agents.play", *arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)


def test_a_picture_shows_the_cell(tmp_path: Path) -> None:
    path = tmp_path / "throw.png"
    done = play("--picture", str(path), "--seed", "3")
    assert done.returncode == 0, done.stderr
    frame = iio.imread(path)
    assert frame.shape == (720, 1280, 3)
    assert frame.std() > 20.0


def test_a_video_lasts_as_long_as_the_throws(tmp_path: Path) -> None:
    path = tmp_path / "throws.mp4"
    done = play("--env", "PnTRelease-v0", "--level", "ideal", "--video", str(path), "--picks", "2")
    assert done.returncode == 0, done.stderr
    frames = iio.imread(path)
    # Two throws of 0.7 to 1.5 s at 30 frames per second.
    assert 2 * 0.7 * 30 <= len(frames) <= 2 * 1.5 * 30


def test_it_wants_exactly_one_way_to_show(tmp_path: Path) -> None:
    for arguments in ((), ("--video", str(tmp_path / "a.mp4"), "--picture", str(tmp_path / "a.png"))):
        done = play(*arguments)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
        assert "--video FILE.mp4" in done.stderr
