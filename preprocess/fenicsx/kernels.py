"""Text in UFL that is no integral, compiled for each cell: lists of pairs (stress, strain).

A list is compiled by FFCx as one `Expression`: rows that are linear in the unknowns of a cell,
first the stresses of all pairs, then their strains, then rows that couple two lists, then others.
One kernel in C calls the lists, adds stress' strain and turns the sum from the axes E of the cell
to G; DOLFINx assembles what it gives. It reads the lists from the constants of the form, so one
kernel serves all lists.

Coordinates of corners come from `ufl.geometry.CellVertices`, other data from one table with a row
for each cell, the only coefficient; its first nine numbers are the rotation v_G = A_GE v_E. The
unknowns are vectors in E, three and three components of an `Argument` that is constant in a cell.

`evaluated` gives values of other texts at points of plane cells with straight or curved edges: a
map of degree 2 with all 6 or 9 nodes. They need no mesh of DOLFINx: cells of a section may share an
edge but not its middle node, and `create_mesh` would then write beyond its arrays."""

import ctypes
import hashlib
import os
import platform
import shlex
import subprocess
import sysconfig
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import ufl

from ...solver.errors import COMPILER
from ...solver.math.arrays import Array
from ...solver.math.disk_cache import DiskCache
from .libraries import HELP, MPI, MissingFenicsx, dolfinx
from .plain_mesh import NODES, order_of_nodes, reference_nodes
from .spaces import JIT, JIT_OPTIONS, element_of, quiet

# Of the lists. With -O2 they compile half as long again and run 5 % faster; with Python's own -g
# and warnings two and a half times as long.
OPTIONS = ["-O1", "-g0", "-w"]
POINT = np.array([[0.25, 0.25]])  # anywhere: rows are the same in all of a cell

# Newer versions of FFCx have a seventh argument, which older functions ignore.
SOURCE = r"""
#include <stdint.h>
#include <string.h>

typedef void rows_of_cell(double *, const double *, const double *, const double *, const int *,
                          const uint8_t *, void *);
struct list { rows_of_cell *rows; int64_t pairs, coupling, count; };
struct lists { int64_t unknowns, rows, lists; struct list list[]; };

static void mirror(double *K, int64_t n)
{
  for (int64_t i = 0; i < n; ++i)
    for (int64_t j = 0; j < i; ++j)
      K[i * n + j] = K[j * n + i];
}

/* Rows for vectors in E -> rows for vectors in G. Paper: Eq. (23). */
static void turn(double *row, int64_t components, const double *A_GE)
{
  for (double *v = row; v < row + components; v += 3) {
    const double x = v[0], y = v[1], z = v[2];
    for (int i = 0; i < 3; ++i)
      v[i] = A_GE[3 * i] * x + A_GE[3 * i + 1] * y + A_GE[3 * i + 2] * z;
  }
}

/* K (n, n) of vectors in E -> that of vectors in G, from its upper triangle. */
static void turn_both(double *K, int64_t n, const double *A_GE)
{
  mirror(K, n);
  for (int64_t i = 0; i < n; ++i)
    turn(K + i * n, n, A_GE);
  for (int64_t i = 0; i < n; i += 3)
    for (int64_t j = i; j < n; ++j) {
      double column[3] = {K[i * n + j], K[(i + 1) * n + j], K[(i + 2) * n + j]};
      turn(column, 3, A_GE);
      for (int64_t k = 0; k < 3; ++k)
        K[(i + k) * n + j] = column[k];
    }
  mirror(K, n);
}

/* Most unknowns in E have no part in a strain. */
static void add(int64_t n, double *K, const double *stress, const double *strain)
{
  for (int64_t i = 0; i < n; ++i)
    if (strain[i] != 0.0)
      for (int64_t j = i; j < n; ++j)
        K[i * n + j] += strain[i] * stress[j];
}

void matrix_of_cell(double *K, const double *w, const double *c, const double *x, const int *e,
                    const uint8_t *p, void *data)
{
  const struct lists *all = (const void *)c;
  const int64_t n = all->unknowns;
  double store[all->rows][n], (*row)[n] = store, (*other)[n] = 0;
  memset(store, 0, sizeof store);
  for (const struct list *l = all->list; l < all->list + all->lists; ++l) {
    l->rows(row[0], w, c, x, e, p, data);
    for (int64_t q = 0; q < l->pairs; ++q)
      add(n, K, row[q], row[l->pairs + q]);
    double (*coupling)[n] = row + 2 * l->pairs;
    for (int64_t q = 0; other && q < l->coupling; ++q) {
      add(n, K, coupling[q], other[q]);
      add(n, K, other[q], coupling[q]);
    }
    if (l->coupling) other = coupling;
    row += l->count;
  }
  turn_both(K, n, w);
}

void rows_in_G(double *rows, const double *w, const double *c, const double *x, const int *e,
               const uint8_t *p, void *data)
{
  const struct lists *all = (const void *)c;
  all->list->rows(rows, w, c, x, e, p, data);
  turn(rows, all->list->count * all->unknowns, w);
}

void each_cell(rows_of_cell *function, int64_t cells, int64_t size, int64_t columns,
               int64_t coordinates, double *out, const double *w, const double *c, const double *x)
{
  for (int64_t i = 0; i < cells; ++i)
    function(out + i * size, w + i * columns, c, x + i * coordinates, 0, 0, 0);
}
"""


