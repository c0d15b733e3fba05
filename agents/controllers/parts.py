"""Parts of controllers that grasp and throw, for controllers of one's own: places, paces and releases.

`docs/extend.md` has a grasp rule that is composed of them.
"""

from .fitted_q import fitted_values
from .grasps import Centre, FixedPace, GaugePace, GraspController, Pace, Place, new_release, shipped_release
from .places import Sight, TrueSurface, centroid, flattest, local_mlp

__all__ = [
    "Centre",
    "FixedPace",
    "GaugePace",
    "GraspController",
    "Pace",
    "Place",
    "Sight",
    "TrueSurface",
    "centroid",
    "fitted_values",
    "flattest",
    "local_mlp",
    "new_release",
    "shipped_release",
]
