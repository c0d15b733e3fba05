"""Fills marked lines of the pages: `<!-- made: NAME ARGUMENT -->` becomes Markdown made from code, levels or results.

Blocks `<!-- table:NAME --> <!-- /table -->` are filled as in the README. So no page can say anything stale: what is
made stands nowhere but in the built site.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Final

from agents.ground.places import SHIPPED as ROOT
from agents.report.readme import with_blocks

from . import cite, commands, controllers, environments, items, levels, results

MADE: Final[Mapping[str, Callable[[str], str]]] = {
    "citation": cite.citation,
    "commands": commands.listed,
    "help": commands.help_of,
    "controllers": controllers.listed,
    "line-controllers": controllers.of_the_line,
    "environment": environments.page,
    "environments": environments.listed,
    "gallery": environments.gallery,
    "hidden": environments.hidden,
    "levels": levels.listed,
    "items": items.listed,
    "item-keys": items.keys,
    "level-files": levels.files,
    "settings": levels.settings,
    "chapter": results.chapter,
    "verdicts": results.verdicts,
}
"""What can be made, by name; each takes the rest of its line."""
LINE: Final = re.compile(r"^<!-- made: (\S+) ?(.*?) ?-->$", re.MULTILINE)
FILE: Final = re.compile(r'^```(\w+) title="([^"]+)"$', re.MULTILINE)
"""A block of code that is a file, as GitHub ignores and Sphinx wants it named."""


def filled(text: str) -> str:
    """A page with its marked lines, tables and named files as Sphinx reads them."""
    text = FILE.sub(r"```{code-block} \1\n:caption: \2\n", with_blocks(text, ROOT / "results"))
    return LINE.sub(lambda found: MADE[found[1]](found[2]), text)


def _read(_app: Any, _page: str, source: list[str]) -> None:
    source[0] = filled(source[0])


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("source-read", _read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
