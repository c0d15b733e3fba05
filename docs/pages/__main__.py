"""`python -m docs.pages` writes the made parts of all pages."""

from __future__ import annotations

from .made import DOCS, write_pages

if __name__ == "__main__":
    changed = [page.relative_to(DOCS).as_posix() for page in write_pages()]
    print(f"written: {', '.join(changed)}" if changed else "every page is up to date")
