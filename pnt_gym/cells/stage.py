"""How cells are lit and what stands behind them, for the eye only."""

from __future__ import annotations

import numpy as np

from pnt_gym.engine import MjSpec, mujoco


def light_stage(spec: MjSpec, ambient: float = 0.38, diffuse: float = 0.42) -> None:
    """Set size and shadows of pictures, the light at the camera, and a plain bright sky.

    MuJoCo's black default hides carbon rods.

    Args:
        spec: a mujoco.MjSpec.
        ambient: of the light at the camera, the same in every direction.
        diffuse: of the light at the camera.
    """
    visual = spec.visual
    visual.global_.offwidth, visual.global_.offheight = 1920, 1080
    visual.headlight.ambient, visual.headlight.diffuse = np.full(3, ambient), np.full(3, diffuse)
    visual.quality.shadowsize = 4096
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.90, 0.93, 0.96],
        rgb2=[0.55, 0.62, 0.70],
        width=64,
        height=384,
    )
