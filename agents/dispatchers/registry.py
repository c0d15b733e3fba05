"""Registry of the controllers of lines."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from pnt_gym.cells.line.core import LineCore
from pnt_gym.errors import one_sentence
from pnt_gym.names import unknown_name

from ..controllers.protocol import Controller
from ..ground import shipped
from ..ground.cli import UsageError, about, check_known, settings_of
from ..ground.environments import Env, core_of
from ..ground.shipped import DECIDING, LINE
from ..policies.scorer import Scorer
from . import clairvoyant
from .lookahead import Beam, GuidedBeam, Lookahead
from .rules import IndexRule, RandomChoice, ScoreController, run_scores
from .settings import check, settings

ENV: Final = LINE
FIRST: Final = "fifo"
GUIDED: Final = "guided_beam"
SEARCHED: Final = "index"
"""The controller whose weights a search tunes; without a search its shipped weights are used."""
FORESEEING: Final = "clairvoyant"
"""The controller that knows each shift in advance."""
_RULES: Final[Mapping[str, Callable[..., Controller]]] = {
    "random": lambda core: RandomChoice(),
    FIRST: lambda core: IndexRule(FIRST, "first"),
    "spt": lambda core: IndexRule("spt", "soonest"),
    "value_rate": lambda core: IndexRule("value_rate", "value_rate"),
    "atc": lambda core, **found: IndexRule("atc", "atc", **found),
    "price": lambda core, **found: IndexRule("price", "atc", **found),
    "beam": lambda core, **found: Beam("beam", core, **found),
    "price_beam": lambda core, **found: Beam("price_beam", core, **found),
    GUIDED: lambda core, guide=SEARCHED, **found: GuidedBeam(GUIDED, core, _make(guide, core), **found),
    SEARCHED: lambda core, **found: ScoreController(SEARCHED, Scorer.linear(**found)),
    FORESEEING: lambda core: clairvoyant.Clairvoyant(FORESEEING, core),
}
_SETTINGS: Final[Mapping[str, Sequence[Callable[..., Any]]]] = {
    **dict.fromkeys(("atc", "price"), (IndexRule,)),
    **dict.fromkeys(("beam", "price_beam"), (Lookahead,)),
    GUIDED: (_RULES[GUIDED], GuidedBeam, Lookahead),
    SEARCHED: (Scorer.linear,),
}
"""What takes the settings of controllers that have any."""
NAMES: Final = tuple(_RULES)
CHOICES: Final[Mapping[str, str]] = {
    "random": "a random choice, all equally likely",
    "fifo": "the object that leaves the window first (first in, first out)",
    "spt": "the choice with the shortest cycle",
    "value_rate": "the choice with the greatest value x chance / cycle",
    "atc": "the choice with the greatest value x chance / cycle x exp(-slack / k): among choices of equal worth the "
    "most urgent (Vepsalainen and Morton 1987)",
    "price": "as `atc`, with less value for an object that a robot downstream can take too",
    "beam": "the first pick of the robot's best plan for its next 4 s, by beam search",
    "price_beam": "as `beam`, with less value for an object that a robot downstream can take too",
    "guided_beam": "one of the four choices that a scorer (`index` or a training run) likes best: the choice with the "
    "greatest sum of its score and the value of the best plan of the next 3 s that begins with it",
    "index": "the choice with the greatest sum of the log of `atc`'s index and weighted entries, found by CMA-ES",
    "clairvoyant": "what the best order begins with that a search finds for the whole shift, all objects and all draws "
    "known: nobody can know them, and the best order is worth at least as much",
}
"""The choice of each controller of a line."""


def line_core(env: Env) -> LineCore:
    """Core of an environment of lines."""
    core = core_of(env)
    assert isinstance(core, LineCore)
    return core


def make(name: str, core: LineCore, **options: Any) -> Controller:
    """Controller of a name with the settings tuned for the level, or a learned controller.

    Args:
        name: one of `NAMES`, a shipped policy such as shipped:line/skills3, a run folder, or a scorer's .npz file, in
            the working folder or among the shipped files.
        core: core of the lines on which the controller will work.
        options: settings that replace the tuned ones.

    Raises:
        UsageError: the name belongs to no controller of a line.
    """
    if name not in _RULES:
        place = shipped.place(name)
        if os.path.isdir(place) or place.suffix == ".npz":
            with about(f"controller {name!r}"):
                check_known("setting", options, ())
        if os.path.isdir(place):  # False for a name too long to be one
            return run_scores(place)
        if place.suffix == ".npz":
            return ScoreController(place.stem, Scorer.load(place))
        further = ", the folder of a training run, and a scorer's .npz file"
        raise UsageError(unknown_name("controller of a line", name, (*NAMES, *shipped.names(DECIDING)), further))
    with about(f"controller {name!r}"):
        check_known("setting", options, settings_of(*_SETTINGS.get(name, ())))
    tuned_settings = settings(core.config.name, name, len(core.config.robots))
    chosen = {**tuned_settings, **options}
    check(name, chosen)
    try:
        return _RULES[name](core, **chosen)
    except TypeError:
        raise UsageError(f"controller {name!r} has no settings {', '.join(map(str, chosen))}") from None


def _make(name: str, core: LineCore) -> ScoreController:
    """Scoring controller that guides a planner.

    Raises:
        UsageError: no scoring controller has this name.
    """
    guide = make(name, core)
    if not isinstance(guide, ScoreController):
        raise UsageError(
            f"{GUIDED} has guide {one_sentence(name, 80)!r}; guides are index, the folder of a training run, and a "
            "scorer's .npz file"
        )
    return guide
