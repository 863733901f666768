"""The reference page of the case file, generated from the schema."""

import re

from pydantic import BaseModel

from ...common.material import MATERIAL_TABLES
from ...common.page import chapters, required
from ...section.mesh_table import SHAPE_MESHES
from ...solid.description import Bore, Plane, SolidInterface
from ..tables.beam_schema import BeamBody, BeamInterface, BeamLine, BeamStation
from ..tables.body_schema import ImportedBody, PackageBody, PointInterface, RigidBody
from ..tables.kinds import COUPLING_TABLES, FORCE_TABLES, JOINT_TABLES
from ..tables.laws import LAW_TABLES, CurveTable, TablePoints
from ..tables.modes import MODE_TABLES
from ..tables.python_code import PythonCode
from ..tables.schema import CaseFile, Fidelity, Figure, GroundPoint, Mechanism, PointMass, Run
from ..tables.section_schema import DescribedSection
from ..tables.shell_schema import ShellBody, ShellInterface
from ..tables.signals import SIGNAL_TABLES
from ..tables.solid_schema import SolidBody
from ..tables.solver import Solver, Spin
from ..tables.sweeps import Sweep, Variation

_FIRST: tuple[type[BaseModel], ...] = (CaseFile, Mechanism, *MATERIAL_TABLES)
_THEN: tuple[type[BaseModel], ...] = (
    DescribedSection,
    BeamBody,
    BeamLine,
    BeamStation,
    ShellBody,
    SolidBody,
    RigidBody,
    PackageBody,
    ImportedBody,
    *MODE_TABLES,
    BeamInterface,
    ShellInterface,
    SolidInterface,
    Bore,
    Plane,
    PointInterface,
    GroundPoint,
    *JOINT_TABLES,
    *COUPLING_TABLES,
    *LAW_TABLES,
    *FORCE_TABLES,
    CurveTable,
    TablePoints,
    PythonCode,
    PointMass,
    *SIGNAL_TABLES,
    Solver,
    Spin,
    Fidelity,
    Run,
    Figure,
    Sweep,
    Variation,
)

_TABLE = re.compile("`[^`]*`")
_KIND = re.compile(r'kind = ("[^:]*")')


def reference_page() -> str:
    """Return docs/case-reference.md."""
    out = [
        "# The case file",
        "",
        "A case is a TOML file; in the repository it is `cases/<name>/case.toml`. This page is "
        "generated from solver/inputs/case by `make docs`.",
        "",
        "A *run* is the case with some *variants* merged into it, in order: tables are merged, "
        "values and lists are replaced. Units are SI; degrees only in keys that end in `_deg`. "
        "Unknown keys are errors.",
        "",
    ]
    found = [*chapters(_FIRST), *_shapes(), *chapters(_THEN)]
    return "\n".join([*out, *_contents(found), *found])


def _contents(lines: list[str]) -> list[str]:
    """Return a list of links to the chapters on tables: one line for the kinds of a table."""
    groups: dict[str, list[str]] = {}
    for line in lines:
        title, table = line.removeprefix("## "), _TABLE.search(line)
        if title == line or not table:
            continue
        kind, (name, _, rest) = _KIND.search(title), title.partition(":")
        label = kind[1].replace('"', "") if kind else name.removeprefix(table[0]).lstrip(", ")
        anchor = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        link = f"[{rest.strip() if not label or table[0] in label else label}](#{anchor})"
        groups.setdefault(table[0], []).append(link)
    return [*(f"- {name}: {'; '.join(links)}" for name, links in groups.items()), ""]


def _shapes() -> list[str]:
    """Return the chapter of sections that are shapes."""
    return [
        "## `[sections.NAME]` with `shape`: a section of one material",
        "",
        "The body names the material. The keys are those of `[mesh]` in a section description, see "
        "[section-description.md](section-description.md); these are required:",
        "",
        *(f'- `shape = "{n}"`: {", ".join(required(m))}' for n, m in SHAPE_MESHES.items()),
        "",
    ]
