"""Configuration of the documentation site; `make docs-site` lays out its sources first."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

project = "Plymotion"
author = "the Plymotion developers"
root_doc = "index"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "docstrings",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "mathml",
]

myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 4  # pages link to headings as a forge names them
myst_dmath_double_inline = True
math_number_all = False
html_math_renderer = "mathml"
suppress_warnings = ["myst.header", "ref.python"]  # types in docstrings are words

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings give shapes, units and frames
napoleon_use_rtype = False
napoleon_use_param = False
napoleon_use_ivar = False

html_theme = "furo"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_title = "Plymotion"
html_copy_source = False
html_show_sourcelink = False
