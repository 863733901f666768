"""What the file of a force element supplies.

A force element is one file of this folder: a kernel of its wrench, one of its rows in Newton's
matrix, and an `Element` or `Load` that says everything else. Nothing else names it: table.py finds
the file, inputs/case/tables/kinds.py makes the table of the case file from its keys,
mechanism/case_tables.py its markers, parameters and law. CONTRIBUTING.md has the recipe.

Markers of an `Element`: z along its key `axis` (global z without one), x along `axis_1` if it has
one; in the given starting position both markers have the same axes. Their origins are the places.

A `CoordinateForce` has no kernels: it writes its force along a coordinate of a joint, or along the
line between two places, as an expression.

A kernel of the others is compiled (`@jit`) and sees two markers as rows of model/motion.py, in
global components:

wrench(one, two, parameters, law) -> Wrench
    parameters : (N_PARAMETER,) the numbers among the keys, in their order
    law : value of the element's law at the present time [N or N m]; 0 without one

rows(one, two, parameters, rows) -> None
    What of the element Newton's iteration of the implicit integrators must know: forces
    F = k e + c edot along some directions g, edot = g v, that act as -g' F. Fills
    rows (most_rows, N_ELEMENT_ROW):
    rows[i, :12] : g by v_1, w_1, v_2, w_2 of the two markers, as in joints/rows.py
    rows[i, FORCE] : F [N, N m]
    rows[i, STIFFNESS] : dF/de [N/m, N m/rad]; 0 or above
    rows[i, DAMPING] : dF/dedot [N s/m, N m s/rad]; 0 or above
    Forces of the wrench that are no such F are loads: right, but they cost iterations, and short
    steps where they are stiff. Below half of the true stiffness Newton's iteration diverges where
    steps do not resolve the element; above it, it is slow.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any, ClassVar, NamedTuple

from ....math.arrays import Array, Triple
from ....math.catalogue import (
    Code,
    Curve,
    Direction,
    Expression,
    Expressions,
    Number,
    OfTime,
    Three,
    argument_names,
)
from ....math.records import record
from ...model.motion import DAMPING, FORCE, N_ELEMENT_ROW, STIFFNESS  # noqa: F401, of rows

Key = Direction | Number | Three | OfTime
# Entry of the values of a `CoordinateForce`: whether its coordinate is the angle (True) or the
# displacement (False) of a joint about or along the axis that it holds; None: another.
ROTATION = "rotation"
# Likewise whether the joint leaves both free, so that its contact slides along and around.
BOTH = "both"
OF_ALL = ("one", "two", "parameters")  # first arguments of the kernels


class Wrench(NamedTuple):
    """Force and moment on marker two at its origin, global components, and their energy.

    Marker one gets the opposite force at the origin of marker two, unless the element is a load
    from outside.
    """

    force: Triple  # [N]
    moment: Triple  # [N m]
    potential: float  # energy stored in springs [J]
    power: float  # of dampers, actuators and loads, into the system [W]


def none_in_use(parameters: Sequence[float]) -> list[int]:
    """Return the rows of a kind that is left out of Newton's matrix."""
    return []


def as_given(values: Mapping[str, Any], shift: Array) -> Mapping[str, Any]:
    """Return the numbers as they stand in the case file."""
    return values


@record(kw_only=True)
class ForceElement:
    """What all kinds have in common.

    Attributes
    ----------
    kind : name in tables and in the case file
    meaning, remark : title and text for docs/case-reference.md; no full stop behind the title
    order : place in the manual and in lists; those of equal order follow by name
    steep : what a user can change where Newton's iteration does not converge because of this kind
    coil : whether pictures show a coil between its places
    turns : whether it has a moment about its places
    """

    kind: str
    meaning: str
    remark: str = ""
    order: int = 100
    steep: str = ""
    coil: bool = False
    turns: bool = True


class State(NamedTuple):
    """An auxiliary state of a force; expressions as in `Terms`.

    Attributes
    ----------
    name : in the expressions of the force
    rate : its rate by time; None: it is constant, but for `update`
    start : its value at the start of a run, which reads earlier states only
    scale : its size, for the tolerance of its error
    update : its value from an instant on, every `sample_time` of the force from t = 0 on; reads
        the values before it
    called : its value from such an instant on is that of the user's function of the expressions
        of the force; 0 before
    level, upwards : it takes `update` when the coordinate passes this level in this direction, an
        instant that is located; None: every `sample_time`
    """

    name: str
    rate: str | None
    start: str = "0"
    scale: float = 1.0
    update: str | None = None
    called: bool = False
    level: float | None = None
    upwards: bool = True


