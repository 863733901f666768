"""A section for tests whose stresses are known in closed form: an isotropic rectangle, nu = 0.

Without Poisson's ratio nothing strains across the beam, so that bending and shear are polynomials
and torsion is a series (Timoshenko and Goodier, Theory of elasticity, art. 109).
"""

import dataclasses

import numpy as np

from plymotion.solver.package.common.materials import bond, isotropic
from plymotion.solver.package.common.recovery_schema import Ply, SectionRecovery
from plymotion.solver.package.section.section_schema import SectionFile, SectionMeshData

E_MODULUS, DENSITY = 70e9, 2700.0
G_MODULUS = E_MODULUS / 2.0
TERMS = np.arange(1, 60, 2)  # of the series of torsion

# Nodes of the cells in VTK's order, on the square (-1, 1)^2 that two triangles divide.
QUAD9 = ((-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0), (0, 0))
TRIANGLES6 = (
    ((-1, -1), (1, -1), (1, 1), (0, -1), (1, 0), (0, 0)),
    ((-1, -1), (1, 1), (-1, 1), (0, 0), (0, 1), (-1, 0)),
)
CELLS = {"quad9": (28, (QUAD9,)), "triangle6": (22, TRIANGLES6)}


def rectangle(
    name: str = "bar",
    width: float = 0.06,
    height: float = 0.02,
    cells: tuple[int, int] = (6, 4),
    cell: str = "quad9",
    estimate: bool = True,
) -> SectionFile:
    """Two walls, one above the other, of two plies each; all of one material.

    The upper wall's layer direction is x2, the lower one's -x2; angles are 0, 30 (upper) and
    0, -45 deg (lower), outermost first. `cells` counts squares along width and height, the
    second an even number.
    """
    half_2, half_3 = width / 2, height / 2
    grid_2, grid_3 = 2 * cells[0] + 1, 2 * cells[1] + 1
    x2, x3 = np.linspace(-half_2, half_2, grid_2), np.linspace(-half_3, half_3, grid_3)
    nodes = np.array([(y, z) for z in x3 for y in x2])
    kind, shapes = CELLS[cell]
    connectivity, rows = [], []
    for row in range(cells[1]):
        for column in range(cells[0]):
            middle = (2 * column + 1, 2 * row + 1)
            for shape in shapes:
                connectivity.append([grid_2 * (middle[1] + j) + middle[0] + i for i, j in shape])
                rows.append(row)
    upper = np.array(rows) >= cells[1] / 2
    depth = np.where(upper, cells[1] - 1 - np.array(rows), np.array(rows))
    ply = np.where(upper, 0, 2) + (depth >= cells[1] / 4)
    direction = np.where(upper, 1.0, -1.0)[:, None] * [1.0, 0.0]
    plies = (
        Ply("upper", 0, "alloy", 0.0),
        Ply("upper", 1, "alloy", 30.0),
        Ply("lower", 0, "alloy", 0.0),
        Ply("lower", 1, "alloy", -45.0),
    )
    angle = np.radians([p.angle_deg for p in plies])[ply]
    fibre = np.column_stack([np.cos(angle), np.sin(angle)[:, None] * direction])

    points, weights, in_cell = _quadrature(nodes, connectivity, len(shapes))
    A_BM = _ply_axes(fibre, direction)[in_cell]
    stress, K_diagonal = _unit_stress(points, weights, half_2, half_3)
    C = isotropic(E_MODULUS, 0.0, DENSITY).stiffness_M
    to_ply = np.swapaxes(bond(np.swapaxes(A_BM, 1, 2)), 1, 2)  # engineering strains, B to M
    strain_M = np.linalg.inv(to_ply) @ np.linalg.solve(C, stress)
    area = width * height
    inertia = DENSITY * area * np.array([height**2 / 12, width**2 / 12])
    K = np.diag(K_diagonal)
    return SectionFile(
        name=name,
        K=K,
        M=np.diag([DENSITY * area] * 3 + [inertia.sum(), *inertia]),
        initial_curvature=np.array([0.2, 0.0, 0.1]),
        end_compliance=np.diag([2e-10, 1e-9, 1e-9, 1e-6, 8e-7, 3e-7]),
        error_estimate=1e-4 * np.sqrt(np.outer(K_diagonal, K_diagonal)) if estimate else None,
        shear_centre=np.zeros(2),
        tension_centre=np.zeros(2),
        mass_centre=np.zeros(2),
        mesh=SectionMeshData(
            nodes=nodes,
            connectivity=np.array(connectivity).ravel(),
            offsets=np.arange(len(connectivity) + 1) * len(connectivity[0]),
            cell_types=np.full(len(connectivity), kind),
            region=upper.astype(np.int64),
            regions=("lower", "upper"),
            ply=ply,
            layer_direction=direction,
            fibre=fibre,
        ),
        warping=_unit_warping(nodes, half_2, half_3, K_diagonal),
        recovery=SectionRecovery(
            points=points,
            weights=weights,
            cell=in_cell,
            ply=ply[in_cell],
            A_BM=A_BM,
            strain_M=strain_M,
            C_M=np.broadcast_to(C, (len(plies), 6, 6)).copy(),
            plies=plies,
            materials={
                "alloy": {"kind": "isotropic", "E": E_MODULUS, "nu": 0.0, "rho": DENSITY},
                "unused Ω": {
                    "kind": "isotropic",
                    "E": 1 / 3,
                    "nu": 0.1,
                    "strength": {"yield_stress": 1e8},
                },
            },
        ),
        warnings=({"code": "sharp-corner", "message": "four corners: µ-stresses grow"},),
        provenance={"spec": {"name": name}, "dofs": 3 * len(nodes), "seconds": {"total": 0.25}},
    )


