"""Pictures: a frame of the cell, the last throw at its true rate, a video with the planned and the flown path.

Rendering is offscreen (EGL on machines without a display). Physics needs none of this.
"""

from pnt_gym.render.canvas import FPS, RENDER_MODES, SIZE, Frame, Marker, rendering_problem
from pnt_gym.render.conveyor import CellView
from pnt_gym.render.view import Playable, ThrowView, View, record_video

__all__ = [
    "FPS",
    "RENDER_MODES",
    "SIZE",
    "CellView",
    "Frame",
    "Marker",
    "Playable",
    "ThrowView",
    "View",
    "record_video",
    "rendering_problem",
]
