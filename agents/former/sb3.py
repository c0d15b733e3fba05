"""Former name of `agents.learning.sb3`."""

from importlib import import_module

# Not `from ... import`: this file lies in a folder that is no package.
_PLACE = import_module(".learning.sb3", __package__)
ThrownBuffer = _PLACE.ThrownBuffer
