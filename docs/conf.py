"""Sphinx configuration of the manual."""

import os
import sys
from pathlib import Path

from ross_payload import __version__

sys.path.insert(0, str(Path(__file__).parent))

project = "RoSS payload"
author = "The RoSS payload authors"
copyright = "2026, the RoSS payload authors"
release = version = __version__
extensions = ["myst_parser", "mathml", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "fields"]
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autodoc_class_signature = "separated"  # fields are listed with their comments instead
autodoc_type_aliases = {name: name for name in ("Samples", "Real", "Complex", "Cancel")}
autodoc_default_options = {"exclude-members": "__init__, __new__"}
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_attr_annotations = False
default_role = "code"  # single backticks of docstrings
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"RoSS payload {release}"
templates_path = ["_templates"]  # the place that the theme has for versions
html_context = {"versions": os.environ.get("ROSS_DOCS_VERSIONS", "").split()}  # told by site.py
html_static_path = ["_static"]
html_css_files = ["manual.css"]
html_math_renderer = "mathml"
exclude_patterns = ["_build"]
nitpicky = True
nitpick_ignore_regex = [("py:.*", ".*")]  # types in signatures: most are not on a page of their own
