"""What the file of a joint supplies.

A joint is one file of this folder: a kernel that fills its constraint rows, and `JOINT`, a `Joint`
that says everything else. Nothing else names it: dynamics/elements/joints/table.py finds the file,
inputs/case/tables/kinds.py makes the table of the case file from its keys,
mechanism/case_tables.py its markers and drives, signals/joints.py its coordinates.
CONTRIBUTING.md has the recipe.

Kernel
------
    @jit
    def name(rows, k, one, two, PARAMETER, ...) -> None

fills rows k, k+1, ... of `rows` (n_c, N_ROW), one for each letter of `units`. rows[i] holds, in the
columns of dynamics/model/model.py,

    0..11   C: Phidot = C (v_1, w_1, v_2, w_2) + Phi_t, velocities and angular velocities of the
            markers in global components
    PHI     the constraint [m or rad]
    PHI_T   Phi_t, its partial derivative by time; 0 unless a law enters
    GAMMA   minus the second derivative of Phi by time at zero coordinate accelerations, where
            `acceleration` and `spin_rate` are the accelerations of a marker

`one` and `two` (24,) are the motions of the markers on the first and second place
(dynamics/model/motion.py: place, velocity, acceleration, axis, spin, spin_rate), all in global
components and SI units. joints/rows.py has the usual building blocks.

Markers: z along `axis`, x along `axis_2` if the joint has one. In the given starting position both
markers have the same axes; their origins are the two places.
"""

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

from ....math.arrays import Array
from ....math.catalogue import Direction, Number, argument_names
from ....math.records import record

Rows = Callable[..., None]
Numbers = dict[str, float]
FREEDOMS = ("x", "y", "z", "about x", "about y", "about z")  # of marker two in axes of marker one
OF_ALL = ("rows", "k", "one", "two")
OF_A_LAW = ("f", "f_d", "f_dd")  # value and rates of a drive's law [rad or m, s]


@record
class Displacement:
    """Coordinate: origin of marker two along an axis of marker one [m]."""

    name: str
    axis: int
    unit = "m"
    meaning = "displacement [m] along the axes of the joint, z its `axis`"


@record
class Angle:
    """Coordinate: from axis `x` of one marker towards its axis `y`, to axis `arm` of the other."""

    name: str
    meaning: str
    frame: Literal[1, 2]  # the marker with x and y
    x: int
    y: int
    arm: int
    unit = "rad"


Coordinate = Displacement | Angle
X, Y, Z = (Displacement(name, axis) for axis, name in enumerate("xyz"))
ANGLE = Angle("angle", "angle [rad] about the axis, over any number of turns", 1, 0, 1, 0)


@record
class Constraint:
    """What joints and drives have in common."""

    kind: str  # name in tables and, of a joint, in the case file
    rows: Rows
    units: str  # of each row: d distance [m], r angle [rad]
    removes: tuple[str, ...]  # of FREEDOMS: what the rows hold whatever the position

    def __post_init__(self) -> None:
        if not self.units or set(self.units) - set("dr"):
            raise ValueError(f"{self.kind}: units = {self.units!r}: expected a d or r for each row")
        if set(self.removes) - set(FREEDOMS) or len(self.removes) > len(self.units):
            raise ValueError(f"{self.kind}: removes = {self.removes}: expected some of {FREEDOMS}")

    def _check(self, numbers: tuple[str, ...]) -> None:
        """Raise ValueError unless the kernel takes these numbers."""
        parameters = argument_names(self.rows)
        if parameters != (*OF_ALL, *numbers):
            raise ValueError(
                f"{self.kind}: its kernel takes {parameters}: expected {OF_ALL + numbers}"
            )


@record
class CouplingKind(Constraint):
    """Row of a coupling of several joints (dynamics/elements/couplings), which is filled
    elsewhere."""


@record
class Drive(Constraint):
    """Rows that prescribe a coordinate; their kernel takes f, f_d, f_dd (OF_A_LAW).

    Attributes
    ----------
    side : f(A_1, A_2, value) -> above 0 where the rows hold the coordinate itself, below 0 where
        they hold another root, from the axes (3, 3) of both markers, global components, and the
        value of the law; None: the rows have no other root
    """

    coordinate: Coordinate
    side: Callable[[Array, Array, float], float] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check(OF_A_LAW)


class DrivenBy(NamedTuple):
    """Key of the case file: the law of a drive."""

    name: str
    drive: Drive
    meaning: str  # one line

    @property
    def start(self) -> str:
        """Key of the coordinate at the start."""
        return "start_deg" if isinstance(self.drive.coordinate, Angle) else "start"


Key = Direction | Number | DrivenBy
Complete = Callable[[Mapping[str, Any], Array], Numbers]


def as_given(values: Mapping[str, Any], shift: Array) -> Numbers:
    """Return the numbers as they stand in the case file."""
    return {key: float(value) for key, value in values.items() if key != "between"}


@record
class Joint(Constraint):
    """A joint of the case file.

    Attributes
    ----------
    meaning : half a line, for docs/case-reference.md
    keys : of the case file, behind `kind` and `between`
    coordinates : that it leaves free and a signal can measure
    complete : f(values, shift) -> numbers of the kernel, from the `Number`s of the case file by
        name (None: not given), its `between`, and the way `shift` (3,) from place one to two at
        the given start, in axes of marker one [m]; the text of an InputError goes on "joints.NAME"
    derived : names of numbers of the kernel that are no keys, behind those that are; of `complete`
    order : place in the manual and in lists; those of equal order follow by name
    """

    meaning: str
    keys: tuple[Key, ...] = ()
    coordinates: tuple[Coordinate, ...] = ()
    complete: Complete = as_given
    derived: tuple[str, ...] = ()
    order: int = 100

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check(self.parameters)
        for key in self.keys:
            absent = isinstance(key, Number) and not key.required and key.default is None
            if absent and self.complete is as_given:
                raise ValueError(f"{self.kind}: {key.name} needs a default, or `complete`")

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the kernel's numbers: keys in their order, then `derived`."""
        return (*(key.name for key in self.keys if isinstance(key, Number)), *self.derived)

    @property
    def drives(self) -> dict[str, DrivenBy]:
        """Keys of its drives by name."""
        return {key.name: key for key in self.keys if isinstance(key, DrivenBy)}
