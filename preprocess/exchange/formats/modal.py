"""Bodies of which a source has modes only.

Computed modes without matrices, and measured ones, take the same way: shapes at nodes, masses of
the nodes, and corrections that make the shapes orthonormal in these masses.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ....solver.errors import InputError, nearest
from ....solver.math.arrays import Array
from ....solver.package import ModalPackage
from ....solver.package.body.measured import Measurement, experimental_package
from ....solver.package.common.files import write_text
from ..free_body import ModalBody, rows_of
from ..import_table import Files, Reduction, damping_ratio, provenance, sizes
from ..imported_interfaces import interface_rows
from .matrices import table_rows

LINES = {3: ((0, 1),), 5: ((0, 1), (1, 2), (2, 0)), 9: ((0, 1), (1, 2), (2, 3), (3, 0))}
LINES |= {22: LINES[5], 23: LINES[9]}
PARTS = {"Jxx": (0, 0), "Jyy": (1, 1), "Jzz": (2, 2), "Jxy": (0, 1), "Jxz": (0, 2), "Jyz": (1, 2)}


def modal_package(body: ModalBody, table: Reduction, files: Files) -> ModalPackage:
    """Package of the lowest modes, made as that of measured ones.

    Raises InputError for nodes without masses, fewer modes than requested, other requests, and
    shapes that contradict the reference or each other.

    Parameters
    ----------
    body : modes and mesh in the units of the source
    table : content of the import file
    files : those of the import file; `masses` is read if the body has no masses
    """
    length, mass, time = sizes(table["units"])
    wanted = sum(mode["count"] for mode in table["modes"] if mode["kind"] == "lowest")
    if any(mode["kind"] != "lowest" for mode in table["modes"]):
        raise InputError(
            f'{body.where}: modes: expected kind = "lowest": the source has modes only'
        )
    if not 0 < wanted <= len(body.hertz):
        raise InputError(f"{body.where}: modes: {wanted} of {len(body.hertz)} modes requested")
    masses = _masses(body, files, length, mass)
    total = table.get("total_mass")
    weighed = float(masses[:, 0].sum())
    if total is not None and abs(weighed - total) > 1e-3 * total:
        raise InputError(
            f"{body.where}: total_mass = {total:.9g} kg, but the nodes have {weighed:.9g} kg"
        )
    metres = replace(body, nodes=body.nodes * length)
    places = {
        name: interface_rows(metres, entry, length, f"{body.where}: interfaces.{name}")
        for name, entry in table["interfaces"].items()
    }
    needed = np.isin(np.arange(len(masses)), np.concatenate([*places.values(), []]))
    needed |= masses[:, 0] > 0.0
    if held := _held(body.where, table):
        needed[places[held]] = False
    lacking = np.flatnonzero(needed & np.isnan(body.shapes).any(axis=(0, 2)))
    if len(lacking):
        raise InputError(
            f"{body.where}: node {body.node_ids[lacking[0]]} ({len(lacking)} such nodes) has no "
            "displacement in a mode; expected one at every node with mass, or of an interface but "
            "the held one"
        )
    order = np.argsort(body.hertz, kind="stable")[:wanted]
    hertz, shapes = body.hertz[order] / time, np.nan_to_num(body.shapes[order])
    shapes[..., 3:] *= length  # a rotation per unit of the same shape
    if not hertz.min(initial=1.0) > 0.0:
        raise InputError(f"{body.where}: expected frequencies above 0, found {hertz.min():g} Hz")
    damping = np.full(wanted, damping_ratio(table, body.where))
    if body.damping_ratios is not None and "damping_ratio" not in table:
        damping = body.damping_ratios[order]
    inertia = np.zeros((len(masses), 3, 3))
    for k, (i, j) in enumerate(PARTS.values(), 1):
        inertia[:, i, j] = inertia[:, j, i] = masses[:, k]
    measurement = Measurement(
        body=table["body"],
        held=held,
        interfaces=places,
        lines=_lines(body),
        node_ids=body.node_ids,
        nodes_B=metres.nodes,
        node_mass=masses[:, 0],
        node_inertia_B=inertia,
        shapes_B=shapes,
        has_rotations=body.has_rotations,
        frequencies=2.0 * np.pi * hertz,
        damping_ratios=damping,
        labels=tuple(f"vibration {i + 1}" for i in range(wanted)),
    )
    notes = provenance(table, files.notes(), len(body.nodes), "masses of the nodes")
    try:
        return experimental_package(measurement, notes)
    except InputError as error:
        raise InputError(f"{body.where}: {error}") from error


def _held(where: str, table: Reduction) -> str | None:
    """Return the interface that carries the frame; None: none, of a free body."""
    kind, at = table["reference"]["kind"], table["reference"].get("at")
    if kind == "mean-axis" and at is None:
        return None
    if kind != "clamped" or not isinstance(at, str):
        raise InputError(
            f'{where}: reference: expected kind = "clamped" with one `at`, or "mean-axis" without: '
            "the source has modes only"
        )
    if at not in table["interfaces"]:
        hint = nearest(at, table["interfaces"])
        raise InputError(f'{where}: reference.at = "{at}": no such interface{hint}')
    return at


def _masses(body: ModalBody, files: Files, length: float, mass: float) -> Array:
    """Mass and six inertias of the nodes, (n, 7), in SI."""
    masses = np.zeros((len(body.nodes), 7))
    if body.mass is not None:
        masses[:, 0] = body.mass * mass
        return masses
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
        if (masses[at] != 0.0).any():
            raise InputError(f"{path}:{number}: node {label} has a line before this one, too")
        masses[at, : len(values)] = values
    if not (masses[:, 0] >= 0.0).all() or not masses[:, 0].sum() > 0.0:
        raise InputError(f"{path}: expected masses >= 0 with a sum > 0")
    return masses * mass * np.array([1.0, *[length**2] * 6])


def _lines(body: ModalBody) -> list[list[int]]:
    """Edges of the cells that are lines or faces, by rows of nodes."""
    pairs = set()
    for kind, rows in body.cells.each():
        for a, b in LINES.get(kind, ()):
            pairs.add(tuple(sorted(rows[[a, b]].tolist())))
    return [list(pair) for pair in sorted(pairs)]


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
