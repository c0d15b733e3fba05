"""Matplotlib's drawings as smaller SVG text: the same picture, in a third of the bytes.

Matplotlib writes six decimals of a point, names for every group, and the same style at each mark; its pixels are PNG in
all colours. Here coordinates have as many decimals as a screen can show and count from the point before, equal styles
are one class, only names that something refers to stay, and pixels are WebP.
"""

from __future__ import annotations

import base64
import io
import re
from collections import Counter
from string import ascii_letters
from typing import Final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

SVG: Final = "http://www.w3.org/2000/svg"
GROUP: Final = f"{{{SVG}}}g"
USE: Final = f"{{{SVG}}}use"
LINK: Final = "{http://www.w3.org/1999/xlink}href"
DECIMALS: Final = 2
"""Decimals of a coordinate in a drawing's points, of which a screen shows two hundred to an inch."""
QUALITY: Final = 85
"""Of a picture in more colours than a palette has; at this one no blocks are seen."""
LETTER: Final = "scale(0.015625)"
"""What makes a letter of its outline, whose points count in so small a unit that ten of them are none to the eye."""
PNG: Final = "data:image/png;base64,"
_NUMBER: Final = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")
_REFERENCE: Final = re.compile(r"#([\w.-]+)")
_MOVE: Final = re.compile(r"translate\(([-\d.]+) ([-\d.]+)\)")
_PATH: Final = re.compile(r"[A-Za-z]|-?[\d.]+(?:e-?\d+)?")
_OF_ONE: Final = re.compile(r"(?<![-\w])opacity")
"""What a style says of each mark alone: of a group it would say something else."""
_POINTS: Final = {"M": 1, "L": 1, "Q": 2, "C": 3}
"""Points behind each letter of a path by Matplotlib, whose coordinates count from the corner."""


def small_svg(text: str) -> str:
    """The drawing in an SVG text by Matplotlib as a smaller text; the same bytes for the same drawing."""
    root = ElementTree.fromstring(text)
    for metadata in root.findall(f"{{{SVG}}}metadata"):
        root.remove(metadata)
    parts = list(root.iter())
    _shorten_names(parts)
    for part in parts:
        _shorten(part)
    for part in parts:
        _lift_style(part)
    _share_styles(root, parts)
    for part in parts:
        part[:] = _without_groups(part)
    ElementTree.register_namespace("", SVG)
    content = ElementTree.tostring(root, encoding="unicode").replace(" />", "/>")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{content}\n'


def _shorten_names(parts: list[Element]) -> None:
    """Give the parts that others refer to short names, and take away all other names."""
    values = [value for part in parts for key, value in part.items() if key == LINK or "url(#" in value]
    used = dict.fromkeys(name for value in values for name in _REFERENCE.findall(value))
    short = {name: _name(number) for number, name in enumerate(used)}
    for part in parts:
        if (name := part.attrib.pop("id", None)) in short:
            part.set("id", short[name])
        for key, value in part.items():
            if key == LINK or "url(#" in value:
                part.set(key, _REFERENCE.sub(lambda found: f"#{short[found[1]]}", value))


def _lift_style(part: Element) -> None:
    """Give a group the style that all of its marks have, if they inherit all that it says."""
    styles = {child.get("style", "") for child in part}
    style = next(iter(styles)) if len(styles) == 1 and {child.tag for child in part} == {USE} else ""
    if style and part.tag == GROUP and "style" not in part.attrib and not _OF_ONE.search(style):
        part.set("style", style)
        for child in part:
            del child.attrib["style"]


def _without_groups(part: Element) -> list[Element]:
    """The children of a part, with those of a group in the group's stead where the group says nothing of them."""
    children: list[Element] = []
    for child in part:
        children += _without_groups(child) if child.tag == GROUP and not child.attrib else [child]
    return children


def _name(number: int) -> str:
    """A short name for each number: a letter, then letters and digits."""
    rest, first = divmod(number, len(ascii_letters))
    return ascii_letters[first] + (str(rest) if rest else "")


