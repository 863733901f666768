"""What the modes of a beam carry with them: section resultants, second-order displacements.

Section resultants
------------------
A shape d is the deformation under a distributed load M a and forces at nodes. a = lambda d for
a mode of eigenvalue lambda, and a = 0 for the static shape of forces at nodes. The forces at
the ends of an element in equilibrium with that load,

    f = K_e d - M_e a,     F6(0) = -f_1,     F6(L) = f_2,

are the resultants there. Both elements of a node give the same value because the node is in
equilibrium: the resultants are continuous where nothing is attached. They are
exact to round-off for static shapes under loads at nodes. For modes with consistent mass
their error falls with the fourth power of the element length in slender bending. It falls with the
second power, from a small value, for rotary inertia, twist or extension, and with
lumped mass. K e6 from the static shape functions inside the element would have an error of
lambda m u L^2 / 12 in the moments at its ends, where the moments are largest.

Second-order displacements, by quadrature of the interpolation
--------------------------------------------------------------
A section displaced by u and rotated by the rotation vector f, R = exp(f~), has the exact
strains R'(e1 + u') - e1 and axial(R'R'). To second order in u and f they are those of the linear
element plus

    - f x u' + 1/2 f x (f x e1)       and       - 1/2 f x f'.

The modes give the strains to first order. The second-order displacement u2, f2 cancels the
second-order strains. The section laws then hold in the rotated axes of each section, and the strain
energy stays 1/2 q' K q:

    f2' = 1/2 f x f',       u2' = f2 x e1 + f x u' - 1/2 f x (f x e1).

A section twisted by k1 also has the strains -1/2 a k1^2 (`LineSection.trapeze`). They need no
resultants, so
a k1^2 is subtracted from the two slopes.

In slender bending u2_1' = -1/2 (v'^2 + w'^2): the beam shortens. Bending with twist and bending
in two planes rotate the section and move the line sideways. A beam held by six dofs is
statically determinate, so the fields are a quadrature along the line for any stiffness.
u and f are polynomials in an element, and the quadrature is exact.

Written as q' (.) q / 2, a field is a table symmetric in two modes. A rigid motion is subtracted, so
that the displacement fulfils the reference condition to second order too.
"""

from dataclasses import dataclass

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.invariants import rigid_motions
from ...solver.package.body.package_schema import BodyRecovery
from .beam_stations import PointMasses, station_places
from .element import Z, gauss
from .line import BeamLine


def shape_resultants(
    line: BeamLine,
    columns_B: Array,
    accelerations_B: Array,
    mass_form: str,
    breaks: tuple[int, ...] = (),
) -> BodyRecovery:
    """Resultants at the nodes per unit modal coordinate.

    Parameters
    ----------
    line : the beam
    columns_B : (6 n, m) shapes, body axes
    accelerations_B : (6 n, m) a of the distributed load M a of each shape; 0 for
        static shapes of forces at nodes [m/s2, rad/s2]
    mass_form : "consistent" or "lumped", that of the loads
    breaks : held or loaded nodes, where the resultants jump: each gives two stations

    Returns
    -------
    Stations in order of x: the nodes, all with the section 0. Those of `breaks` are present twice,
    first as the end of the element before them, then as the start of the element after them.
    """
    d, a = line.to_element(columns_B), line.to_element(accelerations_B)
    ends = np.zeros((line.n_node - 1, 2, 6, d.shape[2]))
    for span in line.spans:
        element, numbers = span.element, span.numbers
        M = element.mass_matrix(span.section.mass, mass_form)
        inner = np.einsum("ij,ejm->eim", element.stiffness(), d[numbers])
        inertial = np.einsum("ij,ejm->eim", M, a[numbers])
        ends[numbers] = (inner - inertial).reshape(len(numbers), 2, 6, d.shape[2])
    ends[:, 0] *= -1.0
    last = line.n_node - 1
    inner_breaks = np.array(sorted({b for b in breaks if 0 < b < last}), dtype=np.int64)
    # The start of each element, and its end if it is the last element or the resultants jump.
    node = np.concatenate([np.arange(last), inner_breaks, [last]])
    resultants = np.concatenate([ends[:, 0], ends[inner_breaks - 1, 1], ends[-1:, 1]])
    at_end = np.concatenate([np.ones(last), np.zeros(len(inner_breaks) + 1)])
    order = np.lexsort([at_end, node])
    return BodyRecovery(
        station_x=line.along[node][order],
        section=np.zeros(len(order), dtype=np.int64),
        resultants_E=resultants[order],
        A_BE=line.A_BE[0],
    )


