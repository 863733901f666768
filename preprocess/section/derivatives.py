"""Exact derivatives of the solutions of a section, by parameters of its description.

Every result is that of central solutions: the warping W and the beam strains S_e of the six unit
resultants, whose change along the beam is W' = W T (helical.py; T = 0 but for M2' = F3, M3' = -F2
of a prismatic beam). With Q = W T + Z S_e, the strain e = G W + G_l Q and the stress s = C e they
satisfy

    load_in_section(s) - P T = 0,   Z' P = 1,   P = load_along_beam(s),

and S = K^-1 is the work of s and e. These equations are linear in C: `changed` evaluates them with
the rate of C. What remains is one more solution, by the factors of the analysis, with what the
rates leave in the equations as loads.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ...solver.math.arrays import Array, IntArray
from .helical import CentralSolutions, Equations, TwistedStrains, change_of_resultants, flat
from .recovery import Result, middles, nodal_displacements, unit_displacements
from .section_parameters import TURN, TURNING, Rates
from .space.layers import Layup
from .space.space import SectionSpace
from .timoshenko import CLASSICAL, SHEAR, mass_centre, mass_matrix, shear_centre, tension_centre
from .warping import WarpingSolver, motions_of_beam

Operators = SectionSpace | TwistedStrains
AT_ONCE = 16  # parameters whose equations are solved together
ENOUGH = 1e-10  # error of the solution of a twisted or curved beam, relative
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


class PrismaticSolver:
    """Solves the equations of `central` of a prismatic beam by the factor of its warping.

    T is nilpotent: first the solutions without shear force, then those with it.
    """

    def __init__(self, result: Result, state: Central, factorised: WarpingSolver) -> None:
        assert not isinstance(result, CentralSolutions)
        self._state, self._solver, self._space = state, factorised, result.space
        self._A, self._V0 = result.A, result.V0
        stress = state.C @ result.space.strain_along_beam(state.Z)
        self._of_motions = result.space.load_along_beam(stress)  # (n_dof, 6)

    def solve(self, load: Array, resultants: Array, _: float) -> tuple[Array, Array]:
        """W (n_dof, p, 6) and S_e (6, p, 6) with these terms, of the same shapes.

        Parameters
        ----------
        load : (n_dof, p, 6) loads on the warping, for p parameters
        resultants : (6, p, 6)
        _ : not used: these solutions are not iterated
        """
        state, space = self._state, self._space
        W, S_e = np.zeros(load.shape), np.zeros(resultants.shape)
        constant, shear = np.s_[..., CLASSICAL], np.s_[..., SHEAR]
        W[constant], S_e[constant] = self._constant(load[constant], resultants[constant])
        # the resultants M2 and M3 change in proportion to F3 and F2
        forces = np.flatnonzero(state.T[:, SHEAR].any(axis=1))
        T = state.T[forces][:, SHEAR]

        def changing(columns: Array) -> Array:
            return columns.reshape(len(columns), -1, len(forces)) @ T

        rate = flat(changing(W[..., forces]))
        left = space.load_in_section(state.C @ space.strain_along_beam(rate))
        along = space.load_along_beam(state.C @ space.strain_in_section(flat(W[..., forces])))
        along += self._of_motions @ flat(S_e[..., forces])
        W[shear], S_e[shear] = self._constant(
            load[shear] - left.reshape(load[shear].shape) + changing(along),
            resultants[shear] - (self._of_motions.T @ rate).reshape(resultants[shear].shape),
        )
        return W, S_e

    def tests(self) -> tuple[Array, Array]:
        """Strains A and B (c, q, 6, 6) by whose work with C' e the stiffness changes.

        M = T'N + N T + S_e' of `changed` is -<A, C' e> + <B, C' e> T. The equations are symmetric,
        their part with T is antisymmetric: two solutions with the loads P give M of any C'.
        """
        state, space, solver = self._state, self._space, self._solver
        W, S_e = self._constant(state.P @ state.T, np.eye(6))
        A = space.strain_in_section(W) + space.strain_along_beam(state.Z @ S_e)
        B = space.strain_along_beam(W)
        change = space.load_along_beam(state.C @ B)
        load = state.P + space.load_in_section(state.C @ B) - space.load_along_beam(state.C @ A)
        W, S_e = self._constant(solver.without_rigid_work(load), state.Z.T @ change)
        B = B - space.strain_in_section(W) - space.strain_along_beam(state.Z @ S_e)
        return A, B

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
class Changes:
    """Rates of the stiffness and of the central solutions, by p parameters."""

    K: Array  # (p, 6, 6)
    W: Array  # (n_dof, p, 6)
    Q: Array  # (n_dof, p, 6)


def changed(
    state: Central, solver: "Solver", of_stiffness: Sequence[tuple[IntArray, Array]]
) -> Changes:
    """Return what rates of the stiffness bring about, each alone.

    Parameters
    ----------
    state : the central solutions
    solver : of their equations
    of_stiffness : cells and rates of C at their points (s, 1 or q, 6, 6) [Pa], by parameter
    """
    at, T, K, shape = state.at, state.T, state.K, (len(state.Z), len(of_stiffness), 6)
    P, load, S = np.empty(shape), np.empty(shape), np.empty((len(of_stiffness), 6, 6))
    for i, (cells, rate) in enumerate(of_stiffness):
        strain = state.strain[cells]
        stress = rate @ strain
        P[:, i] = at.load_along_beam(stress, cells)
        load[:, i] = at.load_in_section(stress, cells) - P[:, i] @ T
        S[i] = at.work(stress, strain, cells)
    W, S_e = solver.solve(-load, -(state.Z.T @ flat(P)).reshape(6, *shape[1:]), ENOUGH)
    Q = W @ T + (state.Z @ flat(S_e)).reshape(shape)
    # the stresses are in equilibrium: their work on new strains is that of P
    N = np.swapaxes((state.P.T @ flat(W)).reshape(S_e.shape), 0, 1)
    S = S + 2.0 * (T.T @ N + N @ T + np.swapaxes(S_e, 0, 1))
    dK = -K @ (0.5 * (S + np.swapaxes(S, 1, 2))) @ K
    return Changes(0.5 * (dK + np.swapaxes(dK, 1, 2)), W, Q)


def _changed_stiffness(
    state: Central, solver: PrismaticSolver, of_stiffness: Sequence[tuple[IntArray, Array]]
) -> Array:
    """Return the rates K' of `changed` alone, (p, 6, 6), by two solutions for all parameters."""
    K, T, rates = state.K, state.T, np.zeros((len(of_stiffness), 6, 6))
    tests = np.concatenate([state.strain, *solver.tests()], axis=-1)
    for i, (cells, rate) in enumerate(of_stiffness):
        work = state.space.work(rate @ state.strain[cells], tests[cells], cells)
        S = work[:, :6] - 2.0 * work[:, 6:12].T + 2.0 * work[:, 12:].T @ T
        rates[i] = -0.5 * K @ (S + S.T) @ K
    return 0.5 * (rates + np.swapaxes(rates, 1, 2))


