"""The panel of the page: figures, inputs and buttons, which follow the design."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final, final

import viser

from pnt_gym.cells.conveyor.robot import sheet_names
from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig

from . import changes, figures
from .answers import in_points
from .changes import Change
from .session import Session, State, Tried

QUIET: Final = 0.6
"""Time for which an input that an engineer moves is left alone [s]."""
OFFERS: Final = 4
"""Changes that are offered at once."""
VIEWS: Final = ("3D", "from above", "play 12 s")
"""Views of the line, the last one a film."""
STEPS: Final = ("undo", "redo", "keep")
"""Steps among designs."""
PLACES: Final = ("bins", "robots", "all", "stop")
"""What a search places, and its end."""
PLACES_HINT: Final = (
    "a search of some minutes, whose find is judged in the full physics; the design stays if that disagrees"
)
NOBODY: Final = "nobody"
Setter = Callable[[Any], Change]
Getter = Callable[[LineConfig], Any]


@final
class Panel:
    """Inputs of a design.

    Args:
        server: viser's server.
        session: the session that the inputs change.
    """

    def __init__(self, server: viser.ViserServer, session: Session) -> None:
        self._gui, self._session = server.gui, session
        self._inputs = list[tuple[Any, Getter]]()
        self._lists = list[Any]()
        self._touched = dict[int, float]()
        self._offers = list[Any]()
        self._structure: Any = None
        self._tried: tuple[Tried, ...] | None = None
        self._figures = self._gui.add_html("")
        self.views = self._gui.add_button_group("view", VIEWS)
        self.steps = self._gui.add_button_group("design", STEPS, hint="keep: compare with this design from now on")
        tabs = self._gui.add_tab_group()
        self._line, self._robots = tabs.add_tab("Line"), tabs.add_tab("Robots")
        self._bins, self._objects = tabs.add_tab("Bins"), tabs.add_tab("Objects")
        self.files = tabs.add_tab("File")
        self._worth = self._gui.add_folder("What keeps it from sorting more")
        with self._worth:
            self._reason = self._gui.add_html("")
            self.places = self._gui.add_button_group("better places", PLACES, hint=PLACES_HINT)
        with self._line:
            self._add_line()

    def show(self, state: State) -> None:
        """Show a state; inputs that the engineer is moving are left alone, unless their change was refused."""
        for html, text in ((self._figures, figures.panel(state)), (self._reason, figures.reason(state))):
            if html.content != text:
                html.content = text
        if tuple(state.offers[:OFFERS]) != self._tried:
            self._offer(tuple(state.offers[:OFFERS]))
        self._rebuild(state.line)
        now = time.monotonic()
        for handle, get in self._inputs:
            if state.refusal or now - self._touched.get(id(handle), -QUIET) >= QUIET:
                handle.value = get(state.line)

    def _input(self, handle: Any, get: Getter, change: Setter) -> Any:
        """Let an input follow the design, and change the design."""
        self._inputs.append((handle, get))

        def moved(event: Any) -> None:
            if event.client is not None:  # else the page itself has set the value
                self._touched[id(handle)] = time.monotonic()
                self._session.change(change(handle.value))

        handle.on_update(moved)
        return handle

    def _add_line(self) -> None:
        """Add the inputs of the whole line."""
        gui, line = self._gui, self._session.state.line
        number = gui.add_slider("robots", 1, MOST_ROBOTS, 1, len(line.robots))
        self._input(number, lambda line: len(line.robots), lambda value: partial(changes.set_robots, count=int(value)))
        belt = gui.add_slider("belt [m/s]", 0.05, 1.5, 0.01, line.cell.belt.speed)
        self._input(belt, lambda line: line.cell.belt.speed, _set(changes.set_belt_speed, "speed"))
        rate = gui.add_slider("infeed [objects/min]", 5.0, 480.0, 1.0, _rate(line))
        self._input(rate, _rate, _set(changes.set_rate, "per_minute"))
        limits = gui.add_slider(
            "speed limits [%]",
            5.0,
            100.0,
            1.0,
            max(line.cell.limits.percent),
            hint="share of each robot's limits of speed, acceleration and jerk",
        )
        self._input(limits, lambda line: max(line.cell.limits.percent), _set(changes.set_limits, "percent"))

    def _rebuild(self, line: LineConfig) -> None:
        """Add the inputs of robots, bins and items anew, where there are others."""
        owners = [
            (owner, [bin_["name"] for bin_ in changes.fixed_bins(line, owner)]) for owner in changes.bin_owners(line)
        ]
        structure = [robot.name for robot in line.robots], owners, line.cell.items
        if structure == self._structure:
            return
        self._structure = structure
        gone = {id(part) for part in self._lists}
        self._inputs = [(handle, get) for handle, get in self._inputs if id(handle) not in gone]
        for part in self._lists:
            part.remove()
        self._lists.clear()
        with self._robots:
            self._add_robots(line)
        with self._bins:
            self._add_bins(line)
        with self._objects:
            self._add_objects(line)

    def _list_input(self, handle: Any, get: Getter, change: Setter) -> None:
        self._lists.append(self._input(handle, get, change))

    def _add_robots(self, line: LineConfig) -> None:
        gui, names = self._gui, sheet_names()
        for index, robot in enumerate(line.robots):
            known = (*names, *({sheet.name for sheet in line.sheets()} - set(names)))
            sheet = gui.add_dropdown(robot.name, known, initial_value=line.sheets()[index].name)
            self._list_input(sheet, lambda line, index=index: line.sheets()[index].name, partial(_choose, index))
            place = gui.add_number("along the belt [m]", robot.x, step=0.05)
            self._list_input(
                place, lambda line, index=index: line.robots[index].x, _set(changes.move_robot, "x", robot=index)
            )
        down = gui.add_dropdown("stands still", (NOBODY, *(robot.name for robot in line.robots)), initial_value=NOBODY)
        length = gui.add_slider("for [s], from the middle", 0.0, 60.0, 5.0, 30.0)
        self._lists.append(length)
        self._list_input(down, _standing, lambda name: _stand_still(name, length.value))

        def moved(event: Any) -> None:
            if event.client is not None and down.value != NOBODY:
                self._session.change(_stand_still(down.value, length.value))

        length.on_update(moved)

    def _add_bins(self, line: LineConfig) -> None:
        hint = "middle of the opening along and across the belt, from the robot [m]"
        for owner in changes.bin_owners(line):
            for number, bin_ in enumerate(changes.fixed_bins(line, owner)):
                own = f"{line.robots[owner].name}: " if line.robots[owner].bins else ""
                place = self._gui.add_vector2(f"{own}{bin_['name']}", (bin_["x"], bin_["y"]), step=0.01, hint=hint)
                self._list_input(place, partial(_place, owner, number), partial(_move, owner, number))

    def _add_objects(self, line: LineConfig) -> None:
        gui = self._gui
        for item in line.cell.items:
            share = gui.add_slider(f"{item} [%]", 0.0, 99.0, 0.5, _share(item, line), hint="share of the objects")
            self._list_input(share, partial(_share, item), _set(changes.set_share, "percent", item=item))
        for item in line.cell.items:
            value = gui.add_number(f"value of {item}", _value(item, line), min=0.0, step=0.1)
            self._list_input(value, partial(_value, item), _set(changes.set_value, "value", item=item))

    def _offer(self, tried: tuple[Tried, ...]) -> None:
        """Offer changes that were tried, with what they bring."""
        for button in self._offers:
            button.remove()
        self._offers.clear()
        self._tried = tried
        with self._worth:
            for each in tried:
                words, points = each.gain.words, each.gain.points
                button = self._gui.add_button(f"{words}: {100.0 * points.value:+.1f}", hint=in_points(points))
                button.on_click(partial(self._take, each))
                self._offers.append(button)

    def _take(self, tried: Tried, event: Any) -> None:
        """Take a change that was tried."""
        del event
        self._session.change(lambda line: tried.line)


def _set(change: Callable[..., LineConfig], name: str, **of: Any) -> Setter:
    return lambda value: partial(change, **of, **{name: float(value)})


def _rate(line: LineConfig) -> float:
    return round(60.0 * line.arrivals.rate, 3)


def _choose(index: int, name: str) -> Change:
    return partial(changes.choose_sheet, robot=index, name=name)


def _standing(line: LineConfig) -> str:
    place = line.down[0].place([robot.name for robot in line.robots]) if line.down else None
    return NOBODY if place is None else line.robots[place].name


def _stand_still(name: str, seconds: float) -> Change:
    return partial(changes.set_standstill, robot=None if name == NOBODY else name, seconds=float(seconds))


def _place(owner: int, number: int, line: LineConfig) -> tuple[float, float]:
    bin_ = changes.fixed_bins(line, owner)[number]
    return bin_["x"], bin_["y"]


def _move(owner: int, number: int, place: tuple[float, float]) -> Change:
    return partial(changes.move_bin, robot=owner, number=number, x=float(place[0]), y=float(place[1]))


def _share(item: str, line: LineConfig) -> float:
    return round(100.0 * float(line.cell.shares()[line.cell.items.index(item)]), 1)


def _value(item: str, line: LineConfig) -> float:
    return line.value.of.get(item, 1.0)
