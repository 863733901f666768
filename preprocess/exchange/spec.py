"""Form of an import file (arm.toml), and of the same table in Python (docs/exchange.md)."""

from typing import Any, Literal, NotRequired, TypedDict

from ...solver.package.body.specification import Attachment, LinkKind, ReferenceTable
from .units import UnitsTable

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
