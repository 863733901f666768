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
 "frequencies": {"count": 6, "free": false}}

SI and degrees; docs/shell-description.md explains each key.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ...solver.errors import did_you_mean
from .choice import Choice
from .errors import ShellError
from .loads import KEYS as LOAD
from .mass import FORMS
from .mesh import KEYS as MESH
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
)
OTHER = ("name", "title", "format")
REGION = (
    *("laminate", "material", "thickness", "offset", "shear_correction"),
    *("axis", "axis_curve", "axis_about", "flip"),
)
ENTRIES = {
    "regions": REGION,
    "stiffeners": STIFFENER,
    "links": ("at", "kind", "point"),
    "supports": ("at", "fixed"),
    "probes": ("at", "near", "what"),
}


class Elements(NamedTuple):
    """Choice of elements and mass form."""

    choice: Choice
    mass_form: str


def check_spec(spec: Mapping[str, Any], where: str) -> None:
    """Raise ShellError for a key that is unknown, missing or not a table; names the nearest key."""
    _keys(spec, (*REQUIRED, *TABLES, *OTHER), where)
    for key in REQUIRED:
        if not isinstance(spec.get(key), Mapping) or not spec[key]:
            raise ShellError(f"{where}.{key} = {spec.get(key)!r}: expected a table")
    for key in TABLES:
        if key in spec and not isinstance(spec[key], Mapping):
            raise ShellError(f"{where}.{key} = {spec[key]!r}: expected a table")
    _keys(spec["mesh"], MESH, f"{where}.mesh")
    for key, known in ENTRIES.items():
        for name, entry in spec.get(key, {}).items():
            _keys(entry, known, f"{where}.{key}.{name}")
    for case, loads in spec.get("loads", {}).items():
        if not isinstance(loads, Mapping):
            raise ShellError(f"{where}.loads.{case} = {loads!r}: expected a table of loads")
        for name, entry in loads.items():
            _keys(entry, LOAD, f"{where}.loads.{case}.{name}")
    _keys(spec.get("frequencies", {}), ("count", "free"), f"{where}.frequencies")


def elements(table: Mapping[str, Any], where: str) -> Elements:
    """Plate, membrane, drilling and mass. Raises ShellError for a name that does not exist."""
    _keys(table, (*Choice._fields, "mass_form"), where)
    form = table.get("mass_form", "consistent")
    if form not in FORMS:
        raise ShellError(
            f"{where}.mass_form = {form!r}: expected one of {', '.join(FORMS)}"
            + did_you_mean(str(form), FORMS)
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


def _keys(table: Any, known: tuple[str, ...], where: str) -> None:
    if not isinstance(table, Mapping):
        raise ShellError(f"{where} = {table!r}: expected a table")
    for key in table:
        if key not in known:
            raise ShellError(
                f"{where}.{key}: unknown key, expected {', '.join(known)}"
                + did_you_mean(str(key), known)
            )
