"""Stiffness and mass that a windIO file has itself, beside those of its stations."""

from dataclasses import dataclass

import numpy as np

from ...math.arrays import Array
from ..section.results import SectionResults
from .along import Along
from .tables import Table, Tables

DIFFERENT = 0.1  # relative difference that is a finding
# EI about the tension centre and the principal axes: files name the axes of K44 and K55 both ways.
QUANTITIES = {
    "mass": "kg/m",
    "EA": "N",
    "EI flap": "N m2",
    "EI edge": "N m2",
    "GJ": "N m2",
}
BENDING = ("K33", "K34", "K35", "K44", "K45", "K55")


@dataclass(frozen=True)
class Given:
    """`elastic_properties` of a file: mass and stiffnesses along the span; no key: not given."""

    mass: Along | None
    stiffness: dict[str, Along]

    def at(self, r: float) -> dict[str, float]:
        """What the file says at r, of QUANTITIES; without what it does not have there."""
        found = {}
        if self.mass is not None and self.mass.covers(r):
            found["mass"] = self.mass.at(r)
        K = {key: one.at(r) for key, one in self.stiffness.items() if one.covers(r)}
        if {"K33", "K44", "K55"} <= K.keys():
            EA, X, Y, XX, XY, YY = (K.get(key, 0.0) for key in BENDING)
            found |= _bending(np.array([[EA, X, Y], [X, XX, XY], [Y, XY, YY]]))
        if "K66" in K:
            found["GJ"] = _torsion(K)
        return {key: value for key, value in found.items() if value > 0.0}


def read_given(tables: Tables, structure: Table) -> Given | None:
    """Return what a file has in `structure.elastic_properties`, None if nothing."""
    if structure.get("elastic_properties") is None:
        return None
    path = "structure.elastic_properties"
    properties = tables.table(structure, path)
    parts: dict[str, dict[str, Along]] = {}
    for part in ("inertia_matrix", "stiffness_matrix"):
        parts[part] = {}
        if properties.get(part) is None:
            continue
        table = tables.table(properties, f"{path}.{part}")
        for key in table:
            if key == "mass" or (part == "stiffness_matrix" and str(key).startswith("K")):
                pair = {key: {"grid": table.get("grid"), "values": table[key]}}
                parts[part][str(key)] = tables.along(pair, f"{path}.{part}.{key}")
    return Given(parts["inertia_matrix"].get("mass"), parts["stiffness_matrix"])


def differences(given: Given, r: float, results: SectionResults) -> list[str]:
    """Return the quantities of a station in which file and section differ, with both numbers."""
    K = results.K
    ours = {"mass": float(results.M[0, 0]), "GJ": float(1.0 / np.linalg.inv(K)[3, 3])}
    ours |= _bending(K[np.ix_([0, 4, 5], [0, 4, 5])])
    found = []
    for key, theirs in given.at(r).items():
        ratio = ours[key] / theirs
        if abs(ratio - 1.0) > DIFFERENT:
            found.append(
                f"{key} {ours[key]:.4g} {QUANTITIES[key]}, elastic_properties {theirs:.4g} "
                f"(x {ratio:.3g})"
            )
    return found


def _bending(K: Array) -> dict[str, float]:
    """EA, and the principal EI about the tension centre, of a stiffness of tension and bending."""
    EI = K[1:, 1:] - np.outer(K[1:, 0], K[0, 1:]) / K[0, 0] if K[0, 0] > 0.0 else K[1:, 1:]
    flap, edge = np.linalg.eigvalsh(EI).tolist()
    return {"EA": float(K[0, 0]), "EI flap": flap, "EI edge": edge}


def _torsion(K: dict[str, float]) -> float:
    """GJ of a section that is free to warp; K66 where a file has no shear stiffness."""
    full = np.array(
        [[K.get(f"K{min(i, j)}{max(i, j)}", 0.0) for j in range(1, 7)] for i in range(1, 7)]
    )
    if np.linalg.eigvalsh(full)[0] <= 0.0:
        return K["K66"]
    return float(1.0 / np.linalg.inv(full)[5, 5])
