"""Keys of beams in a case file; beams from a CSV file of places, twist, stiffness and mass."""

import csv
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo, model_validator

from ....errors import nearest
from ....math.arrays import Array, is_positive_definite
from ....math.laws import lengths_along
from ....package.specification import MassForm, Theory
from ...common.input_table import FilePath, Name, Pair, Table, Vector, entry, optional, usable_path
from ...common.text_file import numbered_lines
from .bodies import DEFAULT_PLACE, Flexible, Modes
from .laws import FOLDER, RESOLVED

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
        slope = self._curve(self.parameter(s), 1)
        return np.asarray(slope / np.linalg.norm(slope, axis=1, keepdims=True))


UPPER = [(i, j) for i in range(6) for j in range(i, 6)]
PLACES = ("x_m", "y_m", "z_m")
TWIST = "twist_deg"
TRAPEZE = tuple(f"A{i + 1}" for i in range(6))
COLUMNS = (*PLACES, TWIST, *(f"{letter}{i + 1}{j + 1}" for letter in "KM" for i, j in UPPER))
REPLACED = ("length", "line", "twist_deg", "section", "stations", "material", "ply_angle_deg")


def with_beam_table(data: dict[str, object], folder: Path) -> dict[str, object]:
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
    file = folder / str(data["table"])
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
    rows: list[list[float]] = matrix.tolist()
    return rows


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
            raise ValueError(f"{file}: column {one!r} occurs twice")
    wanted = known if set(head) & set(TRAPEZE) else COLUMNS
    if missing := [name for name in wanted if name not in head]:
        raise ValueError(f"{file}: column {missing[0]!r} is missing; expected {', '.join(wanted)}")


SYMMETRY = 1e-6  # of sqrt(A_ii A_jj): matrices may be given to six digits
Rows = list[list[float]]


def _symmetric(rows: Rows) -> Rows:
    """Return a symmetric 6x6; raises ValueError for another one."""
    if [len(row) for row in rows] != [6] * 6:
        raise ValueError("expected six rows of six numbers")
    matrix = np.array(rows)
    size = np.sqrt(np.abs(np.diagonal(matrix)))
    gap = np.abs(matrix - matrix.T) - SYMMETRY * np.outer(size, size)
    if gap.max() > 0.0:
        i, j = (int(k) for k in np.unravel_index(np.argmax(gap), gap.shape))
        raise ValueError(
            f"expected a symmetric matrix, found {matrix[i, j]:g} in row {i + 1}, column {j + 1} "
            f"and {matrix[j, i]:g} in row {j + 1}, column {i + 1}"
        )
    even: Rows = (0.5 * (matrix + matrix.T)).tolist()
    return even


def _definite(rows: Rows) -> Rows:
    if not is_positive_definite(np.array(rows)):
        raise ValueError("expected a positive definite matrix")
    return rows


Symmetric = Annotated[Rows, AfterValidator(_symmetric)]
Stiffness = Annotated[Symmetric, AfterValidator(_definite)]


class BeamInterface(Table):
    """`[bodies.NAME.interfaces.NAME]` of a beam: a node where joints, masses and signals attach."""

    at: Literal["start", "end"] | Annotated[float, Field(ge=0, le=1)] = entry(
        '"start", "end", or fraction of the length; the mesh gets a node there'
    )


class BeamLine(Table):
    """`line` of a beam: a circular arc, a spline through points, or given nodes.

    An arc has the given `length` and begins along body x. A spline and nodes have a length.
    """

    one_of = ("arc_deg", "points", "nodes")

    arc_deg: float | None = optional("angle of an arc: the tangent turns by it about `axis`", "deg")
    axis: Vector = entry("axis of an arc in the body frame, normal to x", "-", [0.0, 0.0, 1.0])
    points: list[Vector] | None = optional(
        "of a cubic spline, in the body frame", "m", min_length=2
    )
    nodes: list[Vector] | None = optional(
        "of straight elements, in the body frame; interfaces and stations take the nearest",
        "m",
        min_length=2,
    )
    x2_axes: list[Vector] | None = optional(
        "with nodes: direction of the section's x2 in each element; its part normal to the "
        "element counts",
        "-",
        min_length=1,
    )

    @model_validator(mode="after")
    def _one_of_three(self) -> "BeamLine":
        if (self.nodes is None) != (self.x2_axes is None):
            raise ValueError("expected nodes and x2_axes together")
        return self


