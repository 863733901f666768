"""Solver of E W = load: warping without rigid motion, also where E is ill-conditioned."""

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ...solver.math.arrays import REGULAR, Array
from .. import fenicsx
from .section_specification import SectionError
from .space.space import SectionSpace

# A load must do no work on rigid motions. Round-off gives relative work of 1e-12 and, in very thin
# open sections, more. Above the second value the equations themselves are wrong.
SOLVABILITY = 1e-10
NO_SOLUTION = 1e-6
WELL = 1e8  # growth of a random load up to which no correction is needed
# Parts of its diagonal that are added to E where rounding leaves no positive pivots; the factor
# then is only the preconditioner of conjugate gradients.
SHIFTS = (1e-14, 1e-13, 1e-12)
MOST_STEPS = 300  # of conjugate gradients
ENOUGH = 1e-12  # square root of the relative energy of a step that needs no further one

# Relative error of torsion and bending about the section's own centre, from rounding at a distant
# origin: 0.01 eps r^2 over the least eigenvalue of the scaled stiffness (measured on a rectangle,
# thickness 0.5 to 1e-3 of the width, at r = 10 to 1e5 widths).
ROUNDING = 0.01 * np.finfo(float).eps
MOST_LOST = 1e-3


def rigid_fields(space: SectionSpace) -> Array:
    """(n_dof, 4) motions without strain within the section: the null space of E."""
    return motions_of_beam(space)[:, :4]


def motions_of_beam(space: SectionSpace) -> Array:
    """Rigid motions (n_dof, 6) whose change along the beam is a unit beam strain."""
    x2, x3 = space.x2, space.x3
    return space.displacements(
        (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -x3, x2), (x3, 0, 0), (-x2, 0, 0)
    )


def check_origin(space: SectionSpace, A: Array) -> None:
    """Raise SectionError if the origin is so far that its moments hide torsion and bending.

    Parameters
    ----------
    space : unknowns of the section
    A : (n, n) stiffness about the origin, or work of rigid motions
    """
    x = np.stack([space.x2, space.x3])
    size, distance = np.ptp(x, axis=1).max(), np.linalg.norm(x.mean(axis=1))
    root = np.sqrt(np.abs(np.diag(A)))
    least = np.linalg.eigvalsh(A / np.outer(root, root))[0]
    if distance > size and ROUNDING * (distance / size) ** 2 > MOST_LOST * least:
        raise SectionError(
            f"the section is {size:.4g} m wide and {distance:.4g} m away from the origin of its "
            "mesh, about which stiffness and mass are taken: rounding leaves no digits of its "
            "torsion and bending; move the mesh to the origin, and the reference line with it"
        )


def pinned_dofs(space: SectionSpace, *, six: bool = False) -> NDArray[np.int64]:
    """Four unknowns that prevent the rigid motions in the null space of E, or `six` for all.

    A node, and the motion of a distant one across their line; of six, also u1 at this and at a
    third node.
    """
    whole, x = space.unknowns_at_nodes()
    i = int(np.argmin(x.sum(axis=1)))
    away = x - x[i]
    j = int(np.argmax(np.hypot(*away.T)))
    third = int(np.argmax(np.abs(away[:, 0] * away[j, 1] - away[:, 1] * away[j, 0])))
    a, b, c = 3 * whole[[i, j, third]]
    across = 2 if abs(away[j, 0]) >= abs(away[j, 1]) else 1
    return np.array([a, a + 1, a + 2, b + across, *((b, c) if six else ())])


