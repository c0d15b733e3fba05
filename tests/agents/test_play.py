"""`python -m agents.play`: a picture, a video, and what it refuses."""

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import pytest
from PIL import Image

from tests.tools.commands import call_here, output_of
from tests.tools.nightly import with_nightly

pytestmark = pytest.mark.usefixtures("opengl", "quick")


@pytest.fixture
def quick() -> Iterator[None]:
    """Pictures are means of two drawings."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("agents.pictures.stage.SAMPLES", 2)
        yield


def test_a_picture_shows_the_cell(tmp_path: Path) -> None:
    output_of("play --picture throw.png --seed 3", tmp_path)
    frame = iio.imread(tmp_path / "throw.png")
    assert frame.shape == (720, 1280, 3)
    assert frame.std() > 20.0


def test_a_picture_is_of_the_moment_asked_for(tmp_path: Path) -> None:
    frames = []
    for moment in ("0.0", "0.5", "99"):
        output_of(f"play --env GripperToss-v0 --picture {moment}.png --at {moment}", tmp_path)
        frames.append(iio.imread(tmp_path / f"{moment}.png").astype(int))
    for one, other in ((0, 1), (1, 2)):
        assert (abs(frames[one] - frames[other]).max(axis=2) > 40).sum() > 500


SHORT = ("agents.play", "--env", "OneJointThrow-v0")


BROKEN = [*product((("--picture", "a.png"), ("--video", "a.mp4")), (KeyboardInterrupt, OSError(28, "No space left")))]


@pytest.mark.parametrize(("written", "error"), with_nightly(BROKEN, BROKEN[:2]))
def test_what_was_there_stays_if_writing_is_broken_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: tuple[str, str], error: type[BaseException] | OSError
) -> None:
    option, path = written[0], tmp_path / written[1]
    options = (option, path, *(("--picks", "1") if option == "--video" else ()))
    path.write_text("of yesterday")

    def broken(*given: Any, **_: Any) -> None:
        (target,) = (one for one in given if isinstance(one, Path))
        assert target.suffix == path.suffix
        target.write_text("half")
        raise error

    monkeypatch.setattr(iio, "imwrite", broken)
    monkeypatch.setattr(Image.Image, "save", broken)
    done = call_here(*SHORT, *options, folder=tmp_path)
    assert done.returncode == (130 if error is KeyboardInterrupt else 2)
    assert done.stderr.count("\n") == 1
    assert path.read_text() == "of yesterday"
    assert [*tmp_path.iterdir()] == [path]
    monkeypatch.undo()
    assert call_here(*SHORT, *options, folder=tmp_path).returncode == 0
    assert iio.imread(path).shape[-1] == 3
    assert [*tmp_path.iterdir()] == [path]
