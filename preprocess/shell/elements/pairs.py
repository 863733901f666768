"""Virtual work of a cell as lists of pairs (stress, strain) in UFL, and the compiled lists.

The virtual work is the sum of stress(u) . strain(v) over the pairs, each linear in the unknowns of
the corners (cell.py); the elements are in plates/, membranes/, drilling/ and quadrilateral.py.

    stiffness    a membrane and a plate, coupled by their mean strains, and a drilling stiffness
    mass         the displacements and rotations of the corners interpolated
    geometric    the work of the resultants of a prestress on the second-order strains
    pressure     that of a pressure which stays normal to the surface
"""

from collections.abc import Iterable
from functools import cache
from typing import Any, NamedTuple

from ufl import as_matrix, as_vector, inv

from ....solver.errors import did_you_mean
from ....solver.package.body.package_schema import MASS_FORMS
from ....solver.package.shell import elements
from ...fenicsx import Kernel, Rows, compiled, kernel
from ..shell_cells import ShellError
from .cell import SIZE, Cell, Point, cell_of
from .drilling import DRILLINGS
from .membranes import MEMBRANES
from .plates import PLATES
from .plates.contract import side_differences
from .plates.dkmt import dkmt
from .plates.dst import moment_slopes
from .quadrilateral import hybrid, relief


class Choice(NamedTuple):
    """Names of the elements of triangles and of quadrilaterals, with their parameters.

    Attributes
    ----------
    plate : key of PLATES
    membrane : key of MEMBRANES
    beta0 : factor of the higher-order stiffness of "opt", or "felippa": from the membrane
        stiffness of the laminate
    drilling : key of DRILLINGS, "none", or "auto": "tie" for a membrane without rotations of its
        own, otherwise "none"
    drilling_factor : factor of the drilling stiffness, to the laminate's A66
    quadrilateral : key of QUADS
    """

    plate: str = elements.PLATE
    membrane: str = elements.MEMBRANE
    beta0: float | str = elements.BETA0
    drilling: str = elements.DRILLING
    drilling_factor: float = elements.DRILLING_FACTOR
    quadrilateral: str = elements.QUAD

    def drilling_form(self) -> str:
        """Name of the drilling stiffness, with "auto" resolved."""
        if self.drilling != "auto":
            return self.drilling
        return "none" if MEMBRANES[self.membrane].rotations else "tie"

    def checked(self) -> "Choice":
        """Return itself; raise `ShellError` with key, value and expectation if it is wrong."""
        for key, known in (
            ("plate", PLATES),
            ("membrane", MEMBRANES),
            ("drilling", ("auto", "none", *DRILLINGS)),
            ("quadrilateral", elements.QUADS),
        ):
            _known(key, getattr(self, key), known)
        if isinstance(self.beta0, str):
            if self.beta0 != "felippa":
                raise ShellError(f'beta0 {self.beta0!r}: expected a number above 0 or "felippa"')
        elif not self.beta0 > 0.0:
            raise ShellError(f"beta0 {self.beta0!r}: expected a number above 0")
        if not self.drilling_factor > 0.0:
            raise ShellError(
                f'drilling_factor {self.drilling_factor!r}: expected above 0; drilling = "none" '
                "switches it off"
            )
        return self


def _known(key: str, name: str, known: Iterable[str]) -> None:
    names = list(known)
    if name not in names:
        listed = ", ".join(names)
        raise ShellError(f"{key} {name!r}: expected one of {listed}{did_you_mean(name, names)}")


class Work(NamedTuple):
    """Pairs of vectors (stress, strain), coupling with another list, and mean strains."""

    pairs: list[tuple[Any, Any]]
    coupling: Any = ()
    means: Any = ()


def membrane_work(t: Cell, name: str) -> Work:
    """Membrane of a triangle; the coupling acts on its mean strain.

    Paper: Eq. (25), Eq. (26).
    """
    membrane = MEMBRANES[name].strains(t)
    share = t.area / float(len(membrane.strain))
    e = _mean(membrane.strain)
    pairs = [(share * t.A * strain, strain) for strain in membrane.strain]
    return Work(pairs + membrane.extra, coupling=e, means=e)


