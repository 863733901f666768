"""The manuals of input files: tables of keys, generated from the models (`make docs`).

python -m plymotion.solver.inputs.manual docs
"""

import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from .case.tables.schema import CaseFile, Mechanism
from .json_schema import FILES, reached, referred, tables
from .section.description import SHAPE_MESHES, FileMesh, MeshTable
from .section.shapes.library import SHAPES, walls

HEAD = ["| key | type | unit | bounds | default | meaning |", "|---|---|---|---|---|---|"]
IDENTITY = ("kind", "shape")  # keys that say what a table is
NUMBERS = ("exclusiveMinimum", "minimum", "exclusiveMaximum", "maximum")
LEAST, MOST = ("minItems", "minLength", "minProperties"), ("maxItems", "maxLength", "maxProperties")
WORDS = {"number": "number", "integer": "integer", "string": "text", "boolean": "true or false"}


def chapters(*models: type[BaseModel]) -> list[str]:
    """Return the lines of a chapter for each model, and for each table to which they refer.

    A chapter has the first line of the text of a model, the rest of it, and its keys. Meshes of
    sections have chapters of their own.
    """
    out: list[str] = []
    listed, known = tables(models)
    meshes = {model.__name__ for model in SHAPE_MESHES.values()} | {FileMesh.__name__}
    for table in [*listed, *reached(listed, known, {}).values()]:
        if table["title"] not in meshes or table in listed:
            first, _, rest = table.get("description", "").partition("\n")
            out += [f"## {first.rstrip('.')}", ""]
            out += [" ".join(rest.split()), ""] if rest.strip() else []
            out += [*keys(table), ""]
    return out


def keys(table: Mapping[str, Any]) -> list[str]:
    """Return the lines of the table of keys of a JSON schema."""
    asked = table.get("required", ())
    return [*HEAD, *(_row(n, key, n in asked) for n, key in table["properties"].items())]


def _row(name: str, key: Mapping[str, Any], required: bool) -> str:
    value = key.get("default", "absent")
    default = "required" if required else f"`{value}`" if value != "" else '`""`'
    meaning = key.get("description") or ("kind of this table" if name in IDENTITY else "")
    options = [key, *key.get("anyOf", ())]
    limits = [text for option in options for text in _limits(option)]
    items: Mapping[str, Any] = next((o["items"] for o in options if "items" in o), {})
    cells = [
        f"`{name}`",
        _type(key),
        key.get("unit", ""),
        ", ".join([*limits, *(f"each {text}" for text in _limits(items))]),
        default,
        meaning,
    ]
    return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"


def _type(key: Mapping[str, Any]) -> str:
    if referred(key):
        return "table"
    options = key.get("anyOf") or key.get("oneOf")
    if options:
        text = " or ".join(dict.fromkeys(map(_type, options)))
        return re.sub(r"^list of (.+) or \1$", r"\1, or a list of these", text)
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


def _limits(key: Mapping[str, Any]) -> list[str]:
    signs = dict(zip(NUMBERS, (">", ">=", "<", "<="), strict=True))
    limits = [f"{sign} {key[name]:g}" for name, sign in signs.items() if name in key]
    least = next((key[name] for name in LEAST if name in key), None)
    most = next((key[name] for name in MOST if name in key), None)
    if least is not None and least == most:
        return [*limits, f"exactly {least}"]
    limits += [] if least is None else [f"at least {least}"]
    return limits + ([] if most is None else [f"at most {most}"])


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


def page_keys(kind: str) -> list[str]:
    """Return the keys of a description of a section, shell or solid."""
    lines = chapters(FILES[kind])
    if kind != "section":
        return lines
    (mesh,), _ = tables([MeshTable])
    return [
        *lines,
        "## `[mesh]`",
        "",
        f"Either `file` (last table), or `shape` with its sizes: {', '.join(SHAPE_MESHES)}.",
        "Keys for both:",
        "",
        *keys(mesh),
        "",
        *_shapes(),
        *(line for line in chapters(FileMesh) if not line.startswith("| `degree`")),
    ]


BEGIN, END = "<!-- keys: begin -->\n", "<!-- keys: end -->"


def with_keys(text: str, kind: str) -> str:
    """Return the text of docs/KIND-description.md with its keys written again."""
    head, rest = text.split(BEGIN)
    return "\n".join([head + BEGIN, *page_keys(kind), END]) + rest.split(END)[1]


# Cases: the whole page.

CASE = """\
# The case file

A case is a TOML file; in the repository it is `cases/<name>/case.toml`. This page is \
generated from solver/inputs/case by `make docs`.

A *run* is the case with some *variants* merged into it, in order: tables are merged, \
values and lists are replaced. Units are SI, those of lengths as \
`units` says ([runs.md](runs.md#units-of-lengths)); degrees only in keys that end in `_deg`. \
Unknown keys are errors.
"""
SECTIONS = """\
## `[sections.NAME]` with `shape`: a section of one material

The body names the material. The keys are those of `[mesh]` in a section description, see \
[section-description.md](section-description.md); these are required, and the \
height of rectangles:
"""

_TABLE = re.compile("`[^`]*`")
_KIND = re.compile(r'kind = ("[^:]*")')


def case_page() -> str:
    """Return docs/case-reference.md."""
    lines = [*chapters(CaseFile, Mechanism), SECTIONS]
    for name, table in zip(SHAPE_MESHES, tables(SHAPE_MESHES.values())[0], strict=True):
        asked = [f"`{key}`" for key in table["required"] if key not in IDENTITY]
        lines.append(f'- `shape = "{name}"`: {", ".join(asked)}')
    return "\n".join([CASE, *_contents(lines), *lines, ""])


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
    for kind in FILES:
        page = folder / f"{kind}-description.md"
        page.write_text(with_keys(page.read_text(encoding="utf-8"), kind), encoding="utf-8")
