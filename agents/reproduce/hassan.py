"""Former place of `papers.hassan`, whose module `nlp` was documented by that name."""

from pnt_gym.errors import MovedError

raise MovedError("agents.reproduce.hassan is papers.hassan now, in the source tree of pnt_gym")
