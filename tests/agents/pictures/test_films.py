"""Films: captions are readable beside each other, the camera follows, and every environment has a view of its own."""

import numpy as np
import pytest
from PIL import Image

import pnt_gym
from agents.pictures import films
from agents.pictures.captions import GOOD, Caption, inset, write_caption
from agents.pictures.films import ThrowFilm, save, side_by_side, throw_pictures
from docs import pictures
from pnt_gym.cells.base.canvas import Viewpoint

CLOSE = Viewpoint(lookat=(0.0, 0.2, -0.7), distance=1.5, azimuth=230.0, elevation=-20.0)


def test_every_environment_has_a_film_and_a_view_of_its_own():
    assert {*pictures.FILMS, pictures.LINE[0]} == set(pnt_gym.ENV_IDS)
    views = [film.camera for film in pictures.FILMS.values() if film.env.startswith("PnT")]
    assert len({view.azimuth for view in views}) == len(views)
    left, right = pictures.PAIR
    assert (left.seed, left.level, left.throws, left.env) == (right.seed, right.level, right.throws, right.env)


@pytest.mark.parametrize("width", [480, 960])
def test_a_caption_stands_at_the_edges_and_leaves_the_middle_free(width):
    frame = np.full((540, width, 3), 120, dtype=np.uint8)
    caption = Caption("planner alone", "tetra 200", "128 mm off, sorted", rate=("108", "sorted/min"))
    shown = np.asarray(write_caption(frame, caption))
    changed = (shown != frame).any(axis=2)
    assert changed[:60, :100].any()
    assert changed[-60:, -100:].any()
    assert not changed[80:400].any()
    green = (np.abs(shown.astype(int) - GOOD).max(axis=2) < 30).any(axis=0)
    assert green.sum() > 60, "the result is written over"
    assert np.flatnonzero(changed.any(axis=0)).max() < width - 5
    assert same_without(frame, shown, changed)


def same_without(frame, shown, changed):
    return bool((frame[~changed] == shown[~changed]).all())


def test_what_a_camera_sees_is_in_the_corner():
    image = Image.new("RGB", (960, 540), (120, 120, 120))
    panel = np.full((100, 100, 3), (10, 200, 30), dtype=np.uint8)
    inset(image, [panel, panel], ("camera", "heights"))
    green = (np.asarray(image) == (10, 200, 30)).all(axis=2)
    assert green.sum() == 2 * panel.shape[0] * panel.shape[1]
    assert np.flatnonzero(green.any(axis=0)).min() > 700


@pytest.mark.usefixtures("opengl")
def test_the_same_throws_run_beside_each_other_and_the_camera_follows(monkeypatch):
    monkeypatch.setattr(films, "SAMPLES", 1)
    monkeypatch.setattr(films, "RATE", 2)
    monkeypatch.setattr(films, "WIDTH", 480)
    monkeypatch.setattr(films, "HEIGHT", 270)
    pair = [
        ThrowFilm("PnTRelease-v0", name, name, "ideal", throws=2, slow=1.0, seed=1, camera=CLOSE, follow=follow)
        for name, follow in (("analytic", 0.0), ("analytic", 0.9))
    ]
    alone = [list(throw_pictures(film, 240)) for film in pair]
    assert [len(throw) for throw in alone[0]] == [len(throw) for throw in alone[1]]
    joined = list(side_by_side(pair))
    assert len(joined) == sum(len(throw) for throw in alone[0])
    assert joined[0].size == (480, 270)
    last = np.asarray(joined[-1]).astype(int)
    assert np.abs(last[50:200, :239] - last[50:200, 241:]).max(axis=2).mean() > 5.0, "neither camera moved"


@pytest.mark.parametrize("moves", [False, True])
def test_a_film_is_saved_at_the_best_quality_that_fits(tmp_path, monkeypatch, moves):
    noise = np.random.default_rng(0).integers(0, 255, (3, 90, 160, 3), dtype=np.uint8)
    images = [Image.fromarray(frame) for frame in noise]
    size = save(images, tmp_path / "film.webp", moves=moves)
    assert size == (tmp_path / "film.webp").stat().st_size
    monkeypatch.setattr(films, "MOST_BYTES", size - 1)
    assert save(images, tmp_path / "film.webp", moves=moves) < size
    monkeypatch.setattr(films, "MOST_BYTES", 10)
    with pytest.raises(ValueError, match="film fewer throws"):
        save(images, tmp_path / "film.webp", moves=moves)
