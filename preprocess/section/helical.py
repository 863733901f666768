"""Sections of initially twisted and curved beams: exact strains, and the 6x6 by central solutions.

Of a displacement w of the section and a beam strain e they are G_k w + G_l (w' + Z e) / g; see
space/strains.py. DOLFINx evaluates G_k at the points, as the 6x9 matrix S of (w, w,2, w,3).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import null_space
from ufl import SpatialCoordinate

from ...solver.math.arrays import REGULAR, Array, is_positive_definite
from ...solver.math.rotations import skew
from .. import fenicsx
from .section_specification import IllConditioned, SectionError
from .space.numbering import Restriction
from .space.section_cells import within
from .space.space import ALL, AT_A_TIME, SectionSpace
from .space.strains import coefficients, twisted_strain_in_section, volume
from .warping import check_origin, motions_of_beam, pinned_dofs


class TwistedStrains:
    """Strain operators of a space for initial twist and curvature k (3,) [rad/m].

    Attributes
    ----------
    g : (c, q) volume per area and length at the points of the own cells, of `all_g` (n_cell, q)
    """

    def __init__(self, space: SectionSpace, k: Array) -> None:
        self.space, self.k = space, np.asarray(k, dtype=float)
        self.all_g: Array = volume(self.k, np.moveaxis(space.points, -1, 0))
        self.g = self.all_g[space.own]
        self.least_g = float(self.all_g[space.weights > 0.0].min())
        if not self.least_g > 0.0:
            far = int(np.argmin(np.where(space.weights > 0.0, self.all_g, np.inf)))
            place = space.points.reshape(-1, 2)[far]
            raise SectionError(
                f"initial_curvature: the point ({place[0]:.4g}, {place[1]:.4g}) lies beyond the "
                f"centre of curvature: 1 - x2 k3 + x3 k2 = {self.least_g:.3g}, expected above 0"
            )

    @cached_property
    def S(self) -> Array:
        """G_k w from the values and slopes of w at the points, (c, q, 6, 9)."""
        out = np.zeros((*self.g.shape, 6, 9))
        own = self.space.own
        for part, (reference, _) in self.space.rules:
            mine = np.flatnonzero(within(part.rows, own))
            if len(mine):
                values = part.evaluated(_rows, reference, mine, self.k)
                out[part.rows[mine] - own.start, : len(reference)] = values
        return out

    @cached_property
    def Z(self) -> Array:
        """Rigid motions (n_dof, 6) whose change along the beam is a unit beam strain."""
        return motions_of_beam(self.space)

    def strain_in_section(self, W: Array) -> Array:
        """G_k W at the points, (c, q, 6, m), for displacement columns W (n_dof, m)."""
        values, slopes = self.space.at_points(W), self.space.slopes(W)
        return np.asarray(self.S @ np.concatenate([values, slopes], axis=2))

    def strain_along_beam(self, W: Array) -> Array:
        """G_l W / g at the points, (c, q, 6, m): the strain of a change W per x1."""
        return self.space.strain_along_beam(W) / self.g[..., None, None]

    def load_in_section(self, stress: Array, cells: Any = ALL) -> Array:
        """Integral of (G_k w)' stress g for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        partner = np.swapaxes(self.S[cells], 2, 3) @ (stress * self.g[cells][..., None, None])
        load = self.space.load(partner[:, :, :3], cells)
        return load + self.space.load_of_slopes(partner[:, :, 3:], cells)

    def load_along_beam(self, stress: Array, cells: Any = ALL) -> Array:
        """Integral of (G_l w)' stress for each unknown of w, (n_dof, m), stress (c, q, 6, m)."""
        return self.space.load_along_beam(stress, cells)

    def work(self, stress: Array, strain: Array, cells: Any = ALL) -> Array:
        """Integral of stress' strain g over cells, (m, n).

        Parameters
        ----------
        stress, strain : (c, q, 6, m) and (c, q, 6, n) at their points
        cells : of the own cells, all by default
        """
        return self.space.work(self.g[cells][..., None, None] * stress, strain, cells)

    def E(self, C: Array) -> sp.csr_matrix:
        """Integral of G_k' C G_k g [Pa], for C (c, 1 or q, 6, 6) [Pa]."""
        return self.wave(C, 0.0)[0]

    def wave(self, C: Array, kappa: float) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Real (symmetric) and imaginary (skew) part of the integral of S' C S g.

        S = G_k + i kappa G_l / g is the strain of a warping that varies as exp(i kappa x1).
        """
        space = self.space
        c, _, _, k = space.gradients.shape
        real, imaginary = np.empty((2, c, k, k, 9))
        areas = space.weights[space.own]
        for first in range(0, c, AT_A_TIME):
            some = slice(first, first + AT_A_TIME)
            within, along = self._strains_of_unknowns(some)  # (s, q, 6, 3 k) each
            weight = (areas[some] * self.g[some])[..., None, None]
            stress = weight * (C[some] @ within)
            real[some] = _by_nodes(within, stress)
            if kappa:
                change = weight * (C[some] @ along)
                real[some] += kappa**2 * _by_nodes(along, change)
                mixed = _by_nodes(within, change) - _by_nodes(along, stress)
                imaginary[some] = kappa * mixed
        shape = (c, k * k, 9)
        pattern = space.pattern
        parts = [real, imaginary] if kappa else [real]
        matrices = [pattern.matrix(pattern.data(part.reshape(shape))) for part in parts]
        return matrices[0], matrices[-1]

    def _strains_of_unknowns(self, some: slice) -> tuple[Array, Array]:
        """G_k and G_l / g of the unknowns of some cells, (s, q, 6, 3 k) each, columns (a, k)."""
        space = self.space
        gradients = space.gradients[some]
        s, q, _, k = gradients.shape
        values = space.values[some] if space.values.ndim == 3 else space.values[None]
        values = np.broadcast_to(values, (s, q, k))
        fields = np.concatenate([values[:, :, None], gradients], axis=2)  # (s, q, 3, k)
        S = self.S[some].reshape(s, q, 6, 3, 3).swapaxes(3, 4)  # [..., row, a, field]
        within = S.reshape(s, q, 18, 3) @ fields
        along = np.einsum("ra,sqk->sqrak", space.S_l, values / self.g[some][..., None])
        return within.reshape(s, q, 6, 3 * k), along.reshape(s, q, 6, 3 * k)


def _rows(domain: Any, _u: Any, k: Any) -> Any:
    """S (6, 9) of G_k w = S (w, w,2, w,3)."""
    return coefficients(partial(twisted_strain_in_section, k=k, x=SpatialCoordinate(domain)))


def _by_nodes(strain: Array, stress: Array) -> Array:
    """Work of stresses (s, q, 6, 3 k) on strains of the unknowns, (s, k, k, 9)."""
    s, q, _, columns = strain.shape
    k = columns // 3
    whole = strain.reshape(s, 6 * q, -1).swapaxes(1, 2) @ stress.reshape(s, 6 * q, -1)
    return whole.reshape(s, 3, k, 3, k).transpose(0, 2, 4, 1, 3).reshape(s, k, k, 9)


# Loads (n_dof, ..., 6) and resultants (6, ..., 6), or warping and beam strains.
Residual = tuple[Array, Array]


def flat(columns: Array) -> Array:
    """Columns (n, ...) as a matrix (n, m)."""
    return columns.reshape(len(columns), -1)


class AlongAxis:
    """T = 0: one factorisation; for a slight |k| h."""

    def __init__(
        self, strains: TwistedStrains, C: Array, kept: Restriction, largest_growth: float
    ) -> None:
        E = strains.E(C)
        team = strains.space.team
        self._factor = fenicsx.cholesky(kept.matrix(E.data), team, largest_growth)
        self.free, self.n = kept.free, strains.space.n_dof
        stress = C @ strains.strain_along_beam(strains.Z)
        self.HZ, self.LZ = strains.load_in_section(stress), strains.load_along_beam(stress)
        self.ZLZ = strains.Z.T @ self.LZ
        self._V = np.zeros((self.n, 6))
        self._V[self.free] = self._factor.solve(self.HZ[self.free])
        schur = self.ZLZ - self.HZ.T @ self._V
        self._schur = 0.5 * (schur + schur.T)
        # energies of warping and beam strains in the same units
        self._root = np.sqrt(np.abs(team.total(E.diagonal())[self.free]))[:, None]
        self._unit = np.sqrt(np.abs(np.diag(self.ZLZ)))[:, None]

    @property
    def growth(self) -> float:
        """Growth of a random load by the solution."""
        return self._factor.growth

    def solve(self, load: Array, resultants: Array) -> Residual:
        """Warping and beam strains, with any number of columns."""
        W = np.zeros((self.n, load.size // self.n))
        W[self.free] = self._factor.solve(flat(load)[self.free])
        right = flat(resultants) - self.HZ.T @ W
        S_e: Array = np.asarray(np.linalg.solve(self._schur, right), dtype=np.float64)
        return (W - self._V @ S_e).reshape(load.shape), S_e.reshape(resultants.shape)

    def size(self, W: Array, S_e: Array) -> float:
        """Norm of both unknowns, in units of the same energy."""
        warping, strains = flat(W)[self.free] * self._root, flat(S_e) * self._unit
        return float(np.hypot(np.linalg.norm(warping), np.linalg.norm(strains)))


class Waves:
    """T without its nilpotent part, whose eigenvalues are 0 and +-i |k|: two factorisations.

    Along the eigenvectors of i |k| the equations are complex and Hermitian; they are solved as real
    ones of twice the size.
    """

    def __init__(
        self, strains: TwistedStrains, C: Array, kept: Restriction, T: Array, simple: AlongAxis
    ) -> None:
        self._simple = simple
        kappa = float(np.linalg.norm(strains.k))
        self._basis, self._inverse = _eigenvectors(T, kappa)
        real, imaginary = (kept.matrix(part.data) for part in strains.wave(C, kappa))
        doubled = sp.bmat([[real, -imaginary], [imaginary, real]], format="csr")
        doubled.sort_indices()
        self._factor = fenicsx.cholesky(doubled, strains.space.team, np.inf)
        self._B = simple.HZ - 1j * kappa * simple.LZ  # (n, 6)
        self._V = self._back(self._B)
        self._schur = simple.ZLZ - self._B.conj().T @ self._V

    def _back(self, load: Array) -> Array:
        """Complex solution (n_dof, m) of complex loads."""
        free = self._simple.free
        both = self._factor.solve(np.concatenate([load[free].real, load[free].imag]))
        half = len(both) // 2
        out = np.zeros(load.shape, dtype=complex)
        out[free] = both[:half] + 1j * both[half:]
        return out

    def solve(self, load: Array, resultants: Array) -> Residual:
        """Warping and beam strains, of the shapes of loads and resultants."""
        loads, forces = load @ self._basis, resultants @ self._basis
        W_0, S_0 = self._simple.solve(loads[..., :2], forces[..., :2])
        W_1 = self._back(flat(loads[..., 2:4] + 1j * loads[..., 4:]))
        right = flat(forces[..., 2:4] + 1j * forces[..., 4:]) - self._B.conj().T @ W_1
        S_1 = np.linalg.solve(self._schur, right)
        W_1, S_1 = (W_1 - self._V @ S_1).reshape(W_0.shape), S_1.reshape(S_0.shape)
        W = np.concatenate([W_0, W_1.real, W_1.imag], axis=-1) @ self._inverse
        return W, np.concatenate([S_0, S_1.real, S_1.imag], axis=-1) @ self._inverse


def _eigenvectors(T: Array, kappa: float) -> tuple[Array, Array]:
    """Vectors of the eigenvalues 0 and i kappa of the semisimple part of T, two each.

    (6, 6): those of 0, real and imaginary parts of the others as columns, and their inverse. T is
    scaled, because its rows have different units.
    """
    unit = np.array([1.0] * 3 + [1.0 / kappa] * 3)
    scaled = T * unit[None, :] / unit[:, None] / kappa  # eigenvalues 0, i, -i
    square = scaled @ scaled + np.eye(6)
    at_zero, others = (
        null_space(scaled @ scaled, rcond=1e-9),
        null_space(square @ square, rcond=1e-9),
    )
    part = np.linalg.lstsq(others, scaled @ others, rcond=None)[0]
    semisimple = part @ (3.0 * np.eye(4) + part @ part) / 2.0
    values, vectors = np.linalg.eig(semisimple)
    waves = others @ vectors[:, values.imag > 0.0]
    basis = unit[:, None] * np.concatenate([at_zero, waves.real, waves.imag], axis=1)
    return basis, np.linalg.inv(basis)


SLIGHT = 1e-12  # |k| h below which the digits of waves are lost
ENOUGH, ROUNDS = 1e-13, 12  # what is left of a solution to correct, relative; corrections
NILPOTENT = 3  # corrections until the nilpotent part of T, whose square is 0, is gone
ROUGH = 1e-7  # last correction beyond which they have not converged; K is wrong by its square


@dataclass(frozen=True)
class CentralSolutions:
    """Stiffness of a section of a helical beam, with warping and beam strains per resultant."""

    K: Array  # (6, 6)
    W: Array  # (n_dof, 6) warping
    Q: Array  # (n_dof, 6) change of the displacement along the beam
    S_e: Array  # (6, 6) beam strains of the pinned warping
    residual: float  # of the equilibrium at all nodes, relative
    equations: "Equations"  # with their factors
    solvability: float = 0.0  # the equations have a solution for every k
    round_off: Array | None = None  # (6, 6) of K, in its units, None if it is negligible
    doubtful: bool = False  # its condition would be refused without `allow`

    @property
    def strains(self) -> TwistedStrains:
        """Operators of the space of W and Q."""
        return self.equations.strains

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


def central_solutions(
    space: SectionSpace,
    k: Array,
    C: Array,
    largest_growth: float = 1.0 / REGULAR,
    is_enough: Callable[[float], bool] | None = None,
) -> CentralSolutions:
    """Solve for warping and beam strains of unit resultants.

    Parameters
    ----------
    space : of the section's mesh
    k : (3,) initial twist and curvature [rad/m], not all zero
    C : (c, 1 or q, 6, 6) stiffness of the points, section axes [Pa]
    is_enough : whether the growth of a random load by the factorised matrix allows to go on

    Raises
    ------
    IllConditioned : it does not.
    SectionError : a point beyond the centre of curvature, no convergence, K is not definite.
    FactorisationError : the section is not one part.
    """
    equations = Equations(TwistedStrains(space, k), C, largest_growth)
    if is_enough is not None and not is_enough(equations.growth):
        raise IllConditioned
    return _solution(equations, *equations.solve(np.zeros((space.n_dof, 6)), np.eye(6)))


class Equations:
    """Equilibrium of the section, and the resultants of the central solutions.

    Attributes
    ----------
    T : (6, 6) `change_of_resultants`
    growth : of a random load by the factorised matrix
    """

    def __init__(self, strains: TwistedStrains, C: Array, largest_growth: float = np.inf) -> None:
        self.strains, self.C, self.T = strains, C, change_of_resultants(strains.k)
        self._kept = strains.space.pattern.without(pinned_dofs(strains.space, six=True))
        self._simple = AlongAxis(strains, C, self._kept, largest_growth)
        self.growth = self._simple.growth
        self._shrinks = np.inf  # ratio of corrections for rounding alone, as far as it is known

    @cached_property
    def _solver(self) -> "AlongAxis | Waves":
        """Of the equations but for the nilpotent part of T, and for a slight T."""
        space, strains = self.strains.space, self.strains
        height = float(np.ptp(np.stack([space.x2, space.x3]), axis=1).max())
        if np.linalg.norm(strains.k) * height < SLIGHT:
            return self._simple
        return Waves(strains, self.C, self._kept, self.T, self._simple)

    def solve(self, load: Array, resultants: Array, enough: float = ENOUGH) -> Residual:
        """Warping and beam strains, of the shapes of loads and resultants.

        Each correction is that of the residual; the first ones need not become smaller.

        Parameters
        ----------
        load : (n_dof, ..., 6) on the warping
        resultants : (6, ..., 6)
        enough : what the last correction may leave, relative to the solution

        Raises
        ------
        SectionError
            The corrections do not converge.
        """
        W, S_e = np.zeros_like(load), np.zeros_like(resultants)
        left, last, rest, size = (load, resultants), np.inf, np.inf, 0.0
        for done in range(ROUNDS):
            dW, dS = self._solver.solve(*left)
            now = self._simple.size(dW, dS)
            if done >= NILPOTENT and not now < 0.5 * last:
                break
            W, S_e = W + dW, S_e + dS
            size = self._simple.size(W, S_e)
            nilpotent = done + 1 < NILPOTENT  # what this one corrects; later ones, only rounding
            if not nilpotent:
                self._shrinks = min(self._shrinks, max(now / last, now / size))
            last, rest = now, min(now, self._shrinks * (size if nilpotent else now))
            if done and rest <= enough * size:
                break
            product = self.product(W, S_e)
            left = load - product[0], resultants - product[1]
        if rest > ROUGH * size:
            raise SectionError(
                f"initial_curvature: the iteration for the warping does not converge (last "
                f"correction {rest / size:.1e}): the product of curvature and size of the section "
                "is too large, or cells of a very thin wall are much narrower than others"
            )
        return W, S_e

    def stresses(self, W: Array, S_e: Array) -> tuple[Array, Array, Array]:
        """Stresses and strains at the points, and Q."""
        Q = W @ self.T + (self.strains.Z @ flat(S_e)).reshape(W.shape)
        strain = self.strains.strain_in_section(flat(W)) + self.strains.strain_along_beam(flat(Q))
        return self.C @ strain, strain, Q

    def product(self, W: Array, S_e: Array) -> Residual:
        """Load that warping and beam strains balance, and their resultants, of the same shapes."""
        stress = self.stresses(W, S_e)[0]
        P = self.strains.load_along_beam(stress)
        load = self.strains.load_in_section(stress).reshape(W.shape) - P.reshape(W.shape) @ self.T
        return load, (self.strains.Z.T @ P).reshape(S_e.shape)


def _solution(equations: Equations, W: Array, S_e: Array) -> CentralSolutions:
    strains = equations.strains
    stress, strain, Q = equations.stresses(W, S_e)
    P = strains.load_along_beam(stress)
    balance = strains.load_in_section(stress) - P @ equations.T
    S = strains.work(stress, strain)
    K = np.linalg.inv(0.5 * (S + S.T))
    K = 0.5 * (K + K.T)
    check_origin(strains.space, K)
    if not is_positive_definite(K):
        raise SectionError("the stiffness of the section is not positive definite")
    norm = np.abs(strains.load_in_section(np.abs(stress))).max()
    left = float(np.abs(balance).max() / norm)
    return CentralSolutions(K, W, Q, S_e, left, equations)
