"""Modes of ANSYS: a result file .rst of a modal analysis."""

import numpy as np

from ....solver.errors import InputError
from ..modal import ModalBody
from .ansys_library import mesh_of
from .files import Files

RIGID = 1e-3  # frequency of a rigid motion, relative to the highest in the file


def read(files: Files) -> ModalBody:
    """Body from `rst` and `masses` (CSV: node, mass and inertias).

    Rigid motions of a free body are left out.

    Raises InputError without the library, and for a file without modes of all nodes.
    """
    files.only(("rst", "masses"))
    path = files.path("rst")
    ids, nodes, cells, result = mesh_of(path)
    hertz = np.asarray(result.time_values, dtype=float)
    kept = np.flatnonzero(hertz > RIGID * hertz.max(initial=0.0))
    if not len(kept):
        raise InputError(f"{path}: expected vibrations of a modal analysis")
    kept = kept[np.argsort(hertz[kept], kind="stable")]
    shapes = np.zeros((len(kept), len(nodes), 6))
    size = 0
    for shape, number in zip(shapes, kept, strict=True):
        labels, values = result.nodal_solution(int(number))
        size = values.shape[1]
        if size not in (3, 6) or not np.array_equal(labels, ids) or np.isnan(values).any():
            raise InputError(
                f"{path}: mode {number + 1}: expected 3 or 6 displacements at each of the "
                f"{len(ids)} nodes"
            )
        shape[:, :size] = values
    return ModalBody(
        where=files.where,
        nodes=nodes,
        node_ids=ids,
        cells=cells,
        shapes=shapes,
        has_rotations=size == 6,
        hertz=hertz[kept],
        damping_ratios=np.zeros(len(kept)),
    )
