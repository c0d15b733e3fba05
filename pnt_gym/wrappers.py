"""Wrappers for environments in which one step is a whole throw."""

from __future__ import annotations

from typing import Any, final

import gymnasium


@final
class RecordVideo(gymnasium.wrappers.RecordVideo[Any, Any]):
    """Gymnasium's `RecordVideo` with every frame of every throw, at true rate.

    Gymnasium's own keeps one frame a step, which here is one frame a throw. The environment needs the render mode
    `rgb_array_list`:

        env = gym.make("PnTConveyor-v0", render_mode="rgb_array_list")
        env = RecordVideo(env, "videos")

    Args are those of `gymnasium.wrappers.RecordVideo`; `video_length` counts frames.
    """

    def _capture_frame(self) -> None:
        frames: Any = self.env.render()
        self.recorded_frames += frames if isinstance(frames, list) else [frames]
