"""Specification of a body: build/<case>/bodies/<name>.json, from the case to the preprocessor.

`plymotion check` writes a complete file: every value is checked and every default is filled in. The
preprocessor checks keys and types only (`check_form`). SI units and degrees.

    {"body": "arm", "kind": "beam", "length": 0.545, "elements": 16,
     "x2_axis": [0.0, 1.0, 0.0],                 section's x2 in body axes
     "section": {...},                           see preprocess/section/section_analysis.py
     "theory": "timoshenko",                     or "classical": without shear
     "mass_form": "consistent",                  or "lumped": of modes and invariants
     "reference": {"kind": "clamped", "at": "root"},    or chord (two places), mean-axis (none)
     "modes": [{"kind": "bending-xy", "count": 4},
               {"kind": "attachment", "at": "mid", "directions": ["y"]},
               {"kind": "static-axial"}],
     "damping_ratio": 0.0,
     "interfaces": {"root": {"at": "start"}, "mid": {"at": 0.5}, "tip": {"at": "end"}}}

A curved or twisted beam has its nodes, a tapered beam the sections of its stations. `length` and
fractions of it are then along the line, `elements` counts those of the line, and `x2_axis` and
`section` are those at the start:

     "line": {"nodes": [[0, 0, 0], ...], "x2_axes": [[0, 1, 0], ...]},
     "stations": [{"at": 0.0, "section": {...}}, {"at": 1.0, "section": {...}}]

    {"body": "hand", "kind": "shell",
     "shell": {"mesh": {...}, "materials": {...}, "laminates": {...}, "regions": {...},
               "elements": {...}, "stiffeners": {...}},  see preprocess/shell/model/shell_problem.py
     "mass_form": ..., "reference": ..., "modes": ..., "damping_ratio": ...,
     "interfaces": {"root": {"at": "left edge", "link": "rigid", "rotation_deg": [0, 0, 0]},
                    "tip": {"at": "right edge", "link": "average", "position": [0.7, 0.0, 0.0],
                            "rotation_deg": [0.0, 0.0, 90.0]}}}

    {"body": "arm", "kind": "imported", "file": "cases/x/arm.toml", "table": {...},
     "sha256": {"arm.inp": "..."}}                see preprocess/exchange/import_table.py

    {"body": "bracket", "kind": "solid",
     "solid": {"mesh": {"file": "bracket.step", "size": 0.004}, "materials": {...},
               "regions": {"all": {"material": "aluminium"}}},    see preprocess/solid/solid_mesh.py
     "reference": ..., "modes": ..., "damping_ratio": ...,
     "interfaces": {"root": {"bore": {"radius": 0.005, "point": [0, 0, 0], "direction": [0, 0, 1]},
                             "link": "rigid", "rotation_deg": [0, 0, 0]},
                    "tip": {"plane": {"point": [0.1, 0, 0], "normal": [1, 0, 0]}, ...},
                    "lug": {"at": "named face", ...}}}

A beam or shell with `"design": {"a": [{"of": "section.regions.wall.plies.0.angle_deg"}]}` has
the derivatives by the parameter a in its package; the specification has the values at which they
are taken. `"design_without": ["stresses", "second_order", "ply_axes"]` of a beam leaves out those
of the stresses in its sections, most of the file, of the terms of second order, or of the axes of
plies, in which stresses are given.

A shell's or solid's body axes are those of its mesh. `inputs_sha256` and `case` may be added; they
go to the provenance of the package. `"candidates": true` of a beam or shell: a plan of
`[fidelity]` takes some of the modes, so the package has no remarks on modes that were requested.
`"errors": true` of a beam: the package has the errors of its stiffness by mesh and sections.
"""

from collections.abc import Mapping
from typing import Any, Literal, NotRequired, TypedDict, get_args

from ..math.disk_cache import sources_sha256
from .common.plain_data import inputs_sha256

