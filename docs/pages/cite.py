"""How to cite, from CITATION.cff."""

from __future__ import annotations

from typing import Any, Final

import yaml

from agents.ground.places import SHIPPED as ROOT

from .marks import fence

FIELDS: Final = {"journal": "journal", "volume": "volume", "issue": "number", "doi": "doi", "year": "year"}
"""Keys of the file, and what BibTeX calls them."""


def citation(_: str) -> str:
    """BibTeX of the suite and of the papers whose methods it ships."""
    suite = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    entries = [
        _entry("software", suite | {"year": ""}),
        *(_entry(paper["type"], paper) for paper in suite["references"]),
    ]
    return fence("\n\n".join(entries), "bibtex")


def _entry(kind: str, entry: dict[str, Any]) -> str:
    people = [_name(person) for person in entry["authors"]]
    lines = {"title": f"{{{entry['title']}}}", "author": " and ".join(people)}
    lines |= {name: str(entry[key]) for key, name in FIELDS.items() if entry.get(key)}
    if kind == "software":
        lines["version"] = str(entry["version"])
    if "start" in entry:
        lines["pages"] = f"{entry['start']}--{entry['end']}"
    body = ",\n".join(f"  {name} = {{{value}}}" for name, value in lines.items())
    first = entry["authors"][0].get("family-names", "pnt_gym").lower()
    return f"@{'misc' if kind == 'software' else 'article'}{{{first}{entry.get('year', '')},\n{body}\n}}"


def _name(person: dict[str, str]) -> str:
    """Family name first; a group in braces, so that it is not taken apart."""
    if "name" in person:
        return f"{{{person['name']}}}"
    return f"{person['family-names']}, {person['given-names']}"
