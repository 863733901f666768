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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.common.materials import bond
from .helical import CentralSolutions, Equations, TwistedStrains, change_of_resultants, flat
from .recovery import Result, middles, nodal_displacements, unit_displacements
from .section_parameters import TINY, Rates
from .space.layers import Layup
from .space.space import SectionSpace
from .timoshenko import CLASSICAL, SHEAR, mass_centre, mass_matrix, shear_centre, tension_centre
from .warping import WarpingSolver, motions_of_beam

Operators = SectionSpace | TwistedStrains
AT_ONCE = 16  # parameters whose equations are solved together
FAINT = 1e-6  # of the loads of the solutions: loads below it may do relative work on rigid motions


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
    return Central(at, C, T, Z, W, S_e, result.K, strain, P, size)


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


class PrismaticSolver:
    """Solves the equations of `central` of a prismatic beam by the factor of its warping.

    T is nilpotent: first the solutions without shear force, then those with it.
    """

    def __init__(self, result: Result, state: Central, factorised: WarpingSolver) -> None:
        assert not isinstance(result, CentralSolutions)
        self._state, self._solver, self._space = state, factorised, result.space
        self._A, self._V0 = result.A, result.V0

    def solve(self, load: Array, resultants: Array) -> tuple[Array, Array]:
        """W (n_dof, p, 6) and S_e (6, p, 6) with these terms, of the same shapes."""
        state, space = self._state, self._space
        W, S_e = np.zeros(load.shape), np.zeros(resultants.shape)
        constant, shear = np.s_[..., CLASSICAL], np.s_[..., SHEAR]
        W[constant], S_e[constant] = self._constant(load[constant], resultants[constant])
        # the resultants M2 and M3 change in proportion to F3 and F2
        forces = np.flatnonzero(state.T[:, SHEAR].any(axis=1))
        T = state.T[forces][:, SHEAR]

        def changing(columns: Array) -> Array:
            return columns.reshape(len(columns), -1, len(forces)) @ T

        stress = state.C @ (
            space.strain_in_section(flat(W[..., forces]))
            + space.strain_along_beam(state.Z @ flat(S_e[..., forces]))
        )
        change = state.C @ space.strain_along_beam(flat(changing(W[..., forces])))
        left = space.load_in_section(change).reshape(load[shear].shape)
        along = state.Z.T @ space.load_along_beam(change)
        W[shear], S_e[shear] = self._constant(
            load[shear] - left + changing(space.load_along_beam(stress)),
            resultants[shear] - along.reshape(resultants[shear].shape),
        )
        return W, S_e

    def _constant(self, loads: Array, resultants: Array) -> tuple[Array, Array]:
        """Solutions that do not change along the beam."""
        load = flat(loads)
        size = float(np.linalg.norm(load)) + FAINT * self._state.size
        W = np.zeros(load.shape)
        there = np.flatnonzero(load.any(axis=0))
        if len(there):
            W[:, there] = self._solver.solve(load[:, there], size, self._product)
        S_e = np.zeros((6, load.shape[1]))
        S_e[CLASSICAL] = np.linalg.solve(self._A, flat(resultants)[CLASSICAL] + self._V0.T @ load)
        W += self._V0 @ S_e[CLASSICAL]
        return W.reshape(loads.shape), S_e.reshape(resultants.shape)

    def _product(self, W: Array) -> Array:
        space = self._space
        return space.load_in_section(self._state.C @ space.strain_in_section(W))


@dataclass(frozen=True)
class Change:
    """Rates of the stiffness and of the central solutions."""

    K: Array  # (6, 6)
    W: Array  # (n_dof, 6)
    Q: Array  # (n_dof, 6)


def changed(state: Central, solver: "Solver", terms: Sequence[Terms]) -> list[Change]:
    """Return what rates of the terms bring about, for each of them."""
    load = -np.stack([one.load for one in terms], axis=1)
    W, S_e = solver.solve(load, -np.stack([one.resultants for one in terms], axis=1))
    Q = W @ state.T + (state.Z @ flat(S_e)).reshape(W.shape)
    # the stresses are in equilibrium: their work on new strains is that of P
    N = (state.P.T @ flat(W)).reshape(S_e.shape)
    changes = []
    for i, one in enumerate(terms):
        S = one.work + 2.0 * (state.T.T @ N[:, i] + N[:, i] @ state.T + S_e[:, i])
        K = -state.K @ (0.5 * (S + S.T)) @ state.K
        changes.append(Change(0.5 * (K + K.T), W[:, i], Q[:, i]))
    return changes


Solver = PrismaticSolver | Equations


class Recovered:
    """Where strains and stresses of a result are recovered.

    Parameters
    ----------
    strain : `unit_strains` at the points of the space, (c, q, 6, 6)
    """

    def __init__(self, space: SectionSpace, lay: Layup, strain: Array, state: Central) -> None:
        self.space, self.lay, self.strain = space, lay, strain
        self.at: Operators = space
        if isinstance(state.at, TwistedStrains):
            self.at = TwistedStrains(space, state.at.k)
        self.to_plies = np.swapaxes(bond(lay.A_BM), -1, -2)
        self.real = space.weights.ravel() > 0.0  # not those that fill up cells with fewer points


