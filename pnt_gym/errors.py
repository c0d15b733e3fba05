"""The errors a user can cause; each carries one sentence that names the value and the valid range.

The rule: every error that the package raises on purpose because of a user's input descends from `PntGymError`, a
ValueError. `except PntGymError` therefore catches "there is no throw" (`planning.InfeasibleThrow`), "there is no
release" (`planning.one_joint.UnreachableGoal`), numbers out of range, arrays of the wrong shape, and broken configs.

An unknown keyword of an environment, of `pnt_gym.evaluate`, `compare`, `fit` or `plan_line` is such an error too, and
no TypeError: Gymnasium adds all arguments of `gymnasium.make` to the sentence of a TypeError. Functions of
`pnt_gym.planning` have Python's own TypeError.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NoReturn


def one_sentence(text: object, limit: int = 400) -> str:
    """A text, or the message of an error, on one line of at most ``limit`` characters."""
    line = " ".join(str(text).split())
    return line if len(line) <= limit else f"{line[: limit - 3]}..."


class PntGymError(ValueError):
    """Base of every error that pnt_gym raises on purpose.

    The message is one sentence on one line. Of several problems, the first argument says where they are, and each
    further argument is a problem with a line of its own.
    """

    def __str__(self) -> str:
        return "\n- ".join(one_sentence(part, 500) for part in self.args)


class ReachWarning(UserWarning):
    """A part of a line's objects is out of reach of its robots."""


class ConfigError(PntGymError):
    """A level, a config file or a setting that describes no working cell."""


class PlanningError(PntGymError):
    """Numbers or shapes from which no plan, path or motion can be computed."""


class ActionError(PntGymError):
    """An action of the wrong shape, or with a number that is not finite."""


class PhysicsError(PntGymError):
    """The engine warned or stopped: the throw's numbers would be worthless."""

    simulations: Sequence[int] = ()
    """Simulations in which the engine warned."""


class OrderError(PntGymError):
    """A step of an environment that was not reset, or a call on a closed environment."""


class MovedError(PntGymError, ImportError):
    """A name that has left pnt_gym; an ImportError too, since `from ... import` hides the message of other errors."""


def refuse_moved_names(module: str, places: Mapping[str, str]) -> Callable[[str], NoReturn]:
    """Return a module's `__getattr__` that refuses moved names and says where each name is now.

    Args:
        module: name of the module.
        places: the module that each name moved to.
    """

    def refuse(name: str) -> NoReturn:
        if name in places:
            raise MovedError(f"{module}.{name} is {places[name]}.{name} now, in the source tree of pnt_gym")
        raise AttributeError(f"module {module!r} has no attribute {name!r}")

    return refuse
