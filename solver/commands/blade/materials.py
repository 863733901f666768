"""Materials of a windIO file, as a section description has them."""

from collections.abc import Set
from typing import Any

import numpy as np

from .tables import Table, Tables

GLUE = "adhesive"  # part of the name of the material of bond lines


def read_materials(tables: Tables, top: Table, used: Set[str]) -> dict[str, dict[str, Any]]:
    """Return the materials of the blade by name; those of other components may have other keys.

    Parameters
    ----------
    used : names of the materials of layers
    """
    found = {}
    for i, entry in enumerate(tables.entries(top, "materials")):
        name = tables.text(entry, f"materials[{i}].name")
        if name in used or GLUE in name.lower():
            found[name] = _material(tables, entry, f"materials.{name}")
    return found


def _material(tables: Tables, entry: Table, path: str) -> dict[str, Any]:
    (rho,) = tables.numbers(entry, f"{path}.rho", 1).tolist()
    if not entry.get("orth"):
        E, nu = (float(tables.numbers(entry, f"{path}.{key}", 1)[0]) for key in ("E", "nu"))
        return {"kind": "isotropic", "E": E, "nu": nu, "rho": rho}
    found: dict[str, Any] = {"kind": "orthotropic", "rho": rho}
    for key, names in (
        ("E", ("E1", "E2", "E3")),
        ("G", ("G12", "G13", "G23")),
        ("nu", ("nu12", "nu13", "nu23")),
    ):
        found |= dict(zip(names, tables.numbers(entry, f"{path}.{key}", 3).tolist(), strict=True))
    if strength := _strength(entry):
        found["strength"] = strength
    return found


def _strength(entry: Table) -> dict[str, float]:
    """Strengths of a ply; files without them write zeros or infinity."""
    try:
        Xt, Xc, S = (np.array(entry[key], dtype=float) for key in ("Xt", "Xc", "S"))
        values = np.array([Xt[0], Xc[0], Xt[1], Xc[1], S[0]])
    except (KeyError, TypeError, ValueError, IndexError):
        return {}
    if not (np.isfinite(values).all() and values.min() > 0.0):
        return {}
    return dict(zip(("Xt", "Xc", "Yt", "Yc", "S12"), values.tolist(), strict=True))
