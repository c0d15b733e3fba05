"""Learn from tries where a cup holds, and compare with rules: `python -m agents.grasping --out FILE.npz`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

from ..ground.cli import at_least, check_libraries, option, run
from ..ground.outputs import check_ending, check_writable, deliver
from ..ground.tables import Grid, console, throws_bar

if TYPE_CHECKING:
    from .network import PlaceNetwork


HELD_OUT: Final = 10_000_000
"""Offset of the seeds of the judged objects from those of tries."""


JUDGED: Final = ("grasp", "grasp_unseen")
"""Levels on whose objects places are compared: with seen and with unseen kinds."""


@dataclass(frozen=True)
class Arguments:
    """Try places on drawn objects, one try an object and without a robot, fit networks, and compare them with rules."""

    level: str = "grasp"
    """Level of PnTGrasp-v0 with surfaces, on whose objects places are tried."""
    drawn: int = 0
    """Kinds that are drawn at random, each with a shape, a surface and a look, and tried beside those of the level."""
    tries: int = 20_000
    """Tries, of which the first 30 % are at random places."""
    sees: Literal["all", "local", "depth"] = "local"
    """What the networks see: all features, those without the colours of the whole object, or depths alone."""
    seed: int = 0
    """Seed of objects, places and networks."""
    out: Annotated[Path | None, option("none", "FILE.npz")] = None
    """File of the networks' arrays, which NumPy alone computes: the option `file` of local_mlp."""
    judge: int = 2000
    """Held-out objects, of seen and of unseen kinds, on which the places are compared; 0 for no table."""


def main(arguments: Arguments) -> None:
    """Practise, save, and compare."""
    at_least(vars(arguments), drawn=0, tries=1, seed=0, judge=0)
    check_ending("--out", arguments.out, (".npz",))
    check_writable(arguments.out)
    check_libraries("torch")
    from .features import SIGHTS  # noqa: PLC0415 - help comes first
    from .practice import practise  # noqa: PLC0415 - as above
    from .scenes import with_drawn_kinds  # noqa: PLC0415 - as above

    level = with_drawn_kinds(arguments.level, arguments.drawn, arguments.seed)
    with throws_bar() as bar:
        advance = partial(bar.advance, bar.add_task("tries", total=arguments.tries))
        practice = practise(level, arguments.tries, arguments.seed, SIGHTS[arguments.sees], advance)
    count = max(arguments.tries // 5, 1)
    first, last = practice.held[:count].mean(), practice.held[-count:].mean()
    print(f"held: {first:.1%} of the first {count} tries, {last:.1%} of the last")
    if arguments.out is not None:
        deliver(arguments.out, practice.network.save)
    if arguments.judge > 0:
        compare(practice.network, arguments)


def compare(network: PlaceNetwork, arguments: Arguments) -> None:
    """Print how often cups hold at the places of the rules, of the network and of the oracle."""
    from .features import place_features  # noqa: PLC0415 - help comes first
    from .practice import network_places  # noqa: PLC0415 - as above
    from .rules import PLACES  # noqa: PLC0415 - as above
    from .scenes import Scenes  # noqa: PLC0415 - as above

    rows: list[tuple[str, ...]] = []
    for level in JUDGED:
        scenes = Scenes.draw(level, arguments.judge, HELD_OUT + arguments.seed)
        features = place_features(scenes.images, scenes.radius)
        by_rule = {name: place(scenes, features) for name, place in PLACES.items()}
        for name, places in {**by_rule, "networks": network_places(features, network)}.items():
            tries = scenes.try_places(places)
            rows.append((level, name, f"{tries.held.mean():.1%}", f"{tries.kept.mean():.1%}"))
    title = f"{arguments.judge} held-out objects of each"
    console().print(Grid(title, ("level", "places", "held", "kept at 45 %"), rows).terminal())


if __name__ == "__main__":
    run(main, Arguments, "agents.grasping")
