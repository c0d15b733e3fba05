"""Size of the site: the pages and the words that its readers see, and the limits of both.

`python -m docs.pages.size [FOLDER]` counts what a build has left. The build itself counts too, and warns beyond a
limit.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, Final

from sphinx.util import logging

from .made import DOCS

BUILT: Final = DOCS / "_build" / "html"
MOST_PAGES: Final = 70
"""Pages of HTML, the search and all other pages of the theme included."""
MOST_WORDS: Final = 110_000
"""Words of all pages, without the navigation around them."""


class ArticleText(HTMLParser):
    """Collects the text of a page's `<article>`."""

    def __init__(self) -> None:
        """Begin outside of every article."""
        super().__init__()
        self.depth = 0
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Go into an article."""
        self.depth += tag == "article"

    def handle_endtag(self, tag: str) -> None:
        """Leave an article."""
        self.depth -= tag == "article"

    def handle_data(self, data: str) -> None:
        """Keep text inside of an article."""
        if self.depth:
            self.text.append(data)


def words_of(page: str) -> int:
    """Number of words that a page of HTML shows: pieces between spaces, dashes in tables included."""
    article = ArticleText()
    article.feed(page)
    return len(" ".join(article.text).split())


def page_words(folder: Path, pages: Iterable[Path] | None = None) -> dict[str, int]:
    """Number of words of pages of HTML by their places in a folder; of all pages there, if none are named."""
    return {
        page.relative_to(folder).as_posix(): words_of(page.read_text(encoding="utf-8"))
        for page in sorted(folder.rglob("*.html") if pages is None else pages)
    }


def _count(app: Any, exception: Exception | None) -> None:
    """Warn of a site that is too large; a build of other kinds than HTML has no pages."""
    if exception is None and app.builder.name == "html":
        # The pages of this build, and not what an earlier one has left.
        folder = Path(app.outdir)
        names = {*app.env.found_docs, "search"}
        words = page_words(folder, [folder / f"{name}.html" for name in names])
        if len(words) > MOST_PAGES or sum(words.values()) > MOST_WORDS:
            logging.getLogger(__name__).warning(
                "the site has %d pages and %d words; at most %d and %d can be read",
                len(words), sum(words.values()), MOST_PAGES, MOST_WORDS,
            )  # fmt: skip


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("build-finished", _count)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    counted = page_words(Path(sys.argv[1]) if len(sys.argv) > 1 else BUILT)
    for name, count in sorted(counted.items(), key=lambda entry: -entry[1]):
        print(f"{count:7,} {name}")
    print(f"{sum(counted.values()):7,} words on {len(counted)} pages; at most {MOST_WORDS:,} on {MOST_PAGES}")
