"""Pictures show the cell, a recording is the throw it was made of, and a video has the length of its throws."""

from contextlib import nullcontext
from itertools import pairwise

import gymnasium as gym
import imageio.v3 as iio
import mujoco
import numpy as np
import pytest

from pnt_gym.cells.base import canvas
from pnt_gym.cells.base.canvas import FPS
from pnt_gym.cells.base.view import ThrowView, record_video
from pnt_gym.cells.conveyor.view import camera
from pnt_gym.errors import ConfigError
from tests.tools.nightly import with_nightly
from tests.tools.throws import make_core, same_bits

pytestmark = pytest.mark.usefixtures("opengl")

SMALL = (96, 160)
ZERO = np.zeros((1, 2))


def belt_core(level="nominal", seed=0, count=1):
    return make_core(level, count, picks="belt", seed=seed)


def small_view(core):
    """A view with small frames, opened on a model with coarse shadows, which software draws five times as quickly."""
    view = ThrowView(core.cell, camera(), size=SMALL)
    model, _ = core.cell.pose(0)
    quality = model.vis.quality
    quality.shadowsize, quality.offsamples = 256, 0
    view._canvas._open_renderer(model)
    return view


@pytest.fixture(scope="module")
def viewed():
    """One throw of a cell that is looked at, and its frames."""
    core = belt_core(seed=2)
    view = small_view(core)
    before = view.frame()
    outcome = core.preview(ZERO, jitter=True)
    info = core.step(ZERO).info
    frames = view.last_throw()
    yield core, before, info, outcome, frames, view
    view.close()


def test_a_frame_shows_belt_bins_and_object(viewed):
    _, frame, *_ = viewed
    assert frame.shape == (*SMALL, 3)
    assert frame.dtype == np.uint8
    assert frame.std() > 20.0
    assert 40.0 < frame.mean() < 250.0
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 200
    pixels = frame.reshape(-1, 3).astype(int)
    red, green, blue = pixels.T
    assert ((blue > red + 40) & (blue > green)).any(), "no blue bin"
    assert ((red > 120) & (red > blue + 60)).any(), "no orange cup and no yellow object"
    assert ((red < 90) & (green < 90) & (blue < 100)).sum() > 100, "no dark belt"


def test_another_pick_is_another_picture(viewed):
    core, before, _, _, _, view = viewed
    after = view.frame()
    assert (np.abs(after.astype(int) - before).max(axis=2) > 40).sum() > 20
    assert same_bits(view.frame(), after)
    assert core.cell.markers(0)


def test_a_throw_is_shown_at_its_true_rate(viewed):
    _, _, info, _, frames, view = viewed
    recording = view._cell.plant.recording
    seconds = len(recording.control) * recording.model.opt.timestep
    assert len(frames) == pytest.approx(seconds * FPS, abs=1.0)
    # Physics runs until hand and object have come to rest; the dwell is counted, not simulated.
    assert seconds >= info["cycle_time"][0] - 0.10 - 1e-3
    assert seconds < info["cycle_time"][0] + 0.6
    moving = [np.abs(a.astype(int) - b).max() for a, b in pairwise(frames)]
    assert np.mean(np.array(moving) > 40) > 0.5


def test_other_rates_give_other_counts(viewed):
    *_, frames, view = viewed
    assert len(view.last_throw(fps=10)) == pytest.approx(len(frames) / 3, abs=1.0)


@pytest.mark.parametrize("moment", [0.0, 0.5, 99.0, np.inf])
def test_one_moment_is_the_frame_of_the_throw_that_is_shown_then(viewed, moment):
    *_, frames, view = viewed
    assert same_bits(view.at(moment), frames[round(min(FPS * moment, len(frames) - 1))])


def test_a_recording_replays_the_throw(viewed):
    """Stepped again by MuJoCo itself, with the robot to the end, the object passes where the batch left it."""
    core, _, _, outcome, _, _ = viewed
    recording = core.cell.plant.recording
    last = None
    for data, trail in recording.play(1.0 / FPS):
        assert trail.shape[1] == 3
        last = data
    assert last.time == pytest.approx(len(recording.control) * recording.model.opt.timestep, abs=1e-9)
    replay = mujoco.MjData(recording.model)
    mujoco.mj_setState(recording.model, replay, recording.state, int(mujoco.mjtState.mjSTATE_INTEGRATION))
    nu, body = recording.model.nu, recording.model.body("object").id
    places = []
    for control in recording.control:
        replay.ctrl[:], replay.eq_active[:] = control[:nu], control[nu:] > 0
        mujoco.mj_step(recording.model, replay)
        places.append(replay.xpos[body].copy())
    assert same_bits(last.qpos, replay.qpos)
    assert np.linalg.norm(np.array(places) - outcome.final[0], axis=1).min() < 1e-6


def test_the_planned_flight_ends_at_the_target(viewed):
    core, *_ = viewed
    recording = core.cell.plant.recording
    np.testing.assert_allclose(recording.plan[-1], recording.target, atol=1e-6)


