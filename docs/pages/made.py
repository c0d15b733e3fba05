"""Fills marked blocks of the pages with Markdown made from code, levels and results.

    <!-- made: NAME ARGUMENT -->
    what was made
    <!-- /made -->

`make pages` writes the blocks, so that the pages can be read on a code host, and a test holds the written text against
what is made. The site makes each block again. Blocks `<!-- table:NAME --> <!-- /table -->` are filled as in the README.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from agents.ground.outputs import deliver_text
from agents.ground.places import SHIPPED as ROOT
from agents.report.readme import with_blocks

from . import cite, commands, controllers, environments, examples, items, levels, papers, results, throw

DOCS: Final = ROOT / "docs"
MADE: Final[Mapping[str, Callable[[str], str]]] = {
    "citation": cite.citation,
    "commands": commands.listed,
    "help": commands.help_of,
    "controllers": controllers.listed,
    "line-controllers": controllers.of_the_line,
    "environment": environments.page,
    "environments": environments.listed,
    "gallery": environments.gallery,
    "examples": examples.listed,
    "hidden": environments.hidden,
    "levels": levels.listed,
    "items": items.listed,
    "item-keys": items.keys,
    "level-files": levels.files,
    "settings": levels.settings,
    "throw": throw.stages,
    "parts": papers.parts,
    "chapter": results.chapter,
    "verdicts": results.verdicts,
}
"""What can be made, by name; each takes the rest of its line."""
DRAWN: Final[Mapping[str, Callable[[], str]]] = {"pictures/throw.svg": throw.drawing}
"""Drawings of the pages, by their place."""
SITE_ALONE: Final[Mapping[str, Callable[[str, Path], str]]] = {"chapter": results.pointer}
"""Long text that stands elsewhere in the repository: what a page has in its place, by the text and the page."""
BLOCK: Final = re.compile(r"^<!-- made: (\S+) ?(.*?) ?-->\n(.*?)^<!-- /made -->$", re.MULTILINE | re.DOTALL)
FILE: Final = re.compile(r'^```(\w+) title="([^"]+)"$', re.MULTILINE)
"""A block of code that is a file, as GitHub ignores and Sphinx wants it named."""


def filled(text: str) -> str:
    """A page with its marked blocks, tables and named files as Sphinx reads them."""
    text = FILE.sub(r"```{code-block} \1\n:caption: \2\n", with_blocks(text, ROOT / "results"))
    return BLOCK.sub(lambda block: MADE[block[1]](block[2]), text)


def written(text: str, page: Path) -> str:
    """A page with its marked blocks and tables as the repository holds it."""

    def block(old: re.Match[str]) -> str:
        name, argument = old[1], old[2]
        new = SITE_ALONE[name](argument, page) if name in SITE_ALONE else MADE[name](argument)
        return f"{old[0].partition(chr(10))[0]}\n{new}\n<!-- /made -->"

    return BLOCK.sub(block, with_blocks(text, ROOT / "results"))


def by_hand(text: str) -> str:
    """A page without its marked blocks: the text that people write."""
    return BLOCK.sub("", text)


def pages() -> list[Path]:
    """All pages, without those of a build."""
    return sorted(page for page in DOCS.rglob("*.md") if "_build" not in page.parts)


def write_pages() -> list[Path]:
    """Write the marked blocks of all pages and the drawings anew; return the files that changed."""
    texts = {page: written(page.read_text(encoding="utf-8"), page) for page in pages()}
    texts |= {DOCS / name: draw() for name, draw in DRAWN.items()}
    changed = [file for file, text in texts.items() if not file.is_file() or file.read_text(encoding="utf-8") != text]
    for file in changed:
        deliver_text(file, texts[file])
    return changed


def _read(_app: Any, _page: str, source: list[str]) -> None:
    source[0] = filled(source[0])


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
