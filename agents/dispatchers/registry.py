"""Every controller of a line by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from pnt_gym.cells.line.core import LineCore
from pnt_gym.errors import one_sentence

from ..controllers.protocol import Controller
from ..ground.cli import UsageError
from ..ground.environments import Env, core_of
from ..ground.places import at
from ..policies.scorer import Scorer
from .lookahead import Beam, Guided
from .rules import Anything, Index
from .scored import Scored, run_scores, scorer_in
from .settings import settings

ENV: Final = "PnTLine-v0"
FIRST: Final = "fifo"
GUIDED: Final = "guided_beam"
SEARCHED: Final = "index"
"""The controller that a search finds where it has decisions to learn from; without any it is the one that ships."""
_RULES: Final[Mapping[str, Callable[..., Controller]]] = {
    "random": lambda core: Anything(),
    FIRST: lambda core: Index(FIRST, "first"),
    "spt": lambda core: Index("spt", "soonest"),
    "value_rate": lambda core: Index("value_rate", "value_rate"),
    "atc": lambda core, **found: Index("atc", "atc", **found),
    "price": lambda core, **found: Index("price", "atc", **found),
    "pair": lambda core: Beam("pair", core, depth=1, width=10**6, by_rate=True),
    "beam": lambda core, **found: Beam("beam", core, **found),
    "price_beam": lambda core, **found: Beam("price_beam", core, **found),
    "joint_beam": lambda core, **found: Beam("joint_beam", core, joint=True, **found),
    GUIDED: lambda core, guide=SEARCHED, **found: Guided(GUIDED, core, _guide(guide, core), **found),
    SEARCHED: lambda core, **found: Scored(SEARCHED, Scorer.linear(**found)),
}
NAMES: Final = tuple(_RULES)


def the_line(env: Env) -> LineCore:
    """The lines behind an environment of lines."""
    core = core_of(env)
    assert isinstance(core, LineCore)
    return core


def line_controller(name: str, core: LineCore, **options: Any) -> Controller:
    """The controller of a name, with the settings that were tuned for the level, or one that has learned.

    Args:
        name: one of `NAMES`, a run folder, or a scorer's .npz file, from the working folder or where what ships lies.
        core: the lines that it will work on.
        options: settings that replace those.

    Raises:
        UsageError: there is no such controller of a line.
    """
    if name not in _RULES:
        place = at(name)
        if place.is_dir():
            return run_scores(place)
        if name.endswith(".npz"):
            return scorer_in(place)
        known = ", ".join(NAMES)
        raise UsageError(
            f"{one_sentence(name, 80)!r} is no controller of a line; controllers are {known}, the folder of a training "
            "run, and a scorer's .npz file"
        )
    tuned = settings(core.config.name, name, len(core.config.robots))
    return _RULES[name](core, **{**tuned, **options})


def _guide(name: str, core: LineCore) -> Scored:
    """What guides a planner: a controller that scores choices.

    Raises:
        UsageError: there is none of that name.
    """
    found = line_controller(name, core)
    if not isinstance(found, Scored):
        raise UsageError(
            f"{GUIDED} has guide {one_sentence(name, 80)!r}; guides are index, the folder of a training run, and a "
            "scorer's .npz file"
        )
    return found
