"""Mesh and modes of a MED file: the field DEPL, whose times are frequencies [Hz]."""

import h5py
import numpy as np

from ....solver.errors import InputError, nearest
from ..free_body import Cells
from ..modal import ModalBody
from ..write.med import FIELD, MED_CELLS, MESH_STEP
from .files import Files


def read(files: Files) -> ModalBody:
    """Body from `med` and `masses` (CSV: node, mass and inertias).

    Raises InputError for a file of another kind, without modes, or with values on a part only.
    """
    files.only(("med", "masses"), ("field",))
    path = files.path("med")
    name = str(files.table.get("field", FIELD))
    try:
        with h5py.File(path) as file:
            (mesh,) = (item[MESH_STEP] for item in file["ENS_MAA"].values())
            nodes = mesh["NOE/COO"][()].reshape(3, -1).T
            ids = mesh["NOE/NUM"][()] if "NUM" in mesh["NOE"] else np.arange(1, len(nodes) + 1)
            if name not in file["CHA"]:
                hint = nearest(name, file["CHA"])
                raise InputError(f"{path}: no field {name!r} of the modes{hint}")
            steps = list(file[f"CHA/{name}"].values())
            hertz = np.array([float(step.attrs["PDT"]) for step in steps])
            parts = [next(iter(step["NOE"].values()))["CO"][()] for step in steps]
            cells = _cells(mesh["MAI"])
    except (OSError, KeyError, ValueError) as error:
        raise InputError(
            f"{path}: expected a MED file with one mesh and modes ({error})"
        ) from error
    sizes = {len(part) // len(nodes) for part in parts if len(part) % len(nodes) == 0}
    if len(sizes) != 1 or not sizes <= {3, 6}:
        raise InputError(f"{path}: field {name!r}: expected 3 or 6 components at every node")
    (size,) = sizes
    shapes = np.zeros((len(parts), len(nodes), 6))
    for shape, part in zip(shapes, parts, strict=True):
        shape[:, :size] = part.reshape(size, -1).T
    order = np.argsort(hertz, kind="stable")
    ids = np.asarray(ids, dtype=np.int64)
    return ModalBody(files.where, nodes, ids, cells, shapes[order], hertz[order], size == 6)


def _cells(groups: h5py.Group) -> Cells:
    cells, types = [], []
    for kind, (title, order) in MED_CELLS.items():
        if title in groups:
            rows = groups[title]["NOD"][()].reshape(len(order), -1).T - 1
            back = np.argsort(order)
            cells += rows[:, back].tolist()
            types += [kind] * len(rows)
    return Cells.of(cells, types)
