"""What the pages hold that is made from code, levels and results, between the marks that `agents.report.blocks` fills.

    <!-- made: NAME ARGUMENT -->
    text that the function of this NAME returns
    <!-- /made -->

`make pages` writes the blocks, so that the pages can be read on a code host, and a test compares the written text with
the text of the functions. The site shows each block as it stands in its page.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from agents.ground.outputs import deliver_text
from agents.ground.places import SHIPPED as ROOT
from agents.report.blocks import MARKED, fill, makers_from, rewrite

from . import (
    cite,
    commands,
    controllers,
    environments,
    examples,
    fit,
    items,
    levels,
    papers,
    reality,
    results,
    side,
    throw,
)
from .texts import link_texts, write_texts

DOCS: Final = ROOT / "docs"
RESULTS: Final = ROOT / "results"
MAKERS: Final[Mapping[str, Callable[[str], str]]] = {
    "citation": cite.citation,
    "commands": commands.command_table,
    "help": commands.command_help,
    "controllers": controllers.controller_table,
    "shipped": controllers.shipped_table,
    "line-controllers": controllers.line_controller_table,
    "environment": environments.page,
    "environments": environments.environment_table,
    "gallery": environments.gallery,
    "examples": examples.example_code,
    "log-columns": fit.column_table,
    "fit-priors": fit.prior_table,
    "hidden": environments.hidden_table,
    "levels": levels.level_table,
    "items": items.item_table,
    "item-keys": items.key_table,
    "shapes": items.shape_table,
    "settings": levels.setting_table,
    "throw": throw.stage_table,
    "parts": papers.part_table,
    "drawings": papers.drawings,
    "verdicts": results.verdict_table,
    "measured": reality.measured_table,
    "measure-yours": reality.advice_table,
}
"""Functions that fill blocks, by the name of the block; each takes the argument of the block."""
DRAWINGS: Final[Mapping[str, Callable[[], str]]] = {
    "pictures/throw.svg": throw.drawing,
    "pictures/throw_side.svg": side.drawing,
}
"""Functions that draw the pictures of pages, by the place of the picture in docs/."""
RESULTS_PAGE: Final = re.compile(r"\]\(\.\./((?:\.\./)*)(results/[\w/-]+\.md)")
"""A link from a page of docs/ to a page of results."""
FILE: Final = re.compile(r'^```(\w+) title="([^"]+)"$', re.MULTILINE)
"""A block of code that is a file: GitHub ignores the title, and Sphinx wants a caption."""


def _made(words: str) -> str:
    """The text of a block `made`."""
    name, _, argument = words.partition(" ")
    return MAKERS[name](argument)


KINDS: Final = {**makers_from(RESULTS), "made": _made}
"""What makes the blocks of pages, by their kinds."""


def site_page(text: str) -> str:
    """A page as Sphinx reads it: blocks as they stand, without their marks, and files with their names."""
    unmarked = MARKED.sub(lambda block: block[3].removesuffix("\n") if block[1] in KINDS else block[0], text)
    return FILE.sub(_caption_block, unmarked)


def _caption_block(block: re.Match[str]) -> str:
    """The first line of a block of code that is a file; a caption is Markdown, in which `__init__` would be bold."""
    caption = block[2].replace("_", r"\_")
    return f"```{{code-block}} {block[1]}\n:caption: {caption}\n"


def hand_text(text: str) -> str:
    """The text of a page outside of its blocks `made`, which people write."""
    return fill(text, {"made": lambda words: ""}, is_marked=False)


def page_files() -> list[Path]:
    """All pages, without those of a build and of the results, which `python -m agents.report` writes."""
    return sorted(page for page in DOCS.rglob("*.md") if not {"_build", "results"} & {*page.parts[len(DOCS.parts) :]})


def write_pages() -> list[Path]:
    """Write the marked blocks of all pages and the drawings anew; return the files that changed."""
    changed = [page for page in page_files() if rewrite(page, KINDS)]
    drawn = {DOCS / name: draw() for name, draw in DRAWINGS.items()}
    stale = [file for file, text in drawn.items() if not file.is_file() or file.read_text(encoding="utf-8") != text]
    for file in stale:
        deliver_text(file, drawn[file])
    return [*changed, *stale]


def results_files() -> list[Path]:
    """The pages of results that are pages of the site; the tables beside them are texts."""
    return sorted(RESULTS.glob("*.md"))


def results_page(text: str) -> str:
    """A page of results as a page of the site: links lead to the site's pages, and drawings to their files."""
    return text.replace("](figures/", "](../../results/figures/").replace("](../docs/", "](../")


def _copy_results(_app: Any) -> None:
    """Copy the pages of results into docs/results, which git ignores."""
    for page in results_files():
        text = link_texts(page.read_text(encoding="utf-8"), page)
        deliver_text(DOCS / "results" / page.name, results_page(text))


def _change_source(_app: Any, page: str, source: list[str]) -> None:
    """Make a page of the site of a page that Sphinx reads; copied pages of results are such pages already."""
    if not page.startswith("results/"):
        source[0] = RESULTS_PAGE.sub(r"](\1\2", link_texts(site_page(source[0]), DOCS / f"{page}.md"))


def _write_texts(app: Any, exception: Exception | None) -> None:
    """Write what the pages link to beside the pages."""
    if exception is None:
        pages = [*page_files(), *results_files()]
        write_texts({page: page.read_text(encoding="utf-8") for page in pages}, Path(app.outdir))


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("builder-inited", _copy_results)
    app.connect("source-read", _change_source)
    app.connect("build-finished", _write_texts)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
