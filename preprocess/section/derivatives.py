"""Exact derivatives of the solutions of a section, by parameters of its description.

Every result is that of central solutions: the warping W and the beam strains S_e of the six unit
resultants, whose change along the beam is W' = W T (helical.py; T = 0 but for M2' = F3, M3' = -F2
of a prismatic beam). With Q = W T + Z S_e, the strain e = G W + G_l Q and the stress s = C e they
satisfy

    load_in_section(s) - P T = 0,   Z' P = 1,   P = load_along_beam(s),

and S = K^-1 is the work of s and e. These equations are linear in C and smooth in the positions of
the points: `_terms` evaluates them with the rate of C, or with complex numbers whose imaginary
parts are rates. What remains is one more solution, by the factors of the analysis, with what the
rates leave in the equations as loads.
"""

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.design import Derivative
from ...solver.package.common.materials import bond
from .helical import (
    AlongAxis,
    CentralSolutions,
    Equations,
    TwistedStrains,
    Waves,
    change_of_resultants,
)
from .parameters import TINY, MovedMesh, Rates, places
from .recovery import Result, middles, nodal_displacements, numbered, unit_displacements
from .space.cells import CellMesh
from .space.layers import Layup
from .space.space import SectionSpace
from .space.strains import fixed, strain_in_section, volume
from .spec import SectionError
from .timoshenko import (
    CLASSICAL,
    SHEAR,
    mass_centre,
    mass_matrix,
    shear_centre,
    tension_centre,
)
from .warping import WarpingSolver, motions_of_beam, pinned_dofs, rigid_fields

Operators = SectionSpace | TwistedStrains
FAINT = 1e-6  # of the loads of the solutions: loads below it may do relative work on rigid motions
ENOUGH, ROUNDS = 1e-13, 8  # last correction of twisted sections, corrections
ROUGH = 1e-7  # last correction beyond which they have not converged


@dataclass(frozen=True)
class Central:
    """The central solutions of a result, prismatic or not, and their strains and stresses."""

    at: Operators
    C: Array  # (c, 1 or q, 6, 6)
    T: Array  # (6, 6)
    Z: Array  # (n_dof, 6)
    W: Array  # (n_dof, 6)
    S_e: Array  # (6, 6)
    K: Array  # (6, 6)
    strain: Array  # (c, q, 6, 6)
    P: Array  # (n_dof, 6) loads of the stresses on a change along the beam
    size: float  # norm of the terms of the loads
    prismatic: bool

    @property
    def space(self) -> SectionSpace:
        """The space of the warping."""
        return self.at.space if isinstance(self.at, TwistedStrains) else self.at


def central(result: Result, C: Array) -> Central:
    """Central solutions of a result for the stiffness (c, 1 or q, 6, 6) of its points."""
    space = result.space
    Z = motions_of_beam(space)
    if isinstance(result, CentralSolutions):
        at: Operators = result.strains
        T, W, S_e = change_of_resultants(result.strains.k), result.W, result.S_e
    else:
        at, T, S_e = space, change_of_resultants(np.zeros(3)), np.zeros((6, 6))
        W = unit_displacements(space, result)[0]
        change = result.T @ np.eye(6)[SHEAR]
        F_c = np.eye(6)[CLASSICAL]
        S_e[CLASSICAL] = np.linalg.solve(result.A, F_c - (result.B - result.B.T) @ change)
    strain = at.strain_in_section(W) + at.strain_along_beam(W @ T + Z @ S_e)
    stress = C @ strain
    P = at.load_along_beam(stress)
    size = float(np.linalg.norm(at.load_in_section(np.abs(stress))))
    return Central(at, C, T, Z, W, S_e, result.K, strain, P, size, at is space)


@dataclass(frozen=True)
class Terms:
    """What stresses leave in the equations of `central`, and their work on the strains."""

    load: Array  # (n_dof, 6)
    resultants: Array  # (6, 6)
    work: Array  # (6, 6)


def _terms(at: Operators, stress: Array, strain: Array, T: Array, Z: Array) -> Terms:
    P = at.load_along_beam(stress)
    return Terms(at.load_in_section(stress) - P @ T, Z.T @ P, at.work(stress, strain))


def stiffness_terms(state: Central, cells: IntArray, dC: Array) -> Terms:
    """Rates of the terms by the rate dC (s, 1 or q, 6, 6) of the stiffness of some own cells."""
    strain = state.strain[cells]
    return _terms(state.at.of_some(cells), dC @ strain, strain, state.T, state.Z)


