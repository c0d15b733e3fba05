"""The equations of the pages are drawn when the site is built, by what Matplotlib knows of TeX."""

import base64
import re

import pytest

from docs.pages import made, maths

TEX = re.compile(r"\$\$(.+?)\$\$|\$([^$\n]+?)\$", re.DOTALL)


def equations():
    """Every equation of the papers' pages, once."""
    texts = [page.read_text(encoding="utf-8") for page in made.page_files() if page.parent.name == "papers"]
    return sorted({block or inline for text in texts for block, inline in TEX.findall(made.hand_text(text))})


def test_there_are_equations():
    assert len(equations()) > 60


@pytest.mark.parametrize("tex", equations())
def test_an_equation_can_be_drawn(tex):
    data, height, depth = maths.picture(" ".join(tex.split()))
    assert b"<svg" in base64.b64decode(data)
    assert 0.0 <= depth < height < 60.0


def test_what_cannot_be_drawn_is_an_error():
    with pytest.raises(ValueError, match="nothing"):
        maths.picture(r"\nothing{x}")
