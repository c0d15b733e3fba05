"""Figures of an answer as HTML: for the panel of the page, for a shared file and for a report."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from typing import Any, Final, final

from ..judging.losses import FATES, WORDS
from ..line.plan_picture import FATE_COLOURS
from .answers import Answer, in_points
from .session import State

STYLE: Final = """
.pg{font:14px/1.35 system-ui,sans-serif;color:#1d2733;padding:2px 10px 6px}
.pg .top{display:flex;align-items:baseline;gap:8px}
.pg .big{font-size:34px;font-weight:650;letter-spacing:-.5px}
.pg .chip{margin-left:auto;font-size:11px;padding:1px 8px;border-radius:9px;background:#fdf0d5;color:#8a5a00}
.pg .chip.ok{background:#e0f2e6;color:#1c6b3a}
.pg small{color:#66707c;font-size:12px}
.pg .grid{display:grid;grid-template-columns:1fr 1fr;gap:6px 12px;margin:6px 0}
.pg .grid b{font-size:16px;font-weight:600;display:block}
.pg .bar{display:flex;height:12px;border-radius:3px;overflow:hidden;margin:6px 0 4px}
.pg .key{display:flex;flex-wrap:wrap;gap:1px 10px;font-size:11px;color:#4c5560}
.pg .key i{display:inline-block;width:8px;height:8px;border-radius:2px;margin-right:4px}
.pg .gain{margin:6px 0 0;padding:5px 8px;background:#eef2f8;border-radius:4px}
.pg .bad{margin:6px 0 0;padding:5px 8px;background:#fdecea;color:#8c1d18;border-radius:4px}
.pg .why{margin:4px 0 0;font-size:13px}
"""
"""Style of the figures."""


@final
@dataclass(frozen=True)
class Figure:
    """A figure with its unit and its interval."""

    name: str
    value: str
    interval: str


def figures(answer: Answer) -> Iterator[Figure]:
    """The figures of a design, the recovery first."""
    row = answer.row
    yield _figure("recovery", row, "recovery", 100.0, 1, " %")
    yield _figure("purity", row, "purity", 100.0, 1, " %")
    yield _figure("sorted a minute", row, "sorted_per_min", 1.0, 1, "")
    yield _figure("money an hour", row, "money_per_hour", 1.0, 2, "", "no prices")
    yield _figure("energy a sorted object", row, "energy_per_sorted_j", 1.0, 1, " J", "unknown")


def _figure(
    name: str, row: dict[str, Any], key: str, scale: float, digits: int, unit: str, without: str = "nothing is sorted"
) -> Figure:
    """A figure of a row by its key; `without` says why there is none."""
    if row[key] is None:
        return Figure(name, "none", without)
    value, low, high = (scale * row[part] for part in (key, f"{key}_low", f"{key}_high"))
    return Figure(name, f"{value:.{digits}f}{unit}", f"{low:.{digits}f}..{high:.{digits}f}")


def panel(state: State) -> str:
    """What stands at the top of the page's panel."""
    refusal = f'<div class="bad">{escape(state.refusal)}</div>' if state.refusal else ""
    if state.answer is None:
        return page_part(
            f'<div class="top"><span class="big">...</span> <small>{escape(state.doing)}</small></div>{refusal}'
        )
    parts = [top(state.answer, state), refusal]
    if state.over_saved is not None:
        parts.append(f'<div class="gain">Against the kept design: {escape(in_points(state.over_saved))}</div>')
    return page_part("".join(parts))


def reason(state: State) -> str:
    """What keeps the design from sorting more, and which change is being tried."""
    text = f"{sentence(state.causes)}." if state.causes else ""
    doing = f"{state.doing} ..." if state.doing else ""
    note = f'<div class="gain">{escape(sentence(state.note))}.</div>' if state.note else ""
    return page_part(f'{note}<div class="why">{escape(text)}</div><small>{escape(doing)}</small>')


def sentence(text: str) -> str:
    """A text that begins with a capital letter."""
    return f"{text[:1].upper()}{text[1:]}"


def page_part(text: str) -> str:
    """A part of a page with the style of the figures."""
    return f'<style>{STYLE}</style><div class="pg">{text}</div>'


def top(answer: Answer, state: State | None = None) -> str:
    """The figures of an answer, and what became of the objects."""
    first, *others = figures(answer)
    is_settled = answer.is_settled and (state is None or state.is_current)
    mark = "settled" if is_settled else "provisional" if state is None or state.is_current else "of the design before"
    chip = f'<span class="chip{" ok" if is_settled else ""}">{mark}</span>'
    small = f"<small>recovery<br>{first.interval}</small>"
    head = f'<div class="top"><span class="big">{first.value}</span>{small}{chip}</div>'
    cells = [
        f"<div><small>{figure.name}</small><b>{figure.value}</b><small>{figure.interval}</small></div>"
        for figure in others
    ]
    return f'{head}<div class="grid">{"".join(cells)}</div>{fates(answer)}{robots(answer)}'


def fates(answer: Answer) -> str:
    """What became of the objects, as a bar and its key."""
    shares = answer.row["fates"]
    parts, key = list[str](), list[str]()
    for fate, colour in zip(FATES, FATE_COLOURS, strict=True):
        share = 100.0 * shares[fate]
        parts.append(f'<div style="width:{share:.2f}%;background:{colour}" title="{WORDS[fate]}"></div>')
        if share >= 0.05:
            key.append(f'<span><i style="background:{colour}"></i>{WORDS[fate]} {share:.1f} %</span>')
    return f'<div class="bar">{"".join(parts)}</div><div class="key">{"".join(key)}</div>'


def robots(answer: Answer) -> str:
    """How much of the time each robot is at work."""
    shares = zip(answer.line.robots, answer.row["utilisation"], strict=True)
    text = ", ".join(f"{escape(robot.name)} {100.0 * share:.0f} %" for robot, share in shares)
    return f'<div class="why"><small>at work: {text}</small></div>'