Solver = PrismaticSolver | Equations


def derivatives(
    result: Result,
    factorised: WarpingSolver | None,
    asked: Sequence[Rates],
    space: SectionSpace,
    lay: Layup,
    strain: Array,
    *,
    shown: bool = True,
    strains: bool = True,
) -> dict[str, dict[str, Array]]:
    """Derivatives of the datasets of a section file by parameters that do not move its mesh.

    By name of the parameter and path, without those that are zero.

    Parameters
    ----------
    result : of the analysis, in the space of `factorised` or of a twisted beam
    factorised : the solver with its factors, None of a twisted or curved beam
    asked : the rates of each parameter
    space, lay : points of recovery and their plies
    strain : `unit_strains` at these points
    shown : also of warping and mesh, which a body has no use for
    strains : also of strains at the points; a prismatic beam without has those of K and M
    """
    state = central(result, asked[0].lay.stiffness)
    solver: Solver
    if isinstance(result, CentralSolutions):
        solver = result.equations
    else:
        assert factorised is not None
        solver = PrismaticSolver(result, state, factorised)
    recovered = Recovered(space, lay, strain, state)
    middle = middles(state.space) if shown else None
    by_parameter = {one.parameter.name: _of_plies(state, one, middle) for one in asked}
    moving = [one for one in asked if len(one.cells)]
    if not strains and isinstance(solver, PrismaticSolver):
        rates = _changed_stiffness(state, solver, [(one.cells, one.stiffness()) for one in moving])
        for one, K in zip(moving, rates, strict=True):
            by_parameter[one.parameter.name]["K"] = K
        moving = []
    for first in range(0, len(moving), AT_ONCE):
        some = moving[first : first + AT_ONCE]
        changes = changed(state, solver, [(one.cells, one.stiffness()) for one in some])
        recovered_rates = recovered.rates(some, changes)
        warping = _warping(state, flat(changes.W)) if shown else None
        for i, (one, K) in enumerate(zip(some, changes.K, strict=True)):
            values = by_parameter[one.parameter.name]
            values |= {"K": K, **recovered_rates[i]}
            values["shear_centre"] = _by_step(shear_centre, state.K, K)
            values["tension_centre"] = _by_step(tension_centre, state.K, K)
            if warping is not None:
                values["warping"] = warping[6 * i : 6 * i + 6]
    return {
        name: {path: rate for path, rate in values.items() if rate.any()}
        for name, values in by_parameter.items()
    }


