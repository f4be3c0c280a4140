"""Sphinx configuration of the manual."""

import sys
from pathlib import Path

from ross_payload import __version__

sys.path.insert(0, str(Path(__file__).parent))

project = "RoSS payload"
author = "The RoSS payload authors"
copyright = "2026, the RoSS payload authors"
release = version = __version__
extensions = ["myst_parser", "mathml"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"RoSS payload {release}"
html_static_path = ["_static"]
html_math_renderer = "mathml"
exclude_patterns = ["_build"]
nitpicky = True
