"""A design as one HTML file: its scene, which a reader turns, its figures beside it, and its level file."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from typing import Final

from . import figures
from .level_files import text_of_line
from .session import State

STYLE: Final = """
body{margin:0}
iframe{position:fixed;inset:0 320px 0 0;width:calc(100% - 320px);height:100%;border:0}
.shared{position:fixed;inset:0 0 0 auto;width:320px;overflow:auto;border-left:1px solid #d9dee4;box-sizing:border-box;
padding:12px 6px;font:14px/1.4 system-ui,sans-serif}
.shared h1{font-size:17px;margin:0 10px 6px}.shared a{margin:10px;display:inline-block}
.shared pre{font-size:11px;background:#f5f6f8;padding:8px;white-space:pre-wrap;margin:10px}
@media (max-width:700px){iframe{width:100%;height:55%;inset:0}.shared{inset:55% 0 0 0;width:100%}}
"""


def html(scene: str, state: State) -> str:
    """One HTML file with a scene and the figures of a state.

    Args:
        scene: the scene as an HTML document, as viser writes it.
        state: what the page shows.
    """
    text, name = text_of_line(state.line), escape(state.line.name)
    link = f"data:application/yaml;base64,{b64encode(text.encode()).decode()}"
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{name}</title><style>{STYLE}</style></head>'
        f'<body><iframe srcdoc="{escape(scene)}"></iframe><aside class="shared"><h1>{name}</h1>'
        f"{figures.panel(state)}{figures.reason(state)}"
        f'<a download="{name}.yaml" href="{link}">download the level file</a><pre>{escape(text)}</pre></aside>'
        "</body></html>"
    )