FORMAT_VERSION = (1, 6)  # of the modal package that is made from it
Theory = Literal["timoshenko", "classical"]
MassForm = Literal["consistent", "lumped"]
ReferenceKind = Literal["clamped", "chord", "mean-axis"]
ModeKind = Literal["lowest", "bending-xy", "bending-xz", "torsion", "axial"]
ShellModeKind = Literal["lowest", "bending-xy", "bending-xz", "axial"]
SpinningKind = Literal["spinning-xy", "spinning-xz"]
Direction = Literal["x", "y", "z", "rx", "ry", "rz"]  # along and about the body axes
LinkKind = Literal["rigid", "average"]
ShellLinkKind = Literal["rigid", "average", "section"]

CAD_WITH_UNIT = (".step", ".stp", ".iges", ".igs")  # files that have a unit of length
CAD = (*CAD_WITH_UNIT, ".brep")
DIRECTIONS: tuple[Direction, ...] = get_args(Direction)
SHELL_LINK_KINDS: tuple[ShellLinkKind, ...] = get_args(ShellLinkKind)


class ReferenceTable(TypedDict):
    """Reference condition: the body frame at one interface, two, or none."""

    kind: ReferenceKind
    at: NotRequired[str | list[str]]


class Eigenmodes(TypedDict):
    """The lowest vibration modes of a kind."""

    kind: ModeKind
    count: int


class ShellEigenmodes(TypedDict):
    """The same of a shell: the kind is the main direction of motion; there is no torsion."""

    kind: ShellModeKind
    count: int


class Attachment(TypedDict):
    """Static shapes under unit loads at an interface; without `directions` all six."""

    kind: Literal["attachment"]
    at: str
    directions: NotRequired[list[Direction]]


class StaticAxial(TypedDict):
    """The static shape under a load that increases along the body."""

    kind: Literal["static-axial"]


class StaticInertia(TypedDict):
    """The static shapes under the inertia loads of rigid accelerations, six."""

    kind: Literal["static-inertia"]


class SpinningModes(TypedDict):
    """Static shapes of a spinning beam."""

    kind: SpinningKind
    count: int


class LineTable(TypedDict):
    """The nodes of a curved or twisted beam, and x2 of the section in each element, body axes.

    Only the part of an axis normal to its element counts.
    """

    nodes: list[list[float]]
    x2_axes: list[list[float]]


class PlyTable(TypedDict):
    """A ply of a section or shell; of a section without thickness: an equal share of the wall."""

    material: str
    angle_deg: float
    thickness: NotRequired[float]


class LayerDirection(TypedDict, total=False):
    """Layer direction y2 of a region of a section: one of these."""

    vector: list[float]
    circle: list[float]
    curve: str
    cells: bool  # in the arrays of the mesh


class SectionRegionTable(TypedDict):
    """Plies of a region of a section, outermost first."""

    plies: list[PlyTable]
    direction: NotRequired[LayerDirection]


class SectionMeshTable(TypedDict, total=False):
    """Mesh of a section: a script of meshes/, a file of gmsh, or arrays of another program."""

    script: str
    parameters: dict[str, float | list[float]]
    coordinates: list[list[float]]  # of a contour
    file: str
    arrays: str
    sha256: str
    scale: float
    degree: int | Literal["mesh"]


class StationTable(TypedDict):
    """A section at a fraction of the length; between two stations K and mass change linearly."""

    at: float
    section: dict[str, object]


class BeamInterfaceTable(TypedDict):
    """A position on a beam: an end, or a fraction of the length."""

    at: Literal["start", "end"] | float


class ShellInterfaceTable(TypedDict):
    """A physical group of a shell's mesh."""

    at: str
    link: ShellLinkKind
    position: NotRequired[list[float]]
    rotation_deg: list[float]


class ShellTable(TypedDict):
    """A shell without supports and loads."""

    mesh: dict[str, object]
    materials: dict[str, object]
    laminates: dict[str, object]
    regions: dict[str, object]
    elements: dict[str, object]
    stiffeners: NotRequired[dict[str, object]]


class BoreTable(TypedDict):
    """Faces on a cylinder; with `length`, those within it along the axis, about the point."""

    radius: float
    point: list[float]
    direction: list[float]
    length: NotRequired[float]


class PlaneTable(TypedDict):
    """Faces in a plane."""

    point: list[float]
    normal: list[float]


