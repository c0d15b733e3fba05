"""The fitted level as a YAML file, and a page with predicted and measured landings."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Final

import numpy as np

from pnt_gym.arrays import Floats

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


def text(fitted: Fitted, samples: Floats, base: str, place: Path, source: str) -> str:
    """Text of a level with the fitted values, each with its interval in a comment.

    Args:
        fitted: the fit.
        samples: of its posterior (S, P).
        base: name or file of the level from which the fit began.
        place: file of the new level.
        source: command that made it.
    """
    # A level's file names the file of its base relative to itself.
    base = os.path.relpath(base, place.parent) if Path(base).suffix else base
    level, estimates = fitted.level, fitted.estimates(samples)
    notes = {key: f"  # {part.label}: {part.text}" for key, part in estimates.items()}
    bias = level.bias
    cameras = [part for key, part in estimates.items() if key in ("camera_x", "camera_y")]
    camera = ", ".join(f"{part.label}: {part.text}" for part in cameras)
    count = int(fitted.log.has_landing.sum())
    lines = [
        f"# {source}: {count} landings of {len(fitted.log)} throws; 95 % intervals in brackets.",
        *(f"# {sentence}" for sentence in sentences(fitted, samples)),
        f"name: {place.stem}",
        f"base: {base}",
        "suction:",
        f"  valve: {level.suction.valve:.6g}{notes.get('valve', '')}",
        f"  tau: {level.suction.tau:.6g}{notes.get('tau', '')}",
        *([f"cup: {{stiffness: {level.cup.stiffness:.6g}}}{notes['stiffness']}"] if "stiffness" in estimates else []),
        "bias:",
        f"  camera: [{_within(bias.camera[0], 0.05):.6g}, {_within(bias.camera[1], 0.05):.6g}]  # {camera}",
        f"  encoder: {_within(bias.encoder, 0.05):.6g}{notes.get('encoder', '')}",
        f"  drag: {_within(bias.drag, 0.9):.6g}{notes.get('drag', '')}",
        *([f"  delay: {_within(bias.delay, 0.03):.6g}  # of the valve, below zero"] if bias.delay else []),
        *(f"# {s.item} sealed in {s.sealed} of {s.tries} picks; pick_chance {s.mean:.2f} ({s.low:.2f}..{s.high:.2f})"
          for s in fitted.seals),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _within(value: float, bound: float) -> float:
    """A value within the bounds of a level."""
    return float(np.clip(value, -bound, bound))


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
