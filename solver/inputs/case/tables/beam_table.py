"""A beam from a CSV file: places on its line, a spline through them, twist, stiffness, mass."""

import csv
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import nearest
from ....math.arrays import Array
from ....math.curves import lengths_along
from ...common.text_file import numbered_lines

FINE = 2000  # steps of a spline through points, at least


class Spline:
    """A curve through points.

    Attributes
    ----------
    knots : (k,) places of the points along the polygon through them [m]
    u : (n,) fine division of the same parameter, with all knots
    along : (n,) length of the curve up to there [m]
    tangents : (n, 3) unit vectors
    """

    def __init__(self, points: Array) -> None:
        from scipy.interpolate import CubicSpline  # 0.3 s: only for lines through points

        self.knots = lengths_along(points)
        self._curve = CubicSpline(self.knots, points)
        parts = max(FINE // (len(self.knots) - 1), 20)
        first, last = self.knots[:-1], self.knots[1:]
        u = np.append(np.linspace(first, last, parts, endpoint=False).T.ravel(), last[-1])
        speed = np.linalg.norm(self._curve(u, 1), axis=1)
        middle = np.linalg.norm(self._curve(0.5 * (u[:-1] + u[1:]), 1), axis=1)
        steps = np.diff(u) * (speed[:-1] + 4.0 * middle + speed[1:]) / 6.0  # Simpson
        self.u, self.along = u, np.concatenate([[0.0], np.cumsum(steps)])
        self.tangents = self._curve(u, 1) / speed[:, None]
        self._inverse = CubicSpline(self.along / self.along[-1], u)

    @property
    def length(self) -> float:
        """Length of the curve [m]."""
        return float(self.along[-1])

    @property
    def fractions(self) -> Array:
        """Places of the points as fractions of the length, (k,)."""
        return np.asarray(self.along[np.searchsorted(self.u, self.knots)] / self.along[-1])

    def parameter(self, s: Array) -> Array:
        """Parameter at fractions of the length (m,)."""
        return np.asarray(self._inverse(s))

    def place(self, s: Array) -> Array:
        """Positions (m, 3) at fractions of the length [m]."""
        return np.asarray(self._curve(self.parameter(s)))

    def tangent(self, s: Array) -> Array:
        """Unit tangents (m, 3) at fractions of the length."""
        found = self._curve(self.parameter(s), 1)
        return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


UPPER = [(i, j) for i in range(6) for j in range(i, 6)]
PLACES = ("x_m", "y_m", "z_m")
TWIST = "twist_deg"
TRAPEZE = tuple(f"A{i + 1}" for i in range(6))
COLUMNS = (*PLACES, TWIST, *(f"{letter}{i + 1}{j + 1}" for letter in "KM" for i, j in UPPER))
REPLACED = ("length", "line", "twist_deg", "section", "stations", "material", "ply_angle_deg")


def with_beam_table(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the table of a beam with line, twist and stations of its file `table`.

    Parameters
    ----------
    data : as the user wrote it
    folder : of the case file

    Raises
    ------
    ValueError : what is wrong with the file, or keys that it replaces.
    """
    if given := [key for key in REPLACED if data.get(key)]:
        raise ValueError(f"expected no `{given[0]}`, which the file of `table` has")
    file = folder / data["table"]
    try:
        values = _read(file)
        points = np.column_stack([values[key] for key in PLACES])
        if np.linalg.norm(np.diff(points, axis=0), axis=1).min() == 0.0:
            raise ValueError(f"{file}: two neighbouring stations have the same place")
    except ValueError as error:
        raise ValueError(f'table = "{data["table"]}": {error}') from error
    at = Spline(points).fractions
    trapeze = [values[key] for key in TRAPEZE if key in values]
    stations = [
        {
            "at": float(at[k]),
            "stiffness": _matrix(values, "K", k),
            "mass": _matrix(values, "M", k),
            "trapeze": [float(column[k]) for column in trapeze] or [0.0] * 6,
        }
        for k in range(len(at))
    ]
    return {
        "elements": 2 * (len(at) - 1),
        **data,
        "line": {"points": points.tolist()},
        "twist_deg": [[float(s), float(angle)] for s, angle in zip(at, values[TWIST], strict=True)],
        "stations": stations,
    }


def _matrix(values: dict[str, Array], letter: str, k: int) -> list[list[float]]:
    matrix = np.zeros((6, 6))
    for i, j in UPPER:
        matrix[i, j] = matrix[j, i] = values[f"{letter}{i + 1}{j + 1}"][k]
    found: list[list[float]] = matrix.tolist()
    return found


def _read(file: Path) -> dict[str, Array]:
    """Return the columns of a file, two rows or more."""
    lines = numbered_lines(file)
    table = list(csv.reader(line for _, line in lines))
    head = [name.strip() for name in table[0]] if table else []
    _check_head(file, head)
    rows = []
    for (number, _), row in zip(lines[1:], table[1:], strict=True):
        try:
            rows.append([float(word) for word in row])
        except ValueError as error:
            raise ValueError(f"{file} line {number}: {error}; expected numbers") from error
        if len(row) != len(head) or not np.isfinite(rows[-1]).all():
            raise ValueError(f"{file} line {number}: expected {len(head)} finite numbers")
    if len(rows) < 2:
        raise ValueError(f"{file}: expected two stations or more, found {len(rows)}")
    return dict(zip(head, np.array(rows).T, strict=True))


def _check_head(file: Path, head: list[str]) -> None:
    known = (*COLUMNS, *TRAPEZE)
    for name in head:
        if name not in known:
            raise ValueError(f"{file}: unknown column {name!r}{nearest(name, known)}")
    for one, two in pairwise(sorted(head)):
        if one == two:
            raise ValueError(f"{file}: column {one!r} is there twice")
    wanted = known if set(head) & set(TRAPEZE) else COLUMNS
    if missing := [name for name in wanted if name not in head]:
        raise ValueError(f"{file}: column {missing[0]!r} is missing; expected {', '.join(wanted)}")
