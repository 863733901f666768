"""The only door to DOLFINx, PETSc, SLEPc, gmsh and MPI.

Everything version-dependent of the FEniCSx stack is met here, by looking for
the feature and never at a version number, so that the rest of the preprocessor
is one code for DOLFINx 0.5 up to the present one. Importing this module where
the stack is incomplete raises `MissingFenicsx` (an ImportError) that says what
is missing and how to get it.
"""

import importlib.util
import inspect
import json
import logging
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

Array = NDArray[np.float64]

HELP = (
    "Run `make fenicsx` to find or install FEniCSx, or install it yourself: on Debian and Ubuntu "
    "`apt-get install python3-dolfinx-real python3-slepc4py-real python3-gmsh python3-h5py "
    "python3-scipy`; with conda `fenics-dolfinx petsc=*=*real* slepc4py python-gmsh`."
)


class MissingFenicsx(ImportError):
    """A part of the FEniCSx stack is missing or cannot be used."""


class FactorisationError(Exception):
    """A matrix that should be symmetric positive definite is not."""


class EigenError(Exception):
    """Fewer eigenpairs than asked for, or eigenpairs that do not satisfy their equation."""


class MeshError(Exception):
    """A gmsh model that cannot become a finite-element mesh."""


try:
    from mpi4py import MPI  # first: the wheel of DOLFINx finds libmpi through it

    if importlib.util.find_spec("dolfinx_solver") is not None:
        importlib.import_module("dolfinx_solver")
    import basix
    import dolfinx
    import dolfinx.fem.petsc
    import gmsh
    import h5py
    import slepc4py
    import ufl
    from petsc4py import PETSc
    from slepc4py import SLEPc

    try:
        from dolfinx.io import gmsh as gmsh_bridge
    except ImportError:
        from dolfinx.io import gmshio as gmsh_bridge
    try:
        import basix.ufl as basix_ufl
    except ImportError:
        basix_ufl = None
except ImportError as _error:
    raise MissingFenicsx(f"{sys.executable} cannot use FEniCSx: {_error}. {HELP}") from _error

if np.dtype(PETSc.ScalarType).kind != "f":
    raise MissingFenicsx(
        f"{sys.executable} has a PETSc of complex numbers ({np.dtype(PETSc.ScalarType)}); "
        f"the real build is needed. {HELP}"
    )

_external = getattr(PETSc.Sys, "hasExternalPackage", lambda _name: False)
HAS_MUMPS = bool(_external("mumps"))


def versions() -> dict[str, str]:
    """Versions of everything that a number may depend on, for the provenance of a file."""
    return {
        "dolfinx": dolfinx.__version__,
        "basix": basix.__version__,
        "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
        "slepc": ".".join(str(part) for part in SLEPc.Sys.getVersion()),
        "slepc4py": slepc4py.__version__,
        "gmsh": str(gmsh.__version__),
        "numpy": np.__version__,
        "h5py": h5py.__version__,
        "python": sys.version.split()[0],
        "factorisation": "mumps" if HAS_MUMPS else "petsc",
    }


# ------------------------------------------------------------------ sparse linear algebra

_PETSC_ERRORS = (PETSc.Error, SystemError)  # slepc4py wraps the first in the second on some builds


def _reason(error: BaseException) -> str:
    """The last line of PETSc's message: the lines before it are its call stack."""
    return str(error.__cause__ or error).strip().splitlines()[-1]


def _petsc_matrix(A: sp.csr_matrix, *, spd: bool) -> Any:
    index = PETSc.IntType
    mat = PETSc.Mat().createAIJ(
        size=A.shape,
        csr=(A.indptr.astype(index), A.indices.astype(index), A.data),
        comm=MPI.COMM_SELF,
    )
    mat.setOption(PETSc.Mat.Option.SYMMETRIC, True)
    if spd:
        mat.setOption(PETSc.Mat.Option.SPD, True)  # MUMPS then runs with SYM=1, half an LU
    return mat


def _sorted_csr(A: Any) -> sp.csr_matrix:
    A = sp.csr_matrix(A, dtype=np.float64)
    if not A.has_sorted_indices:
        A = A.sorted_indices()
    return A


