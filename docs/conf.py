"""How the pages are built: `make docs`. A warning is an error; nothing is fetched from a network."""

from __future__ import annotations

import re
from typing import Any

project = "ObstacleWatch bench"
html_title = "ObstacleWatch bench"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
nb_execution_mode = "off"  # notebooks hold their outputs; tests/docs/test_notebook.py executes them
exclude_patterns = ["_build"]

highlight_language = "text"  # blocks without a language are commands

html_theme = "furo"
html_show_copyright = False
html_copy_source = False

myst_heading_anchors = 3
suppress_warnings = ["ref.python"]  # names of attributes that several classes have, listed below their own class

default_role = "code"  # docstrings put names in single backticks, as Markdown does
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_class_signature = "mixed"
autodoc_type_aliases = {name: name for name in ("ArrayLike", "NDArray", "Array", "Floats", "Walk")}
autodoc_preserve_defaults = True
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_attr_annotations = False  # types stand beside the attributes themselves


def keep_bars(_app: Any, _what: str, _name: str, _obj: Any, _options: Any, lines: list[str]) -> None:
    """Magnitudes such as |g| are no substitutions of reStructuredText."""
    lines[:] = [re.sub(r"\|", r"\\|", line) for line in lines]


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", keep_bars)
