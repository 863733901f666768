"""Reference conditions: six equations that define the body frame of a deforming body.

Modes and static shapes are computed among the displacements that fulfil the condition of the
frame:

- `HeldDofs`: six dofs that prevent all rigid motions are zero. For the clamped frame they are all
  six of one node. For the chord frame they are the three displacements and the twist of one node
  and the two transverse displacements of another; its x axis runs through both nodes.
  - `MeanAxis`: the body is free and its shapes have neither linear nor angular momentum,
  R' M u = 0 with the rigid motions R. The paper mentions it in section 2.3.

The conditions describe the same body: with all modes kept, each gives the same equations of motion
in other coordinates.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from ...solver.math.arrays import Array, IntArray, smallest_eigenvalue
from ..parts import Part

# Dofs of the nodes that carry a frame which are zero in it, by kind of the condition.
HELD = {"clamped": (range(6),), "chord": ((0, 1, 2, 3), (1, 2))}
LEAST_INERTIA = 1e-12  # smallest eigenvalue of the rigid body's mass of unit diagonal

# K, M sparse and n: the n lowest values and vectors of K x = value M x, K positive definite
EigenSolver = Callable[[Any, Any, int], tuple[Array, Array]]


class ModeError(Exception):
    """The model does not have the requested modes, or modes fail their checks."""


def without_exchanges(A: sp.csc_matrix) -> Any:
    """Factors of a matrix that needs no row exchanges."""
    how = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0}
    return spla.splu(A, **how, options={"SymmetricMode": True})


def solve_indefinite(A: Any, B: Array, factors_of: Callable[[Any], Any] = spla.splu) -> Array:
    """Solve A X = B, A sparse symmetric and regular, one step of refinement included.

    Parameters
    ----------
    A : matrix (n, n)
    B : right-hand sides (n, k)
    factors_of : factors of a sparse matrix
    """
    scale = sp.diags(1.0 / np.sqrt(np.abs(A.diagonal())))
    factors = factors_of((scale @ A @ scale).tocsc())
    X = scale @ factors.solve(scale @ B)
    return np.asarray(X + scale @ factors.solve(scale @ (B - A @ X)))


solve_definite = partial(solve_indefinite, factors_of=without_exchanges)


class Algebra(NamedTuple):
    """Direct solvers for sparse symmetric matrices: those of SciPy, or faster ones."""

    solve: Callable[[Any, Array], Array]  # A X = B of a positive definite A
    negative_pivots: Callable[[Any], int]  # number of negative eigenvalues
    solve_indefinite: Callable[[Any, Array], Array] = solve_indefinite  # of any regular A


class StaticShapes(NamedTuple):
    """Static shapes u relative to the frame: K u = load, except for the reactions of held dofs."""

    columns: Array  # (n_dof, k) u
    accelerations: Array  # (n_dof, k) a, of which M a is the distributed part of the load
    loads: Array  # (n_dof, k) nodal forces + M a


class HeldDofs:
    """Frame fixed to six dofs.

    Attributes
    ----------
    K, M : (n_dof, n_dof) stiffness and mass of the free body, six dofs per node
    free : dofs that move, `n_free` of them, whose equations the modes fulfil
    n_finite : number of elastic modes of finite frequency
    """

    def __init__(self, K: Any, M: Any, held: IntArray, algebra: "Algebra | None" = None) -> None:
        self.K, self.M = K.tocsr(), M.tocsr()
        self.algebra = algebra or SCIPY
        self.free = np.setdiff1d(np.arange(self.K.shape[0]), held)
        self._K_free, self._M_free = (principal(A, self.free) for A in (self.K, self.M))
        self.n_finite = _massive(self._M_free)
        self.n_free = len(self.free)

    def lowest(self, count: int, solver: EigenSolver) -> tuple[Array, Array]:
        """Ascending values (count,) and M-orthonormal columns (n_dof, count)."""
        columns = self._expanded(solver(self._K_free, self._M_free, count)[1])
        return _rayleigh(self.K, self.M, columns), columns

    def count_below(self, value: float) -> int:
        """Number of elastic eigenvalues below a value."""
        return self.algebra.negative_pivots(self._K_free - value * self._M_free)

    def static(self, forces: Array, accelerations: Array) -> StaticShapes:
        """Shapes under nodal forces (n_dof, k) and loads M a, a = accelerations (n_dof, k)."""
        loads = forces + self.M @ accelerations
        columns = self._expanded(self.algebra.solve(self._K_free, loads[self.free]))
        return StaticShapes(columns, accelerations, loads)

    def relief(self, loads: Array) -> Array:
        """Accelerations (n_dof, k) of a free body that balance loads (n_dof, k).

        Also the rigid motion in the derivative of shapes, with that of the mass times them as load.
        Zero here: the held dofs carry all loads.
        """
        return np.zeros_like(loads)

    def load_rates(
        self, static: StaticShapes, mass: Any, forces: Array, accelerations: Array
    ) -> tuple[Array, Array]:
        """Derivatives of accelerations and loads of static shapes by a parameter.

        Parameters
        ----------
        static : the k shapes
        mass : (n_dof, n_dof) derivative of the mass
        forces, accelerations : (n_dof, k) derivatives of those that were given
        """
        return accelerations, forces + mass @ static.accelerations + self.M @ accelerations

    def _expanded(self, X_free: Array) -> Array:
        columns = np.zeros((self.K.shape[0], X_free.shape[1]))
        columns[self.free] = X_free
        return columns


class MeanAxis:
    """Frame at the mean position of a free body: no shape has linear or angular momentum.

    Static loads are balanced by the inertia of the rigid body, or by reactions at six dofs.
    Raises ModeError for a body without inertia about some axis, which has no mean orientation.
    """

    def __init__(
        self,
        K: Any,
        M: Any,
        rigid: Array,
        algebra: "Algebra | None" = None,
        still: "IntArray | None" = None,
        *,
        reactions: bool = False,
    ) -> None:
        """`rigid` (n_dof, 6): rigid motions R of the nodes.

        `still`: six dofs that prevent rigid motions; absent: those of the first node. `reactions`:
        they carry the loads of static shapes.
        """
        self.algebra = algebra or SCIPY
        self.K, self.M, self.rigid = K.tocsr(), M.tocsr(), rigid
        self._MR = self.M @ rigid
        inertia = rigid.T @ self._MR
        size = np.sqrt(np.abs(np.diag(inertia)))
        size[3:] = size[3:].max()
        if not smallest_eigenvalue(inertia, size) > LEAST_INERTIA:
            raise ModeError(
                "reference: a mean-axis frame needs inertia about every axis, but the body has "
                "none about one (see its section's mass): expected clamped or chord"
            )
        self._inertia = scipy.linalg.cho_factor(inertia)
        # For loads in equilibrium, any six dofs that prevent rigid motions can be held: no
        # reactions.
        self._held = np.arange(6) if still is None else still
        self._still = HeldDofs(K, M, self._held, algebra)
        self._reactions = reactions
        self.n_finite = _massive(self.M) - 6
        self.n_free = self.K.shape[0]
        self.free = np.arange(self.n_free)

    def lowest(self, count: int, solver: EigenSolver) -> tuple[Array, Array]:
        """See `HeldDofs`. The shift is below zero, where K + shift M is positive definite."""
        shift = self._soft_value()
        X = self._without_momentum(solver(self.K + shift * self.M, self.M, count + 6)[1])
        length = np.sqrt(np.einsum("ni,ni->i", X, self.M @ X))
        elastic = length > 0.5  # norm after removal of rigid motions: zero for a rigid motion
        # a Krylov method may miss one of the six equal values and find one more mode instead
        if np.count_nonzero(elastic) < count:
            raise ModeError(
                f"modes: the free body has {np.count_nonzero(~elastic)} rigid motions among its "
                f"lowest {count + 6} modes, expected 6: is its stiffness that of a free body?"
            )
        X = X[:, elastic] / length[elastic]
        values = _rayleigh(self.K, self.M, X)
        order = np.argsort(values, kind="stable")[:count]
        return values[order], X[:, order]

    def count_below(self, value: float) -> int:
        """See `HeldDofs`."""
        return self.algebra.negative_pivots(self.K - value * self.M) - 6

    def static(self, forces: Array, accelerations: Array) -> StaticShapes:
        """See `HeldDofs`."""
        accelerations, loads = self._balanced(accelerations, forces + self.M @ accelerations)
        shapes = self._still.static(loads, np.zeros_like(loads))
        return StaticShapes(self._without_momentum(shapes.columns), accelerations, loads)

    def relief(self, loads: Array) -> Array:
        """See `HeldDofs`."""
        resultant = self.rigid.T @ loads
        return np.asarray(-self.rigid @ scipy.linalg.cho_solve(self._inertia, resultant))

    def load_rates(
        self, static: StaticShapes, mass: Any, forces: Array, accelerations: Array
    ) -> tuple[Array, Array]:
        """See `HeldDofs`. What balances the load changes, too.

        Parameters
        ----------
        static, mass, forces, accelerations : as of `HeldDofs`
        """
        loads = forces + mass @ static.accelerations + self.M @ accelerations
        return self._balanced(accelerations, loads)

    def _balanced(self, accelerations: Array, loads: Array) -> tuple[Array, Array]:
        """Return accelerations and loads (n_dof, k) in equilibrium: with reactions, or inertia."""
        if self._reactions:
            loads = loads.copy()
            loads[self._held] -= np.linalg.solve(self.rigid[self._held].T, self.rigid.T @ loads)
            return accelerations, loads
        relief = self.relief(loads)
        return accelerations + relief, loads + self.M @ relief

    def _without_momentum(self, X: Array) -> Array:
        return X - self.rigid @ scipy.linalg.cho_solve(self._inertia, self._MR.T @ X)

    def _soft_value(self) -> float:
        """Value near the lowest elastic one: Rayleigh quotient of the static shape of a random
        load."""
        load = np.random.default_rng(0).standard_normal((self.n_free, 1))
        zero = np.zeros_like(load)
        for _ in range(2):  # the second load is the inertia of the first shape
            shape = self.static(load, zero).columns
            load = self.M @ (shape / np.sqrt(np.sum(shape * (self.M @ shape))))
        return float(_rayleigh(self.K, self.M, shape)[0])


Condition = HeldDofs | MeanAxis


def _rayleigh(K: Any, M: Any, X: Array) -> Array:
    """Rayleigh quotients of columns, (m,): eigenvalues with errors of second order."""
    stiffness, mass = (np.einsum("ni,ni->i", X, A @ X) for A in (K, M))
    return np.asarray(stiffness / mass)


def principal(A: sp.csr_matrix, kept: IntArray) -> sp.csr_matrix:
    """Rows and columns `kept` of a matrix, without stored zeros."""
    if isinstance(A, Part):
        return Part(principal(A.own, kept), A.team)
    part = sp.csr_matrix(A[kept][:, kept])
    part.eliminate_zeros()
    return part


def _massive(M: Any) -> int:
    """Number of dofs with mass: a dof without mass gives no mode."""
    return int(np.count_nonzero(abs(M) @ np.ones(M.shape[0])))


def negative_pivots(A: Any) -> int:
    """Number of negative eigenvalues of a sparse symmetric matrix (Sylvester's law of inertia)."""
    try:
        factors = without_exchanges(A.tocsc())
        if np.array_equal(factors.perm_r, factors.perm_c):
            return int(np.count_nonzero(factors.U.diagonal() < 0.0))
    except RuntimeError:
        pass  # a pivot is exactly zero: row exchanges would be needed
    _, D, _ = scipy.linalg.ldl(A.toarray())
    return int(np.count_nonzero(scipy.linalg.eigvalsh(D) < 0.0))


SCIPY = Algebra(solve_definite, negative_pivots)
