"""The 6x6 stiffness of a beam with initial twist and curvature: central solutions.

The resultants of an unloaded bar change along it by F' = T F, and so does all else in the section:
warping W F, beam strains S_e F. Equilibrium of the section gives linear equations for W and S_e,
whose strain energy per length is the compliance S = K^-1. Without initial curvature this is the
method of timoshenko.py.
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, gmres

from ...solver.math.arrays import Array
from ...solver.math.definite import is_positive_definite
from ...solver.math.rotations import skew
from .errors import IllConditioned, SectionError
from .helical_solvers import AlongAxis, Residual, Waves
from .space import SectionSpace
from .twist import TwistedStrains
from .warping import LARGEST_GROWTH, unknowns_at_nodes

TOLERANCE = 1e-15  # of the residual of the preconditioned equations
ENOUGH = 1e-7  # residual that round-off leaves at most; K is wrong by its square
SLOW = 0.05  # reduction of the residual by a round that suggests the other solver
STEPS, ROUNDS = 24, 6  # of GMRES in a round, rounds


@dataclass(frozen=True)
class CentralSolutions:
    """Stiffness of a section of a helical beam, with warping and beam strains per resultant."""

    K: Array  # (6, 6)
    W: Array  # (n_dof, 6) warping
    Q: Array  # (n_dof, 6) change of the displacement along the beam
    S_e: Array  # (6, 6) beam strains of the pinned warping
    work_of_warping: Array  # (6, 6) N = -P' W
    residual: float  # of the equilibrium at all nodes, relative
    strains: TwistedStrains  # operators of the space of W and Q
    growth: float  # of a random load by the factorised matrix
    by_waves: bool  # with the second solver
    solvability: float = 0.0  # the equations have a solution for every k
    round_off: Array | None = None  # (6, 6) of K, in its units, None if it is negligible
    doubtful: bool = False  # its condition would be refused without `allow`

    @property
    def space(self) -> SectionSpace:
        """The space of W and Q."""
        return self.strains.space


def change_of_resultants(k: Array) -> Array:
    """T (6, 6) of F' = T F for k (3,): equilibrium of an unloaded bar."""
    T = np.zeros((6, 6))
    T[:3, :3] = T[3:, 3:] = -skew(k)
    T[3:, :3] = -skew(np.array([1.0, 0.0, 0.0]))
    return T


def six_pins(space: SectionSpace) -> NDArray[np.int64]:
    """Six unknowns that prevent every rigid motion of the section.

    A node, the motion of a second one across their line, and u1 at both and at a third node.
    """
    whole, x = unknowns_at_nodes(space)
    i = int(np.argmin(x.sum(axis=1)))
    away = x - x[i]
    j = int(np.argmax(np.hypot(*away.T)))
    across = 2 if abs(away[j, 0]) >= abs(away[j, 1]) else 1
    third = int(np.argmax(np.abs(away[:, 0] * away[j, 1] - away[:, 1] * away[j, 0])))
    a, b, c = 3 * whole[[i, j, third]]
    return np.array([a, a + 1, a + 2, b + across, b, c])


def central_solutions(
    space: SectionSpace,
    k: Array,
    C: Array,
    largest_growth: float = LARGEST_GROWTH,
    is_enough: Callable[[float], bool] | None = None,
    *,
    by_waves: bool = False,
) -> CentralSolutions:
    """Solve for warping and beam strains of unit resultants.

    Parameters
    ----------
    space : of the section's mesh
    k : (3,) initial twist and curvature [rad/m], not all zero
    C : (c, 1 or q, 6, 6) stiffness of the points, section axes [Pa]
    is_enough : whether the growth of a random load by the factorised matrix allows to go on
    by_waves : the first solver is known to be too slow

    Raises
    ------
    IllConditioned : it does not.
    SectionError : a point beyond the centre of curvature, no convergence, K is not definite.
    FactorisationError : the section is not one part.
    """
    strains, T = TwistedStrains(space, k), change_of_resultants(k)
    kept = space.pattern.without(six_pins(space))
    simple = AlongAxis(strains, C, kept, largest_growth)
    if is_enough is not None and not is_enough(simple.growth):
        raise IllConditioned
    equations = Equations(strains, C, T)
    unknowns, left = None, np.inf
    if not by_waves:
        unknowns, left = _iterated(equations, simple, simple, None)
        by_waves = left > ENOUGH**2 and left > TOLERANCE * simple.growth
    if by_waves:
        # thin walls and large |k| h: few steps, but a factorisation of twice the size
        waves = Waves(strains, C, kept, T, simple)
        unknowns, left = _iterated(equations, simple, waves, unknowns)
    if not left < ENOUGH:
        raise SectionError(
            f"initial_curvature: the iteration for the warping does not converge (residual "
            f"{left:.1e}): the product of curvature and size of the section is too large, or cells "
            "of a very thin wall are much narrower than others"
        )
    assert unknowns is not None
    return _solution(equations, *unknowns, simple.growth, by_waves)


