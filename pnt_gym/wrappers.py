"""Wrappers for environments in which one step is a whole throw."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, final

import gymnasium
from gymnasium.utils import RecordConstructorArgs

from .cells.base.view import check_video, write_video
from .errors import ConfigError

Trigger = Callable[[int], bool]


def _is_cube(episode: int) -> bool:
    """Whether Gymnasium's default records an episode: 0, 1, 8, 27, ... up to 1000, and then every 1000th."""
    return round(episode ** (1 / 3)) ** 3 == episode if episode < 1000 else episode % 1000 == 0


@final
class RecordVideo(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Records videos as Gymnasium's `RecordVideo` does, but with every frame of every throw, at true rate.

    Gymnasium's own wrapper keeps one frame a step, which here is one frame a throw, and writes by MoviePy. This wrapper
    writes by imageio, of the extra `video`. The environment needs the render mode `rgb_array_list`:

        env = gym.make("PnTConveyor-v0", render_mode="rgb_array_list")
        env = RecordVideo(env, "videos")

    Args:
        env: the environment.
        video_folder: folder of the videos; a video of the same name is replaced.
        episode_trigger: whether a video begins with an episode of this number, from 0; without any trigger, with the
            episodes 0, 1, 8, 27 and so on, and from 1000 on with every 1000th.
        step_trigger: whether a video begins with a step of this number, from 0, over all episodes.
        video_length: frames of a video; 0 for a whole episode.
        name_prefix: a video is called NAME_PREFIX-episode-N.mp4 or NAME_PREFIX-step-N.mp4.
        fps: frames per second; None for the environment's own.

    Raises:
        ConfigError: the environment renders nothing that can be recorded, or imageio with ffmpeg is not installed.
    """

    def __init__(
        self,
        env: gymnasium.Env[Any, Any],
        video_folder: str | Path,
        episode_trigger: Trigger | None = None,
        step_trigger: Trigger | None = None,
        video_length: int = 0,
        name_prefix: str = "rl-video",
        fps: int | None = None,
    ) -> None:
        RecordConstructorArgs.__init__(
            self,
            video_folder=video_folder,
            episode_trigger=episode_trigger,
            step_trigger=step_trigger,
            video_length=video_length,
            name_prefix=name_prefix,
            fps=fps,
        )
        super().__init__(env)
        if env.render_mode not in ("rgb_array", "rgb_array_list"):
            raise ConfigError(f"render_mode is {env.render_mode!r}; a video needs 'rgb_array_list' or 'rgb_array'")
        check_video()
        self.video_folder, self.name_prefix = Path(video_folder).absolute(), name_prefix
        self.video_length = video_length
        self.frames_per_sec: int = fps or env.metadata.get("render_fps", 30)
        self.episode_trigger = _is_cube if episode_trigger is None and step_trigger is None else episode_trigger
        self.step_trigger = step_trigger
        self.recorded_frames: list[Any] = []
        self.episode_id = self.step_id = -1
        self._video: str | None = None

    @property
    def recording(self) -> bool:
        """Whether a video is being recorded."""
        return self._video is not None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment; the video of the last episode ends, and a new video may begin."""
        first = self.env.reset(seed=seed, options=options)
        self.episode_id += 1
        if not self.video_length:
            self.stop_recording()
        if self.episode_trigger is not None and self.episode_trigger(self.episode_id):
            self.start_recording(f"{self.name_prefix}-episode-{self.episode_id}")
        self._record()
        return first

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step the environment, and record the frames of the step."""
        outcome = self.env.step(action)
        self.step_id += 1
        if self.step_trigger is not None and self.step_trigger(self.step_id):
            self.start_recording(f"{self.name_prefix}-step-{self.step_id}")
        self._record()
        return outcome

    def close(self) -> None:
        """End the video that is being recorded, and close the environment."""
        self.stop_recording()
        super().close()

    def start_recording(self, video_name: str) -> None:
        """Begin a video; a video that is being recorded ends."""
        self.stop_recording()
        self._video = video_name

    def stop_recording(self) -> None:
        """End the video that is being recorded, if any, and write its frames."""
        video, self._video = self._video, None
        frames, self.recorded_frames = self.recorded_frames, []
        if video is not None and frames:
            write_video(frames[: self.video_length or None], self.video_folder / f"{video}.mp4", self.frames_per_sec)

    def _record(self) -> None:
        """Keep the frames of the last step, while a video is being recorded."""
        if not self.recording:
            return
        frames: Any = self.env.render()
        self.recorded_frames += frames if isinstance(frames, list) else [frames]
        if 0 < self.video_length <= len(self.recorded_frames):
            self.stop_recording()
