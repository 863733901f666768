"""Texts in UFL that DOLFINx compiles for points of a plane cell, evaluated for many cells.

The cells have straight or curved edges: a map of degree 2 with all 6 or 9 nodes. They need no mesh
of DOLFINx: cells of a section may share an edge but not its middle node, and `create_mesh` would
then write beyond its arrays.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import ufl

from ...solver.math.arrays import Array
from .kernels import each_cell
from .plain import NODES
from .reference_cell import order_of_nodes, reference_nodes
from .spaces import JIT, JIT_OPTIONS, element_of, quiet
from .stack import MPI, dolfinx

MOST_COORDINATES = 1000
Text = Callable[[Any, Any, Any], Any]


def evaluated(
    text: Text, cell: str, degree: int, points: Array, nodes: Array, constants: Array | None = None
) -> Array:
    """Evaluate a text in UFL at points of the reference cell, for each of some cells.

    Parameters
    ----------
    text : `text(domain, u, k)` with the UFL domain, all Lagrange functions u of `degree`
        as one argument, in the order of `reference_nodes`, and the constants k; compiled once for
        each cell, degree and rule
    points : (q, 2); at most `MOST_COORDINATES` numbers, because FFCx takes the printed array as
        part of the name of the compiled code
    nodes : (c, 6 or 9, 2) of the cells, in gmsh's order [m]
    constants : (n,)

    Returns
    -------
    (c, q, *shape of the text), with u (c, q, *shape, k) for its k functions.
    """
    if nodes.shape[1:] != (len(NODES[cell]), 2) or not np.isfinite(nodes).all():
        raise ValueError(f"{nodes.shape} nodes of {cell}s: expected (c, {len(NODES[cell])}, 2)")
    if points.ndim != 2 or points.shape[1] != 2 or points.size > MOST_COORDINATES:
        raise ValueError(f"points {points.shape}: expected (q, 2), not too many")
    k = np.zeros(0) if constants is None else np.asarray(constants, dtype=np.float64)
    address, shape, _ = compiled_text(text, cell, degree, points.tobytes(), len(k))
    out = np.zeros((len(nodes), *shape))
    x = np.zeros((*nodes.shape[:2], 3))
    x[:, order_of_nodes(cell), :2] = nodes
    each_cell(ctypes.c_void_p(address), out, np.zeros((len(nodes), 0)), k, x)
    return out


@cache
def compiled_text(
    text: Text, cell: str, degree: int, points: bytes, constants: int
) -> tuple[int, tuple[int, ...], Any]:
    """Address of the compiled text, shape of its values in a cell, and what keeps it loaded."""
    at = np.frombuffer(points).reshape(-1, 2)
    domain = ufl.Mesh(element_of(cell, 2, (2,), 2))
    functions = ufl.FunctionSpace(domain, element_of(cell, degree, (), 2))
    k = ufl.Constant(domain, shape=(constants,)) if constants else None
    expression = text(domain, ufl.TrialFunction(functions), k)
    with quiet():
        found, module, _ = dolfinx.jit.ffcx_jit(
            MPI.COMM_SELF, (expression, at), **{JIT_OPTIONS: JIT}
        )
    address = int(module.ffi.cast("intptr_t", found.tabulate_tensor_float64))
    shape = (len(at), *expression.ufl_shape)
    if ufl.algorithms.extract_arguments(expression):
        shape += (len(reference_nodes(cell, degree)),)
    return address, shape, (found, module)
