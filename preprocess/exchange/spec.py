"""Form of an import file (arm.toml), and of the same table in Python (docs/exchange.md)."""

from typing import Any, Literal, NotRequired, TypedDict

from ...solver.package.specification import Attachment, LinkKind, ReferenceTable

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048}
MASSES = {
    "kg": 1.0,
    "g": 1e-3,
    "t": 1e3,
    "lb": 0.45359237,
    "slug": 14.59390293720636,
    "slinch": 175.12683524647636,  # lbf s2/in
}
TIMES = {"s": 1.0, "ms": 1e-3}


class UnitsTable(TypedDict):
    """`units` of an import file; force and stress follow, e.g. N and MPa from mm, t, s."""

    length: Literal["m", "cm", "mm", "in", "ft"]
    mass: Literal["kg", "g", "t", "lb", "slug", "slinch"]
    time: Literal["s", "ms"]


SI: UnitsTable = {"length": "m", "mass": "kg", "time": "s"}


def sizes(units: UnitsTable) -> tuple[float, float, float]:
    """Size of the units of length, mass and time [m, kg, s]."""
    return LENGTHS[units["length"]], MASSES[units["mass"]], TIMES[units["time"]]


Source = Literal[
    "matrices", "calculix", "calculix-modes", "nastran", "med", "uff", "ansys", "ansys-modes"
]


class InterfaceTable(TypedDict):
    """`[interfaces.NAME]`: nodes of one of `set`, `nodes`, `box`, and how they carry the joint."""

    link: LinkKind
    set: NotRequired[str]
    nodes: NotRequired[list[int]]
    box: NotRequired[list[list[float]]]
    weights: NotRequired[Literal["equal", "area"]]
    position: NotRequired[list[float]]
    rotation_deg: NotRequired[list[float]]


class Vibrations(TypedDict):
    """The lowest vibration modes."""

    kind: Literal["lowest"]
    count: int


class Reduction(TypedDict):
    """What becomes of the matrices: the part of an import file that is not about files."""

    body: str
    reference: ReferenceTable
    modes: list[Vibrations | Attachment]
    interfaces: dict[str, InterfaceTable]
    units: UnitsTable
    total_mass: NotRequired[float]
    damping_ratio: NotRequired[float]


class ImportFile(Reduction):
    """The whole file; `from` is a word of Python, so the table is written as a dictionary."""

    format: Literal[1]
    files: dict[str, Any]


ImportFile.__annotations__["from"] = NotRequired[Source]
