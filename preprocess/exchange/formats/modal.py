"""Bodies of which a source has modes only: tables for measured modes (docs/modes.md).

Computed modes without matrices, and measured ones, take the same way: shapes at nodes, masses of
the nodes, and corrections that make the shapes orthonormal in these masses.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ....solver.errors import InputError
from ....solver.math.arrays import Array, IntArray
from ....solver.package import ModalPackage
from ....solver.package.common.files import write_text
from ....solver.package.common.plain_data import toml_text
from ..free_body import Cells, rows_of
from ..import_table import Files, Reduction, sizes
from ..links import interface_rows
from .matrices import table_rows

LINES = {3: ((0, 1),), 5: ((0, 1), (1, 2), (2, 0)), 9: ((0, 1), (1, 2), (2, 3), (3, 0))}
LINES |= {22: LINES[5], 23: LINES[9]}
PARTS = {"Jxx": (0, 0), "Jyy": (1, 1), "Jzz": (2, 2), "Jxy": (0, 1), "Jxz": (0, 2), "Jyz": (1, 2)}


@dataclass(frozen=True)
class ModalBody:
    """Modes of a source in its units; n nodes, m modes in ascending frequency.

    Attributes
    ----------
    shapes : (m, n, 6) displacements and rotations, any scale
    hertz : (m,) natural frequencies [1 / time]
    has_rotations : whether the source has rotations
    damping_ratios : (m,); None: zero
    mass : (n,); None: from the file `masses`
    """

    where: str
    nodes: Array
    node_ids: IntArray
    cells: Cells
    shapes: Array
    hertz: Array
    has_rotations: bool = False
    damping_ratios: Array | None = None
    mass: Array | None = None
    groups: dict[str, IntArray] = field(default_factory=dict)

    @property
    def dof_node(self) -> IntArray:
        """Nodes that move: all."""
        return np.arange(len(self.nodes))


def write_tables(body: ModalBody, table: Reduction, files: Files, folder: Path) -> Path:
    """Write measured.toml and its CSV files in SI; returns the former.

    Raises InputError for nodes without masses, or fewer modes than requested.
    """
    length, mass, time = sizes(table["units"])
    wanted = sum(mode["count"] for mode in table["modes"] if mode["kind"] == "lowest")
    if any(mode["kind"] != "lowest" for mode in table["modes"]):
        raise InputError(
            f'{body.where}: modes: expected kind = "lowest": the source has modes only'
        )
    if wanted > len(body.hertz):
        raise InputError(f"{body.where}: modes: {wanted} of {len(body.hertz)} modes requested")
    masses = _masses(body, files, length, mass)
    total = table.get("total_mass")
    weighed = float(masses[:, 0].sum())
    if total is not None and abs(weighed - total) > 1e-3 * total:
        raise InputError(
            f"{body.where}: total_mass = {total:.9g} kg, but the nodes have {weighed:.9g} kg"
        )
    folder.mkdir(parents=True, exist_ok=True)
    names = ["node", "x", "y", "z", "mass", *PARTS]
    _csv(folder / "nodes.csv", names, body.node_ids, np.hstack([body.nodes * length, masses]))
    found: dict[str, Any] = {
        "format": 1,
        "body": table["body"],
        "nodes": "nodes.csv",
        "lines": _lines(body),
    }
    found["reference"] = {k: v for k, v in table["reference"].items() if k in ("kind", "at")}
    columns = ["ux", "uy", "uz", "rx", "ry", "rz"][: 6 if body.has_rotations else 3]
    found["modes"], found["interfaces"] = [], {}
    damping = np.zeros(wanted) if body.damping_ratios is None else body.damping_ratios
    for i in range(wanted):
        shape = body.shapes[i, :, : len(columns)].copy()
        shape[:, 3:] *= length  # a rotation per unit of the same shape
        _csv(folder / f"mode{i + 1}.csv", ["node", *columns], body.node_ids, shape)
        found["modes"].append(
            {
                "frequency_hz": float(body.hertz[i] / time),
                "shape": f"mode{i + 1}.csv",
                "damping_ratio": float(table.get("damping_ratio", damping[i])),
                "label": f"vibration {i + 1}",
            }
        )
    metres = replace(body, nodes=body.nodes * length)
    for name, entry in table["interfaces"].items():
        rows = interface_rows(metres, entry, length, f"{body.where}: interfaces.{name}")
        found["interfaces"][name] = {"nodes": body.node_ids[rows].tolist()}
    file = folder / "measured.toml"
    file.write_text(toml_text(found), encoding="utf-8")
    return file


def _masses(body: ModalBody, files: Files, length: float, mass: float) -> Array:
    """Mass and six inertias of the nodes, (n, 7), in SI."""
    found = np.zeros((len(body.nodes), 7))
    if body.mass is not None:
        found[:, 0] = body.mass * mass
        return found
    path = files.path("masses")
    for number, row in table_rows(path, "node, mass, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz"):
        try:
            label, values = int(row[0]), [float(part) for part in row[1:]]
        except ValueError:
            label, values = 0, []
        if len(values) not in (1, 7):
            raise InputError(
                f"{path}:{number}: expected node, mass [, six inertias]; found {', '.join(row)}"
            )
        at = int(rows_of(np.array([label]), body.node_ids, f"{path}:{number}")[0])
        found[at, : len(values)] = values
    return found * mass * np.array([1.0, *[length**2] * 6])


def _lines(body: ModalBody) -> list[list[int]]:
    """Edges of the cells that are lines or faces, by labels."""
    pairs = set()
    for kind, rows in body.cells.each():
        for a, b in LINES.get(kind, ()):
            ends = body.node_ids[rows[[a, b]]].tolist()
            pairs.add((min(ends), max(ends)))
    return [list(pair) for pair in sorted(pairs)]


def _csv(file: Path, names: list[str], ids: IntArray, values: Array) -> None:
    lines = [",".join(names)]
    for label, row in zip(ids, values, strict=True):
        lines.append(",".join([str(label), *(f"{value:.17g}" for value in row)]))
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_masses(package: ModalPackage, out: Path) -> Path:
    """Write node, mass [kg] and inertia [kg m2] as CSV beside `out`; returns the file."""
    file = out.with_name(f"{out.stem}_masses.csv")
    lines = [",".join(["node", "mass", *PARTS])]
    for label, m, J in zip(
        package.node_ids, package.node_mass, package.node_inertia_B, strict=True
    ):
        values = [m, *(J[part] for part in PARTS.values())]
        lines.append(",".join([str(label), *(f"{value:.17g}" for value in values)]))
    write_text(file, "\n".join(lines) + "\n")
    return file