class Cholesky:
    """A factorised symmetric positive definite matrix; `update` reuses the symbolic part."""

    def __init__(self, A: Any) -> None:
        self.A = _sorted_csr(A)
        self._mat = _petsc_matrix(self.A, spd=True)
        self._pc = PETSc.PC().create(comm=MPI.COMM_SELF)
        self._pc.setOperators(self._mat)
        self._pc.setType("cholesky")
        if HAS_MUMPS:
            self._pc.setFactorSolverType("mumps")
        else:
            self._pc.setFactorOrdering(ord_type="nd")
        self._factorise()

    def update(self, A: Any) -> None:
        """Factorise another matrix of exactly the same sparsity pattern."""
        A = _sorted_csr(A)
        same = np.array_equal(A.indptr, self.A.indptr) and np.array_equal(A.indices, self.A.indices)
        if not same:
            raise FactorisationError("update() needs a matrix of the same sparsity pattern")
        self.A = A
        index = PETSc.IntType
        self._mat.zeroEntries()
        self._mat.setValuesCSR(A.indptr.astype(index), A.indices.astype(index), A.data)
        self._mat.assemble()
        self._factorise()

    def solve(self, B: Array) -> Array:
        """Solve A X = B for one (n,) or several (n, k) right-hand sides."""
        columns = np.asarray(B, dtype=np.float64).reshape(self.A.shape[0], -1)
        X = self._solve(columns)
        residual = np.abs(self.A @ X - columns).max(axis=0)
        size = self._norm * np.abs(X).max(axis=0) + np.abs(columns).max(axis=0)
        if not np.all(residual <= 1e-10 * size):
            raise FactorisationError(
                f"backward error {np.max(residual / size):.1e} of a Cholesky solve; the matrix is "
                "singular or indefinite: is every rigid motion constrained?"
            )
        return X.reshape(np.shape(B))

    def _factorise(self) -> None:
        try:
            self._pc.setUp()
        except _PETSC_ERRORS as error:
            raise FactorisationError(
                f"the matrix cannot be factorised: {_reason(error)}"
            ) from error
        self._factor = self._pc.getFactorMatrix()
        if HAS_MUMPS:
            status = self._factor.getMumpsInfog(1)
            negative = self._factor.getMumpsInfog(12)
            if status < 0 or negative > 0:
                raise FactorisationError(
                    f"the matrix is not positive definite (MUMPS: {negative} negative pivots, "
                    f"status {status}): is every rigid motion constrained?"
                )
        self._norm = float(np.abs(self.A).sum(axis=1).max())
        self._check_condition()

    def _check_condition(self) -> None:
        # A singular matrix passes the factorisation with one pivot of round-off size. A random
        # right-hand side finds it; scaling by the diagonal keeps units out of the number.
        scale = np.sqrt(np.abs(self.A.diagonal()))
        z = np.random.default_rng(0).standard_normal(scale.size)
        x = scale * self._solve((scale * z)[:, None])[:, 0]
        growth = np.linalg.norm(x) / np.linalg.norm(z)
        if not growth < 1e13:
            raise FactorisationError(
                f"the matrix is singular (scaled condition above {growth:.0e}): is every rigid "
                "motion constrained and every part connected?"
            )

    def _solve(self, columns: Array) -> Array:
        rhs = PETSc.Mat().createDense(
            columns.shape, array=np.asfortranarray(columns), comm=MPI.COMM_SELF
        )
        rhs.assemble()
        out = PETSc.Mat().createDense(columns.shape, comm=MPI.COMM_SELF)
        out.setUp()
        self._factor.matSolve(rhs, out)
        return np.array(out.getDenseArray())


def cholesky(A: Any) -> Cholesky:
    """Factorise a symmetric positive definite sparse matrix (MUMPS where PETSc has it).

    Raises FactorisationError if the matrix is indefinite or singular.
    """
    return Cholesky(A)


