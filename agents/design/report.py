"""A report of two pages on a design, as HTML, and as PDF where a Chromium is installed."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import tempfile
from datetime import date
from html import escape
from pathlib import Path
from typing import Final

from ..ground.cli import UsageError
from ..ground.versions import versions
from ..line.plan_picture import line_picture
from ..line.reasons import ENDED, THROWN
from . import answers, figures
from .answers import LAST, Answer
from .assumptions import assumptions
from .changes import bin_owners
from .session import State

BROWSERS: Final = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
"""Programs that print a page as PDF."""
PATIENCE: Final = 60.0
"""Time in which such a program is done [s]."""
STYLE: Final = """
@page{size:A4;margin:16mm}
body{font:13px/1.45 system-ui,sans-serif;color:#1d2733;max-width:178mm;margin:8mm auto;padding:0 4mm}
h1{font-size:22px;margin:0 0 2px}h2{font-size:15px;margin:16px 0 6px}
svg{width:100%;height:auto}
table{border-collapse:collapse;width:100%}td,th{border-bottom:1px solid #d9dee4;padding:3px 8px;text-align:left}
td.n,th.n{text-align:right}
.second{break-before:page}small{color:#66707c}li{margin:2px 0}
"""


def html(state: State) -> str:
    """The report on the design of a state, which must have an answer.

    Raises:
        UsageError: the design has no settled answer yet.
    """
    answer = state.answer
    if answer is None or not answer.is_settled or not state.is_current:
        raise UsageError("the figures are not settled yet; ask for the report in a second")
    name, line = escape(answer.line.name), answer.line
    over = state.over_saved
    gain = "" if over is None else f"<p>Against the design that was kept: {escape(answers.in_points(over))}.</p>"
    reason = escape(figures.sentence(state.reason))
    how = (
        f"{LAST.shifts} shifts of {line.duration / 60.0:g} min, seed {LAST.seed}, order of picks by "
        f"{LAST.controller!r}; intervals hold 95 % of what other shifts and other counts of throws would give."
    )
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in assumptions(line))
    packages = ", ".join(f"{package} {version}" for package, version in versions().items())
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{name}: a sorting line</title>'
        f"<style>{STYLE}{figures.STYLE}</style></head><body>"
        f"<h1>{name}</h1><small>a sorting line that throws, {date.today().isoformat()}</small>{line_picture(line)}"
        f'<h2>What it sorts</h2><div class="pg">{figures.top(answer)}</div>{gain}'
        f"<p>{reason}.</p><p><small>{how}</small></p>"
        f'<h2 class="second">The line</h2>{_settings(answer)}<h2>What became of each item</h2>{_items(answer)}'
        f"<h2>What these figures assume</h2><ul>{items}</ul><h2>Versions</h2><small>{escape(packages)}</small>"
        "</body></html>"
    )


def _settings(answer: Answer) -> str:
    """Robots, belt and bins of a design, as a table."""
    line, rows = answer.line, list[tuple[str, str]]()
    for robot, sheet in zip(line.robots, line.sheets(), strict=True):
        skills = ", ".join(robot.skills) or "all items that its bins take"
        rows.append((f"robot {robot.name}", f"{sheet.name} at x {robot.x:g} m; takes {skills}"))
    percents = ", ".join(f"{percent:g}" for percent in line.cell.limits.percent)
    rows.append(("speed limits", f"{percents} % of the robots' own"))
    rows.append(("belt", f"{line.cell.belt.speed:g} m/s; {60.0 * line.arrivals.rate:.0f} objects a minute"))
    for owner in bin_owners(line):
        robot = line.robots[owner]
        whose = robot.name if robot.bins else "each robot without bins of its own"
        for bin_ in robot.bins or line.cell.bins.fixed:
            size = " x ".join(f"{1000.0 * side:.0f}" for side in bin_.size)
            takes = ", ".join(bin_.accepts) or "every item"
            rows.append((f"bin {bin_.name}", f"x {bin_.x:g} m, y {bin_.y:g} m from {whose}; {size} mm; for {takes}"))
    for down in line.down:
        rows.append(("standstill", f"robot {down.robot} from {down.start:g} s to {down.end:g} s"))
    cells = "".join(f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>" for name, text in rows)
    return f"<table>{cells}</table>"


def _items(answer: Answer) -> str:
    """Shares and fates of the items, as a table."""
    line, row = answer.line, answer.row
    body = list[str]()
    for item, share in zip(line.cell.items, 100.0 * line.cell.shares(), strict=True):
        fates = row["fates_by_item"][item]
        thrown = sum(fates[name] for name in THROWN)
        passed = sum(fates[name] for name in ENDED)
        numbers = (share, 100.0 * fates["sorted"], 100.0 * thrown, 100.0 * passed)
        columns = "".join(f'<td class="n">{number:.1f} %</td>' for number in numbers)
        body.append(f"<tr><td>{escape(item)}</td>{columns}</tr>")
    names = ("share of the objects", "sorted", "thrown in vain", "passed the end")
    head = "".join(f'<th class="n">{name}</th>' for name in names)
    return f"<table><tr><th>item</th>{head}</tr>{''.join(body)}</table>"


def browser() -> str | None:
    """The program that prints PDF files; None where there is none."""
    return next((path for name in BROWSERS if (path := shutil.which(name)) is not None), None)


def pdf(page: str) -> bytes:
    """A page as PDF.

    Raises:
        UsageError: there is no Chromium, or the Chromium prints nothing.
    """
    program = browser()
    if program is None:
        raise UsageError("a PDF needs Chromium or Chrome, which is not installed; print the HTML report instead")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "report.html", Path(folder) / "report.pdf"
        source.write_text(page, encoding="utf-8")
        # Chromium has no sandbox for the user root.
        rooted = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        options = ["--headless", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={folder}/profile"]
        command = [program, *options, *rooted, f"--print-to-pdf={target}", source.as_uri()]
        with contextlib.suppress(subprocess.TimeoutExpired):
            subprocess.run(command, check=False, capture_output=True, timeout=PATIENCE)
        if not target.is_file():
            raise UsageError(
                f"{Path(program).name} printed no PDF within {PATIENCE:g} s; print the HTML report instead"
            )
        return target.read_bytes()
