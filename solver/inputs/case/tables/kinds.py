"""Tables of joints, couplings and forces of a case, made from the keys of their kinds."""

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, Union

from pydantic import BeforeValidator, ConfigDict, Field, create_model, model_validator

from ....dynamics.elements.couplings.contract import Coupling
from ....dynamics.elements.couplings.table import COUPLINGS
from ....dynamics.elements.forces.contract import (
    Contact,
    CoordinateForce,
    Element,
    ForceElement,
    Load,
)
from ....dynamics.elements.forces.table import FORCES
from ....dynamics.elements.joints.contract import FREEDOMS, Angle, Coordinate, DrivenBy, Joint
from ....dynamics.elements.joints.table import JOINTS
from ....math.catalogue import Number
from ...common.input_table import Axis, Name, Table, entry, optional
from .laws import LoadLaw, field_of
from .signals import JointCoordinate

Kind = TypeVar("Kind", bound=Table)
Two = Annotated[list[str], Field(min_length=2, max_length=2)]  # places
ALONG = "m or rad"  # unit of keys that are lengths or angles, as the coordinate of a force is
CURVE = "force_displacement.x"
START = (
    "coordinate at the start, from the given positions: bodies are moved so that the joints close "
    "with it; without a drive of it. With solver.start = equilibrium the search begins there"
)


def table_of(base: type[Kind], group: str, kind: Joint | Coupling | ForceElement) -> type[Kind]:
    """Return the table `[group.NAME]` of one kind: the keys of `base` and its own ones.

    Parameters
    ----------
    base : keys that all kinds of the group have
    group : name of the group, as "joints"
    kind : the kind
    """
    remark = getattr(kind, "remark", "")
    text = f'`[{group}.NAME]` with kind = "{kind.kind}": {kind.meaning}.'
    name = f"{kind.kind.title().replace('_', '')}{group.removesuffix('s').title()}"
    own: dict[str, Any] = {"kind": (Literal[kind.kind], ...)}
    for key in getattr(kind, "keys", ()):
        own[key.name] = field_of(key)
        if isinstance(key, DrivenBy):
            unit = "deg" if key.start == "start_deg" else "m"
            own[key.start] = (float | None, optional(START, unit))
    return create_model(
        name, __base__=base, __doc__=f"{text}\n\n{remark}" if remark else text, **own
    )


class JointTable(Table):
    """Keys of every joint."""

    between: Two = entry(
        'two places: "BODY.INTERFACE" or "ground.POINT"; motion is that of the second relative to'
        " the first"
    )
    kind: str


class FreeJoint(Table):
    """`[joints.NAME]` with `free` in place of `kind`: a joint by the directions left free.

    It is the kind of joint with these freedoms and its `axis`, and takes the other keys of this
    kind: free = ["rz"] is a revolute joint about z, ["x", "rx"] a cylindrical one along x.
    """

    model_config = ConfigDict(extra="allow")

    between: Two = entry("two places, as of every joint")
    free: list[Literal["x", "y", "z", "rx", "ry", "rz"]] = entry(
        "displacements along and rotations about global directions at the start"
    )


def by_freedoms(table: Any) -> Any:
    """Return the table of a joint with the kind and the axis that its key `free` asks for.

    Raises
    ------
    ValueError : no kind of joint has these freedoms.
    """
    if not isinstance(table, dict) or "free" not in table or "kind" in table:
        return table
    free, known = table["free"], ("x", "y", "z", "rx", "ry", "rz")
    if not isinstance(free, list) or any(each not in known for each in free):
        listed = f' in a list: ["{free}"]' if isinstance(free, str) else ""
        raise ValueError(f"free = {free}: expected some of {', '.join(known)}{listed}")
    if "axis" in table:
        raise ValueError("expected no `axis` with `free`, which are global directions")
    for axis, order in enumerate(("yzx", "zxy", "xyz")):  # the last one is that of the joint
        local = {"about " * (len(d) - 1) + "xyz"[order.index(d[-1])] for d in free}
        for joint in JOINTS.values():
            whole = len(joint.removes) == len(joint.units)
            if whole and set(FREEDOMS) - set(joint.removes) == local:
                own: dict[str, object] = {"kind": joint.kind}
                if any(key.name == "axis" for key in joint.keys):
                    own["axis"] = [float(k == axis) for k in range(3)]
                return {**{k: v for k, v in table.items() if k != "free"}, **own}
    raise ValueError(
        f"free = {free}: no joint leaves just these free; expected none, one rotation or "
        "displacement, both along one axis, rx, ry, rz with or without one displacement, or two "
        "displacements and the rotation across them"
    )


