"""What report.html carries inside: arrays, histories, scripts and styles with their hashes."""

import base64
import hashlib
import json
import zlib
from collections.abc import Callable
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..math.arrays import Array, IntArray
from ..package.common.plain_data import plain
from ..results import RunResult
from .case_figures import UNITS, WORDS

# All arrays of a page as one text: byte-shuffled, compressed, base64.

TYPES = {"<f4": "f4", "<f8": "f8", "<u2": "u2", "<u4": "u4", "|u1": "u1"}
LEVEL = 6


class Blob:
    """Arrays that the page reads by number; equal ones are kept once.

    Bytes of the same significance stand together (first bytes of all numbers, then second bytes,
    ...), which halves the compressed size of smooth histories.
    """

    def __init__(self) -> None:
        self.index: list[dict[str, object]] = []
        self._known: dict[bytes, int] = {}
        self._size = 0  # bytes before compression
        self._squeeze = zlib.compressobj(LEVEL, zlib.DEFLATED, 31)  # gzip without a time
        self._packed = b""  # what the compression has given up to now

    def add(self, values: Array | IntArray, kind: str = "<f4") -> int:
        """Add an array as numbers of a kind (a key of TYPES); return its number."""
        array = np.ascontiguousarray(values, dtype=np.dtype(kind))
        raw = array.reshape(-1).view(np.uint8).reshape(-1, array.dtype.itemsize).T.tobytes()
        key = hashlib.sha256(repr((kind, array.shape)).encode() + raw).digest()
        if key not in self._known:
            self._known[key] = len(self.index)
            self.index.append({"type": TYPES[kind], "shape": array.shape, "at": self._size})
            self._packed += self._squeeze.compress(raw)
            self._size += len(raw)
        return self._known[key]

    def text(self) -> str:
        """Return the arrays as base64 of a gzip stream without time and name."""
        data = self._packed + self._squeeze.copy().flush()
        return base64.b64encode(data).decode("ascii")

    def mark(self) -> Callable[[], None]:
        """Return a function that takes out what is added from now on."""
        index, known = list(self.index), dict(self._known)
        size, squeeze, packed = self._size, self._squeeze.copy(), self._packed

        def undo() -> None:
            self.index, self._known = index, known
            self._size, self._squeeze, self._packed = size, squeeze, packed

        return undo


def json_for_script(value: Any) -> str:
    """Return JSON that may stand in a <script> element; NaN and infinity become null."""
    value = plain(value, finite=True)
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


# Histories of a run for the plots: signals, energies, error of their balance, violations.

NUMBERS = 350_000  # of all histories of a page; longer ones keep the extremes of intervals
FEWEST = 500  # rows of a run at least
AT_ONCE = 250_000  # rows of a history that are searched together


def histories(
    blob: Blob, result: RunResult, share: int, *, verified: bool = True
) -> dict[str, object]:
    """Add the histories of a run; return what the page needs to plot them.

    Parameters
    ----------
    blob : arrays of the page, added to
    result : results of the run
    share : numbers that this run may take
    verified : with energies, energy balance and violations of constraints
    """
    groups = {
        "signals": [(s.name, s.unit, s.description or s.name, s.values) for s in result.signals]
    }
    if verified:
        groups |= {
            "energies": [(n, "J", label, _from_start(n, result)) for n, label in WORDS.items()],
            "balance": [("balance", "-", "error of the energy balance", result.relative_balance)],
            "violations": [(n, UNITS.get(n, "-"), n, v) for n, v in result.violations.items()],
        }
    every = [np.asarray(each[3]) for group in groups.values() for each in group]
    rows = chosen_rows(every, len(result.t), max(share // (len(every) + 2), FEWEST))
    table: dict[str, object] = {
        "t": blob.add(np.asarray(result.t)[rows], "<f8"),
        "complete": len(rows) == len(result.t),
        "steps": len(result.t),
    }
    for name, group in groups.items():
        table[name] = [
            {"name": n, "unit": unit, "text": text, "values": blob.add(np.asarray(values)[rows])}
            for n, unit, text, values in group
        ]
    return table


def chosen_rows(series: list[Array], k: int, most: int) -> IntArray:
    """Return at most about `most` of k rows: all, or the extremes of every series in intervals.

    No maximum or minimum of an interval is lost, in contrast to every n-th row.

    Parameters
    ----------
    series : histories (k,)
    k : number of rows
    most : largest number of rows that are kept, about
    """
    if k <= most or not series:
        return np.arange(k)
    size = -(-k * 2 * len(series) // most)  # rows of an interval
    at_once = size * (1 + AT_ONCE // size)  # copies of a long history need no memory of its length
    kept = [np.array([0, k - 1])]
    for values in series:
        for first in range(0, k, at_once):
            part = values[first : first + at_once]
            blocks = np.full((-(-len(part) // size), size), np.nan)
            blocks.flat[: len(part)] = np.where(np.isfinite(part), part, np.nan)
            usable = np.flatnonzero(~np.isnan(blocks).all(axis=1))
            for extreme in (np.nanargmin, np.nanargmax):
                kept.append(first + usable * size + extreme(blocks[usable], axis=1))
    return np.unique(np.concatenate(kept))


def _from_start(name: str, result: RunResult) -> Array:
    values = np.asarray(result.energies[name])
    return values - values[0] if name == "potential" else values


# Scripts and styles as the page contains them, with the hashes that its policy allows.

ROOM = Path(__file__).parent
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
    "colours",
    "motion",
    "orbit",
    "plots",
    "camera",
    "gl",
    "body_gl",
    "renderer_gl",
    "renderer_2d",
    "overlay",
    "loads",
    "film",
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


def markup() -> str:
    """Return the elements of the view of the mechanism."""
    return _read(ROOM / "view.html")


def policy() -> str:
    """Return the Content-Security-Policy: nothing but the page's own script and style."""
    return (
        f"default-src 'none'; script-src {source(script())}; style-src {source(style())}; "
        "base-uri 'none'; form-action 'none'"
    )


def document(title: str, body: str, reload_s: int = 0) -> str:
    """Return a whole page, without other files or network, read again after a time [s].

    Parameters
    ----------
    title : title of the page
    body : its content as HTML
    reload_s : time after which the page is read again [s]; 0: never
    """
    again = f"<meta http-equiv='refresh' content='{reload_s}'>" if reload_s else ""
    return (
        "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
        f'<meta http-equiv="Content-Security-Policy" content="{policy()}">'
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"{again}<title>{escape(title)}</title><style>{style()}</style></head>\n"
        f"<body>{body}</body></html>\n"
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
