"""A throw from the side, to scale: what the planner plans, what happens, and what moves the landing, in millimetres."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from typing import Any, Final, NamedTuple

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import pnt_gym  # noqa: F401 - registers the environments
from agents.ground.places import SHIPPED as ROOT

TINY: Final = ROOT / "examples" / "09_tiny_throw.py"
LEVEL: Final = {"base": "waste_plain", "fidelity": "flight", "cup": {"stiffness": 1.0, "peel": True, "fitted": True}}
"""The cell whose hand stands still at the pick, with the soft lip of the level `waste`."""
SEED: Final = 58
"""Of a throw of a crushed can in which every effect is to be seen; most swing less."""
WIDTH: Final = 860
HEIGHT: Final = 545
PICK: Final = (80.0, 285.0)
"""Place of the pick in the drawing; a pixel is a millimetre."""
LADDER: Final = 425
"""Height of the first arrow in the drawing."""
STEP: Final = 24
RELEASE: Final = '<tspan dy="4" font-size="10">r</tspan><tspan dy="-4">&#8203;</tspan>'
"""A subscript of the release."""
PLAN, FLIGHT, GREY, DARK = "#0b5cad", "#c2410c", "#64748b", "#1e293b"
VELOCITY: Final = 0.05
"""Time whose way is the length of an arrow of a velocity [s]."""


class SideView(NamedTuple):
    """One throw, and where it would land with one effect more each time."""

    thing: Any
    thrown: Any
    limits: Any
    reach: float
    """From pick to target [m]."""
    rise: float
    """Of the target above the pick [m]."""
    opening: float
    """Of the bin, along the throw [m]."""
    item: str
    shifts: dict[str, float]
    """Shift of the landing along the throw by each effect, after those before it [m]."""


@cache
def tiny() -> Any:
    """The module of the example."""
    spec = importlib.util.spec_from_file_location("tiny_throw", TINY)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@cache
def side_view() -> SideView:
    """The throw of the drawing: all but the swing by the example, and the swing by the suite."""
    env: Any = gym.make("PnTRelease-v0", level=LEVEL).unwrapped
    env.reset(seed=SEED)
    core, context = env.core, env.core.cell.context
    thing, *place = tiny().coming(core)
    held = thing._replace(spin=np.zeros(3))
    at_once, thrown = held._replace(delay=0.0), tiny().throw(held, *place)
    landings = {
        "height and grasp": tiny().throw(at_once, *place, share=0.0).landing,
        "late release": tiny().throw(held, *place, share=0.0).landing,
        "air": thrown.landing,
        "swing and spin": core.preview(np.zeros((1, 2)), jitter=True).landing[0],
    }
    along = [float((landing - place[1][:2]) @ context.direction[0]) for landing in landings.values()]
    shifts = dict(zip(landings, np.diff([0.0, *along]).tolist(), strict=True))
    name, opening = core.cell.item_names[int(context.kind[0])], float(context.opening[0, 0])
    rise = float(place[1][2] - place[0][2])
    return SideView(thing, thrown, place[2], float(context.distance[0]), rise, opening, name, shifts)


def drawing() -> str:
    """The throw from the side, as SVG."""
    view = side_view()
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
        'font-family="sans-serif" font-size="14">',
        "<title>A throw from the side</title>",
        "<defs>",
        *(_tip(name, colour) for name, colour in (("plan", PLAN), ("flight", FLIGHT), ("dark", DARK))),
        "</defs>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
        *_cell(view),
        *_planned(view),
        *_flown(view),
        *_ladder(view),
    ]
    return "\n".join([*parts, "</svg>", ""])


def _tip(name: str, colour: str) -> str:
    """The tip of an arrow."""
    return (
        f'<marker id="side-{name}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" markerHeight="6" orient="auto">'
        f'<path d="M0 0 8 4 0 8z" fill="{colour}"/></marker>'
    )


def _at(along: float, up: float) -> tuple[float, float]:
    """Place in the drawing of a point relative to the pick [m]."""
    return PICK[0] + 1000.0 * along, PICK[1] - 1000.0 * up


def _path(points: list[tuple[float, float]], colour: str, style: str) -> str:
    """A line through points relative to the pick [m]."""
    way = "L".join(f"{x:.1f} {y:.1f}" for x, y in (_at(*point) for point in points))
    return f'<path d="M{way}" fill="none" stroke="{colour}" {style}/>'


def _text(x: float, y: float, words: str, colour: str = DARK, anchor: str = "start") -> str:
    return f'<text x="{x:.0f}" y="{y:.0f}" fill="{colour}" text-anchor="{anchor}">{words}</text>'


def _cell(view: SideView) -> list[str]:
    """Belt, object, cup and bin."""
    (x, y), length, height = PICK, 2000 * view.thing.half[0], 2000 * view.thing.half[2]
    left, rim = _at(view.reach - view.opening / 2.0, view.rise)
    right, deep = left + 1000.0 * view.opening, LADDER - 40.0
    middle, below = _at(view.reach, view.rise)
    return [
        f'<rect x="10" y="{y + height:.1f}" width="165" height="10" fill="#475569"/>',
        f'<rect x="{x - length / 2:.1f}" y="{y:.1f}" width="{length:.1f}" height="{height:.1f}" fill="#fdba74" '
        'stroke="#9a3412"/>',
        f'<path d="M{x - 12:.1f} {y:.1f}l6 -16h12l6 16z" fill="#94a3b8"/>',
        _text(10, y + height + 28, f"belt, object {view.item}", GREY),
        f'<path d="M10 {LADDER}v8h100v-8" fill="none" stroke="{GREY}" stroke-width="2"/>',
        _text(60, LADDER + 26, "100 mm", GREY, "middle"),
        f'<path d="M{left:.1f} {rim:.1f}V{deep}H{right:.1f}V{rim:.1f}" fill="#f1f5f9" stroke="{GREY}" '
        'stroke-width="3"/>',
        _text(right + 8, (rim + deep) / 2, "bin", GREY),
        f'<path d="M{middle:.1f} {below - 8:.1f}v16m-8 -8h16" stroke="{PLAN}" stroke-width="2"/>',
    ]


def _planned(view: SideView) -> list[str]:
    """Line of the hand with release, velocity, angle and window, and the planned flight."""
    plan, seconds = view.thrown.plan, tiny().WINDOW
    across, up = float(np.cos(plan.angle)), float(np.sin(plan.angle))
    (x, y), (end_x, end_y) = (
        _at(way * across, way * up) for way in (plan.distance, plan.distance + plan.speed * seconds)
    )
    stop, _ = tiny().hand(9.0, plan, view.limits)
    tip = plan.distance + VELOCITY * plan.speed
    flight = (view.reach - plan.distance * across) / (plan.speed * across)
    times: NDArray[np.float64] = np.linspace(0.0, flight, 60)
    arc = [
        (plan.distance * across + plan.speed * across * t, plan.distance * up + plan.speed * up * t - 9.81 * t * t / 2)
        for t in times.tolist()
    ]
    bend = [(0.06 * float(np.cos(a)), 0.06 * float(np.sin(a))) for a in np.linspace(0.0, plan.angle, 12)]
    return [
        _path([(0.0, 0.0), (0.13, 0.0)], GREY, 'stroke-dasharray="3 3"'),
        _path(bend, DARK, ""),
        _text(PICK[0] + 68, PICK[1] - 16, f"θ = {np.degrees(plan.angle):.0f}°"),
        _path([(0.0, 0.0), (stop * across, stop * up)], GREY, 'stroke-dasharray="2 4" stroke-width="2"'),
        _path([(0.0, 0.0), (plan.distance * across, plan.distance * up)], PLAN, 'stroke-width="4"'),
        f'<path d="M{x:.1f} {y:.1f}L{end_x:.1f} {end_y:.1f}" stroke="#93c5fd" stroke-width="4"/>',
        _path(arc, PLAN, 'stroke-width="2" stroke-dasharray="7 5"'),
        _path(
            [(plan.distance * across, plan.distance * up), (tip * across, tip * up)],
            PLAN,
            'stroke-width="2" marker-end="url(#side-plan)"',
        ),
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{PLAN}"/>',
        _text(x - 12, y - 4, f"P{RELEASE} = {1000 * plan.distance:.0f} mm", PLAN, "end"),
        _text(x - 12, y - 22, f"V{RELEASE} = {plan.speed:.2f} m/s", PLAN, "end"),
        _text(end_x - 16, end_y - 6, f"window: {1000 * seconds:.0f} ms at V{RELEASE}, then the stop", GREY, "end"),
        _text(*_at(view.reach * 0.75, 0.06), "planned", PLAN, "end"),
    ]


def _flown(view: SideView) -> list[str]:
    """Late release, and the flight of the example."""
    plan, flight = view.thrown.plan, view.thrown.flight
    ahead = plan.ahead[:2] / np.linalg.norm(plan.ahead[:2])
    way, _ = tiny().hand(plan.time + view.thing.delay, plan, view.limits)
    late_x, late_y = _at(way * np.cos(plan.angle), way * np.sin(plan.angle))
    hanging = view.thing.hanging
    begin = way * np.cos(plan.angle) + hanging[:2] @ ahead, way * np.sin(plan.angle) + hanging[2]
    moved = flight - flight[0]
    points = [(float(begin[0] + m[:2] @ ahead), float(begin[1] + m[2])) for m in moved[::4]]
    landed = sum(view.shifts.values())
    x, y = _at(view.reach + landed, view.rise)
    return [
        _path(points, FLIGHT, 'stroke-width="2.5"'),
        f'<circle cx="{late_x:.1f}" cy="{late_y:.1f}" r="5" fill="{FLIGHT}"/>',
        _text(late_x + 14, late_y + 28, f"let go {1000 * view.thing.delay:.0f} ms late", FLIGHT),
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{FLIGHT}"/>',
        _text(*_at(view.reach * 0.9, 0.16), "flown, but for the swing", FLIGHT),
    ]


def _ladder(view: SideView) -> list[str]:
    """An arrow for each effect on the landing, one below the other, each from where the last one ends."""
    place, parts = view.reach, list[str]()
    bottom = LADDER + STEP * len(view.shifts)
    for along, colour in ((view.reach, PLAN), (view.reach + sum(view.shifts.values()), FLIGHT)):
        parts.append(
            _path([(along, view.rise), (along, (PICK[1] - bottom) / 1000.0)], colour, 'stroke-dasharray="2 3"')
        )
    rows = [*((name, place, shift) for name, shift in view.shifts.items())]
    for number, (name, _, shift) in enumerate(rows):
        parts += _arrow(name, place, shift, LADDER + STEP * number, "dark")
        place += shift
    return [*parts, *_arrow("together", view.reach, place - view.reach, bottom, "flight")]


def _arrow(name: str, start: float, shift: float, y: float, tip: str) -> list[str]:
    """An arrow at a height of the drawing along the throw, with the name and size of an effect."""
    (x, _), (end, _), colour = _at(start, 0.0), _at(start + shift, 0.0), FLIGHT if tip == "flight" else DARK
    return [
        f'<path d="M{x:.1f} {y}H{end:.1f}" stroke="{colour}" stroke-width="2.5" marker-end="url(#side-{tip})"/>',
        _text(470, y + 5, name, colour),
        _text(650, y + 5, f"{1000 * shift:+.0f} mm", colour, "end"),
    ]