class Symbols(NamedTuple):
    """What the text of a cell is written with: UFL objects.

    `corners` (k, 3) in DOLFINx's order, `table` (columns,) and `unknowns` (n,) of the cell.
    """

    corners: Any
    table: Any
    unknowns: Any


def symbols(cell: str, columns: int, unknowns: int) -> Symbols:
    """Symbols of triangles or quadrilaterals in space.

    Parameters
    ----------
    cell : "triangle" or "quadrilateral"
    columns : numbers that the table has of a cell
    unknowns : of a cell
    """
    domain = ufl.Mesh(element_of(cell, 1, (3,), 3))
    constant = [element_of(cell, 0, (n,), 3, dg=True) for n in (columns, unknowns)]
    table, rows = (ufl.FunctionSpace(domain, element) for element in constant)
    # FFCx of DOLFINx 0.5 makes no valid name in C of a number above 9, which UFL would count up to
    only = ufl.Coefficient(table, count=0)
    return Symbols(ufl.geometry.CellVertices(domain), only, ufl.TestFunction(rows))


@dataclass(frozen=True)
class Rows:
    """A compiled list of `count` rows: 2 `pairs` of stresses and strains, `coupling`, others."""

    compiled: Any  # holds the library
    address: int
    pairs: int
    coupling: int
    count: int
    columns: int  # of the table


def compiled(
    columns: int, stresses: Sequence[Any], strains: Sequence[Any],
    coupling: Sequence[Any] = (), others: Sequence[Any] = (),
) -> Rows:  # fmt: skip
    """Compile a list of rows, each a scalar in UFL that is linear in the unknowns.

    Parameters
    ----------
    columns : of the table
    stresses, strains : rows of the pairs, as many of each
    coupling : rows that couple lists (`Kernel`)
    others : rows that are only evaluated (`rows`)

    Raises
    ------
    MissingFenicsx : there is no C compiler, or it fails.
    """
    library()  # without a compiler it has the better message
    rows = [*stresses, *strains, *coupling, *others]
    address, keeps = _by_ffcx(ufl.as_vector(rows), POINT, cffi_extra_compile_args=OPTIONS)
    return Rows(keeps, address, len(stresses), len(coupling), len(rows), columns)


def _by_ffcx(expression: Any, points: Array, **options: Any) -> tuple[int, Any]:
    """Address of a compiled expression at points, and what keeps it loaded."""
    jit = dolfinx.jit.ffcx_jit
    with quiet():
        compiled, module, _ = jit(
            MPI.COMM_SELF, (expression, points), **{JIT_OPTIONS: {**JIT, **options}}
        )
    return int(module.ffi.cast("intptr_t", compiled.tabulate_tensor_float64)), (compiled, module)


@dataclass(frozen=True)
class Kernel:
    """Lists whose matrices of cells are summed; those with coupling rows are coupled.

    Attributes
    ----------
    unknowns : of a cell
    lists : they stay alive as long as the kernel
    constants : the lists as the kernel in C reads them, a structure in a vector of numbers
    """

    unknowns: int
    lists: tuple[Rows, ...]
    constants: Array

    def check(self, columns: int, corners: int) -> None:
        """Raise ValueError if cells or data are not those of the lists, which read past them."""
        if 6 * corners != self.unknowns:
            raise ValueError(f"cells of {corners} corners for a kernel of {self.unknowns} unknowns")
        for rows in self.lists:
            if rows.columns != columns:
                raise ValueError(f"{columns} columns of data, expected {rows.columns}")


def kernel(unknowns: int, lists: Sequence[Rows]) -> Kernel:
    """The kernel of some lists of a cell."""
    words = [unknowns, sum(rows.count for rows in lists), len(lists)]
    for rows in lists:
        words += [rows.address, rows.pairs, rows.coupling, rows.count]
    return Kernel(unknowns, tuple(lists), np.array(words, dtype=np.int64).view(np.float64))


def matrices(given: Kernel, table: Array, corners: Array) -> Array:
    """Matrices of single cells, (c, n, n), in G.

    Parameters
    ----------
    given : lists of pairs of a cell with n unknowns
    table : (c, columns)
    corners : (c, k, 3) in DOLFINx's order
    """
    out = np.zeros((len(table), given.unknowns**2))
    _each(library().matrix_of_cell, given, out, table, corners)
    return out.reshape(-1, given.unknowns, given.unknowns)