class WarpingSolver:
    """Solves E W = load for warping without rigid motion; one solver for all materials of a mesh.

    With four unknowns pinned the matrix is positive definite, so a Cholesky factorisation is used.
    Loads that do no work on rigid motions give no force at the pins, so the choice of the pins
    has no effect. The rigid part is removed afterwards. The pattern without the pins
    and the symbolic factorisation are kept for the next material.
    """

    def __init__(self, space: SectionSpace, pins: NDArray[np.int64] | None = None) -> None:
        self.largest_growth = 1.0 / REGULAR
        self.shift = 0.0
        self.rigid = rigid_fields(space)
        self._rigid_size = np.linalg.norm(self.rigid, axis=0)
        self._rigid_load = space.load(space.at_points(self.rigid))
        self.rigid_gram = self.rigid.T @ self._rigid_load
        self._kept = space.pattern.without(pinned_dofs(space) if pins is None else pins)
        self._team = space.team
        self._factor: fenicsx.Cholesky | None = None
        self.solvability = (
            0.0  # largest relative work of a load on a rigid motion, for this material
        )

    def factorise(self, E: sp.csr_matrix) -> None:
        """Factorise the stiffness of a material.

        Raises FactorisationError if E has more zero modes than the rigid motions.
        """
        self.solvability = 0.0
        pinned = self._kept.matrix(E.data)
        if self.shift:
            pinned = (pinned + self.shift * sp.diags(pinned.diagonal())).tocsr()
        if self._factor is None:
            self._factor = fenicsx.cholesky(pinned, self._team, self.largest_growth)
        else:
            self._factor.largest_growth = self.largest_growth
            self._factor.update(pinned)

    @property
    def growth(self) -> float:
        """Growth of a random load by the solution, which measures the condition of E."""
        return 0.0 if self._factor is None else self._factor.growth

    def measured_growth(self) -> float:
        """The growth of the matrix factorised last, although nothing was solved with it yet."""
        assert self._factor is not None, "call factorise() first"
        self._factor.check()
        return self._factor.growth

    def solve(
        self, load: Array, size: float, product: Callable[[Array], Array] | None = None
    ) -> Array:
        """Warping (n_dof, m) under loads; `solvability` keeps their relative work on rigid motions.

        Parameters
        ----------
        load : (n_dof, m)
        size : norm of the terms that the load is a sum of
        product : computes E W from the strains of W, which is more accurate than E itself. If the
            condition of E requires it, the solution is corrected by its residual.

        Raises
        ------
        SectionError
            The work of the loads on rigid motions exceeds round-off.
        """
        assert self._factor is not None, "call factorise() first"
        work = np.linalg.norm(self.rigid.T @ load, axis=1) / self._rigid_size
        self.solvability = max(self.solvability, float(np.max(work)) / size if size else 0.0)
        if not self.solvability <= NO_SOLUTION and self.largest_growth < np.inf:
            raise SectionError(
                f"the warping has no solution: its load does work of {self.solvability:.1e} "
                f"(relative) on a rigid motion; round-off is at most {SOLVABILITY:g}"
            )
        free = self._kept.free
        W = np.zeros_like(load)
        W[free] = self._factor.solve(load[free])
        if self.shift or (product is not None and self.growth > WELL):
            assert product is not None, "a shifted factor needs the residual"
            W = self._by_gradients(W, load, product)
        return W - self.rigid @ np.linalg.solve(self.rigid_gram, self._rigid_load.T @ W)

    def without_rigid_work(self, load: Array) -> Array:
        """Loads (n_dof, m) that do the same work on what `solve` returns, none on rigid motions."""
        work = np.linalg.solve(self.rigid_gram.T, self.rigid.T @ load)
        return np.asarray(load - self._rigid_load @ work)

    def _by_gradients(self, W: Array, load: Array, product: Callable[[Array], Array]) -> Array:
        """Conjugate gradients from W, each column on its own; the factor is the preconditioner.

        Without a shift they correct the rounding of the factor in a few steps. With a shift, all
        but the few softest motions of the section are solved at once. Raises SectionError if the
        others do not converge, as those of a singular matrix.
        """
        assert self._factor is not None
        free = self._kept.free
        residual = (load - product(W))[free]
        step = self._factor.solve(residual)
        along, sizes = step.copy(), np.sum(step * residual, axis=0)
        whole = np.zeros_like(load)
        for _ in range(MOST_STEPS):
            # energy of the next step over that of the solution
            energy = np.abs(np.sum(W * load, axis=0))
            if np.all(sizes <= ENOUGH**2 * energy):
                return W
            whole[free] = along
            force = product(whole)[free]
            work = np.sum(along * force, axis=0)
            active = (sizes > ENOUGH**2 * energy) & (work > 0.0)
            length = np.where(active, sizes / np.where(active, work, 1.0), 0.0)
            W[free] += length * along
            residual -= length * force
            step = self._factor.solve(residual)
            new = np.sum(step * residual, axis=0)
            along = step + np.where(active, new / np.where(active, sizes, 1.0), 0.0) * along
            sizes = np.where(active, new, sizes)
            if not np.all(np.isfinite(sizes)):
                break
        raise SectionError(
            "the equations of the warping appear to be singular: conjugate gradients do not "
            "converge; is every part connected by elements that are not much softer?"
        )
