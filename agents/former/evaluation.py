"""Former name of `agents.judging.evaluation`."""

from importlib import import_module

# Not `from ... import`: this file lies in a folder that is no package.
_PLACE = import_module(".judging.evaluation", __package__)
evaluate = _PLACE.evaluate
