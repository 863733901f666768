"""The manuals of input files: tables of keys, generated from the models (`make docs`).

python -m plymotion.solver.inputs.manual docs
"""

import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from .case.tables.beam_schema import BeamBody, BeamInterface, BeamLine, BeamStation
from .case.tables.body_schema import ImportedBody, PackageBody, PointInterface, RigidBody
from .case.tables.kinds import COUPLING_TABLES, FORCE_TABLES, JOINT_TABLES
from .case.tables.laws import LAW_TABLES, CurveTable, TablePoints
from .case.tables.modes import MODE_TABLES
from .case.tables.python_code import PythonCode
from .case.tables.schema import CaseFile, Fidelity, Figure, GroundPoint, Mechanism, PointMass, Run
from .case.tables.section_schema import DescribedSection
from .case.tables.shell_schema import ShellBody, ShellInterface
from .case.tables.signals import SIGNAL_TABLES
from .case.tables.solid_schema import SolidBody
from .case.tables.solver import Solver, Spin
from .case.tables.sweeps import Sweep, Variation
from .common.lay_up import Laminate, Ply
from .common.material import MATERIAL_TABLES
from .json_schema import referred, tables
from .section.description import Direction, Region, SectionDescription
from .section.mesh_table import SHAPE_MESHES, FileMesh, MeshTable
from .section.shapes.library import SHAPES, walls
from .shell import description as shell
from .shell import loading
from .solid.description import SOLID_TABLES, Bore, Plane, SolidInterface

Models = Iterable[type[BaseModel]]
HEAD = ["| key | type | unit | bounds | default | meaning |", "|---|---|---|---|---|---|"]
IDENTITY = ("kind", "shape")  # keys that tell what a table is
NUMBERS = ("exclusiveMinimum", "minimum", "exclusiveMaximum", "maximum")
LEAST, MOST = ("minItems", "minLength", "minProperties"), ("maxItems", "maxLength", "maxProperties")
WORDS = {"number": "number", "integer": "integer", "string": "text", "boolean": "true or false"}


def chapters(models: Models) -> list[str]:
    """Return the lines of one chapter per model: its first line, its text, its keys."""
    out = []
    for table in tables(models)[0]:
        first, _, rest = table.get("description", "").partition("\n")
        out += [f"## {first.rstrip('.')}", ""]
        if rest.strip():
            out += [" ".join(rest.split()), ""]
        out += [*keys(table), ""]
    return out


def keys(table: Mapping[str, Any]) -> list[str]:
    """Return the lines of the table of keys of a JSON schema."""
    asked = table.get("required", ())
    return [*HEAD, *(_row(n, key, n in asked) for n, key in table["properties"].items())]


def _row(name: str, key: Mapping[str, Any], required: bool) -> str:
    default = "required" if required else f"`{key.get('default', 'absent')}`"
    meaning = key.get("description") or ("kind of this table" if name in IDENTITY else "")
    cells = [
        f"`{name}`",
        _type(key),
        key.get("unit", ""),
        ", ".join(_bounds(key)),
        default,
        meaning,
    ]
    return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"


def _type(key: Mapping[str, Any]) -> str:
    if referred(key):
        return "table"
    options = key.get("anyOf") or key.get("oneOf")
    if options:
        return " or ".join(dict.fromkeys(map(_type, options)))
    values = key.get("enum", [key["const"]] if "const" in key else [])
    if values:
        return " or ".join(f'`"{v}"`' if isinstance(v, str) else f"`{v}`" for v in values)
    if key.get("type") == "array":
        return f"list of {_type(key['items'])}"
    if key.get("type") == "object":
        within = key.get("additionalProperties")
        inner = _type(within) if isinstance(within, dict) else "any"
        return f"named {inner}s" if inner == "table" else f"table of {inner}"
    return WORDS.get(str(key.get("type")), "any")


def _bounds(key: Mapping[str, Any]) -> list[str]:
    options = [key, *key.get("anyOf", ())]
    found = [text for option in options for text in _limits(option)]
    items: Mapping[str, Any] = next((o["items"] for o in options if "items" in o), {})
    return [*found, *(f"each {text}" for text in _limits(items))]


def _limits(key: Mapping[str, Any]) -> list[str]:
    signs = dict(zip(NUMBERS, (">", ">=", "<", "<="), strict=True))
    found = [f"{sign} {key[name]:g}" for name, sign in signs.items() if name in key]
    least = next((key[name] for name in LEAST if name in key), None)
    most = next((key[name] for name in MOST if name in key), None)
    if least is not None and least == most:
        return [*found, f"exactly {least}"]
    found += [] if least is None else [f"at least {least}"]
    return found + ([] if most is None else [f"at most {most}"])


# Cross-sections, shells and solids: pages with the keys between two marks.


