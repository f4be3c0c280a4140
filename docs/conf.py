"""Sphinx configuration of the manual."""

from ross_payload import __version__

project = "RoSS payload"
author = "The RoSS payload authors"
copyright = "2026, the RoSS payload authors"
release = version = __version__
extensions = ["myst_parser", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"RoSS payload {release}"
html_static_path = ["_static"]
mathjax_path = "mathjax-is-not-bundled.js"  # nothing is fetched from elsewhere; formulas read well as TeX too
exclude_patterns = ["_build"]
nitpicky = True
