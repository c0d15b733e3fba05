"""Former name of `agents.dataset.episodes`."""

from importlib import import_module

# Not `from ... import`: this file lies in a folder that is no package.
_PLACE = import_module(".dataset.episodes", __package__)
Episode = _PLACE.Episode
episodes = _PLACE.episodes
episode_seeds = _PLACE.episode_seeds
