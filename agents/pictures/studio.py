"""The live viewer, loaded where it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from pnt_gym.engine import has_display

from ..ground import environments
from ..ground.cli import UsageError
from ..learning import trained
from .door import open_front
from .stage import Stage


def show(
    address: str | None, controller: str, env: str | None, level: str | None, open_stage: Callable[[str, str], Stage]
) -> None:
    """Show throws in a viewer until the viewer is closed.

    Args:
        address: address of this machine at which a page is served; None for a window.
        controller: first controller, as `--controller` takes it.
        env: as `--env` takes it; None for the environment of the controller's training, or the default.
        level: first level; None for the level of the controller's training, or the environment's own.
        open_stage: returns the stage of a controller and a level, either of which the viewer may have changed.

    Raises:
        UsageError: there is no display for a window, or the platform lacks MuJoCo's Studio.
    """
    if address is None and not has_display():
        raise UsageError("--viewer native needs a display; --viewer web does without one")
    try:
        from . import viewer as screen  # noqa: PLC0415 - takes a second, and is not on every platform
    except ImportError as error:
        raise UsageError(f"--viewer needs MuJoCo's Studio, which this platform has not ({error})") from None
    env_id, level, _ = trained.resolve(controller, env, level, None)
    first = screen.Choice(controller, level or environments.find(env_id).kwargs.get("level", "nominal"))
    with ExitStack() as ends:
        front = None if address is None else ends.enter_context(open_front(address))
        screen.watch(lambda choice: open_stage(choice.controller, choice.level), first, front)