def _shorten(part: Element) -> None:
    """Write the numbers of a part with fewer digits, and its pixels with fewer bytes."""
    part.text, part.tail = (None if text is None or not text.strip() else text for text in (part.text, part.tail))
    link = part.attrib.pop(LINK, None)
    if link is not None:
        part.set("href", _small_picture(link) if link.startswith(PNG) else link)
    if (move := _MOVE.fullmatch(part.get("transform", ""))) and part.tag == USE:
        del part.attrib["transform"]
        # A letter of a text, whose unit is a tenth of a point.
        part.attrib |= {"x": _rounded(move[1], 1), "y": _rounded(move[2], 1)}
    is_letter = part.get("transform") == LETTER
    for key, value in part.items():
        if key == "d":
            part.set(key, small_path(value, -1 if is_letter else DECIMALS if "." in value else 0))
        elif value == LETTER:
            part.set(key, "scale(.15625)")
        elif key == "transform":
            # A factor keeps its digits: what it scales may be thousands of points wide.
            part.set(key, re.sub(r"translate\([^)]*\)", lambda found: _rounded(found[0]), value))
        elif key in ("x", "y", "width", "height", "viewBox"):
            part.set(key, _rounded(value))


def _share_styles(root: Element, parts: list[Element]) -> None:
    """Make a class of each style that several parts have."""
    counts = Counter(style for part in parts if (style := part.get("style")))
    shared = [style for style, count in counts.items() if count > 1]
    names = {style: _name(number) for number, style in enumerate(shared)}
    for part in parts:
        if (style := part.get("style")) in names:
            del part.attrib["style"]
            part.set("class", names[style])
    sheet = root.find(f"{{{SVG}}}defs/{{{SVG}}}style")
    if sheet is not None:
        rules = [f".{name}{{{style}}}" for style, name in names.items()]
        sheet.text = re.sub(r"(?<=[:;]) ", "", "".join([sheet.text or "", *rules]))


def _rounded(text: str, decimals: int = DECIMALS) -> str:
    return _NUMBER.sub(lambda found: _number(round(float(found[0]) * 10**decimals), decimals), text)


def _number(units: int, decimals: int) -> str:
    """A whole number of units of the last decimal, without a digit more than it needs."""
    if decimals <= 0:
        return str(units)
    text = f"{units / 10**decimals:.{decimals}f}".rstrip("0").rstrip(".")
    return re.sub(r"^(-?)0\.", r"\1.", text)


def small_path(path: str, decimals: int) -> str:
    """A path whose points count from the point before; each is rounded where it lies, so no error adds up.

    Args:
        path: by Matplotlib.
        decimals: of the coordinates; with -1 they come out in tens.
    """
    tokens, parts = _PATH.findall(path), list[str]()
    place, start, at, last = (0, 0), (0, 0), 0, ""
    while at < len(tokens):
        letter, at = tokens[at], at + 1
        if letter == "z":
            place, last = start, ""
            parts.append(letter)
            continue
        count = 2 * _POINTS[letter]
        units = [round(float(token) * 10**decimals) for token in tokens[at : at + count]]
        at += count
        steps = [value - place[number % 2] for number, value in enumerate(units)]
        place = (units[-2], units[-1])
        if letter == "M":
            start = place
        elif letter == "L" and 0 in steps:
            letter, steps = ("h", steps[:1]) if steps[1] == 0 else ("v", steps[1:])
        numbers = " ".join(_number(step, decimals) for step in steps).replace(" -", "-")
        gap = letter.lower() if letter != last else "" if numbers.startswith("-") else " "
        parts.append(gap + numbers)
        last = letter
    return "".join(parts)


def _small_picture(link: str) -> str:
    """Pixels of a PNG as WebP: all of them where a palette would hold their colours, nearly the same otherwise."""
    from PIL import Image  # noqa: PLC0415 - comes with Matplotlib, needed for drawings only

    picture = Image.open(io.BytesIO(base64.b64decode(link.removeprefix(PNG))))
    content = io.BytesIO()
    exact = picture.getcolors(256) is not None
    picture.save(content, "webp", lossless=exact, quality=QUALITY, method=6)
    return f"data:image/webp;base64,{base64.b64encode(content.getvalue()).decode()}"