def _shapes() -> list[str]:
    """Return a section of the page for each shape: its sizes and its walls."""
    out = []
    for name, table in zip(SHAPE_MESHES, tables(SHAPE_MESHES.values())[0], strict=True):
        head, _, meaning = table["description"].partition("\n\n")
        out += [f"### `{head}`", "", meaning, ""]
        out += [line for line in keys(table) if not line.startswith(("| `degree`", "| `shape`"))]
        out += ["", "| region | y2 | thickness |", "|---|---|---|"]
        for wall in walls(name, SHAPES[name].example):
            thickness = f"`{wall.thickness}`" if wall.stacked else "its own; no rows for plies"
            out.append(f"| `{wall.region}` | {_direction(wall.direction)} | {thickness} |")
        out.append("")
    return out


def _direction(direction: Mapping[str, Any]) -> str:
    ((kind, value),) = direction.items()
    if kind == "vector":
        return f"({value[0]:g}, {value[1]:g})"
    return "around the centre" if kind == "circle" else f"along the {value} contour"


def section_keys() -> list[str]:
    """Return the keys of a section description."""
    (mesh,), _ = tables([MeshTable])
    return [
        *chapters((SectionDescription, Laminate, Ply, Region, Direction, *MATERIAL_TABLES)),
        "## `[mesh]`",
        "",
        "Either `shape` with the sizes below, or `file`. Keys for both:",
        "",
        *keys(mesh),
        "",
        *_shapes(),
        *(line for line in chapters((FileMesh,)) if not line.startswith("| `degree`")),
    ]


def shell_keys() -> list[str]:
    """Return the keys of a shell description."""
    return chapters((*shell.TABLES, *loading.TABLES, *MATERIAL_TABLES))


def solid_keys() -> list[str]:
    """Return the keys of a solid description."""
    return chapters((*SOLID_TABLES, *MATERIAL_TABLES))


PAGES = {
    "section-description.md": section_keys,
    "shell-description.md": shell_keys,
    "solid-description.md": solid_keys,
}
BEGIN, END = "<!-- keys: begin -->\n", "<!-- keys: end -->"


def with_keys(text: str, page: str) -> str:
    """Return the text of one of PAGES with its keys written anew."""
    head, rest = text.split(BEGIN)
    return "\n".join([head + BEGIN, *PAGES[page](), END]) + rest.split(END)[1]


# Cases: the whole page.

FIRST: Models = (CaseFile, Mechanism, *MATERIAL_TABLES)
FLEXIBLE: Models = (DescribedSection, BeamBody, BeamLine, BeamStation, ShellBody, SolidBody)
OTHERS: Models = (RigidBody, PackageBody, ImportedBody, *MODE_TABLES)
FACES: Models = (BeamInterface, ShellInterface, SolidInterface, Bore, Plane)
BETWEEN: Models = (PointInterface, GroundPoint, *JOINT_TABLES, *COUPLING_TABLES, *LAW_TABLES)
FORCES: Models = (*FORCE_TABLES, CurveTable, TablePoints, PythonCode, PointMass, *SIGNAL_TABLES)
RUNS: Models = (Solver, Spin, Fidelity, Run, Figure, Sweep, Variation)
THEN: Models = (*FLEXIBLE, *OTHERS, *FACES, *BETWEEN, *FORCES, *RUNS)
CASE = """\
# The case file

A case is a TOML file; in the repository it is `cases/<name>/case.toml`. This page is \
generated from solver/inputs/case by `make docs`.

A *run* is the case with some *variants* merged into it, in order: tables are merged, \
values and lists are replaced. Units are SI; degrees only in keys that end in `_deg`. \
Unknown keys are errors.
"""
SECTIONS = """\
## `[sections.NAME]` with `shape`: a section of one material

The body names the material. The keys are those of `[mesh]` in a section description, see \
[section-description.md](section-description.md); these are required:
"""

_TABLE = re.compile("`[^`]*`")
_KIND = re.compile(r'kind = ("[^:]*")')


def case_page() -> str:
    """Return docs/case-reference.md."""
    found = [*chapters(FIRST), SECTIONS]
    for name, table in zip(SHAPE_MESHES, tables(SHAPE_MESHES.values())[0], strict=True):
        asked = [f"`{key}`" for key in table["required"] if key not in IDENTITY]
        found.append(f'- `shape = "{name}"`: {", ".join(asked)}')
    found += ["", *chapters(THEN)]
    return "\n".join([CASE, *_contents(found), *found])


def _contents(lines: list[str]) -> list[str]:
    """Return a list of links to the chapters on tables: one line for the kinds of a table."""
    groups: dict[str, list[str]] = {}
    for text in lines:
        line = text.partition("\n")[0]
        title, table = line.removeprefix("## "), _TABLE.search(line)
        if title == line or not table:
            continue
        kind, (name, _, rest) = _KIND.search(title), title.partition(":")
        label = kind[1].replace('"', "") if kind else name.removeprefix(table[0]).lstrip(", ")
        anchor = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        link = f"[{rest.strip() if not label or table[0] in label else label}](#{anchor})"
        groups.setdefault(table[0], []).append(link)
    return [*(f"- {name}: {'; '.join(links)}" for name, links in groups.items()), ""]


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    (folder / "case-reference.md").write_text(case_page(), encoding="utf-8")
    for name in PAGES:
        page = folder / name
        page.write_text(with_keys(page.read_text(encoding="utf-8"), name), encoding="utf-8")
