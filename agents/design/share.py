"""A design as one HTML file: its scene, which a reader turns, its figures beside it, and its level file."""

from __future__ import annotations

from base64 import b64encode
from html import escape

from . import figures
from .level_files import text_of_line
from .session import State

STYLE = """
.shared{position:fixed;top:0;right:0;bottom:0;width:320px;overflow:auto;background:#fff;z-index:9;
border-left:1px solid #d9dee4;box-sizing:border-box;padding:12px 6px;font:14px/1.4 system-ui,sans-serif}
.shared h1{font-size:17px;margin:0 10px 6px}.shared a{margin:10px;display:inline-block}
.shared pre{font-size:11px;background:#f5f6f8;padding:8px;white-space:pre-wrap;margin:10px}
@media (max-width:700px){.shared{top:auto;width:100%;height:45%}}
"""


def html(scene: str, state: State) -> str:
    """One HTML file with a scene and the figures of a state.

    Args:
        scene: the scene as an HTML document, as viser writes it.
        state: what the page shows.
    """
    text, name = text_of_line(state.line), escape(state.line.name)
    link = f"data:application/yaml;base64,{b64encode(text.encode()).decode()}"
    part = (
        f'<style>{STYLE}</style><aside class="shared"><h1>{name}</h1>{figures.panel(state)}{figures.reason(state)}'
        f'<a download="{name}.yaml" href="{link}">download the level file</a><pre>{escape(text)}</pre></aside>'
    )
    end = scene.rindex("</body>")
    return f"{scene[:end]}{part}{scene[end:]}"
