"""Every controller of a line by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.errors import one_sentence

from ..controllers.protocol import Controller
from ..ground.cli import UsageError
from ..ground.environments import Env, make_vector
from ..ground.places import at
from ..policies.scorer import Scorer
from .lookahead import Beam, Guided
from .rules import Anything, Index
from .scored import Scored, run_scores, scorer_in
from .settings import settings

ENV: Final = "PnTLine-v0"
GUIDED: Final = "guided_beam"
_RULES: Final[Mapping[str, Callable[..., Controller]]] = {
    "random": lambda core: Anything(),
    "fifo": lambda core: Index("fifo", "first"),
    "spt": lambda core: Index("spt", "soonest"),
    "value_rate": lambda core: Index("value_rate", "value_rate"),
    "atc": lambda core, **found: Index("atc", "atc", **found),
    "price": lambda core, **found: Index("price", "atc", **found),
    "pair": lambda core: Beam("pair", core, depth=1, width=10**6, by_rate=True),
    "beam": lambda core, **found: Beam("beam", core, **found),
    "price_beam": lambda core, **found: Beam("price_beam", core, **found),
    "joint_beam": lambda core, **found: Beam("joint_beam", core, joint=True, **found),
    GUIDED: lambda core, guide="index", **found: Guided(GUIDED, core, _guide(guide, core), **found),
    "index": lambda core, **found: Scored("index", Scorer.linear(**found)),
}
NAMES: Final = tuple(_RULES)


def line_of(env: Env) -> LineCore | None:
    """The lines behind an environment; None where it is none of lines."""
    core: Any = getattr(env.unwrapped, "core", None)
    return core if isinstance(core, LineCore) else None


def the_line(env: Env) -> LineCore:
    """The lines behind an environment of lines."""
    core = line_of(env)
    assert core is not None
    return core


def opened(
    env_id: str, level: Any, num_envs: int, threads: int, mode: str | None = None, throws: str | None = None
) -> Env:
    """An environment as `make_vector` opens it, on a line with throws as they are asked for.

    Raises:
        UsageError: throws are asked for, and there is no line.
    """
    env = make_vector(env_id, level, num_envs, threads, mode)
    if throws is None:
        return env
    line = line_of(env)
    env.close()
    if line is None:
        raise UsageError("--throws goes with a line, such as PnTLine-v0")
    return make_vector(env_id, LineConfig.load(line.config, throws=throws), num_envs, threads, mode)


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
