"""Equations as pictures: the build of the site draws the equations, so the site needs no other site to show them.

Matplotlib draws a part of TeX (fractions, roots, Greek letters, accents). Other TeX is an error of the build.
"""

from __future__ import annotations

import base64
import io
from functools import cache
from html import escape
from typing import Any, Final

from docutils import nodes

SIZE: Final = 11.0
"""Size of the letters, equal to the text around an equation [points]."""
PIXELS: Final = 96.0 / 72.0
"""Pixels in a point."""


@cache
def picture(tex: str) -> tuple[str, float, float]:
    """An equation as SVG in base64, its height, and its depth below the line of the text [pixels].

    Raises:
        ValueError: Matplotlib cannot draw this TeX.
    """
    import matplotlib as mpl  # noqa: PLC0415 - heavy, needed for the site only
    from matplotlib.font_manager import FontProperties  # noqa: PLC0415
    from matplotlib.mathtext import math_to_image  # noqa: PLC0415

    text = io.BytesIO()
    with mpl.rc_context({"mathtext.fontset": "cm", "svg.hashsalt": "pnt_gym"}):
        depth = math_to_image(f"${tex}$", text, prop=FontProperties(size=SIZE * 1.25), dpi=72, format="svg")
    height = float(text.getvalue().decode().partition('height="')[2].partition("pt")[0])
    return base64.b64encode(text.getvalue()).decode(), height * PIXELS, depth * PIXELS


def image(tex: str) -> str:
    """An equation as an element of HTML, with its TeX for readers who cannot see the picture."""
    data, height, depth = picture(" ".join(tex.split()))
    style = f"height: {height:.1f}px; vertical-align: {-depth:.1f}px"
    return f'<img class="math" alt="{escape(tex, quote=True)}" style="{style}" src="data:image/svg+xml;base64,{data}">'


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(image(node.astext()))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    lines = "".join(f"<p>{image(line)}</p>" for line in node.astext().strip().split("\n\n"))
    translator.body.append(f'<div class="math">{lines}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.add_html_math_renderer("pictures", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
