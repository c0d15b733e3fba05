"""Moving pictures of all environments, for the site and the README: `make pictures`, or `python docs/pictures.py`.

Every film is a few throws of a controller, the planned flight in blue and the flown one in orange; of a line it is the
begin of a shift, every throw simulated. The film `hero` shows the same throws by the planner and by a learned policy.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import closing
from itertools import chain, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

ROOT: Final = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from agents.ground.drawings import svg  # noqa: E402
from agents.ground.files import write_text  # noqa: E402
from agents.judging.trials import open_trial  # noqa: E402
from agents.line import plan  # noqa: E402
from agents.pictures import films, places  # noqa: E402
from agents.pictures.films import ThrowFilm  # noqa: E402
from pnt_gym.cells.base.canvas import Viewpoint  # noqa: E402

FOLDER: Final = ROOT / "docs" / "pictures"
LINE: Final = ("PnTLine-v0", "skills3", "price", 6.0)
"""The environment of lines, its level, who decides, and for how many seconds it is filmed, every throw simulated."""
PLACES: Final = "grasp_places"
"""Name of the figure of places to grasp."""
HERO: Final = "hero"
"""Name of the film of the planner and of a learned policy beside each other."""
ACROSS: Final = Viewpoint(lookat=(0.0, 0.20, -0.70), distance=2.0, azimuth=232.0, elevation=-26.0)
"""Over the bins to the belt, close."""
PAIR: Final = tuple(
    ThrowFilm("PnTRelease-v0", controller, title, "waste", throws=6, slow=1.0, seed=16, camera=ACROSS)
    for controller, title in (("analytic", "planner alone"), ("shipped:waste-sac", "planner + learned"))
)
"""The same throws by both; `check_typical` holds the seed to what many seeds show."""
SEEDS: Final = 60
"""Seeds whose mean the seed of the pair shows, rounded."""
FILMS: Final = {
    film.env: film
    for film in (
        ThrowFilm(
            "PnTConveyor-v0", "shipped:waste-sac", "conveyor: learned by SAC", "waste", throws=4, slow=1.5,
            camera=Viewpoint(lookat=(-0.05, 0.02, -0.80), distance=1.6, azimuth=228.0, elevation=-24.0), follow=0.45,
        ),
        ThrowFilm(
            "PnTAdapt-v0", "kalman", "a cell that drifts: Kalman filter", "day", throws=4, slow=1.5,
            camera=Viewpoint(lookat=(0.0, 0.0, -0.50), distance=2.9, azimuth=308.0, elevation=-14.0), follow=0.2,
        ),
        ThrowFilm(
            "PnTRelease-v0", "analytic", "one throw: plan blue, flight orange", "waste", throws=3, slow=2.0, seed=8,
            camera=Viewpoint(lookat=(0.0, 0.20, -0.76), distance=1.15, azimuth=200.0, elevation=-9.0), follow=0.6,
        ),
        ThrowFilm(
            "OneJointThrow-v0", "virtual_goal", "one joint: virtual goal", "paper", throws=2, slow=3.0, follow=0.3,
        ),
        ThrowFilm(
            "OneJointSort-v0", "virtual_goal", "three pallets: virtual goal", "nominal", throws=3, slow=2.0,
            camera=Viewpoint(lookat=(0.0, 0.0, 0.06), distance=1.5, azimuth=62.0, elevation=-16.0), follow=0.25,
        ),
        ThrowFilm(
            "OneJointAssembly-v0", "virtual_goal", "thrown together: virtual goal", "nominal", throws=2, slow=2.0,
            camera=Viewpoint(lookat=(0.10, 0.0, 0.02), distance=0.95, azimuth=112.0, elevation=-12.0), follow=0.5,
        ),
        ThrowFilm(
            "GripperToss-v0", "virtual_goal", "claws in the platform", "nominal", throws=3, slow=2.0, seed=3,
            camera=Viewpoint(lookat=(0.07, 0.0, -0.30), distance=0.60), follow=0.35,
        ),
        ThrowFilm(
            "PnTGrasp-v0", "local_mlp", "see, grasp, throw", "grasp", throws=3, slow=1.5,
            camera=Viewpoint(lookat=(-0.10, -0.12, -0.84), distance=1.25, azimuth=205.0, elevation=-30.0), follow=0.6,
        ),
    )
}  # fmt: skip
"""A film of each environment of throws, each with a view of its own."""


def main() -> None:
    """Film all environments, or those that are named, and draw places to grasp."""
    for name in sys.argv[1:] or (HERO, *FILMS, LINE[0], PLACES):
        if name == PLACES:
            write_text(FOLDER / f"{PLACES}.svg", svg(places.figure()))
            continue
        path = FOLDER / f"{name}.webp"
        size = films.save(list(pictures(name)), path, moves=name in FILMS)
        print(f"{path.relative_to(ROOT)}: {size / 1000:.0f} KB", flush=True)
        if name == LINE[0]:
            who_took_what()
            plans_of_the_plant()


def pictures(name: str) -> Iterator[Any]:
    """Pictures of a film by name."""
    if name == HERO:
        check_typical()
        return films.side_by_side(PAIR)
    if name == LINE[0]:
        return films.line(LINE[2], "three robots, one belt", LINE[1], LINE[3])
    return chain.from_iterable(films.throw_pictures(FILMS[name]))


def check_typical() -> None:
    """Make sure that in the film of the pair each sorts as many objects as `SEEDS` seeds show on average, rounded."""
    for film in PAIR:
        counts = [sorted_objects(film, seed) for seed in range(SEEDS)]
        mean, shown = sum(counts) / SEEDS, counts[film.seed]
        print(f"{film.title}: {mean:.2f} of {film.throws} sorted, mean of {SEEDS} seeds; {shown} shown", flush=True)
        if shown != round(mean):
            raise ValueError(f"the film shows {shown} sorted objects of {film.title}; typical are {mean:.2f}")


def sorted_objects(film: ThrowFilm, seed: int) -> int:
    """Number of objects that a film's controller sorts in its throws with a seed."""
    with closing(open_trial(film.env, film.level, 1, 1)) as trial:
        actor = trial.controller(film.controller)
        actor.reset(seed)
        return sum(int(throw.sorted[0]) for throw in islice(trial.steps(actor, seed), film.throws))


def who_took_what() -> None:
    """The same line's first minute as bars."""
    env_id, level, name, _ = LINE
    with closing(open_trial(env_id, level, 1, 1)) as trial:
        drawing = trial.run(trial.controller(name), 1, 0).picture()
    write_text(FOLDER / "line_gantt.svg", str(drawing))


def plans_of_the_plant() -> None:
    """Plans of the plant on the page on plans, at two limits of its robots."""
    text = re.search(r'^```yaml title="plant.yaml"\n(.*?)^```$', (ROOT / "docs" / "plan.md").read_text(), re.M | re.S)
    assert text is not None
    with TemporaryDirectory() as folder:
        level, drawing = Path(folder) / "plant.yaml", Path(folder) / "plans.svg"
        write_text(level, text[1])
        plan.main(
            plan.Arguments(str(level), robots=(2, 3, 4), percents=(30.0, 60.0), picture=drawing, tables=Path(folder))
        )
        write_text(FOLDER / "line_plan.svg", drawing.read_text())


if __name__ == "__main__":
    main()
