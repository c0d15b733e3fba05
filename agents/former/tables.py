"""Former name of `agents.ground.tables`."""

from importlib import import_module

# Not `from ... import`: this file lies in a folder that is no package.
_PLACE = import_module(".ground.tables", __package__)
Grid = _PLACE.Grid
