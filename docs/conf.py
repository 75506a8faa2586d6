"""Sphinx's settings. Pages of effects, of the API and of the repository's other folders are made before every build."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE / "extensions"), str(HERE.parent / "scripts")]

import docs_api  # noqa: E402
import docs_effects  # noqa: E402
import docs_repository  # noqa: E402

import flexdyn as fd  # noqa: E402

project = "flexdyn"
author = "The flexdyn developers"
copyright = author
release = version = fd.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "mathml"]
exclude_patterns = ["extensions", "jupyter_execute"]
html_theme = "furo"
html_title = "flexdyn"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_math_renderer = "mathml"

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # signatures show them; attributes are documented in the class
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_custom_sections = [("Class attributes", "params_style"), ("Class attributes for a diagnosis", "params_style")]
suppress_warnings = ["mystnb.unknown_mime_type"]


def setup(app: Any) -> None:
    """Make the generated pages, and lead links that leave this folder to where the site has their target."""
    generated = HERE / "generated"
    docs_effects.write(generated / "effects", HERE / "effects.yaml")
    docs_api.write(generated / "api")
    docs_repository.write(generated / "repository")
    app.connect("source-read", docs_repository.redirect)