def eigenpairs(
    K: Any, M: Any, n_mode: int, *, target: float = 0.0, tolerance: float = 1e-12
) -> tuple[Array, Array]:
    """Eigenpairs of K x = lambda M x nearest to `target`, ascending and M-orthonormal.

    Parameters
    ----------
    K : (n, n) symmetric sparse; K - target M must be regular. Positive definite at target 0;
        a structure free to move needs a negative target.
    M : (n, n) symmetric positive semi-definite sparse (lumped masses without rotary inertia are
        allowed: massless directions have no eigenpair and are not returned).
    n_mode : number of pairs, up to the number of finite eigenvalues
    target : shift of the shift-and-invert transformation, in the unit of lambda
    tolerance : relative tolerance of the Krylov-Schur iteration

    Returns
    -------
    (n_mode,) eigenvalues and (n, n_mode) vectors with X' M X = I. Signs are SLEPc's.

    Raises
    ------
    EigenError : more pairs asked for than exist, too few converged, or a residual too large.
    """
    K, M = _sorted_csr(K), _sorted_csr(M)
    n_dof = K.shape[0]
    # rows of M without an entry are massless: each takes one eigenvalue to infinity
    n_finite = int(np.count_nonzero(np.abs(M).sum(axis=1)))
    if not 1 <= n_mode <= n_finite:
        raise EigenError(
            f"{n_mode} modes asked for: the problem of {n_dof} unknowns has {n_finite} of finite "
            "frequency"
        )
    n_krylov = max(2 * n_mode + 10, n_mode + 20)
    if n_krylov < n_finite:
        X = _krylov_schur(K, M, n_mode, n_krylov, target, tolerance)
    else:  # the Krylov space would be the whole space
        X = _dense(K, M, n_mode, target)
    return _checked(K, M, X)


def _krylov_schur(
    K: sp.csr_matrix, M: sp.csr_matrix, n_mode: int, n_krylov: int, target: float, tolerance: float
) -> Array:
    eps = SLEPc.EPS().create(comm=MPI.COMM_SELF)
    eps.setOperators(_petsc_matrix(K, spd=target == 0.0), _petsc_matrix(M, spd=False))
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(target)
    eps.setDimensions(nev=n_mode, ncv=n_krylov)
    eps.setTolerances(tol=tolerance, max_it=500)
    transformation = eps.getST()
    transformation.setType(SLEPc.ST.Type.SINVERT)
    transformation.setShift(target)
    ksp = transformation.getKSP()
    ksp.setType("preonly")
    pc = ksp.getPC()
    # PETSc's own Cholesky does not pivot: an indefinite matrix gets an LU there
    pc.setType("cholesky" if HAS_MUMPS or target <= 0.0 else "lu")
    if HAS_MUMPS:
        pc.setFactorSolverType("mumps")
    start = PETSc.Vec().createSeq(K.shape[0], comm=MPI.COMM_SELF)
    start.setArray(np.random.default_rng(0).standard_normal(K.shape[0]))  # runs must reproduce
    eps.setInitialSpace([start])
    try:
        eps.solve()
    except _PETSC_ERRORS as error:
        raise EigenError(
            f"K - {target:g} M cannot be factorised ({_reason(error)}): is the body free to move? "
            "A negative target is needed then"
        ) from error
    n_converged = eps.getConverged()
    if n_converged < n_mode:
        raise EigenError(
            f"{n_converged} of {n_mode} modes converged in {eps.getIterationNumber()} iterations "
            f"(tolerance {tolerance:g})"
        )
    vector = start.duplicate()
    X = np.empty((K.shape[0], n_mode))
    for i in range(n_mode):
        eps.getEigenvector(i, vector)
        X[:, i] = vector.getArray()
    return X


def _dense(K: sp.csr_matrix, M: sp.csr_matrix, n_mode: int, target: float) -> Array:
    # M may be singular and K - shift M is not: its pencil is the inverse one. Beyond the lowest
    # eigenvalue the shifted matrix is indefinite, so a positive target shifts nothing here.
    shift = min(target, 0.0)
    shifted = (K - shift * M).toarray()
    try:
        inverse, X = scipy.linalg.eigh(M.toarray(), shifted)
    except scipy.linalg.LinAlgError as error:
        raise EigenError(
            "K is not positive definite: is the body free to move? A negative target is needed then"
        ) from error
    finite = inverse > 1e-15 * inverse[-1]
    values = np.full_like(inverse, np.inf)
    values[finite] = shift + 1.0 / inverse[finite]
    order = np.argsort(np.abs(values - target), kind="stable")[:n_mode]
    if not np.all(np.isfinite(values[order])):
        raise EigenError(
            f"{n_mode} modes asked for, {np.count_nonzero(finite)} have a finite frequency"
        )
    return X[:, order]


