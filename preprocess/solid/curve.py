"""A curve that fibres follow: straight pieces with the tangents at their ends."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...solver.errors import nearest
from ...solver.math.arrays import Array
from .errors import SolidError

AT_ONCE = 200_000  # points whose nearest piece is sought at a time
SAME = 1e-9  # distance of two ends that are one, relative to the size of the curve


class Curve:
    """Pieces (s, 2, 3) of a curve [m]; the tangent at a common end is the mean of both pieces."""

    def __init__(self, pieces: Array) -> None:
        self._start, self._along = pieces[:, 0], pieces[:, 1] - pieces[:, 0]
        self._square = (self._along**2).sum(axis=1)
        size = float(np.ptp(pieces.reshape(-1, 3), axis=0).max())
        ends = np.round(pieces.reshape(-1, 3) / (SAME * size))
        _, row = np.unique(ends, axis=0, return_inverse=True)
        tangents = np.zeros((row.max() + 1, 3))
        np.add.at(tangents, row.ravel(), np.repeat(self._along, 2, axis=0))
        self._ends = (tangents / np.linalg.norm(tangents, axis=1)[:, None])[row.reshape(-1, 2)]

    @classmethod
    def of(cls, table: Mapping[str, Any], curves: Mapping[str, Array], where: str) -> "Curve":
        """A curve by `points`, or by `at`, the name of one of `curves`. Raises SolidError."""
        if "at" in table:
            if table["at"] not in curves:
                raise SolidError(
                    f'{where}.at = "{table["at"]}": the mesh has no physical curve of this name'
                    f"{nearest(table['at'], curves)}; CAD files have none: expected points"
                )
            pieces = curves[table["at"]]
        else:
            points = np.array(table["points"], dtype=float)
            pieces = np.stack([points[:-1], points[1:]], axis=1)
        if not len(pieces) or not (np.ptp(pieces, axis=1).max(axis=1) > 0.0).all():
            raise SolidError(f"{where}: expected two or more different points, one after the other")
        return cls(pieces)

    def tangents(self, x: Array) -> Array:
        """Unit tangents at the points of the curve nearest to x (..., 3)."""
        flat = x.reshape(-1, 3)
        parts = [self._tangents(flat[i : i + AT_ONCE]) for i in range(0, len(flat), AT_ONCE)]
        return np.concatenate([np.zeros((0, 3)), *parts]).reshape(x.shape)

    def _tangents(self, x: Array) -> Array:
        best, piece, at = np.full(len(x), np.inf), np.zeros(len(x), dtype=int), np.zeros(len(x))
        for k, (start, along) in enumerate(zip(self._start, self._along, strict=True)):
            share = np.clip((x - start) @ along / self._square[k], 0.0, 1.0)
            distance = ((x - start - share[:, None] * along) ** 2).sum(axis=1)
            nearer = distance < best
            best[nearer], piece[nearer], at[nearer] = distance[nearer], k, share[nearer]
        one, other = self._ends[piece, 0], self._ends[piece, 1]
        tangent = (1.0 - at)[:, None] * one + at[:, None] * other
        return np.asarray(tangent / np.linalg.norm(tangent, axis=1, keepdims=True))
