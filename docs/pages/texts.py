"""Files of the repository that pages link to, tables of results, levels and changes: the site has them as plain text.

A table of 40 columns or 300 rows is no page to read. It stays a file, which a link opens and a browser searches.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from agents.ground.outputs import deliver_text
from agents.ground.places import SHIPPED as ROOT

FOLDER: Final = "files"
"""Folder of the texts in the site."""
LINK: Final = re.compile(r"(?<!!)\[([^\[\]]+)\]\(([\w./-]+\.(?:md|yaml|py|cff))(?:#[\w-]+)?\)")
"""A link to a file, and its words; a text has no headings to lead to."""
TABLE: Final = re.compile(r"(?:^\|.*\n?)+", re.MULTILINE)


def is_page(file: Path) -> bool:
    """Whether a file of the repository is a page of the site."""
    place = file.relative_to(ROOT)
    return place.suffix == ".md" and (place.parts[0] == "docs" or place.parent == Path("results"))


def text_of_link(target: str, page: Path) -> Path | None:
    """The file that a page links to, where the site has that file as text; None for pages and for what is no file."""
    file = (page.parent / target).resolve()
    return file if file.is_file() and file.is_relative_to(ROOT) and not is_page(file) else None


def linked_texts(text: str, page: Path) -> Iterator[Path]:
    """Every file that a page links to and the site has as text."""
    yield from (file for link in LINK.finditer(text) if (file := text_of_link(link[2], page)) is not None)


def link_texts(text: str, page: Path) -> str:
    """A page whose links to such files lead to the texts."""
    inside = page.relative_to(ROOT / "docs") if page.is_relative_to(ROOT / "docs") else page.relative_to(ROOT)
    above = "../" * (len(inside.parts) - 1)

    def link(found: re.Match[str]) -> str:
        file = text_of_link(found[2], page)
        return found[0] if file is None else f'<a href="{above}{place(file)}">{found[1]}</a>'

    return LINK.sub(link, text)


def place(file: Path) -> str:
    """Where the site has a file as text."""
    return f"{FOLDER}/{file.relative_to(ROOT).as_posix()}.txt"


def aligned(text: str) -> str:
    """A text of Markdown whose tables have columns of one width each."""
    return TABLE.sub(lambda table: _aligned(table[0].splitlines()), text)


def _aligned(lines: list[str]) -> str:
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))] for line in lines]
    header, marks, *body = rows
    widths = [max(map(len, column)) for column in zip(header, *body, strict=True)]
    shown: list[str] = []
    right = [mark.endswith(":") for mark in marks]
    for row in (header, ["-" * width for width in widths], *body):
        cells = [
            cell.rjust(width) if of_figures else cell.ljust(width)
            for cell, width, of_figures in zip(row, widths, right, strict=True)
        ]
        shown.append("  ".join(cells).rstrip())
    return "\n".join(shown) + "\n"


def write_texts(pages: dict[Path, str], site: Path) -> None:
    """Write every file that some pages link to into the built site."""
    for file in sorted({file for page, text in pages.items() for file in linked_texts(text, page)}):
        text = file.read_text(encoding="utf-8")
        deliver_text(site / place(file), aligned(text) if file.suffix == ".md" else text)