class BeamStation(Table):
    """One entry of `stations` of a beam: another section along it, or its matrices."""

    at: float = entry("fraction of the length")
    section: Name | None = optional("name of a section; absent: `stiffness` and `mass`")
    stiffness: Stiffness | None = optional(
        "6x6 of a section of your own (docs/conventions.md), about the line", "N, N m, N m2"
    )
    mass: Symmetric | None = optional(
        "6x6 per length, of velocities along and rates about the section axes", "kg/m, kg, kg m"
    )
    trapeze: list[float] = entry(
        "with them: strains of a section twisted by 1 rad/m, times -2; the tension of a spinning "
        "beam stiffens torsion by them",
        "m2, m",
        [0.0] * 6,
        min_length=6,
        max_length=6,
    )
    material: Name | None = optional("absent: that of the body")
    ply_angle_deg: float | None = optional("absent: that of the body", "deg", ge=-90, le=90)

    @model_validator(mode="after")
    def _section_or_matrices(self) -> "BeamStation":
        given = [key for key in ("stiffness", "mass") if getattr(self, key) is not None]
        if len(given) != (2 if self.section is None else 0):
            raise ValueError("expected either `section` or `stiffness` and `mass`")
        return self


class BeamBody(Flexible):
    """`[bodies.NAME]` with kind = "beam": from the origin along body x, or along `line`."""

    kind: Literal["beam"]
    length: float | None = optional(
        "length along the beam; required, except for a line of points or nodes, which has a length",
        "m",
        gt=0,
    )
    line: BeamLine | None = optional(
        "curved reference line: an arc, a spline through points, or given nodes; absent: straight"
        " along x"
    )
    twist_deg: list[Pair] = entry(
        "pairs of a fraction of the length and the rotation of the section there about the line; "
        "linear between them",
        "deg",
        [],
    )
    table: FilePath | None = optional(
        "instead of length, line, twist_deg, section and stations: a CSV file with places, twist,"
        " 6x6 stiffness and mass along the beam (docs/blade.md), relative to the case file; "
        "`elements` then has a default of two between stations"
    )
    section: Name | None = optional(
        "name of a section; with `stations`, of the one at the start; required without `table`"
    )
    stations: list[BeamStation] = entry(
        "other sections along the beam; stiffness and mass are linear between them", default=[]
    )
    segments: int = entry(
        "number of equal bodies, joined to each other, that form the beam, for large elastic "
        "rotations (docs/stiffening.md); `modes` are those of each",
        default=1,
        ge=1,
        le=500,
    )
    material: Name | None = optional(
        "name of a material; required by a shape, absent with a described section"
    )
    ply_angle_deg: float | None = optional(
        "fibre direction from x1 towards x2 about the outward normal x3, in solid shapes; absent:"
        " 0",
        "deg",
        ge=-90,
        le=90,
    )
    x2_axis: Vector = entry(
        "direction of the section's x2 (width) in the body frame; normal to x", "-", [0.0, 1.0, 0.0]
    )
    elements: int = entry(
        "beam elements along the length, of all segments", default=16, ge=1, le=2000
    )
    theory: Theory = entry(
        "strains of the beam: all six, or classical without shear (closer to a solid for "
        "vibrating wide strips with bending-twist coupling)",
        default="timoshenko",
    )
    part_of: Name | None = optional(
        "of a segment, written by `check`: the body that it is a part of"
    )
    mass_form: MassForm = entry(
        "inertia from consistent mass, or lumped (the paper)", default="consistent"
    )
    modes: list[Modes] = entry(
        "which modes the solver gets, at least one; of segments, those beside the static shapes "
        "of their ends",
        default=[],
    )
    interfaces: dict[Name, BeamInterface] = entry(
        "named places; some carry the reference condition", min_length=1
    )

    @model_validator(mode="before")
    @classmethod
    def _frame_at_start(cls, data: Any) -> Any:
        """Clamp the frame to the only interface at the start if none is named root."""
        places = data.get("interfaces") if isinstance(data, dict) else None
        given = data.get("reference", {}) if isinstance(data, dict) else None
        if not isinstance(places, dict) or not isinstance(given, dict) or DEFAULT_PLACE in places:
            return data
        starts = [n for n, p in places.items() if isinstance(p, dict) and p.get("at") == "start"]
        if "at" in given or given.get("kind", "clamped") != "clamped" or len(starts) != 1:
            return data
        return {**data, "reference": {**given, "at": starts[0]}}

    @model_validator(mode="before")
    @classmethod
    def _from_table(cls, data: Any, info: ValidationInfo) -> Any:
        context = info.context or {}
        if not isinstance(data, dict) or not isinstance(data.get("table"), str):
            return data
        if context.get(RESOLVED) or (FOLDER not in context and "stations" in data):
            return data
        usable_path(data["table"])
        return with_beam_table(data, Path(context.get(FOLDER, ".")))