def plate_work(t: Cell, name: str) -> Work:
    """Plate of a triangle; the work of the coupling is area e' B k.

    Paper: Eq. (25), Eq. (26).
    """
    plate = PLATES[name].strains(t)
    pairs = [(t.area / 3.0 * t.D * k, k) for k in plate.curvature]
    pairs += [(t.area / float(len(plate.shear)) * t.Ds * gamma, gamma) for gamma in plate.shear]
    k = _mean(plate.curvature)
    if plate.shear:
        gamma = _mean(plate.shear)
    else:  # without shear strain, the shear forces follow from the moments
        Aw = side_differences(t)
        alpha = as_vector([1.5 * Aw[i] / t.length[i] for i in range(3)])
        gamma = inv(t.Ds) * moment_slopes(t) * alpha
    return Work(pairs, coupling=t.area * t.B * k, means=[*_rows(k), *_rows(gamma)])


def quadrilateral_work(q: Cell) -> Work:
    """Hybrid membrane and plate of a quadrilateral, coupled.

    The plate is DKMQ, the discrete Kirchhoff-Mindlin quadrilateral (Katili 1993), as the triangle.
    The ratio phi_k of a side has a part of the width (`width_ratios`), which with the internal
    rotations lets a strip of one cell twist.
    """
    plate = dkmt(q)
    membrane = hybrid(q, plate.curvature)
    D = q.D - q.B * inv(q.A) * q.B  # the rest of B is in the membrane
    pairs = list(membrane.pairs)
    for point, k, gamma in zip(q.points, plate.curvature, plate.shear, strict=True):
        pairs += [(point.weight * D * k, k), (point.weight * q.Ds * gamma, gamma)]
    pairs += relief(q, plate.shear)
    k, gamma = (
        sum((p.weight * value for p, value in zip(q.points, values, strict=True)), 0 * values[0])
        / q.area
        for values in plate
    )
    return Work(pairs, means=[*_rows(membrane.strain), *_rows(k), *_rows(gamma)])


def mass_work(t: Cell, form: str) -> Work:
    """Mass with the displacements and rotations of the corners interpolated.

    A point z above the reference surface moves by (20)-(22) of the paper: u + z bx, v + z by, w.
    With m0, m1, m2 the moments of the density over the thickness, the kinetic energy per area is

        m0/2 (u'^2 + v'^2 + w'^2) + m1 (u' bx' + v' by') + m2/2 (bx'^2 + by'^2).

    The drilling rotation moves no mass. In the consistent form, m2 acts on its difference from the
    rotation of the cell, so every rigid motion has its exact energy. In the lumped form, with the
    area of its function at each corner, m2 acts on it as on the other rotations, so without m1 the
    matrix is diagonal in all axes.

    Paper: Eq. (20), Eq. (21), Eq. (22), Eq. (31).
    """
    m0, m1, m2 = (t.mass[i] for i in range(3))
    fields = [[getattr(c, name) for c in t.corners] for name in ("u", "v", "w", "bx", "by")]
    if form == "consistent":
        fields.append(t.excess(t.corners))
        at = [(point.weight, [point.of(field) for field in fields]) for point in t.points]
    else:
        fields.append([corner.tz for corner in t.corners])
        at = [
            (sum(point.weight * point.N[i] for point in t.points), [field[i] for field in fields])
            for i in range(t.k)
        ]
    pairs = []
    for area, (u, v, w, bx, by, drill) in at:
        stress = (m0 * u + m1 * bx, m0 * v + m1 * by, m0 * w, m1 * u + m2 * bx, m1 * v + m2 * by,
                  m2 * drill)  # fmt: skip
        pairs.append((area * as_vector(stress), as_vector((u, v, w, bx, by, drill))))
    return Work(pairs)


def geometric_work(t: Cell) -> Work:
    """Work of the resultants of a prestress on the second-order strains.

    With constant N in each cell, displacements interpolated from the corners, and the rotation
    about the normal r = (v,x - u,y)/2,

        u' Kg u = int N_ab w,a w,b + (N_xx + N_yy) r^2 dA.

    The second term is the part of the in-plane gradients that is not of the order of the
    pre-strain. A rigid rotation has the exact second-order work, a column may buckle in the plane
    of its wall, and no axes are preferred. Tables of plates have the first term only. The rotation
    tz and terms of N h^2/12 have no part.
    """
    Nxx, Nyy, Nxy = (t.N[i] for i in range(3))
    N, pairs = as_matrix(((Nxx, Nxy), (Nxy, Nyy))), []
    for point in t.gradient_points:
        u, v, slope = _slopes(t, point)
        r = as_vector([0.5 * (v[0] - u[1])])
        pairs += [
            (point.weight * N * slope, slope),
            (point.weight * t.in_plane * (Nxx + Nyy) * r, r),
        ]
    return Work(pairs)