POINTS = 5  # the slopes of u2 and f2 have degree 4 in x, so 5 points determine them
E1 = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True)
class SecondOrderFields:
    """Second-order fields of a beam, symmetric in their last two indices, the modes; body axes.

    Attributes
    ----------
    h_B : (p, 3, m, m) translation of the point masses [m]
    node_u_B, node_f_B : (n, 3, m, m) translation and rotation vector of the nodes [m, rad]
    """

    h_B: Array
    node_u_B: Array
    node_f_B: Array


def second_order_fields(
    line: BeamLine, columns_B: Array, points: PointMasses, mass_form: str, held: IntArray | None
) -> SecondOrderFields:
    """Second-order fields of modes relative to their frame.

    Parameters
    ----------
    line : the beam
    columns_B : (6 n, m) nodal displacements and rotations of the modes, body axes [m, rad]
    points : point masses of the slices, which move with these modes
    mass_form : that of the slices
    held : (6,) dofs that carry the frame; None for a mean axis
    """
    node_u_B, node_f_B, at_slices = _from_first_node(line, columns_B, mass_form)
    of = points.slice_of
    u, f, turn, centre = (part[of] for part in at_slices)
    arm_B = points.s_B + centre
    h_B = u + _cross_arms(f, arm_B) + 0.5 * _both(turn, _cross_arms(turn, arm_B))
    nodal = np.concatenate([node_u_B, node_f_B], axis=1)
    rigid = rigid_motions(line.nodes_B)
    rigid_points = rigid_motions(points.x_B)[:, :3]
    if held is None:
        motion = _mean_motion(points, rigid_points, h_B)
    else:
        flat = nodal.reshape(6 * line.n_node, -1)
        motion = np.linalg.solve(rigid.reshape(-1, 6)[held], flat[held])
        motion = motion.reshape(6, *nodal.shape[2:])
    nodal = nodal - np.einsum("kab,bij->kaij", rigid, motion)
    h_B = h_B - np.einsum("kab,bij->kaij", rigid_points, motion)
    return SecondOrderFields(h_B, nodal[:, :3], nodal[:, 3:])


