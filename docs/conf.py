"""The documentation site: `make docs` builds it into docs/_build/html, warnings as errors."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

HERE: Final = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import pnt_gym  # noqa: E402

project = "pnt_gym"
author = "The pnt_gym maintainers"
copyright = author
version = release = pnt_gym.__version__

extensions = [
    "docs.pages.made",
    "docs.pages.breaks",
    "docs.pages.docstrings",
    "docs.pages.maths",
    "docs.pages.size",
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
]
exclude_patterns = ["_build", "results/tables"]

# Pages are Markdown; the tour is a notebook, which the build runs.
myst_enable_extensions = ["dollarmath", "html_image"]
myst_heading_anchors = 4
html_math_renderer = "pictures"
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_merge_streams = True

# Docstrings are Google's, with code in single backticks.
default_role = "code"
add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
napoleon_use_rtype = False
napoleon_use_ivar = True
napoleon_attr_annotations = False  # the signature of a class has the types

html_theme = "furo"
pygments_dark_style = "github-dark"
html_title = f"pnt_gym {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_use_index = False  # the search finds names
html_domain_indices = False
html_show_sourcelink = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0b5cad", "color-brand-content": "#0b5cad"},
    "dark_css_variables": {"color-brand-primary": "#6cb2f5", "color-brand-content": "#6cb2f5"},
}