@record
class Terms:
    """A force as expressions (math/expressions/parse.py).

    They read the coordinate `x` [m, rad], its rate `v`, the keys of the kind by name (a curve as a
    function), `states`, earlier `names`, and the time `t`. Along a coordinate of a joint that has a
    `ROTATION` they read its reaction on the second place too, drives left out: `radial` and
    `axial` force [N], `bending` and `twisting` moment about that place [N m], across and along the
    axis of the joint, all of them 0 or above. With `BOTH` they read `other` too, the
    rate of z for a force along the angle, that of the angle for a force along z.

    Attributes
    ----------
    force : that pushes the coordinate up [N, N m]
    friction : of a `Contact`, along each direction of sliding, of which it reads the rate `slip`
        [m/s]; `slip_squared` is the square of the whole [m2/s2]; "": none
    names : parts of the others, by name
    states : auxiliary states
    """

    force: str
    names: Mapping[str, str] = field(default_factory=dict)
    states: tuple[State, ...] = ()
    friction: str = ""


@record(kw_only=True)
class CoordinateForce(ForceElement):
    """A force along a coordinate of a joint, or along the line between two places.

    Newton's matrix and the energy balance follow from the expression; its work counts as work done
    on the system.

    Attributes
    ----------
    keys : of the case file, behind `joint`, `coordinate`, `between` and `kind`
    terms : f(values) -> the force, from numbers, texts and curves of the case file by key (None:
        not given), and `ROTATION`; the text of an InputError goes on "forces.NAME"
    """

    keys: tuple[Number | Expression | Expressions | Curve | Code, ...]
    terms: Callable[[Mapping[str, Any]], Terms]


@record(kw_only=True)
class Contact(CoordinateForce):
    """A contact of a sphere about the second place with a plane or a sphere at the first.

    Its keys are `between`, `axis`, `radius`, `other_radius` and its own. The coordinate is the
    height of the centre over the plane, or the distance of the centres. Friction acts along the
    slip of the surfaces where they touch (`Terms`).
    """


@record(kw_only=True)
class KernelForce(ForceElement):
    """An element or a load, whose wrench is a kernel."""

    wrench: Callable[..., Any]

    def __post_init__(self) -> None:
        _check(self.kind, "wrench", self.wrench)


@record(kw_only=True)
class Load(KernelForce):
    """A load from outside at one place; nothing acts back.

    Its keys are `at`, `direction`, `frame` and `law`. Its parameters are the unit vector along
    `direction`, in axes of marker one: the ground, or the place itself if `frame` is "following".
    """

    parameters: ClassVar[tuple[str, ...]] = ("direction x", "direction y", "direction z")


@record(kw_only=True)
class Element(KernelForce):
    """An element between two places.

    Attributes
    ----------
    keys : of the case file, behind `between` and `kind`; the numbers among them, in their order,
        are the parameters of the kernels
    complete : f(values, shift) -> numbers by key, from those of the case file (None: not given),
        its `between`, and the way `shift` (3,) from place one to two at the given start, in axes
        of marker one [m]; the text of an InputError goes on "forces.NAME"
    acts_by : keys of which a case must give one that is not zero; none: whatever it gives
    rows : kernel; None: left out of Newton's matrix
    most_rows : that the kernel fills
    rows_in_use : of an element, by its parameters
    """

    keys: tuple[Key, ...]
    complete: Callable[[Mapping[str, Any], Array], Mapping[str, Any]] = as_given
    acts_by: tuple[str, ...] = ()
    rows: Callable[..., Any] | None = None
    most_rows: int = 0
    rows_in_use: Callable[[Sequence[float]], list[int]] = none_in_use

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rows is not None:
            _check(self.kind, "rows", self.rows)
        if (self.rows is None) != (self.most_rows == 0):
            raise ValueError(f"{self.kind}: expected `rows` and `most_rows`, or neither")
        if len(self.laws) > 1:
            raise ValueError(f"{self.kind}: laws {self.laws}: expected one at most")
        if set(self.acts_by) - {key.name for key in self.keys}:
            raise ValueError(f"{self.kind}: acts_by = {self.acts_by}: expected some of its keys")

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the kernels' numbers, in SI units."""
        return tuple(name for key in self.keys for name in _names(key))

    @property
    def laws(self) -> tuple[str, ...]:
        """Keys that are laws of time: none, or one."""
        return tuple(key.name for key in self.keys if isinstance(key, OfTime))

    def numbers(self, values: Mapping[str, Any], shift: Array) -> tuple[float, ...]:
        """Return the parameters of an element with these keys; see `complete`."""
        complete = self.complete(values, shift)
        flat: list[float] = []
        for key in self.keys:
            if isinstance(key, Number):
                flat.append(float(complete[key.name]))
            elif isinstance(key, Three):
                flat += [float(value) for value in complete[key.name]]
        return tuple(flat)


def _names(key: Key) -> list[str]:
    if isinstance(key, Number):
        return [key.name]
    return [f"{key.name} {axis}" for axis in "xyz"] if isinstance(key, Three) else []


def _check(kind: str, what: str, kernel: Callable[..., Any]) -> None:
    """Raise ValueError unless a kernel takes four arguments."""
    parameters = argument_names(kernel)
    if parameters[:3] != OF_ALL or len(parameters) != len(OF_ALL) + 1:
        raise ValueError(f"{kind}: its {what} takes {parameters}: expected {OF_ALL} and one more")