@dataclass(frozen=True)
class Equations:
    """Equilibrium of the section, and the resultants of the central solutions."""

    strains: TwistedStrains
    C: Array
    T: Array

    def stresses(self, W: Array, S_e: Array) -> tuple[Array, Array, Array]:
        """Stresses and strains at the points, and Q."""
        Q = W @ self.T + self.strains.Z @ S_e
        strain = self.strains.strain_in_section(W) + self.strains.strain_along_beam(Q)
        return self.C @ strain, strain, Q

    def product(self, W: Array, S_e: Array) -> Residual:
        """Load that warping and beam strains balance, (n_dof, 6), and their resultants (6, 6)."""
        stress = self.stresses(W, S_e)[0]
        P = self.strains.load_along_beam(stress)
        return self.strains.load_in_section(stress) - P @ self.T, self.strains.Z.T @ P


def _iterated(
    equations: Equations, simple: AlongAxis, solver: Any, start: Residual | None
) -> tuple[Residual, float]:
    """GMRES with corrections by the residual: warping and beam strains, and what is left."""
    n = equations.strains.space.n_dof
    zero: Residual = np.zeros((n, 6)), np.zeros((6, 6))
    right = simple.packed(*simple.solve(zero[0], np.eye(6)))
    goal = float(np.linalg.norm(right))

    def preconditioned(z: Array) -> Array:
        return simple.packed(*solver.solve(*equations.product(*simple.unpacked(z))))

    operator = LinearOperator((right.size, right.size), matvec=preconditioned, dtype=float)
    W, S_e = start or zero
    best, left = (W, S_e), np.inf
    for _ in range(ROUNDS):
        load, resultants = equations.product(W, S_e)
        residual = simple.packed(*solver.solve(-load, np.eye(6) - resultants))
        now = float(np.linalg.norm(residual)) / goal
        if not now < 0.5 * left:
            break
        slow = solver is simple and now > max(SLOW * left, ENOUGH)
        best, left = (W, S_e), now
        if left < TOLERANCE or slow:
            break
        dW, dS = simple.unpacked(_solved(operator, residual, max(TOLERANCE / left, 1e-10)))
        W, S_e = W + dW, S_e + dS
    return best, left


def _solution(
    equations: Equations, W: Array, S_e: Array, growth: float, by_waves: bool
) -> CentralSolutions:
    strains = equations.strains
    stress, strain, Q = equations.stresses(W, S_e)
    P = strains.load_along_beam(stress)
    balance = strains.load_in_section(stress) - P @ equations.T
    S = strains.work(stress, strain)
    K = np.linalg.inv(0.5 * (S + S.T))
    K = 0.5 * (K + K.T)
    if not is_positive_definite(K):
        raise SectionError("the stiffness of the section is not positive definite")
    norm = np.abs(strains.load_in_section(np.abs(stress))).max()
    left = float(np.abs(balance).max() / norm)
    return CentralSolutions(K, W, Q, S_e, -P.T @ W, left, strains, growth, by_waves)


def _solved(operator: LinearOperator, right: Array, tolerance: float) -> Array:
    """GMRES; its result is corrected by the residual afterwards, so that it may stop early."""
    key = "rtol" if "rtol" in inspect.signature(gmres).parameters else "tol"
    x, _ = gmres(operator, right, restart=STEPS, maxiter=1, atol=0.0, **{key: tolerance})
    return np.asarray(x)