def _from_first_node(
    line: BeamLine, columns_B: Array, mass_form: str
) -> tuple[Array, Array, tuple[Array, Array, Array, Array]]:
    """Fields that are zero at the first node, body axes.

    Returns u2, f2 (n, 3, m, m) at the nodes; and, at the mass stations, u2, f2, the rotation f
    (k, 3, m) of the modes and the mass centre (k, 3) from the line.
    """
    nodal_E = line.to_element(columns_B)
    m = columns_B.shape[1]
    ends = np.zeros((line.n_node - 1, 2, 3, m, m))  # increments of u2 and f2 over an element
    inner = []
    for span in line.spans:
        element, numbers, A = span.element, span.numbers, line.A_BE[span.numbers]
        x, w = gauss(element.length, POINTS)
        own = nodal_E[numbers][:, None]
        d, strain = element.shape(x) @ own, element.strain(x) @ own
        slope = strain + Z @ d
        f, u_slope, f_slope = d[:, :, 3:], slope[:, :, :3], slope[:, :, 3:]
        k1 = strain[:, :, 3]
        twisted = np.einsum("a,egi,egj->egaij", span.section.trapeze, k1, k1)
        f2_slope = 0.5 * _both(f, f_slope) - twisted[:, :, 3:]
        f2 = np.einsum("gh,ehaij->egaij", _integration(x, x), f2_slope)
        u2_slope = _cross(f2, E1, 2) + _both(f, u_slope - 0.5 * _cross(f, E1, 2))
        u2_slope -= twisted[:, :, :3]
        for part, slopes in enumerate((u2_slope, f2_slope)):
            ends[numbers, part] = _turned(A, np.einsum("g,egbij->ebij", w, slopes))
        at, _ = station_places(element.length, mass_form)
        to_stations = _integration(x, at)
        u_in, f_in = (
            np.einsum("gh,ehaij->egaij", to_stations, _turned(A[:, None], slopes))
            for slopes in (u2_slope, f2_slope)
        )
        turn = A[:, None] @ (element.shape(at)[:, 3:] @ own)
        inner.append((span, at, u_in, f_in, turn))
    zero = np.zeros((1, 3, m, m))
    node_f = np.concatenate([zero, np.cumsum(ends[:, 1], axis=0)])
    swept = _cross_arms(node_f[:-1], np.diff(line.nodes_B, axis=0))
    node_u = np.concatenate([zero, np.cumsum(ends[:, 0] + swept, axis=0)])
    parts = []
    for span, at, u_in, f_in, turn in inner:
        A, shape = line.A_BE[span.numbers], (len(span.numbers), len(at))
        arms = np.einsum("ea,g->ega", A[:, :, 0], at).reshape(-1, 3)
        start_u, start_f = (
            np.repeat(part[span.numbers], len(at), axis=0) for part in (node_u, node_f)
        )
        centre = np.broadcast_to((A @ span.section.slice_mass.centre_E)[:, None], (*shape, 3))
        parts.append(
            (
                start_u + _cross_arms(start_f, arms) + u_in.reshape(-1, 3, m, m),
                start_f + f_in.reshape(-1, 3, m, m),
                turn.reshape(-1, 3, m),
                centre.reshape(-1, 3),
            )
        )
    u, f, turns, centres = (np.concatenate(part) for part in zip(*parts, strict=True))
    return node_u, node_f, (u, f, turns, centres)


def _turned(A: Array, field: Array) -> Array:
    """A field (..., 3, m, m) in other axes."""
    return np.asarray(A @ field.reshape(*field.shape[:-2], -1)).reshape(field.shape)


def _mean_motion(points: PointMasses, rigid: Array, h_B: Array) -> Array:
    """Rigid motion (6, m, m) with the same momentum as the field at the points.

    `rigid` (p, 3, 6) are the displacements of the points in unit rigid motions.
    """
    inertia = np.einsum("k,kab,kac->bc", points.m, rigid, rigid, optimize=True)
    moment = np.einsum("k,kab,kaij->bij", points.m, rigid, h_B, optimize=True)
    return np.linalg.solve(inertia, moment.reshape(6, -1)).reshape(moment.shape)


def _integration(x: Array, at: Array) -> Array:
    """Integral from 0 to each of `at` of the polynomial through values at x, (t, k)."""
    scale = x[-1]
    powers = np.arange(len(x))
    values = (x[:, None] / scale) ** powers
    integrals = scale * (at[:, None] / scale) ** (powers + 1) / (powers + 1)
    return np.asarray(np.linalg.solve(values.T, integrals.T).T)


def _cross(a: Array, b: Array, axis: int) -> Array:
    """a x b of an array a whose `axis` counts components and a vector b (3,)."""
    return np.moveaxis(np.cross(np.moveaxis(a, axis, -1), b), -1, axis)


def _cross_arms(a: Array, arms: Array) -> Array:
    """a x b of a (p, 3, ...) and one vector each, (p, 3)."""
    return np.cross(a, arms.reshape(*arms.shape, *(1,) * (a.ndim - 2)), axis=1)


def _both(a: Array, b: Array) -> Array:
    """a_i x b_j + a_j x b_i of (..., 3, m) and (..., 3, m), (..., 3, m, m)."""
    one = np.cross(a[..., :, None], b[..., None, :], axisa=-3, axisb=-3, axisc=-3)
    return one + np.swapaxes(one, -1, -2)
