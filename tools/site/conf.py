"""Configuration of the documentation site; `make docs-site` lays out its sources first."""

import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

project = "Plymotion"
author = "the Plymotion developers"
root_doc = "index"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
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


# Equations as MathML: browsers typeset it without scripts and without network.


def _mathml(text: str, display: str) -> str:
    """MathML of an equation; `aligned`, which the converter does not know, is its `align*`."""
    return convert(text.replace("{aligned}", "{align*}"), display=display)


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(translator.starttag(node, "div", CLASS="math"))
    if node.get("number"):
        translator.body.append(f'<span class="eqno">({node["number"]})</span>')
    translator.body.append(_mathml(node.astext(), "block") + "</div>\n")
    raise nodes.SkipNode


def _headed(app: Sphinx, what: str, name: str, found: Any, options: Any, lines: list[str]) -> None:
    """Put a heading before the first example, which else belongs to the section above."""
    if "Examples" in lines:
        return
    for number, line in enumerate(lines):
        if line.startswith(">>>"):
            lines[number:number] = ["Examples", "--------"]
            return


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer of equations; docstrings get headings before napoleon reads them."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("autodoc-process-docstring", _headed, priority=1)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