def _quadrature(nodes, connectivity, n_shape):
    """Gauss points of squares 3 x 3, or of triangles by collapsing the square."""
    g = np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0])
    xi, eta = (axis.ravel() for axis in np.meshgrid(g, g))
    weight = np.outer([5, 8, 5], [5, 8, 5]).ravel() / 18.0**2
    corners = nodes[np.array(connectivity)[:, : 4 if n_shape == 1 else 3]]
    s, t = (1 + xi) / 2, (1 + eta) / 2
    if n_shape == 1:
        shape = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t])
    else:
        shape, weight = np.stack([1 - s, s * (1 - t), s * t]), 2.0 * s * weight
    points = np.einsum("kq,cka->cqa", shape, corners)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / (1 if n_shape == 1 else 2)
    weights = area[:, None] * weight
    return points.reshape(-1, 2), weights.ravel(), np.repeat(np.arange(len(connectivity)), 9)


def _ply_axes(fibre, direction):
    """Columns: fibre, in-plane normal to it, outward normal y3 = x1 x y2."""
    normal = np.column_stack([np.zeros(len(direction)), -direction[:, 1], direction[:, 0]])
    return np.stack([fibre, np.cross(normal, fibre), normal], axis=2)


def _series(x2, x3, half_2, half_3):
    """Warping of unit twist and its derivatives along x2 and x3."""
    k = np.pi * TERMS / (2 * half_2)
    sign = (-1.0) ** ((TERMS - 1) // 2)
    y, z = np.multiply.outer(x2, k), np.multiply.outer(x3, k)
    # sinh and cosh over cosh(k half_3), free of overflow
    up, down = np.exp(np.abs(z) - k * half_3), np.exp(-np.abs(z) - k * half_3)
    below = 1 + np.exp(-2 * k * half_3)
    sinh, cosh = np.sign(z) * (up - down) / below, (up + down) / below
    c = 32 * half_2**2 / np.pi**3 * sign / TERMS**3
    return (
        x2 * x3 - np.sin(y) * sinh @ c,
        x3 - np.cos(y) * sinh @ (c * k),
        x2 - np.sin(y) * cosh @ (c * k),
    )


def _unit_stress(points, weights, half_2, half_3):
    """Stresses (p, 6, 6) per unit resultant, and the diagonal of K.

    What the quadrature misses of the series is taken out, so that each state integrates to its
    resultant exactly.
    """
    x2, x3 = points.T
    area = 4 * half_2 * half_3
    I2, I3 = area * half_3**2 / 3, area * half_2**2 / 3
    ratio = half_3 / half_2
    rest = 64 / np.pi**5 / ratio * np.sum(np.tanh(np.pi * TERMS * ratio / 2) / TERMS**5)
    J = 16 * half_2**3 * half_3 * (1 / 3 - rest)
    _, along_2, along_3 = _series(x2, x3, half_2, half_3)
    stress = np.zeros((len(x2), 6, 6))
    stress[:, 0, 0] = 1 / area
    stress[:, 5, 1] = 1.5 / area * (1 - (x2 / half_2) ** 2)
    stress[:, 4, 2] = 1.5 / area * (1 - (x3 / half_3) ** 2)
    stress[:, 5, 3], stress[:, 4, 3] = (along_2 - x3) / J, (along_3 + x2) / J
    stress[:, 0, 4], stress[:, 0, 5] = x3 / I2, -x2 / I3
    s11, s13, s12 = stress[:, 0], stress[:, 4], stress[:, 5]
    twist, bend_2, bend_3 = x2 * s13.T - x3 * s12.T, x3 * s11.T, -x2 * s11.T
    back = np.stack([s11.T, s12.T, s13.T, twist, bend_2, bend_3]) @ weights
    GA = G_MODULUS * area
    EI2, EI3 = E_MODULUS * I2, E_MODULUS * I3
    K_diagonal = np.array([E_MODULUS * area, GA / 1.2, GA / 1.2, G_MODULUS * J, EI2, EI3])
    return stress @ np.linalg.inv(back), K_diagonal


def _unit_warping(nodes, half_2, half_3, K_diagonal):
    x2, x3 = nodes.T
    out = np.zeros((6, len(nodes), 3))
    GA = 1.2 * K_diagonal[1]
    for row, x, half in ((1, x2, half_2), (2, x3, half_3)):
        out[row, :, 0] = (0.3 * x - 0.5 * x**3 / half**2) / GA
    out[3, :, 0] = _series(x2, x3, half_2, half_3)[0] / K_diagonal[3]
    return out


def with_recovery(**changes: object) -> SectionFile:
    """The rectangle with other fields of its recovery data."""
    section = rectangle()
    return dataclasses.replace(section, recovery=dataclasses.replace(section.recovery, **changes))
