"""Check of the outer form of a shell's specification, which may be written by hand.

{"name": "panel", "mesh": {"file": "panel.msh"}, "materials": {...},
 "laminates": {"skin": {"plies": [{"material": "cfrp", "angle_deg": 45.0, "thickness": 1e-4}]}},
 "regions": {"all": {"laminate": "skin", "axis": [1.0, 0.0, 0.0]}},
 "elements": {"plate": "dkmt", "membrane": "opt", "mass_form": "consistent"},
 "stiffeners": {"rib": {"at": "ridge", "section": {...}, "offset": [0.0, 0.01]}},
 "links": {"end": {"at": "tip", "kind": "rigid"}},
 "supports": {"root": {"at": "root", "fixed": "all"}},
 "loads": {"pull": {"tip": {"at": "end", "force": [1.0, 0.0, 0.0]}}},
 "probes": {"tip": {"at": "end", "what": "uz"}},
 "frequencies": {"count": 6, "free": false, "prestress": "pull", "error": true},
 "buckling": {"count": 4, "cases": ["pull"], "constant": "weight", "in_plane": true,
              "error": true}}

SI and degrees; docs/shell-description.md explains each key.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ....solver.errors import check_keys, did_you_mean
from ....solver.package.body.schema import MASS_FORMS
from ..elements.choice import Choice
from ..errors import ShellError
from ..mesh.mesh import KEYS as MESH
from .loads import KEYS as LOAD
from .stiffeners import KEYS as STIFFENER

REQUIRED = ("mesh", "materials", "regions")
TABLES = (
    "laminates",
    "elements",
    "stiffeners",
    "links",
    "supports",
    "loads",
    "probes",
    "frequencies",
    "buckling",
)
OTHER = ("name", "title", "format", "allow")
REGION = (
    *("laminate", "material", "thickness", "offset", "shear_correction"),
    *("axis", "axis_curve", "axis_about", "flip"),
)
ENTRIES = {
    "regions": REGION,
    "stiffeners": STIFFENER,
    "links": ("at", "kind", "point"),
    "supports": ("at", "fixed", "only"),
    "probes": ("at", "near", "what"),
}


BUCKLING = ("count", "cases", "constant", "in_plane", "error")


class Elements(NamedTuple):
    """Choice of elements and mass form."""

    choice: Choice
    mass_form: str


def check_spec(spec: Mapping[str, Any], where: str) -> None:
    """Raise ShellError for a key that is unknown, missing or not a table."""
    check_keys(spec, (*REQUIRED, *TABLES, *OTHER), where, ShellError)
    for key in REQUIRED:
        if not isinstance(spec.get(key), Mapping) or not spec[key]:
            raise ShellError(f"{where}.{key} = {spec.get(key)!r}: expected a table")
    for key in TABLES:
        if key in spec and not isinstance(spec[key], Mapping):
            raise ShellError(f"{where}.{key} = {spec[key]!r}: expected a table")
    check_keys(spec["mesh"], MESH, f"{where}.mesh", ShellError)
    for key, known in ENTRIES.items():
        for name, entry in spec.get(key, {}).items():
            check_keys(entry, known, f"{where}.{key}.{name}", ShellError)
    for case, loads in spec.get("loads", {}).items():
        if not isinstance(loads, Mapping):
            raise ShellError(f"{where}.loads.{case} = {loads!r}: expected a table of loads")
        for name, entry in loads.items():
            check_keys(entry, LOAD, f"{where}.loads.{case}.{name}", ShellError)
    modes = ("count", "free", "prestress", "error")
    check_keys(spec.get("frequencies", {}), modes, f"{where}.frequencies", ShellError)
    check_keys(spec.get("buckling", {}), BUCKLING, f"{where}.buckling", ShellError)


def elements(table: Mapping[str, Any], where: str) -> Elements:
    """Plate, membrane, drilling and mass. Raises ShellError for a name that does not exist."""
    check_keys(table, (*Choice._fields, "mass_form"), where, ShellError)
    form = table.get("mass_form", "consistent")
    if form not in MASS_FORMS:
        raise ShellError(
            f"{where}.mass_form = {form!r}: expected one of {', '.join(MASS_FORMS)}"
            + did_you_mean(str(form), MASS_FORMS)
        )
    given = {key: table[key] for key in Choice._fields if key in table}
    try:
        return Elements(Choice(**given).checked(), form)
    except ShellError as error:
        raise ShellError(f"{where}.{error}") from error


def mode_count(table: Mapping[str, Any], where: str) -> int:
    """Number of requested modes. Raises ShellError."""
    count = table.get("count", 6)
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise ShellError(f"{where}.count = {count!r}: expected a whole number above 0")
    return count
