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
from agents.report.blocks import fill_blocks

from . import cite, commands, controllers, environments, examples, items, levels, papers, results, throw

DOCS: Final = ROOT / "docs"
RESULTS: Final = ROOT / "results"
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
    "verdicts": results.verdicts,
}
"""What can be made, by name; each takes the rest of its line."""
DRAWN: Final[Mapping[str, Callable[[], str]]] = {"pictures/throw.svg": throw.drawing}
"""Drawings of the pages, by their place."""
BLOCK: Final = re.compile(r"^<!-- made: (\S+) ?(.*?) ?-->\n(.*?)^<!-- /made -->$", re.MULTILINE | re.DOTALL)
RESULTS_PAGE: Final = re.compile(r"\]\(\.\./((?:\.\./)*)(results/[\w/-]+\.md)")
"""A link from a page of docs/ to a page of results."""
FILE: Final = re.compile(r'^```(\w+) title="([^"]+)"$', re.MULTILINE)
"""A block of code that is a file, as GitHub ignores and Sphinx wants it named."""


def filled(text: str) -> str:
    """A page with its marked blocks, tables and named files as Sphinx reads them."""
    text = FILE.sub(r"```{code-block} \1\n:caption: \2\n", fill_blocks(text, RESULTS))
    return BLOCK.sub(lambda block: MADE[block[1]](block[2]), text)


def written(text: str) -> str:
    """A page with its marked blocks and tables as the repository holds it."""

    def block(old: re.Match[str]) -> str:
        return f"{old[0].partition(chr(10))[0]}\n{MADE[old[1]](old[2])}\n<!-- /made -->"

    return BLOCK.sub(block, fill_blocks(text, RESULTS))


def by_hand(text: str) -> str:
    """A page without its marked blocks: the text that people write."""
    return BLOCK.sub("", text)


def pages() -> list[Path]:
    """All pages, without those of a build and of the results, which `python -m agents.report` writes."""
    return sorted(page for page in DOCS.rglob("*.md") if not {"_build", "results"} & {*page.parts[len(DOCS.parts) :]})


def write_pages() -> list[Path]:
    """Write the marked blocks of all pages and the drawings anew; return the files that changed."""
    texts = {page: written(page.read_text(encoding="utf-8")) for page in pages()}
    texts |= {DOCS / name: draw() for name, draw in DRAWN.items()}
    changed = [file for file, text in texts.items() if not file.is_file() or file.read_text(encoding="utf-8") != text]
    for file in changed:
        deliver_text(file, texts[file])
    return changed


def results_page(text: str, *, is_tables: bool) -> str:
    """A page of results as a page of the site: links lead to the site's pages, and drawings to their files."""
    if is_tables:
        return "---\norphan: true\n---\n" + text.replace("](../figures/", "](../../../results/figures/")
    return text.replace("](figures/", "](../../results/figures/").replace("](../docs/", "](../")


def _copy_results(_app: Any) -> None:
    """Copy the pages of results into docs/results, which git ignores."""
    for page in sorted(RESULTS.glob("**/*.md")):
        place = page.relative_to(RESULTS)
        if place.parts[0] != "policies":
            text = results_page(page.read_text(encoding="utf-8"), is_tables=place.parts[0] == "tables")
            deliver_text(DOCS / "results" / place, text)


def _read(_app: Any, page: str, source: list[str]) -> None:
    """Fill a page that Sphinx reads; copied pages of results are full."""
    if not page.startswith("results/"):
        source[0] = RESULTS_PAGE.sub(r"](\1\2", filled(source[0]))


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("builder-inited", _copy_results)
    app.connect("source-read", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