def pressure_work(t: Cell) -> Work:
    """Stiffness of a pressure p that stays normal to its cells.

    The area vector of a displaced cell is e3 + (u,x + v,y) e3 - w,x e1 - w,y e2 per area; minus
    the derivatives of the nodal forces by the displacements, their symmetric part. On a closed
    surface, and where the edges are held, the sum over all cells is symmetric by itself.
    """
    pairs = []
    for n, point in enumerate(t.points):
        half = 0.5 * t.p[n] * point.weight
        by_u, by_v, slope = _slopes(t, point)
        u, v, w = (point.of([getattr(c, name) for c in t.corners]) for name in ("u", "v", "w"))
        moved, stretch, up = as_vector((u, v)), as_vector([by_u[0] + by_v[1]]), as_vector([w])
        pairs += [(half * moved, slope), (half * slope, moved)]
        pairs += [(-half * up, stretch), (-half * stretch, up)]
    return Work(pairs)


def stiffness_kernel(k: int, choice: Choice, drilling: bool = True) -> Kernel:
    """Stiffness of cells.

    Parameters
    ----------
    k : 3 or 4 corners
    choice : the elements
    drilling : with the drilling stiffness of triangles

    Raises
    ------
    ShellError
        A choice that does not exist.
    """
    choice.checked()
    if k == 4:
        names = [("quadrilateral", choice.quadrilateral)]
    else:
        names = [("membrane", choice.membrane), ("plate", choice.plate)]
        if drilling and choice.drilling_form() != "none":
            names.append(("drilling", choice.drilling_form()))
    return kernel_of(k, *names)


def mass_kernel(k: int, form: str) -> Kernel:
    """Mass of cells with k corners. Raises `ShellError` for an unknown form."""
    if form not in MASS_FORMS:
        raise ShellError(f"mass form {form!r}: expected one of {', '.join(MASS_FORMS)}")
    return kernel_of(k, ("mass", form))


def geometric_kernel(k: int) -> Kernel:
    """Geometric stiffness of cells with k corners."""
    return kernel_of(k, ("geometric", ""))


def pressure_kernel(k: int) -> Kernel:
    """Stiffness of a pressure on cells with k corners."""
    return kernel_of(k, ("pressure", ""))


WORKS = {
    "membrane": membrane_work,
    "plate": plate_work,
    "drilling": lambda t, name: Work(DRILLINGS[name].pairs(t)),
    "quadrilateral": lambda q, _: quadrilateral_work(q),
    "mass": mass_work,
    "geometric": lambda t, _: geometric_work(t),
    "pressure": lambda t, _: pressure_work(t),
}


def kernel_of(k: int, *names: tuple[str, str]) -> Kernel:
    """Kernel of some lists of cells with k corners: pairs of a key of `WORKS` and a name."""
    return kernel(6 * k, [_compiled(k, kind, name) for kind, name in names])


@cache
def _compiled(k: int, kind: str, name: str) -> Rows:
    """A list, compiled once a process (and once a machine, by FFCx)."""
    work = WORKS[kind](cell_of(k), name)
    stresses = [row for stress, _ in work.pairs for row in _rows(stress)]
    strains = [row for _, strain in work.pairs for row in _rows(strain)]
    return compiled(SIZE, stresses, strains, _rows(work.coupling), _rows(work.means))


def _rows(vector: Any) -> list[Any]:
    return [vector[i] for i in range(len(vector))]


def _mean(values: list[Any]) -> Any:
    return sum(values[1:], values[0]) / float(len(values))


def _slopes(t: Cell, point: Point) -> tuple[Any, Any, Any]:
    """Gradients of u, v, w."""
    u, v, w = (point.slope([getattr(c, name) for c in t.corners]) for name in ("u", "v", "w"))
    return u, v, w
