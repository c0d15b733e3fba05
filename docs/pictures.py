"""Moving pictures of all environments, for the site and the README: `make pictures`, or `python docs/pictures.py`.

Every film is a few throws of a controller, the planned flight in blue and the flown one in orange; of a line it is the
begin of a shift, every throw simulated.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

ROOT: Final = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from agents.ground.drawings import svg  # noqa: E402
from agents.ground.files import replace_file, write_text  # noqa: E402
from agents.judging.trials import open_trial  # noqa: E402
from agents.line import plan  # noqa: E402
from agents.pictures import places  # noqa: E402
from agents.pictures.stage import Stage  # noqa: E402
from pnt_gym.cells.base.canvas import Picture  # noqa: E402

FOLDER: Final = ROOT / "docs" / "pictures"
SIZE: Final = (480, 270)
"""Width and height of a frame [pixels]; one of another shape keeps it, at this width."""
RATE: Final = 15
"""Frames per second."""
MOST_BYTES: Final = 700_000
QUALITIES: Final = (60, 45, 30, 20)
"""Of WebP; the first one that keeps a film below `MOST_BYTES` is taken."""


@dataclass(frozen=True)
class Film:
    """What to show of an environment.

    Attributes:
        controller: by name; it practises first if it learns.
        level: of the cell.
        throws: how many.
        slow: how many times slower than in truth.
        seed: names the objects.
    """

    controller: str
    level: str
    throws: int
    slow: int
    seed: int = 0


FILMS: Final = {
    "PnTConveyor-v0": Film("oracle", "waste", throws=4, slow=1),
    "PnTAdapt-v0": Film("kalman", "day", throws=4, slow=1),
    "PnTRelease-v0": Film("analytic", "waste", throws=3, slow=1),
    "OneJointThrow-v0": Film("virtual_goal", "paper", throws=2, slow=3),
    "OneJointSort-v0": Film("virtual_goal", "nominal", throws=3, slow=2),
    "OneJointAssembly-v0": Film("virtual_goal", "nominal", throws=2, slow=2),
    "GripperToss-v0": Film("virtual_goal", "nominal", throws=3, slow=3, seed=3),
    "PnTGrasp-v0": Film("centre", "grasp", throws=4, slow=1),
}


LINE: Final = ("PnTLine-v0", "skills3", "price", 6.0)
"""The environment of lines, its level, who decides, and for how many seconds it is filmed, every throw simulated."""
PLACES: Final = "grasp_places"
"""Name of the figure of places to grasp."""


def main() -> None:
    """Film all environments, or those that are named, and draw places to grasp."""
    for env_id in sys.argv[1:] or (*FILMS, LINE[0], PLACES):
        if env_id == PLACES:
            write_text(FOLDER / f"{PLACES}.svg", svg(places.figure()))
            continue
        path = FOLDER / f"{env_id}.webp"
        if env_id == LINE[0]:
            who_took_what()
            plans_of_the_plant()
        size = save(list(line_at_work() if env_id == LINE[0] else frames(env_id, FILMS[env_id])), path)
        print(f"{path.relative_to(ROOT)}: {size / 1000:.0f} KB")


def frames(env_id: str, film: Film) -> Iterator[NDArray[np.uint8]]:
    """Frames (height, width, 3) of a film."""
    with closing(Stage(film.controller, env_id, film.level, film.seed)) as stage:
        for _ in islice(stage.steps, film.throws):
            yield from stage.view.last_throw(RATE * film.slow)


def line_at_work() -> Iterator[NDArray[np.uint8]]:
    """Frames of a line from the beginning of a shift on."""
    env_id, level, name, seconds = LINE
    with closing(Stage(name, env_id, level, 0, throws="full")) as stage:
        stage.view.aim(Picture.of(2 * SIZE[0], 2 * SIZE[1], None))
        for time in stage.steps:
            yield from stage.view.last_throw(RATE)
            if time >= seconds:
                return


def who_took_what() -> None:
    """The same line's first minute as bars."""
    env_id, level, name, _ = LINE
    with closing(open_trial(env_id, level, 1, 1)) as trial:
        drawing = trial.run(trial.controller(name), 1, 0).picture()
    write_text(FOLDER / "line_gantt.svg", str(drawing))


def plans_of_the_plant() -> None:
    """Plans of the plant on the page of levels, at two limits of its robots."""
    text = re.search(r'^```yaml title="plant.yaml"\n(.*?)^```$', (ROOT / "docs" / "levels.md").read_text(), re.M | re.S)
    assert text is not None
    with TemporaryDirectory() as folder:
        level, drawing = Path(folder) / "plant.yaml", Path(folder) / "plans.svg"
        write_text(level, text[1])
        plan.main(
            plan.Arguments(str(level), robots=(2, 3, 4), percents=(30.0, 60.0), picture=drawing, tables=Path(folder))
        )
        write_text(FOLDER / "line_plan.svg", drawing.read_text())


def save(pictures: list[NDArray[np.uint8]], path: Path) -> int:
    """Write a film that runs for ever; returns its size in bytes.

    Raises:
        ValueError: it is too large at any quality.
    """
    wide, high = SIZE[0], round(SIZE[0] * pictures[0].shape[0] / pictures[0].shape[1])
    images = [Image.fromarray(picture).resize((wide, high), Image.Resampling.LANCZOS) for picture in pictures]
    duration = round(1000 / RATE)
    for quality in QUALITIES:
        film = BytesIO()
        images[0].save(
            film, "WEBP", save_all=True, append_images=images[1:], duration=duration, loop=0, quality=quality, method=6
        )
        if film.tell() <= MOST_BYTES:
            replace_file(path, partial(Path.write_bytes, data=film.getvalue()))
            return film.tell()
    raise ValueError(f"{path.name} is larger than {MOST_BYTES} bytes; film fewer throws")


if __name__ == "__main__":
    main()
