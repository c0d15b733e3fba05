"""Films of throws and of lines: a camera that follows the object, captions, and cells beside each other."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from io import BytesIO
from itertools import islice, zip_longest
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from PIL import Image

from pnt_gym.arrays import concatenate_records
from pnt_gym.cells.base.canvas import Picture, Viewpoint
from pnt_gym.cells.line.rows import Fate

from ..ground import metrics
from ..ground.files import replace_file
from ..judging.throws import Throws
from .captions import Caption, inset, write_caption
from .stage import Stage

WIDTH, HEIGHT = 960, 540
"""Size of a film [pixels]."""
RATE: Final = 12
"""Frames per second."""
SAMPLES: Final = 6
"""Drawings of a frame, whose mean it is: no stairs, and soft shadows."""
HOLD: Final = 1.2
"""How long a film stays at its last picture [s]."""
MOST_BYTES: Final = 900_000
QUALITIES: Final = (72, 60, 50, 40, 32, 24, 18, 12)
"""Of WebP; the first one that keeps a film below `MOST_BYTES` is taken."""
LAZY: Final = 0.82
"""Share of its distance to the object that the camera keeps from frame to frame."""
PANEL: Final = 112
"""Side of the small pictures of a grasp [pixels]."""
LATER: Final = 0.20
"""Time after the landing at which the film tells how the throw ended [s]."""


@final
@dataclass(frozen=True)
class ThrowFilm:
    """What to show of an environment of throws.

    Attributes:
        env: id of the environment.
        controller: by name; it practises first if it learns.
        title: who that is, for people.
        level: of the cell; None for that of the controller's training.
        throws: how many.
        slow: how many times slower than in truth.
        seed: names the objects.
        camera: changes of the cell's standard view.
        follow: share of the object's way that the camera follows.
    """

    env: str
    controller: str
    title: str
    level: str | None
    throws: int
    slow: float
    seed: int = 0
    camera: Viewpoint = field(default_factory=Viewpoint)
    follow: float = 0.0


def throw_pictures(film: ThrowFilm, width: int = WIDTH) -> Iterator[list[Any]]:
    """Pictures of each throw of a film."""
    with closing(Stage(film.controller, film.env, film.level, film.seed)) as stage:
        stage.view.aim(Picture(width=width, height=HEIGHT, camera=film.camera), SAMPLES)
        done, centre = list[Throws](), np.array(stage.view.camera.lookat)
        seen = centre.copy()
        for throw in islice(stage.steps, film.throws):
            before = _rate(done)
            done.append(throw)
            landed, pictures = _landing(stage.view), list[Any]()
            fps = round(RATE * film.slow)
            count = sum(1 for _ in stage.view.recording.play(1.0 / fps))
            for number, scene in enumerate(stage.view.scenes(fps)):
                place = np.array(scene[1].xpos[stage.view.recording.body])
                seen = LAZY * seen + (1.0 - LAZY) * (centre + film.follow * (place - centre))
                stage.view.camera.lookat[:] = seen
                over = number >= min(round(fps * (landed + LATER)), count - 3)
                caption = _caption(film, stage, throw, _rate(done) if over else before, over=over)
                pictures.append(_with_grasp(stage, write_caption(stage.view.draw(scene), caption)))
            yield pictures


def side_by_side(films: Sequence[ThrowFilm]) -> Iterator[Any]:
    """Pictures of films of the same throws beside each other; each throw begins in all of them at the same time."""
    wide = WIDTH // len(films)
    for throws in zip(*(throw_pictures(film, wide) for film in films), strict=True):
        last = [pictures[-1] for pictures in throws]
        for moment in zip_longest(*throws):
            picture = Image.new("RGB", (WIDTH, HEIGHT), "white")
            for number, (panel, end) in enumerate(zip(moment, last, strict=True)):
                picture.paste(end if panel is None else panel, (number * wide + (number > 0), 0))
            yield picture


def line(controller: str, title: str, level: str, seconds: float) -> Iterator[Any]:
    """Pictures of a line from the beginning of a shift on, every throw simulated."""
    with closing(Stage(controller, "PnTLine-v0", level, 0, throws="full")) as stage:
        stage.view.aim(Picture(width=WIDTH, height=HEIGHT), SAMPLES)
        for clock in stage.steps:
            for scene in stage.view.scenes(RATE):
                count, time = _sorted_until(stage, float(scene[1].time)), float(scene[1].time)
                rate = (f"{60.0 * count / time:.0f}" if time > 1.0 else "-", "sorted/min")
                yield write_caption(
                    stage.view.draw(scene), Caption(title, f"{count} sorted in {time:.1f} s", rate=rate)
                )
            if clock >= seconds:
                return


def save(pictures: Sequence[Any], path: Path, *, moves: bool) -> int:
    """Write a film that runs for ever, and stays at its last picture for `HOLD`; returns its size in bytes.

    Where the camera moves, every picture is stored whole if they fit so: of differences to the one before, WebP keeps
    blocks.

    Args:
        pictures: of one size.
        path: the .webp file.
        moves: whether the camera moves.

    Raises:
        ValueError: it is too large at any quality.
    """
    durations = [round(1000 / RATE)] * (len(pictures) - 1) + [round(1000 * HOLD)]
    written: dict[int, bytes] = {}
    for keys in ({"kmin": 0, "kmax": 1}, {"kmin": 999, "kmax": 1000})[not moves :]:

        def fits(quality: int, keys: dict[str, int] = keys) -> bool:
            film, options = BytesIO(), {"quality": quality, "method": 4, "duration": durations, "loop": 0, **keys}
            pictures[0].save(film, "WEBP", save_all=True, append_images=pictures[1:], **options)
            written[quality] = film.getvalue()
            return film.tell() <= MOST_BYTES

        best = bisect_left(QUALITIES, True, key=fits)
        if best < len(QUALITIES):
            replace_file(path, partial(Path.write_bytes, data=written[QUALITIES[best]]))
            return len(written[QUALITIES[best]])
    raise ValueError(f"{path.name} is larger than {MOST_BYTES} bytes; film fewer throws")


def _rate(throws: Sequence[Throws]) -> float | None:
    """Sorted objects per minute of all throws so far; None before the first."""
    if not throws:
        return None
    every = concatenate_records(list(throws))
    return metrics.throughput(every.sorted, every.cycle_time).sorted


def _caption(film: ThrowFilm, stage: Stage, throw: Throws, rate: float | None, *, over: bool) -> Caption:
    item = stage.core.item_names[throw.item[0]].replace("_", " ")
    is_good, result = bool(throw.sorted[0]), ""
    if over and not throw.picked[0]:
        result = "not picked"
    elif over:
        off = f"{1000.0 * throw.landing_error[0]:.0f} mm off, " if np.isfinite(throw.landing_error[0]) else ""
        result = f"{off}{'sorted' if is_good else 'missed'}"
    return Caption(film.title, item, result, is_good, ("-" if rate is None else f"{rate:.0f}", "sorted/min"))


def _landing(view: Any) -> float:
    """Time of the last throw at which its object is nearest to its target [s]."""
    recording, interval = view.recording, 0.01
    *_, (_, trail) = recording.play(interval)
    return interval * float(np.linalg.norm(trail - recording.target, axis=1).argmin())


def _with_grasp(stage: Stage, picture: Any) -> Any:
    """The picture with what a controller sees that grasps."""
    if stage.seen is not None and stage.seen.grasp is not None:
        panels = stage.seen.grasp.panels(PANEL)
        inset(picture, panels, ("camera", "heights", "worth")[: len(panels)])
    return picture


def _sorted_until(stage: Stage, time: float) -> int:
    """Number of objects of a line that lie sorted in their bins at a time [s]."""
    fates = stage.core.cell.state.accounts["fate"][0]
    tracks = [(cycle.number, cycle.object_track) for cycle in stage.core.cell.acts.cycles]
    ended = [number for number, track in tracks if track is not None and track.time[-1] <= time]
    return sum(int(fates[number]) == Fate.SORTED for number in ended)
