"""Laminates of NASTRAN shells: PCOMP, PSHELL, MAT8 and MAT1, and the axes of the elements."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ....solver.math.arrays import Array
from ..free_body import Cells
from ..layups import Layups
from .bulk_data import ELEMENTS, Card, real

SHELLS = {"CQUAD4": 4, "CTRIA3": 3}  # number of corners; then come an angle and an offset
MOST_NU23 = 0.45  # where E2 / (2 G2Z) - 1 is no ratio of a material


class NotRead(Exception):
    """A deck has shells whose plies are not understood; the words say which."""


def read_layups(path: Path, deck: Sequence[Card], nodes: Array, cells: Cells) -> Layups | str:
    """Return the laminates of all shells of a deck; or why there are none.

    Parameters
    ----------
    path : of the deck, for messages
    deck : `bulk_cards` of it
    nodes, cells : as `read_bulk_data` returns them
    """
    cards = [(name, [*fields, *[""] * 20]) for name, fields in deck]
    listed = [(name, fields) for name, fields in cards if name in ELEMENTS]
    by_id = {
        (name, fields[0]): fields
        for name, fields in cards
        if name in ("PCOMP", "PSHELL", "MAT8", "MAT1")
    }
    materials: dict[str, dict[str, Any]] = {}
    laminates: dict[str, dict[str, Any]] = {}
    rows, numbers, axes = [], [], []
    try:
        for cell, (name, fields) in enumerate(listed):
            if name not in SHELLS:
                continue
            label = f"laminate {fields[1]}"
            if label not in laminates:
                laminates[label] = _laminate(by_id, fields[1], materials, path)
            start = int(cells.offsets[cell])
            corners = nodes[cells.connectivity[start : start + SHELLS[name]]]
            axes.append(_axes(corners, name, fields, path))
            rows.append(cell)
            numbers.append(list(laminates).index(label))
    except NotRead as error:
        return str(error)
    if not rows:
        return "no shells"
    return Layups(materials, laminates, np.array(rows), np.array(numbers), np.array(axes))


def _laminate(
    by_id: dict[tuple[str, str], list[str]],
    number: str,
    materials: dict[str, dict[str, Any]],
    path: Path,
) -> dict[str, Any]:
    """Table of plies of a property; its materials are added to `materials`."""
    if ("PCOMP", number) in by_id:
        fields = by_id["PCOMP", number]
        plies = _plies(fields[8:], path)
        if fields[7].upper() == "SYM":
            plies = [*plies, *(dict(ply) for ply in plies[::-1])]
        elif fields[7]:
            raise NotRead(f"PCOMP {number}: LAM = {fields[7]}")
        total = sum(float(ply["thickness"]) for ply in plies)
        bottom = real(fields[1], path, "PCOMP") if fields[1] else -0.5 * total
        offset = bottom + 0.5 * total
    elif ("PSHELL", number) in by_id:
        fields = by_id["PSHELL", number]
        if fields[3] != fields[1] or fields[4] not in ("", "1.", "1.0"):
            raise NotRead(f"PSHELL {number}: expected MID2 = MID1, and 12I/T3 of a plate")
        thickness = real(fields[2], path, "PSHELL")
        plies = [{"material": fields[1], "angle_deg": 0.0, "thickness": thickness}]
        offset = 0.0
    else:
        raise NotRead(f"property {number} is no PCOMP or PSHELL")
    for ply in plies:
        name = f"MAT {ply['material']}"
        materials.setdefault(name, _material(by_id, str(ply["material"]), path))
        ply["material"] = name
    return {"plies": plies, "offset": offset}


def _plies(fields: list[str], path: Path) -> list[dict[str, Any]]:
    """Four fields a ply: material, thickness (both as before if blank), angle, output."""
    plies: list[dict[str, Any]] = []
    material, thickness = "", 0.0
    for at in range(0, len(fields) - 3, 4):
        if not any(fields[at : at + 3]):
            continue
        material = fields[at] or material
        thickness = real(fields[at + 1], path, "PCOMP") if fields[at + 1] else thickness
        angle = real(fields[at + 2], path, "PCOMP")
        plies.append({"material": material, "angle_deg": angle, "thickness": thickness})
    return plies


def _material(by_id: dict[tuple[str, str], list[str]], number: str, path: Path) -> dict[str, Any]:
    """Constants of MAT8 or MAT1.

    MAT8 has no constants across the ply: E3 = E2, nu13 = nu12 and, with G23 = G2Z, nu23 as of a
    material that is isotropic in 2 and 3. G1Z and G2Z that are blank count as G12.
    """
    if ("MAT1", number) in by_id:
        E, G, nu, rho = (real(text, path, "MAT1") for text in by_id["MAT1", number][1:5])
        if not nu and G:
            nu = E / (2.0 * G) - 1.0
        return {"kind": "isotropic", "E": E, "nu": nu, "rho": rho}
    if ("MAT8", number) not in by_id:
        raise NotRead(f"material {number} is no MAT8 or MAT1")
    fields = by_id["MAT8", number]
    E1, E2, nu12, G12, G1Z, G2Z, rho = (real(text, path, "MAT8") for text in fields[1:8])
    G23 = G2Z or G12
    nu23 = E2 / (2.0 * G23) - 1.0
    table: dict[str, Any] = {"kind": "orthotropic", "E1": E1, "E2": E2, "E3": E2, "rho": rho}
    table |= {"G12": G12, "G13": G1Z or G12, "G23": G23, "nu12": nu12, "nu13": nu12}
    table["nu23"] = float(np.clip(nu23, 0.0, MOST_NU23))
    strengths = [real(text, path, "MAT8") for text in fields[11:16]]
    if all(strengths) and fields[18] not in ("1", "1.", "1.0"):  # STRN: allowed strains
        table["strength"] = dict(zip(("Xt", "Xc", "Yt", "Yc", "S12"), strengths, strict=True))
    return table


def _axes(corners: Array, name: str, fields: list[str], path: Path) -> Array:
    """Axes of the laminate of an element, (3, 3): angles count from the side of nodes 1 and 2."""
    count = SHELLS[name]
    theta, offset = fields[2 + count], fields[3 + count]
    label = f"{name} {fields[0]}"
    if offset and real(offset, path, name):
        raise NotRead(f"{label}: ZOFFS")
    turned = len(corners) == 4
    e3 = (
        np.cross(corners[2] - corners[0], corners[3] - corners[1])
        if turned
        else np.cross(corners[1] - corners[0], corners[2] - corners[0])
    )
    e3 /= np.linalg.norm(e3)
    along = corners[1] - corners[0]
    angle = 0.0
    if theta and ("." in theta or "E" in theta.upper()):
        angle = np.deg2rad(real(theta, path, name))
    elif theta == "0":  # MCID: x of the basic system
        along = np.array([1.0, 0.0, 0.0])
    elif theta:
        raise NotRead(f"{label}: MCID = {theta}: a coordinate system of its own")
    e1 = along - (along @ e3) * e3
    e1 /= np.linalg.norm(e1)
    e1 = np.cos(angle) * e1 + np.sin(angle) * np.cross(e3, e1)
    return np.column_stack([e1, np.cross(e3, e1), e3])
