"""The module of the live viewer, loaded where it is asked for."""

from __future__ import annotations

from typing import Any

from pnt_gym.engine import has_display

from ..ground.cli import UsageError


def load_viewer(kind: str) -> Any:
    """The module of the live viewer; kind is "native" or "web".

    Raises:
        UsageError: there is no display for a window, or the platform lacks MuJoCo's Studio.
    """
    if kind == "native" and not has_display():
        raise UsageError("--viewer native needs a display; --viewer web does without one")
    try:
        from . import viewer  # noqa: PLC0415 - takes a second, and is not on every platform
    except ImportError as error:
        raise UsageError(f"--viewer needs MuJoCo's Studio, which this platform has not ({error})") from None
    return viewer
