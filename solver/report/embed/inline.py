"""Scripts and styles as the page contains them, with the hashes that its policy allows."""

import base64
import hashlib
import json
from functools import cache
from pathlib import Path

ROOM = Path(__file__).parents[1]
VENDOR = ROOM / "vendor" / "uplot"
# In the order in which they are read: a file uses names of earlier files only.
SCRIPTS = (
    "data",
    "clock",
    "words",
    "theme",
    "tables",
    "download",
    "fourier",
    "chart",
    "plots",
    "colours",
    "motion",
    "camera",
    "gl",
    "body_gl",
    "renderer_gl",
    "renderer_2d",
    "overlay",
    "print",
    "viewer",
    "keys",
    "main",
)


@cache
def script() -> str:
    """Return the one script of the page: uPlot, then the files of script/ in one scope."""
    shaders = {path.name: _read(path) for path in sorted((ROOM / "shader").iterdir())}
    table = f"const SHADERS = {json.dumps(shaders)};"
    own = table + "\n" + "\n".join(_read(ROOM / "script" / f"{name}.js") for name in SCRIPTS)
    licence = _read(VENDOR / "LICENSE").replace("*/", "* /")
    library = _read(VENDOR / "uPlot.iife.min.js")
    return f"/*\nuPlot, {licence}*/\n{library}\n(() => {{\n'use strict';\n{own}\n}})();\n"


@cache
def style() -> str:
    """Return the one style sheet of the page."""
    return _read(VENDOR / "uPlot.min.css") + "\n" + _read(ROOM / "page.css")


def policy() -> str:
    """Return the Content-Security-Policy: nothing but the page's own script and style."""
    return (
        f"default-src 'none'; script-src {source(script())}; style-src {source(style())}; "
        "base-uri 'none'; form-action 'none'"
    )


def source(text: str) -> str:
    """Return the hash of an element's text as the policy writes it."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _read(path: Path) -> str:
    text = path.read_text(encoding="utf-8")
    if "</script" in text.lower() or "<!--" in text:
        raise ValueError(f"{path}: must not contain the end of a script element")
    return text