class Recovered:
    """Where strains and stresses of a result are recovered.

    Parameters
    ----------
    strain : `unit_strains` at the points of the space, (c, q, 6, 6)
    """

    def __init__(self, space: SectionSpace, lay: Layup, strain: Array, state: Central) -> None:
        # not the points that fill up cells with fewer ones
        self.real, self.ply = np.flatnonzero(space.weights), lay.ply[space.weights > 0.0]
        self.to_plies = np.swapaxes(lay.T, -1, -2)
        self.at: Operators = space
        if isinstance(state.at, TwistedStrains):
            self.at = TwistedStrains(space, state.at.k)
        strain_M = (self.to_plies @ strain).reshape(-1, 6, 6)
        self.turning_strain = TURNING.T @ strain_M[self.real]
        turning = np.broadcast_to(lay.A_BM @ TURN, (*lay.ply.shape, 3, 3))
        self.turning_axes = turning.reshape(-1, 3, 3)[self.real]

    def rates(self, asked: Sequence[Rates], changes: Changes) -> list[dict[str, Array]]:
        """Rates of the strains of the points in ply axes and of these axes, by each parameter."""
        at, found = self.at, []
        strain = at.strain_in_section(flat(changes.W))
        strain += at.strain_along_beam(flat(changes.Q))
        strain_M = (self.to_plies @ strain).reshape(-1, 6, len(asked), 6)
        for i, one in enumerate(asked):
            rate = {"recovery/strain_M": strain_M[self.real, :, i]}
            if one.angle.any():
                angle = one.angle[self.ply][:, None, None]
                rate["recovery/strain_M"] += angle * self.turning_strain
                rate["recovery/A_BM"] = angle * self.turning_axes
            found.append(rate)
        return found


def _of_plies(state: Central, rate: Rates, middle: IntArray | None) -> dict[str, Array]:
    """Rates that follow from those of the plies; fibres at the `middles`, for a file with them."""
    lay, of_plies = rate.lay, {"plies/C_M": rate.C_M, "plies/angle_deg": np.degrees(rate.angle)}
    if rate.density.any():
        g = state.at.g if isinstance(state.at, TwistedStrains) else 1.0
        M, change = (
            mass_matrix(state.space, density * g)
            for density in (lay.density, rate.density[lay.ply])
        )
        of_plies |= {"M": change, "mass_centre": _by_step(mass_centre, M, change)}
    if middle is not None and rate.angle.any():
        every = np.arange(len(middle))
        axes = lay.A_BM[every, middle % lay.A_BM.shape[1]]
        of_plies["mesh/fibre"] = rate.angle[lay.ply[every, middle]][:, None] * axes[:, :, 1]
    return of_plies


def _warping(state: Central, W: Array) -> Array:
    """Rates of the warping without rigid motion, at the nodes of the file, (m, n, 3)."""
    space = state.space
    if isinstance(state.at, TwistedStrains):
        load = space.load(space.at_points(state.Z))
        W = W - state.Z @ np.linalg.solve(state.Z.T @ load, load.T @ W)
    return nodal_displacements(space, W)


def _by_step(function: Callable[[Array], Array], x: Array, rate: Array) -> Array:
    """Rate of a function of an array."""
    size = 1e-30 / (np.abs(rate).max() or 1.0)
    return np.asarray(function(x + 1j * size * rate).imag) / size