def derivatives(
    result: Result,
    factorised: WarpingSolver | None,
    asked: Sequence[Rates],
    space: SectionSpace,
    lay: Layup,
    strain: Array,
    *,
    shown: bool = True,
) -> dict[str, dict[str, Array]]:
    """Derivatives of the datasets of a section file by parameters that do not move its mesh.

    By name of the parameter and path.

    Parameters
    ----------
    result : of the analysis, in the space of `factorised` or of a twisted beam
    factorised : the solver with its factors, None of a twisted or curved beam
    asked : the rates of each parameter
    space, lay : points of recovery and their plies
    strain : `unit_strains` at these points
    shown : also of warping and mesh, which a body has no use for
    """
    state = central(result, asked[0].lay.stiffness)
    solver: Solver
    if isinstance(result, CentralSolutions):
        solver = result.equations
    else:
        assert factorised is not None
        solver = PrismaticSolver(result, state, factorised)
    at, by_parameter = Recovered(space, lay, strain, state), dict[str, dict[str, Array]]()
    for first in range(0, len(asked), AT_ONCE):
        some = [_Moved(state, rate) for rate in asked[first : first + AT_ONCE]]
        terms = [one.terms for one in some if one.terms is not None]
        changes = iter(changed(state, solver, terms) if terms else ())
        for one in some:
            change = None if one.terms is None else next(changes)
            by_parameter[one.rate.parameter.name] = one.values(change, at, shown=shown)
    return by_parameter


class _Moved:
    """A section whose parameter has an imaginary part."""

    def __init__(self, state: Central, rate: Rates) -> None:
        self.state, self.rate = state, rate
        self.terms: Terms | None = None
        if len(rate.cells):
            self.terms = stiffness_terms(state, rate.cells, rate.stiffness().imag / TINY)

    def values(self, change: Change | None, at: Recovered, *, shown: bool) -> dict[str, Array]:
        """Derivatives by path, without those that are zero."""
        state, rate, values_by_path = self.state, self.rate, {}
        if change is not None:
            values_by_path = {"K": change.K}
            for name, centre in (
                ("shear_centre", shear_centre),
                ("tension_centre", tension_centre),
            ):
                values_by_path[name] = _by_step(centre, state.K, change.K)
            values_by_path |= self._recovery(at, change)
            if shown:
                values_by_path["warping"] = self._warping(change.W)
        if rate.density.any():
            density = rate.lay.density + 1j * TINY * rate.density[rate.lay.ply]
            if isinstance(state.at, TwistedStrains):
                density = density * state.at.g
            M = mass_matrix(state.space, density)
            values_by_path["M"] = M.imag / TINY
            values_by_path["mass_centre"] = _by_step(mass_centre, M.real, values_by_path["M"])
        if shown and rate.angle.any():
            cells, axes = rate.cells, rate.axes()
            middle, fibre = middles(state.space)[cells], np.zeros((state.space.n_cell, 3))
            fibre[cells] = axes[np.arange(len(cells)), middle % axes.shape[1], :, 0].imag / TINY
            values_by_path["mesh/fibre"] = fibre
        values_by_path["plies/C_M"] = rate.C_M
        values_by_path["plies/angle_deg"] = np.degrees(rate.angle)
        return {path: values for path, values in values_by_path.items() if values.any()}

    def _warping(self, W: Array) -> Array:
        """Rate of the warping without rigid motion, at the nodes of the file."""
        space = self.state.space
        if isinstance(self.state.at, TwistedStrains):
            Z = motions_of_beam(space)
            load = space.load(space.at_points(Z))
            W = W - Z @ np.linalg.solve(Z.T @ load, load.T @ W)
        return nodal_displacements(space, W)

    def _recovery(self, at: Recovered, change: Change) -> dict[str, Array]:
        """Rates of strains of the points in ply axes, and of these axes."""
        rate, real, values = replace(self.rate, lay=at.lay), at.real, {}
        strain = at.at.strain_in_section(change.W) + at.at.strain_along_beam(change.Q)
        strain_M = at.to_plies @ strain
        if rate.angle.any():
            cells, axes = rate.cells, rate.axes()
            A_BM = np.zeros((*at.space.weights.shape, 3, 3))
            A_BM[cells] = axes.imag / TINY
            values["recovery/A_BM"] = A_BM.reshape(-1, 3, 3)[real]
            turning = np.swapaxes(bond(axes).imag, -1, -2) / TINY
            strain_M[cells] += turning @ at.strain[cells]
        values["recovery/strain_M"] = strain_M.reshape(-1, 6, 6)[real]
        return values


def _by_step(function: Callable[[Array], Array], x: Array, rate: Array) -> Array:
    """Rate of a function of an array."""
    size = TINY / (np.abs(rate).max() or 1.0)
    return np.asarray(function(x + 1j * size * rate).imag) / size
