"""How to cite, from CITATION.cff."""

from __future__ import annotations

from typing import Any, Final

import yaml

from agents.ground.places import SHIPPED as ROOT

from .marks import fenced

FIELDS: Final = {"journal": "journal", "volume": "volume", "issue": "number", "doi": "doi", "year": "year"}
"""Keys of the file, and what BibTeX calls them."""


def citation(_: str) -> str:
    """BibTeX of the suite and of the papers whose methods it ships."""
    said = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    entries = [_entry("software", said | {"year": ""}), *(_entry(e["type"], e) for e in said["references"])]
    return fenced("\n\n".join(entries), "bibtex")


def _entry(kind: str, said: dict[str, Any]) -> str:
    people = [_name(person) for person in said["authors"]]
    lines = {"title": f"{{{said['title']}}}", "author": " and ".join(people)}
    lines |= {name: str(said[key]) for key, name in FIELDS.items() if said.get(key)}
    if kind == "software":
        lines["version"] = str(said["version"])
    if "start" in said:
        lines["pages"] = f"{said['start']}--{said['end']}"
    body = ",\n".join(f"  {name} = {{{value}}}" for name, value in lines.items())
    first = said["authors"][0].get("family-names", "pnt_gym").lower()
    return f"@{'misc' if kind == 'software' else 'article'}{{{first}{said.get('year', '')},\n{body}\n}}"


def _name(person: dict[str, str]) -> str:
    """Family name first; a group in braces, so that it is not taken apart."""
    if "name" in person:
        return f"{{{person['name']}}}"
    return f"{person['family-names']}, {person['given-names']}"
