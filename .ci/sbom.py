"""Write sbom.cdx.json: the packages that the wheel runs on, at the versions of constraints.txt, in CycloneDX's format.

Packages of the core are required, those of extras optional; tools for working on the suite are left out. The same two
files give the same bytes: the bill has neither a date nor a serial number.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cyclonedx.model import Property
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentScope, ComponentType
from cyclonedx.model.license import DisjunctiveLicense
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT: Final = Path(__file__).resolve().parents[1]
FILE: Final = ROOT / "sbom.cdx.json"
TOOLS: Final = ("dev", "docs")
"""Extras for working on the suite."""
PIN: Final = re.compile(r"(?P<name>[\w.-]+)==(?P<version>[^\s;]+)(?: ; (?P<marker>[^#]+?))?\s+# via (?P<parents>.+)")


@dataclass(frozen=True)
class Pin:
    """A line of constraints.txt.

    Attributes:
        name: of the package, normalised.
        version: the package's version.
        marker: environments for which the line counts; empty for all.
        parents: normalised names of the packages that need the package.
    """

    name: str
    version: str
    marker: str
    parents: tuple[str, ...]


def pins(text: str) -> list[Pin]:
    """Parse the lines of constraints.txt.

    Raises:
        ValueError: a line is no pin with its parents.
    """
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    return [_pin(line) for line in lines]


def _pin(line: str) -> Pin:
    match = PIN.fullmatch(line)
    if match is None:
        raise ValueError(f"constraints.txt has line {line!r}; it must read NAME==VERSION  # via PARENT, ...")
    parents = tuple(canonicalize_name(parent.split()[0]) for parent in match["parents"].split(","))
    return Pin(canonicalize_name(match["name"]), match["version"], match["marker"] or "", parents)


def direct_names(project: Mapping[str, Any], extras: Iterable[str]) -> set[str]:
    """Collect normalised names of the packages that pyproject.toml names for the core and for some extras."""
    lines = [*project["dependencies"], *(line for extra in extras for line in project["optional-dependencies"][extra])]
    return {canonicalize_name(Requirement(line).name) for line in lines}


def closure(names: set[str], listed: Sequence[Pin]) -> set[str]:
    """Collect the names of packages and of all packages that those need in turn."""
    reached = set(names)
    while more := {pin.name for pin in listed if reached & {*pin.parents}} - reached:
        reached |= more
    return reached


def component(pin: Pin, required: set[str]) -> Component:
    """Describe a package as a component of the bill."""
    url = PackageURL("pypi", None, pin.name, pin.version)
    return Component(
        name=pin.name,
        version=pin.version,
        type=ComponentType.LIBRARY,
        purl=url,
        bom_ref=str(url),
        scope=ComponentScope.REQUIRED if pin.name in required else ComponentScope.OPTIONAL,
        properties=[Property(name="pnt_gym:marker", value=pin.marker)] if pin.marker else (),
    )


def bill(project: Mapping[str, Any], listed: Sequence[Pin]) -> Bom:
    """Make the bill of a project from its part of pyproject.toml and the pins of constraints.txt."""
    extras = [extra for extra in project["optional-dependencies"] if extra not in TOOLS]
    required = closure(direct_names(project, ()), listed)
    names = closure(direct_names(project, extras), listed)
    parts = [(pin, component(pin, required)) for pin in listed if pin.name in names]
    bom = Bom(components=[part for _, part in parts])
    bom.metadata.component = root = Component(
        name=project["name"],
        version=project["version"],
        type=ComponentType.LIBRARY,
        description=project["description"],
        licenses=[DisjunctiveLicense(id=project["license"])],
        bom_ref=project["name"],
    )
    direct = direct_names(project, extras)
    bom.register_dependency(root, [part for pin, part in parts if pin.name in direct])
    for pin, part in parts:
        bom.register_dependency(part, [child for other, child in parts if pin.name in other.parents])
    return bom


def text() -> str:
    """Compose the text of sbom.cdx.json from the files of this checkout."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    bom = bill(project, pins((ROOT / "constraints.txt").read_text(encoding="utf-8")))
    data = json.loads(JsonV1Dot6(bom).output_as_string())
    del data["serialNumber"], data["metadata"]["timestamp"]
    return json.dumps(data, indent=1, sort_keys=True) + "\n"


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
