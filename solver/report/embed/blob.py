"""All arrays of a page as one text: byte-shuffled, compressed, base64."""

import base64
import hashlib
import json
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np

from ...math.arrays import Array, IntArray
from ...results.summary import plain

TYPES = {"<f4": "f4", "<f8": "f8", "<u2": "u2", "<u4": "u4", "|u1": "u1"}
LEVEL = 6


class Blob:
    """Arrays that the page reads by number; equal ones are kept once.

    Bytes of the same significance stand together (first bytes of all numbers, then second bytes,
    ...), which halves the compressed size of smooth histories.
    """

    def __init__(self) -> None:
        self.index: list[dict[str, Any]] = []
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
    text = json.dumps(plain(value), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
