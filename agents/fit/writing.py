"""The fitted level as a YAML file, and a page with predicted and measured landings."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import Item
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.drift import CameraOffset, Encoder, Valve
from pnt_gym.reading import yaml_text

from ..ground.tables import Grid, html_text
from .fitted import Fitted
from .words import sentences, tables

WIDE: Final = 640
"""Width of the picture [px]."""
FRAME: Final = 30
"""Margin of the picture [px]."""
STYLE: Final = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:1rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;display:block;overflow-x:auto}td,th{padding:.2rem .7rem;text-align:right;"
    "border-bottom:1px solid #ddd}.left{text-align:left}figure{margin:0}svg{width:100%;max-width:640px;height:auto}"
    ".wrong{color:#b00;font-weight:700}"
)


def differences(fitted: Fitted) -> dict[str, Any]:
    """Sections of the fitted level that differ from the level from which the fit began, in JSON types."""
    level, names = fitted.level, fitted.posterior.values.keys()
    bias = level.bias
    values: dict[str, Any] = {
        "suction": {"valve": _round(level.suction.valve), "tau": _round(level.suction.tau)},
        "cup": {key: _round(getattr(level.cup, key)) for key in ("stiffness", "blow_off") if key in names},
        "bias": {
            "camera": [_within(place, CameraOffset.bound) for place in bias.camera],
            "encoder": _within(bias.encoder, Encoder.bound),
            "drag": _within(bias.drag, 0.9),
            "delay": _within(bias.delay, Valve.bound),
        },
        "extra_items": [_item(item, fitted.config) for item in level.extra_items],
    }
    return {section: value for section, value in values.items() if value}


def _item(item: Item, config: ConveyorConfig) -> dict[str, Any]:
    """An item of the fitted level: as in the catalogue but for its chance to be sealed, or all keys of a user's own."""
    if item.name in {own.name for own in config.extra_items}:
        return item.model_dump(mode="json")
    return {"name": item.name, "like": item.name, "pick_chance": _round(item.pick_chance)}


def text(fitted: Fitted, samples: Floats, base: str, place: Path, source: str) -> str:
    """Text of a level with the fitted values, each with its interval in a comment.

    Args:
        fitted: the fit.
        samples: of its posterior (S, P).
        base: name or file of the level from which the fit began; empty for a line's cell, whose level is written whole.
        place: file of the new level.
        source: command that made it.
    """
    # A level's file names the file of its base relative to itself.
    base = os.path.relpath(base, place.parent) if Path(base).suffix else base
    estimates, count = fitted.estimates(samples), int(fitted.log.has_landing.sum())
    lines = [
        f"{source}: {count} landings of {len(fitted.log)} throws; 95 % intervals in brackets.",
        *sentences(fitted, samples),
        *(f"{part.label}: {part.text}" for part in estimates.values()),
        *(f"{s.item} sealed in {s.sealed} of {s.tries} picks: {s.mean:.2f} ({s.low:.2f}..{s.high:.2f})"
          for s in fitted.seals),
    ]  # fmt: skip
    data: dict[str, Any] = {"base": base} | differences(fitted)
    if not base:
        whole = fitted.config.model_dump(mode="json", exclude_unset=True, exclude={"name", "fidelity"})
        data = ConveyorConfig.merge(whole, differences(fitted))
    return "".join(f"# {line}\n" for line in lines) + yaml_text({"name": place.stem, **data}, default_flow_style=None)


def _within(value: float, bound: float) -> float:
    """A value within the bounds of a level."""
    return _round(np.clip(value, -bound, bound))


def _round(value: float) -> float:
    """A value with six digits."""
    return float(f"{value:.6g}")


def page(fitted: Fitted, samples: Floats, title: str) -> str:
    """A page of the fit: verdict, picture, tables."""
    *texts, last = sentences(fitted, samples)
    grids: Sequence[Grid] = tables(fitted, samples)
    parts = [
        f"<h1>{escape(title)}</h1>",
        f'<p class="{"" if fitted.fits else "wrong"}">{html_text(last)}</p>',
        picture(fitted),
        *(f"<p>{html_text(sentence)}</p>" for sentence in texts),
        *(f"<h2>{html_text(grid.headline)}</h2>{grid.html()}" for grid in grids),
    ]
    phone = "<meta name='viewport' content='width=device-width'>"
    head = f"<!doctype html><html lang='en'><head><meta charset='utf-8'>{phone}<title>{escape(title)}</title>"
    return f"{head}<style>{STYLE}</style></head><body>{''.join(parts)}</body></html>\n"


def picture(fitted: Fitted) -> str:
    """Measured and predicted landings from above, from the target, or from the landing where no target is logged."""
    density, mode = fitted.posterior.density, fitted.posterior.best
    rows = density.has_landing
    origin = np.where(np.isfinite(fitted.log.target), fitted.log.target, fitted.log.landing)[rows]
    measured = 1e3 * (fitted.log.landing[rows] - origin)
    predicted = 1e3 * (density.landings(mode.z, mode.scatter)[rows] - origin)
    largest = max(float(np.abs(np.concatenate([measured, predicted])).max()), 10.0)
    scale = (WIDE / 2 - FRAME) / largest

    def at(point: Floats) -> tuple[float, float]:
        return WIDE / 2 + scale * point[0], WIDE / 2 - scale * point[1]

    marks: list[str] = []
    for landing, model in zip(measured, predicted, strict=True):
        (x, y), (u, v) = at(landing), at(model)
        marks.append(f'<path d="M{x:.1f} {y:.1f}L{u:.1f} {v:.1f}" stroke="#bbb"/>')
        marks.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="#4c72b0"/>')
        marks.append(f'<path d="M{u - 4:.1f} {v:.1f}h8M{u:.1f} {v - 4:.1f}v8" stroke="#dd8452" stroke-width="2"/>')
    middle = WIDE / 2
    cross = f'<path d="M{middle} {FRAME}V{WIDE - FRAME}M{FRAME} {middle}H{WIDE - FRAME}" stroke="#ddd"/>'
    words = (
        f"Landings from above, relative to their targets; the belt runs to the right, and the lines reach "
        f"{largest:.0f} mm to each side. Dots are measured, crosses are predicted by the fit."
    )
    drawing = f'<svg viewBox="0 0 {WIDE} {WIDE}" role="img">{cross}{"".join(marks)}</svg>'
    return f"<figure>{drawing}<figcaption>{words}</figcaption></figure>"