def _checked(K: sp.csr_matrix, M: sp.csr_matrix, X: Array) -> tuple[Array, Array]:
    """Ritz pairs of the span of X, ascending, after a check of their residuals."""
    X = X / np.sqrt(np.einsum("ni,ni->i", X, M @ X))
    values, Y = scipy.linalg.eigh(X.T @ (K @ X), X.T @ (M @ X))
    X = X @ Y
    KX, MX = K @ X, M @ X
    residual = np.linalg.norm(KX - MX * values, axis=0)
    size = np.linalg.norm(KX, axis=0) + np.abs(values) * np.linalg.norm(MX, axis=0)
    # a rigid motion has K x = 0: its residual is measured by the forces that K makes of x
    size = np.maximum(size, np.abs(K).max() * np.linalg.norm(X, axis=0) * 1e-6)
    worst = int(np.argmax(residual / size))
    if not residual[worst] <= 1e-6 * size[worst]:
        raise EigenError(
            f"residual {residual[worst] / size[worst]:.1e} of mode {worst + 1} is too large"
        )
    return values, X


# ------------------------------------------------------------------ gmsh

_session_depth = 0


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """A gmsh without terminal output and without the user's own option files; may be nested."""
    global _session_depth
    if _session_depth == 0:
        keywords: dict[str, Any] = {"readConfigFiles": False}
        if "interruptible" in inspect.signature(gmsh.initialize).parameters:
            keywords["interruptible"] = False  # Ctrl-C stays Python's
        gmsh.initialize([], **keywords)
        gmsh.option.setNumber("General.Terminal", 0)
    _session_depth += 1
    try:
        yield gmsh
    finally:
        _session_depth -= 1
        if _session_depth == 0:
            gmsh.finalize()


@dataclass(frozen=True)
class LabelledMesh:
    """A DOLFINx mesh whose cells know their physical group."""

    mesh: Any
    cell_labels: NDArray[np.int32]  # (n_cell,), in DOLFINx's cell order
    names: dict[str, int]  # physical name -> label

    @property
    def n_cell(self) -> int:
        """Number of cells."""
        return int(self.cell_labels.size)


def mesh_from_geo(
    path: Path, parameters: Mapping[str, float], *, dimension: int = 2, gdim: int = 2
) -> LabelledMesh:
    """Mesh a gmsh script with values for its parameters.

    Parameters
    ----------
    path : a .geo file whose DefineConstant entries are named "Parameters/<key>"
    parameters : value of each <key>; a key that the script does not define is an error
    dimension, gdim : of the cells, of the space

    Raises
    ------
    MeshError : missing file, unknown parameter, gmsh error, cells without physical group.
    """
    if not path.is_file():
        raise MeshError(f"{path}: no such gmsh script")
    text = path.read_text(encoding="utf-8")
    for key in parameters:
        if f'"Parameters/{key}"' not in text:
            raise MeshError(f"{path}: the script has no parameter {key}")
    with gmsh_session():
        gmsh.clear()
        gmsh.onelab.clear()
        gmsh.onelab.set(
            json.dumps(
                [
                    {"type": "number", "name": f"Parameters/{key}", "values": [float(value)]}
                    for key, value in parameters.items()
                ]
            )
        )
        try:
            gmsh.merge(str(path))
            gmsh.model.mesh.generate(dimension)
        except Exception as error:  # gmsh raises bare Exception or ValueError
            raise MeshError(f"{path}: gmsh: {error}") from error
        labelled = mesh_from_model(dimension, gdim, str(path))
        gmsh.clear()
        gmsh.onelab.clear()
    return labelled


