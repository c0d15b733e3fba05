"""The report as one self-contained page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from agents.report.__main__ import Chapter

TEMPLATE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>pnt_gym results</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 0.5rem 0 1.5rem; }
th, td { padding: 0.2rem 0.7rem; border-bottom: 1px solid #ddd; text-align: right; }
.left { text-align: left; }
.wide { overflow-x: auto; }
svg { max-width: 100%; height: auto; }
</style>
</head>
<body>
<h1>pnt_gym results</h1>
{% for chapter in chapters %}
<h2>{{ chapter.title }}</h2>
<p>{{ chapter.note }}</p>
{% for headline, rows, sides in chapter.parts %}
<h3>{{ headline }}</h3>
<div class="wide"><table>
<thead><tr>{% for cell in rows[0] %}<th class="{{ sides[loop.index0] }}">{{ cell }}</th>{% endfor %}</tr></thead>
<tbody>
{% for row in rows[1:] %}<tr>{% for cell in row %}<td class="{{ sides[loop.index0] }}">{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</tbody>
</table></div>
{% endfor %}
{% for figure in chapter.figures %}
<figure>{{ figure | safe }}</figure>
{% endfor %}
{% endfor %}
</body>
</html>
"""


def page(chapters: Sequence[Chapter]) -> str:
    """The page as HTML; figures are inside it."""
    from jinja2 import Environment  # noqa: PLC0415 - needed for reports only

    template = Environment(autoescape=True, trim_blocks=True).from_string(TEMPLATE)
    prepared = [
        {
            "title": chapter.title,
            "note": chapter.note,
            "parts": [(headline, cells(table), alignments(table)) for headline, table in chapter.parts],
            "figures": [text[text.index("<svg") :] for text in chapter.figures.values()],
        }
        for chapter in chapters
    ]
    return template.render(chapters=prepared) + "\n"


def cells(table: str) -> list[list[str]]:
    """Cells of a Markdown table, without its line of dashes."""
    lines = table.splitlines()
    rows = [line.strip("|").replace("\\|", "\0").split("|") for line in [lines[0], *lines[2:]]]
    return [[cell.strip().replace("\0", "|") for cell in row] for row in rows]


def alignments(table: str) -> list[str]:
    """The side, left or right, to which each column of a Markdown table is aligned."""
    dashes = table.splitlines()[1].strip("|").split("|")
    return ["right" if column.strip().endswith(":") else "left" for column in dashes]