def lengths_along(force: Any, joints: Mapping[str, Any]) -> list[str]:
    """Return the keys of a force, as a user wrote it, that are lengths as its coordinate is one."""
    kind = force.get("kind") if isinstance(force, dict) else None
    known = FORCES.get(kind) if isinstance(kind, str) else None
    if not isinstance(known, CoordinateForce):
        return []
    keys = [key.name for key in known.keys if isinstance(key, Number) and key.unit == ALONG]
    return [*keys, CURVE] if _is_along_length(force, joints) else []


def _is_along_length(force: Mapping[str, Any], joints: Mapping[str, Any]) -> bool:
    if force.get("between") is not None:
        return True
    return any(
        not isinstance(each, Angle) and (force.get("coordinate") or each.name) == each.name
        for each in coordinates_of(joints.get(str(force.get("joint"))))
    )


def coordinates_of(joint: Any) -> tuple[Coordinate, ...]:
    """Return the coordinates of a joint in the form of a case file; none if there is no such."""
    with suppress(ValueError):  # which is said of the joint
        joint = by_freedoms(joint)
    known = JOINTS.get(str(joint.get("kind"))) if isinstance(joint, dict) else None
    return known.coordinates if known else ()


JOINT_TABLES = tuple(table_of(JointTable, "joints", joint) for joint in JOINTS.values())
if TYPE_CHECKING:
    CaseJoint = JointTable
else:
    CaseJoint = Annotated[
        Annotated[Union[(*JOINT_TABLES,)], Field(discriminator="kind")],
        BeforeValidator(by_freedoms, json_schema_input_type=Union[(*JOINT_TABLES, FreeJoint)]),
    ]


class CouplingTable(Table):
    """Keys of every coupling."""

    joints: list[Name] = entry("names of two joints", min_length=2, max_length=2)
    coordinates: list[JointCoordinate] | None = optional(
        "of these joints; absent: the only rotation or displacement that each has",
        min_length=2,
        max_length=2,
    )
    kind: str


COUPLING_TABLES = tuple(table_of(CouplingTable, "couplings", c) for c in COUPLINGS.values())
if TYPE_CHECKING:
    CaseCoupling = CouplingTable
else:
    CaseCoupling = Annotated[Union[(*COUPLING_TABLES,)], Field(discriminator="kind")]


class ElementTable(Table):
    """Keys of every element between two places."""

    between: Two = entry('two places: "BODY.INTERFACE" or "ground.POINT"')
    kind: str


class LoadTable(Table):
    """Keys of every load from outside."""

    at: str = entry('"BODY.INTERFACE"')
    direction: Axis = entry("at the start, global; only the direction counts", "-")
    frame: Literal["global", "following"] = entry(
        "the direction is fixed, or rotates with the interface", default="global"
    )
    law: LoadLaw = entry("magnitude over time, along the direction")
    kind: str


class CoordinateTable(Table):
    """Keys of every force along a coordinate."""

    one_of = ("joint", "between")

    joint: Name | None = optional("the joint whose coordinate it acts along; or `between`")
    coordinate: JointCoordinate | None = optional("of the joint; absent: the only one that it has")
    between: Two | None = optional(
        "in place of `joint`, two places: the coordinate is their distance"
    )
    kind: str

    @model_validator(mode="after")
    def _one_coordinate(self) -> "CoordinateTable":
        if self.coordinate is not None and self.joint is None:
            raise ValueError("expected `coordinate` with `joint` only")
        return self


class ContactTable(Table):
    """Keys of every contact of a sphere with a plane or a sphere."""

    between: Two = entry(
        'two places: "BODY.INTERFACE" or "ground.POINT"; the first one is in the plane or the '
        "centre of a sphere, the second one the centre of a sphere"
    )
    axis: Axis | None = optional(
        "normal of the plane at the start, global, towards the sphere; fixed in the first place; "
        "absent: z",
        "-",
    )
    radius: float = entry("of the sphere at the second place; 0: a point", "m", default=0.0, ge=0)
    other_radius: float | None = optional(
        "of a sphere at the first place; absent: a plane", "m", gt=0
    )
    disc_axis: Axis | None = optional(
        "axis at the start, global, of a thin disc about the second place, whose rim touches the "
        "plane; absent: a sphere",
        "-",
    )
    kind: str


ForceTable = ElementTable | LoadTable | CoordinateTable | ContactTable


BASES: dict[type, Any] = {
    Element: ElementTable,
    Load: LoadTable,
    CoordinateForce: CoordinateTable,
    Contact: ContactTable,
}
FORCE_TABLES = tuple(table_of(BASES[type(force)], "forces", force) for force in FORCES.values())
if TYPE_CHECKING:
    CaseForce = ForceTable
else:
    CaseForce = Annotated[Union[(*FORCE_TABLES,)], Field(discriminator="kind")]