def moved_space(space: SectionSpace, cells: CellMesh) -> SectionSpace:
    """The space on a mesh whose points have imaginary parts."""
    other = copy.copy(space)
    for name in ("pattern", "weighted_gradients", "_products"):
        other.__dict__.pop(name, None)
    nodes = places(space, cells)
    motion = space.displacements((0, *nodes.imag.T))
    c, q = space.weights.shape
    slopes = space.slopes(motion).reshape(c, q, 2, 3)[..., 1:]  # [alpha, beta] dv_beta / dx_alpha
    other.points = space.points + 1j * space.at_points(motion)[:, :, 1:, 0]
    other.weights = space.weights * (1.0 + 1j * np.trace(slopes, axis1=2, axis2=3))
    other.gradients = space.gradients - 1j * (slopes @ space.gradients)
    other.x2, other.x3 = np.stack([space.x2, space.x3]) + 1j * nodes.imag.T
    return other


def moved_operators(at: Operators, cells: CellMesh) -> tuple[Operators, SectionSpace]:
    """The operators of `moved_space`, and this space."""
    if isinstance(at, SectionSpace):
        space = moved_space(at, cells)
        return space, space
    space = moved_space(at.space, cells)
    other = copy.copy(at)
    other.space, other.g = space, volume(at.k, np.moveaxis(space.points, -1, 0))
    # (S - S_h) g is affine in the position
    S_h = fixed(strain_in_section)
    turning = (at.S - S_h) * at.g[..., None, None] + 0j
    x2, x3 = np.moveaxis((space.points - at.space.points)[..., None, None, :], -1, 0)
    turning[..., 3:6] += at.k[0] * x3 * space.S_l
    turning[..., 6:9] -= at.k[0] * x2 * space.S_l
    other.S = S_h + turning / other.g[..., None, None]
    return other, space


def moved_terms(state: Central, at: Operators, space: SectionSpace, C: Array) -> Terms:
    """Rates of the terms by the imaginary parts of operators and stiffness."""
    Z = motions_of_beam(space)
    strain = at.strain_in_section(state.W) + at.strain_along_beam(state.W @ state.T + Z @ state.S_e)
    found = _terms(at, C @ strain, strain, state.T, Z)
    return Terms(*(part.imag / TINY for part in (found.load, found.resultants, found.work)))


class PrismaticSolver:
    """Solves the equations of `central` of a prismatic beam by the factor of its warping.

    T is nilpotent: first the solutions without shear force, then those with it.
    """

    def __init__(self, result: Result, state: Central, factorised: WarpingSolver) -> None:
        assert not isinstance(result, CentralSolutions)
        self._state, self._solver, self._space = state, factorised, result.space
        self._A, self._V0 = result.A, result.V0

    def solve(self, load: Array, resultants: Array) -> tuple[Array, Array]:
        """W (n_dof, 6) and S_e (6, 6) with these terms."""
        state, space = self._state, self._space
        W, S_e = np.zeros(load.shape), np.zeros((6, 6))
        W[:, CLASSICAL], S_e[:, CLASSICAL] = self._constant(
            load[:, CLASSICAL], resultants[:, CLASSICAL]
        )
        # the resultants M2 and M3 change in proportion to F3 and F2
        T = state.T[:, SHEAR]
        forces = np.flatnonzero(T.any(axis=1))
        T = T[forces]
        constant = state.C @ (
            space.strain_in_section(W[:, forces])
            + space.strain_along_beam(state.Z @ S_e[:, forces])
        )
        change = state.C @ space.strain_along_beam(W[:, forces] @ T)
        left = space.load_in_section(change) - space.load_along_beam(constant) @ T
        W[:, SHEAR], S_e[:, SHEAR] = self._constant(
            load[:, SHEAR] - left,
            resultants[:, SHEAR] - state.Z.T @ space.load_along_beam(change),
        )
        return W, S_e

    def _constant(self, load: Array, resultants: Array) -> tuple[Array, Array]:
        """Solutions that do not change along the beam."""
        size = float(np.linalg.norm(load)) + FAINT * self._state.size
        W = np.zeros(load.shape)
        there = np.flatnonzero(load.any(axis=0))
        if len(there):
            W[:, there] = self._solver.solve(load[:, there], size, self._product)
        S_e = np.zeros((6, load.shape[1]))
        S_e[CLASSICAL] = np.linalg.solve(self._A, resultants[CLASSICAL] + self._V0.T @ load)
        return W + self._V0 @ S_e[CLASSICAL], S_e

    def _product(self, W: Array) -> Array:
        space = self._space
        return space.load_in_section(self._state.C @ space.strain_in_section(W))