def test_looking_changes_nothing():
    seen, unseen = belt_core(seed=5), belt_core(seed=5)
    view = small_view(seen)
    for _ in range(2):
        view.frame()
        a, b = seen.step(ZERO), unseen.step(ZERO)
        view.last_throw(fps=5)
        assert same_bits(a.observation, b.observation)
        assert same_bits(a.reward, b.reward)
    view.close()
    view.close()


def test_a_throw_that_has_not_happened_has_no_frames():
    core = belt_core()
    view = small_view(core)
    assert view.last_throw() == []
    with pytest.raises(ConfigError, match="there is no throw to draw yet"):
        view.at(0.0)
    view.close()


def test_the_environment_renders_at_full_size():
    env = gym.make("PnTRelease-v0", render_mode="rgb_array")
    env.reset(seed=0)
    assert env.render().shape == (720, 1280, 3)
    env.close()


def test_a_picture_has_the_size_and_the_camera_asked_for():
    standard = {"azimuth": 232.0, "elevation": -24.0, "distance": 2.7, "lookat": (-0.04, 0.10, -0.56)}
    frames = []
    for changed in (None, standard, {"azimuth": 60.0}):
        env = gym.make("PnTRelease-v0", render_mode="rgb_array", width=96, height=64, camera=changed)
        env.reset(seed=0)
        frames.append(env.render())
        env.close()
    assert frames[0].shape == (64, 96, 3)
    assert (frames[0] == frames[1]).all()
    assert (abs(frames[0].astype(int) - frames[2]).max(axis=2) > 40).mean() > 0.1


def test_a_vector_environment_renders_every_row():
    env = gym.make_vec("PnTRelease-v0", num_envs=2, render_mode="rgb_array", width=160, height=96)
    env.reset(seed=0)
    frames = env.render()
    assert [frame.shape for frame in frames] == [(96, 160, 3)] * 2
    assert not same_bits(*frames)
    env.close()


def test_without_a_render_mode_there_is_nothing_to_see():
    env = gym.make("PnTRelease-v0").unwrapped
    env.reset(seed=0)
    assert env.render() is None
    assert gym.make_vec("PnTRelease-v0", num_envs=2).render() is None


@pytest.mark.nightly
def test_a_list_of_frames_covers_the_last_throw():
    """The list mode hands out what the view recorded; small frames keep the test short."""
    env = gym.make("PnTConveyor-v0", render_mode="rgb_array_list").unwrapped
    env._view = small_view(env.core)
    env.reset(seed=0)
    assert env.render() == []
    *_, info = env.step(np.zeros(2))
    frames = env.render()
    assert isinstance(frames, list)
    assert (info["cycle_time"] - 0.1) * FPS - 1 <= len(frames) <= (info["cycle_time"] + 0.6) * FPS
    env.close()


def count_frames(path):
    return sum(1 for _ in iio.imiter(path, plugin="FFMPEG"))


@pytest.mark.parametrize("slow", with_nightly((1, 3), [1]))
def test_a_video_has_as_many_frames_as_its_throws_take(tmp_path, slow):
    core = belt_core(seed=1)
    steps = []

    def throws():
        for _ in range(2):
            core.step(ZERO)
            steps.append(len(core.cell.plant.recording.control))
            yield

    path = record_video(small_view(core), throws(), tmp_path / "deep" / "throws.mp4", fps=10, slow=slow)
    assert path == tmp_path / "deep" / "throws.mp4"
    expected = sum(-(-slow * count // 100) for count in steps)  # a frame every 100 steps of 1 ms, or more often
    assert count_frames(path) == pytest.approx(expected, abs=2)


def test_a_video_of_nothing_is_refused_leaves_no_file_and_closes_its_view(tmp_path, monkeypatch):
    view, closed = belt_core().view(), []
    monkeypatch.setattr(view, "close", lambda: closed.append(view))
    with pytest.raises(ConfigError, match="at least one throw"):
        record_video(view, [], tmp_path / "none.mp4")
    assert closed == [view]
    assert not list(tmp_path.iterdir())


class FakeWindow:
    """A window without a display: keeps the places of the bodies at each picture."""

    def __init__(self, data):
        self.data, self.pictures, self.is_open = data, [], True
        self.lock = nullcontext

    def sync(self):
        self.pictures.append(self.data.xpos.copy())

    def close(self):
        self.is_open = False


def test_a_window_shows_every_picture_of_the_last_throw(viewed, monkeypatch):
    core, *_ = viewed
    windows = []
    monkeypatch.setattr(canvas, "_open_window", lambda model, data: windows.append(FakeWindow(data)) or windows[-1])
    monkeypatch.setattr(canvas.time, "sleep", lambda seconds: None)
    view = ThrowView(core.cell, camera(), size=SMALL)
    core.step(ZERO)
    view.show()
    view.show()
    (window,) = windows
    shown = [scene.xpos.copy() for scene, _ in core.cell.plant.recording.play(1.0 / FPS)]
    assert len(window.pictures) == 2 * len(shown)
    assert all(same_bits(picture, scene) for picture, scene in zip(window.pictures, shown * 2, strict=True))
    view.close()
    assert not window.is_open