def rows(given: Kernel, number: int, table: Array, corners: Array) -> Array:
    """Rows of one list for single cells, for unknowns in G, (c, rows, n).

    Parameters
    ----------
    table : (c, columns)
    corners : (c, k, 3) in DOLFINx's order
    """
    alone = kernel(given.unknowns, [given.lists[number]])
    out = np.zeros((len(table), alone.lists[0].count * alone.unknowns))
    _each(library().rows_in_G, alone, out, table, corners)
    return out.reshape(len(table), -1, alone.unknowns)


def _each(function: Any, given: Kernel, out: Array, table: Array, corners: Array) -> None:
    w, x = (np.ascontiguousarray(a, dtype=np.float64) for a in (table, corners))
    if len(w) != len(x):
        raise ValueError(f"{len(w)} rows of data for {len(x)} cells")
    given.check(w.shape[1], x.shape[1])
    _each_cell(function, out, w, given.constants, x)


def _each_cell(function: Any, out: Array, w: Array, constants: Array, x: Array) -> None:
    """Call a function that FFCx or we have compiled for each cell.

    Arrays are contiguous, those but `constants` with a first axis of cells: `out` of zeros, `w`
    coefficients, `x` (c, nodes, 3) in the order of Basix.
    """
    numbers = [len(x), *(a[0].size if len(x) else 0 for a in (out, w, x))]
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in (out, w, constants, x)]
    library().each_cell(function, *(ctypes.c_int64(number) for number in numbers), *pointers)


def matrix_form(space: Any) -> tuple[Any, int]:
    """Bilinear form of a space with the kernel in C, and the number of its integral.

    Its lists come with the constants, its table with the coefficients when it is assembled.
    """
    address = ctypes.cast(library().matrix_of_cell, ctypes.c_void_p).value
    kind, topology = dolfinx.fem.IntegralType.cell, space.mesh.topology
    cells = np.arange(topology.index_map(topology.dim).size_local, dtype=np.int32)
    coefficients = np.zeros(0, dtype=np.int8)
    mesh = getattr(space.mesh, "_cpp_object", None)
    known: list[tuple[int, Any, tuple[Any, ...]]] = [
        (0, [(0, address, cells, coefficients)], ([], mesh)),  # DOLFINx 0.10 and later
        (-1, [(-1, address, cells, coefficients)], ({}, None)),  # 0.8 and 0.9
        (-1, [(-1, address, cells)], (None,)),  # 0.7
        (-1, ([(-1, address)], None), (None,)),  # earlier
    ]
    for number, integrals, rest in known:
        arguments = [space._cpp_object] * 2, {kind: integrals}, [], [], False, *rest
        try:
            return dolfinx.cpp.fem.Form_float64(*arguments), number
        except TypeError:
            continue
    raise MissingFenicsx(
        f"this DOLFINx ({dolfinx.__version__}) takes no kernels in C as we know it"
    )


@cache
def library() -> Any:
    """The kernel in C, from the cache or compiled.

    Raises
    ------
    MissingFenicsx : there is no C compiler, or it fails.
    """
    compiler = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
    command = [*shlex.split(compiler), "-O3", "-shared", "-fPIC", "-x", "c", "-"]
    key = hashlib.sha256("\n".join([*command, platform.machine(), SOURCE]).encode()).hexdigest()
    kept = DiskCache("kernels", 8)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "kernel.so"
        content = kept.read(key)
        if content is not None:
            path.write_bytes(content)
        else:
            _build([*command, "-o", str(path)])
            kept.write(key, path.read_bytes())
        return ctypes.CDLL(str(path))  # stays loaded without its file


def _build(command: Sequence[str]) -> None:
    try:
        done = subprocess.run(command, input=SOURCE, text=True, capture_output=True, check=False)
    except OSError as error:
        what = f"no C compiler {command[0]!r} ({error}). {COMPILER}"
        raise MissingFenicsx(f"{what}. {HELP}") from None
    if done.returncode:
        raise MissingFenicsx(f"{command[0]} cannot compile the kernel of shells: {done.stderr}")


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
    _each_cell(ctypes.c_void_p(address), out, np.zeros((len(nodes), 0)), k, x)
    return out


@cache
def compiled_text(
    text: Text, cell: str, degree: int, points: bytes, constants: int
) -> tuple[int, tuple[int, ...], Any]:
    """Address of the compiled text, shape of its values in a cell, and what keeps it loaded.

    Parameters
    ----------
    text, cell, degree : as of `evaluated`
    points : bytes of the points (q, 2)
    constants : how many there are
    """
    at = np.frombuffer(points).reshape(-1, 2)
    domain = ufl.Mesh(element_of(cell, 2, (2,), 2))
    functions = ufl.FunctionSpace(domain, element_of(cell, degree, (), 2))
    k = ufl.Constant(domain, shape=(constants,)) if constants else None
    expression = text(domain, ufl.TrialFunction(functions), k)
    address, keeps = _by_ffcx(expression, at)
    shape = (len(at), *expression.ufl_shape)
    if ufl.algorithms.extract_arguments(expression):
        shape += (len(reference_nodes(cell, degree)),)
    return address, shape, keeps