def mesh_from_model(dimension: int = 2, gdim: int = 2, where: str = "gmsh model") -> LabelledMesh:
    """Convert the current gmsh model; every entity of the dimension needs one physical group."""
    for _, tag in gmsh.model.getEntities(dimension):
        groups = gmsh.model.getPhysicalGroupsForEntity(dimension, tag)
        if len(groups) != 1:
            raise MeshError(
                f"{where}: entity {tag} of dimension {dimension} is in {len(groups)} physical "
                "groups, expected exactly one"
            )
    names = {
        gmsh.model.getPhysicalName(dimension, tag): int(tag)
        for _, tag in gmsh.model.getPhysicalGroups(dimension)
    }
    if not names:
        raise MeshError(f"{where}: no physical group of dimension {dimension}")
    with _quiet():
        converted = gmsh_bridge.model_to_mesh(gmsh.model, MPI.COMM_SELF, 0, gdim=gdim)
    mesh, tags = converted[0], converted[1]
    labels = np.full(mesh.topology.index_map(mesh.topology.dim).size_local, -1, dtype=np.int32)
    labels[tags.indices] = tags.values
    return LabelledMesh(mesh, labels, names)


# ------------------------------------------------------------------ spaces, forms, assembly


def _function_space(mesh: Any, element: Any) -> Any:
    make = getattr(dolfinx.fem, "functionspace", None) or dolfinx.fem.FunctionSpace
    with _quiet():
        return make(mesh, element)


def cell_name(mesh: Any) -> str:
    """Name of the cells, e.g. "quadrilateral"."""
    name = mesh.ufl_cell().cellname
    return str(name() if callable(name) else name)


def vector_space(mesh: Any, degree: int, size: int) -> Any:
    """Continuous Lagrange space of `size` components."""
    if basix_ufl is not None:
        element = basix_ufl.element("Lagrange", cell_name(mesh), degree, shape=(size,))
    else:
        element = ufl.VectorElement("Lagrange", mesh.ufl_cell(), degree, dim=size)
    return _function_space(mesh, element)


def cell_space(mesh: Any, shape: tuple[int, ...] = ()) -> Any:
    """One constant value (scalar, vector or tensor) in each cell; see `set_cell_values`."""
    name = cell_name(mesh)
    if basix_ufl is not None:
        element = basix_ufl.element("DG", name, 0, shape=shape)
    else:
        family = "DQ" if name in ("quadrilateral", "hexahedron") else "DG"
        if shape:
            element = ufl.TensorElement(family, mesh.ufl_cell(), 0, shape=shape)
        else:
            element = ufl.FiniteElement(family, mesh.ufl_cell(), 0)
    return _function_space(mesh, element)


def function(space: Any) -> Any:
    """A zero function of the space."""
    return dolfinx.fem.Function(space)


def set_cell_values(target: Any, values: Array) -> None:
    """Set a function of `cell_space` from one value (or tensor) per cell, (n_cell, ...)."""
    rows = cell_dofs(target.function_space)[:, 0]
    table = target.x.array.reshape(rows.size, -1)
    table[rows] = np.reshape(values, (rows.size, -1))


def dof_coordinates(space: Any) -> Array:
    """Coordinates of the nodes of a space, (n_node, 3) [m]."""
    return np.array(space.tabulate_dof_coordinates())


def cell_dofs(space: Any) -> NDArray[np.int32]:
    """Nodes of each cell, (n_cell, nodes per cell), in DOLFINx's order."""
    table = space.dofmap.list
    if hasattr(table, "offsets"):  # AdjacencyList: all cells are of one kind
        table = np.asarray(table.array).reshape(len(table.offsets) - 1, -1)
    return np.array(table, dtype=np.int32)


def compile_forms(forms: Sequence[Any]) -> list[Any]:
    """Compile UFL forms; the machine code is kept on disk and shared by later processes."""
    with _quiet():
        return [dolfinx.fem.form(form) for form in forms]


def assemble(form: Any) -> sp.csr_matrix:
    """Assemble a compiled bilinear form without boundary conditions into a CSR matrix."""
    matrix = dolfinx.fem.petsc.assemble_matrix(form)
    matrix.assemble()
    indptr, indices, data = matrix.getValuesCSR()
    shape = matrix.getSize()
    matrix.destroy()
    return sp.csr_matrix((data, indices, indptr), shape=shape)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the compiler calls of form compilation out of the user's log."""
    previous = logging.root.manager.disable
    logging.disable(max(previous, logging.INFO))
    try:
        yield
    finally:
        logging.disable(previous)
