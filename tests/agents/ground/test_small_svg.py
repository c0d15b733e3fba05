"""Drawings as small SVG: a third of the bytes, and every point where Matplotlib had put it."""

import base64
import io
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from agents.ground.drawings import svg
from agents.ground.small_svg import SVG, small_path, small_svg


def drawing() -> Figure:
    figure = Figure(figsize=(4.0, 3.0))
    axes = figure.subplots()
    axes.plot(np.linspace(0.0, 9.0, 200), np.sin(np.linspace(0.0, 9.0, 200)), "o-", label="a line with marks")
    axes.plot(np.arange(9.0), np.arange(9.0) / 9.0, "s", alpha=0.3)
    axes.imshow(np.outer(np.linspace(0.0, 1.0, 90), np.linspace(0.0, 1.0, 90)), extent=(0.0, 1.0, 0.0, 1.0))
    axes.legend()
    return figure


def large(figure: Figure) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def test_a_drawing_is_smaller_and_says_the_same_twice() -> None:
    text = large(drawing())
    small = small_svg(text)
    assert len(small) < 0.5 * len(text)
    assert small_svg(text) == small
    assert svg(drawing()) == svg(drawing())


def test_every_reference_finds_its_part_and_every_class_its_style() -> None:
    root = ElementTree.fromstring(small_svg(large(drawing())))
    names = [part.get("id") for part in root.iter() if part.get("id")]
    links = {link[1:] for part in root.iter() if (link := part.get("href", "")).startswith("#")}
    clips = {found for part in root.iter() for found in re.findall(r"url\(#(\w+)\)", part.get("clip-path", ""))}
    assert len(names) == len(set(names)) and set(names) == links | clips
    sheet = root.find(f"{{{SVG}}}defs/{{{SVG}}}style")
    assert sheet is not None and sheet.text is not None
    assert {part.get("class") for part in root.iter()} - {None} == set(re.findall(r"\.(\w+)\{", sheet.text))


def test_marks_that_shine_through_do_so_one_by_one() -> None:
    """Opacity of a group would let marks hide each other, where those of Matplotlib add up."""
    root = ElementTree.fromstring(small_svg(large(drawing())))
    sheet = root.find(f"{{{SVG}}}defs/{{{SVG}}}style")
    assert sheet is not None and sheet.text is not None
    through = set(re.findall(r"\.(\w+)\{[^}]*(?<!-)opacity", sheet.text))
    assert all(part.get("class") not in through for part in root.iter(f"{{{SVG}}}g"))


@pytest.mark.parametrize(
    ("path", "small"),
    [
        ("M 1.006 2 L 3.5 2 L 3.5 4.254 z", "m1.01 2h2.49v2.25z"),
        ("M 0.5 0.5 \nL -0.25 0.75 \nL 1 1 \n", "m.5 .5l-.75 .25 1.25 .25"),
        ("M 0.1 0 Q 1.1 1 2.1 0 Q 3.1 -1 4.1 0", "m.1 0q1 1 2 0 1-1 2 0"),
        ("M 0.0 0.0 L 1.5 1.5 z M 2.0 2.0 L 3.0 4.0", "m0 0l1.5 1.5zm2 2l1 2"),
    ],
)
def test_a_path_counts_from_the_point_before(path: str, small: str) -> None:
    assert small_path(path, 2) == small


def test_errors_of_rounding_do_not_add_up() -> None:
    steps = np.random.default_rng(0).uniform(0.0, 0.02, (1000, 2)).cumsum(axis=0)
    path = "M " + " L ".join(f"{x:.6f} {y:.6f}" for x, y in steps)
    tokens, last, place = re.findall(r"[a-z]|-?\d*\.?\d+", small_path(path, 2)), "", np.zeros(2)
    while tokens:
        last = tokens.pop(0) if tokens[0].isalpha() else last
        step = {"h": (1, 0), "v": (0, 1)}.get(last, (1, 1))
        place += [float(tokens.pop(0)) if axis else 0.0 for axis in step]
    np.testing.assert_allclose(place, steps[-1], atol=0.0051)


def test_few_colours_stay_as_they_are() -> None:
    pixels = np.random.default_rng(0).integers(0, 2, (30, 50), dtype=np.uint8) * np.array([[[200]], [[10]], [[90]]])
    figure = Figure(figsize=(2.0, 2.0))
    figure.figimage(np.moveaxis(pixels, 0, -1).astype(np.uint8))
    found = re.search(r'data:image/webp;base64,([^"]*)', small_svg(large(figure)))
    assert found is not None
    shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(found[1]))).convert("RGB"))
    np.testing.assert_array_equal(np.unique(shown.reshape(-1, 3), axis=0), [[0, 0, 0], [200, 10, 90]])