class SolidInterfaceTable(TypedDict):
    """Faces of a solid: one of `bore`, `plane`, and `at`, a physical surface."""

    bore: NotRequired[BoreTable]
    plane: NotRequired[PlaneTable]
    at: NotRequired[str]
    link: LinkKind
    position: NotRequired[list[float]]
    rotation_deg: list[float]


class SolidMeshTable(TypedDict):
    """A CAD file, a script or a mesh; `unit` [m] is that of the file, if it does not have one."""

    file: str
    sha256: NotRequired[str]
    size: NotRequired[float]
    accuracy: NotRequired[float]
    unit: NotRequired[float]
    parameters: NotRequired[dict[str, object]]


class SolidTable(TypedDict):
    """Geometry and materials of a solid."""

    mesh: SolidMeshTable
    materials: dict[str, object]
    regions: dict[str, object]
    allow: NotRequired[list[str]]


class SolidAnalysis(TypedDict):
    """What the command `solid` computes besides the modes of the free body."""

    supports: list[str]
    loads: dict[str, object]
    error: bool


class DesignTarget(TypedDict):
    """A number of the specification that a design parameter sets: factor parameter + offset.

    `of` is its path of keys with dots, rows of lists by number; or a list of these keys.
    """

    of: str | list[str]
    factor: NotRequired[float]
    offset: NotRequired[float]


class _Provenance(TypedDict):
    inputs_sha256: NotRequired[str]
    case: NotRequired[str]


class BeamSpecification(_Provenance):
    """A beam."""

    body: str
    kind: Literal["beam"]
    length: float
    elements: int
    x2_axis: list[float]
    line: NotRequired[LineTable]
    section: dict[str, object]
    stations: NotRequired[list[StationTable]]
    theory: Theory
    mass_form: MassForm
    reference: ReferenceTable
    modes: list[Eigenmodes | Attachment | StaticAxial | StaticInertia | SpinningModes]
    damping_ratio: float
    interfaces: dict[str, BeamInterfaceTable]
    candidates: NotRequired[bool]
    errors: NotRequired[bool]
    design: NotRequired[dict[str, list[DesignTarget]]]
    design_without: NotRequired[list[Literal["stresses", "second_order", "ply_axes"]]]


class ShellSpecification(_Provenance):
    """A laminated shell."""

    body: str
    kind: Literal["shell"]
    shell: ShellTable
    mass_form: MassForm
    reference: ReferenceTable
    modes: list[ShellEigenmodes | Attachment | StaticAxial | StaticInertia]
    damping_ratio: float
    interfaces: dict[str, ShellInterfaceTable]
    second_order: NotRequired[bool]
    candidates: NotRequired[bool]
    design: NotRequired[dict[str, list[DesignTarget]]]


class SolidSpecification(_Provenance):
    """A solid."""

    body: str
    kind: Literal["solid"]
    solid: SolidTable
    reference: ReferenceTable
    modes: list[ShellEigenmodes | Attachment]
    damping_ratio: float
    interfaces: dict[str, SolidInterfaceTable]
    second_order: NotRequired[bool]
    title: NotRequired[str]
    analysis: NotRequired[SolidAnalysis]


class ImportedSpecification(_Provenance):
    """Matrices of another code: the import file, read, and hashes of the files that it names."""

    body: str
    kind: Literal["imported"]
    file: str
    table: dict[str, object]
    sha256: dict[str, str]


Specification = BeamSpecification | ShellSpecification | SolidSpecification | ImportedSpecification

# These keys do not affect the body: a new integrator setting
# in the case file must not rebuild its packages.
NOT_INPUTS = ("inputs_sha256", "case")
SOURCES = ("preprocess", "meshes", "solver/package", "solver/math")


def fingerprint(spec: Mapping[str, Any]) -> str:
    """SHA-256 of a body specification, of the sources that make its file, and of the format.

    The file keeps it; both halves compare it (`has_fingerprint`) before they build anything. The
    version of DOLFINx is not included: all versions give the same numbers (to 1e-9, tested).
    """
    inputs = {key: value for key, value in spec.items() if key not in NOT_INPUTS}
    return inputs_sha256([inputs, list(FORMAT_VERSION), sources_sha256(*SOURCES)])
