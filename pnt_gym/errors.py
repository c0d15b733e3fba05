"""The errors a user can cause; each carries one sentence that names the value and the valid range."""


class PntGymError(ValueError):
    """Base of every error that pnt_gym raises on purpose."""


class ConfigError(PntGymError):
    """A level, a config file or a setting that describes no working cell."""


class ActionError(PntGymError):
    """An action of the wrong shape, or one that is not a finite number."""