@dataclass(frozen=True)
class Change:
    """Rates of the stiffness and of the central solutions."""

    K: Array  # (6, 6)
    W: Array  # (n_dof, 6)
    Q: Array  # (n_dof, 6)


def changed(state: Central, solver: "Solver", terms: Terms) -> Change:
    """Return what rates of the terms bring about."""
    W, S_e = solver.solve(-terms.load, -terms.resultants)
    Q = W @ state.T + state.Z @ S_e
    # the stresses are in equilibrium: their work on new strains is that of P
    work = state.T.T @ (state.P.T @ W) + state.P.T @ W @ state.T + S_e
    S = terms.work + work + work.T
    K = -state.K @ (0.5 * (S + S.T)) @ state.K
    return Change(0.5 * (K + K.T), W, Q)


class HelicalSolver:
    """Solves the equations of `central` of a twisted or curved beam by the factors of its waves.

    Waves leave the nilpotent part of T, whose square is zero: two corrections are enough, but for
    round-off.
    """

    def __init__(self, state: Central) -> None:
        strains = state.at
        assert isinstance(strains, TwistedStrains)
        kept = strains.space.pattern.without(pinned_dofs(strains.space, six=True))
        self._simple = AlongAxis(strains, state.C, kept, np.inf)
        self._waves = Waves(strains, state.C, kept, state.T, self._simple)
        self._equations = Equations(strains, state.C, state.T)

    def solve(self, load: Array, resultants: Array) -> tuple[Array, Array]:
        """W (n_dof, 6) and S_e (6, 6) with these terms."""
        W, S_e = np.zeros(load.shape), np.zeros((6, 6))
        left, last, size = (load, resultants), np.inf, 0.0
        for _ in range(ROUNDS):
            step = self._waves.solve(*left)
            now = float(np.linalg.norm(self._simple.packed(*step)))
            if size and not now < 0.5 * last:
                break
            W, S_e, last = W + step[0], S_e + step[1], now
            size = float(np.linalg.norm(self._simple.packed(W, S_e)))
            if now <= ENOUGH * size:
                break
            product = self._equations.product(W, S_e)
            left = load - product[0], resultants - product[1]
        if last > ROUGH * size:
            raise SectionError(
                "design: the derivatives of the warping do not converge; the product of curvature "
                "and size of the section is too large"
            )
        return W, S_e


Solver = PrismaticSolver | HelicalSolver


@dataclass(frozen=True)
class Recovered:
    """Where strains and stresses of the result are recovered."""

    space: SectionSpace
    lay: Layup
    strain: Array  # `unit_strains`, (c, q, 6, 6)


def derivatives(
    result: Result,
    factorised: WarpingSolver | None,
    rates_of: Sequence[Rates],
    at: Recovered,
) -> tuple[Derivative, ...]:
    """Derivatives of the datasets of a section file by parameters.

    Parameters
    ----------
    result : of the analysis, in the space of `factorised` or of a twisted beam
    factorised : the solver with its factors, None of a twisted or curved beam
    rates_of : each parameter
    at : points of recovery
    """
    state = central(result, rates_of[0].lay.stiffness)
    solver = (
        HelicalSolver(state) if factorised is None else PrismaticSolver(result, state, factorised)
    )
    return tuple(
        Derivative(p.name, p.kind, p.targets, _values(state, solver, rate, at))
        for rate in rates_of
        for p in (rate.parameter,)
    )


def _values(state: Central, solver: Solver, rate: Rates, at: Recovered) -> dict[str, Array]:
    """Derivatives by path, without those that are zero."""
    lay, found = rate.lay, {}
    operators, space = state.at, state.space
    if rate.moved is not None:
        operators, space = moved_operators(state.at, moved_cells(rate.moved))
        terms = moved_terms(state, operators, space, rate.stiffness())
    elif len(rate.cells):
        terms = stiffness_terms(state, rate.cells, rate.stiffness().imag / TINY)
    if len(rate.cells):
        change = changed(state, solver, terms)
        found = {"K": change.K, "warping": _warping(state, space, change.W)}
        for name, centre in (("shear_centre", shear_centre), ("tension_centre", tension_centre)):
            found[name] = _by_step(centre, state.K, change.K)
        found |= _recovery(state, at, rate, change)
    density = lay.density + 1j * TINY * rate.density[lay.ply]
    if isinstance(operators, TwistedStrains):
        density = density * operators.g
    M = mass_matrix(space, density)
    found["M"] = M.imag / TINY
    found["mass_centre"] = _by_step(mass_centre, M.real, found["M"])
    found |= _mesh(state, rate)
    found["plies/C_M"] = rate.C_M
    found["plies/angle_deg"] = np.degrees(rate.angle)
    return {path: values for path, values in found.items() if values.any()}


def moved_cells(moved: MovedMesh) -> CellMesh:
    """The mesh with TINY times the velocity of its points as their imaginary part."""
    cells = moved.mesh.cells
    return replace(cells, points=cells.points + 1j * TINY * moved.velocity)


def _mesh(state: Central, rate: Rates) -> dict[str, Array]:
    """Rates of what `mesh_data` shows."""
    cells, space = rate.cells, state.space
    axes, middle = rate.axes(), middles(space)[cells]
    fibre = np.zeros((space.n_cell, 3))
    some = np.arange(len(cells)), middle if axes.shape[1] > 1 else 0 * middle
    fibre[cells] = axes[some][..., 0].imag / TINY
    found = {"mesh/fibre": fibre}
    if rate.moved is not None:
        found["mesh/nodes"] = numbered(moved_cells(rate.moved))[0].imag / TINY
    if rate.y2 is not None:
        found["mesh/layer_direction"] = rate.y2[some]
    return found


def _by_step(function: Callable[[Array], Array], x: Array, rate: Array) -> Array:
    """Rate of a function of an array."""
    size = TINY / (np.abs(rate).max() or 1.0)
    return np.asarray(function(x + 1j * size * rate).imag) / size


def _warping(state: Central, space: SectionSpace, rate: Array) -> Array:
    """Rate of the warping without rigid motion, at the nodes of the file."""
    W, Z = state.W + 1j * TINY * rate, motions_of_beam(space)
    rigid = rigid_fields(space) if state.prismatic else Z
    load = space.load(space.at_points(rigid))

    def part(W: Array) -> Array:
        return np.asarray(np.linalg.solve(rigid.T @ load, load.T @ W))

    if state.prismatic:
        # a translation of the warping by M2 and M3 shears the beam under F3 and F2
        change = part(W) @ state.T
        W = W + np.outer(Z[:, 4], change[2]) - np.outer(Z[:, 5], change[1])
    W = W - rigid @ part(W)
    return nodal_displacements(state.space, W.imag / TINY)


def _recovery(state: Central, at: Recovered, rate: Rates, change: Change) -> dict[str, Array]:
    """Rates of points, of their strains in ply axes, and of these axes."""
    rate = rate.at(at.space, at.lay)
    space = at.space
    real = space.weights.ravel() > 0.0
    operators: Operators = space
    if isinstance(state.at, TwistedStrains):
        operators = TwistedStrains(space, state.at.k)
    strain = operators.strain_in_section(change.W) + operators.strain_along_beam(change.Q)
    found = {}
    if rate.moved is not None:
        operators, space = moved_operators(operators, moved_cells(rate.moved))
        Q = state.W @ state.T + motions_of_beam(space) @ state.S_e
        moved = operators.strain_in_section(state.W) + operators.strain_along_beam(Q)
        strain = strain + moved.imag / TINY
        found["recovery/points"] = space.points.reshape(-1, 2)[real].imag / TINY
        found["recovery/weights"] = space.weights.ravel()[real].imag / TINY
    cells, axes = rate.cells, rate.axes()
    A_BM = np.zeros((*space.weights.shape, 3, 3))
    A_BM[cells] = axes.imag / TINY
    found["recovery/A_BM"] = A_BM.reshape(-1, 3, 3)[real]
    strain_M = np.swapaxes(bond(at.lay.A_BM), -1, -2) @ strain
    strain_M[cells] += np.swapaxes(bond(axes).imag, -1, -2) @ at.strain[cells] / TINY
    found["recovery/strain_M"] = strain_M.reshape(-1, 6, 6)[real]
    return found
