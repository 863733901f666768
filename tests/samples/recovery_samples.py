"""The recovery of a laminated rectangle by plain beam theory, in closed form.

s11 = F1/A + M2 x3/I2 - M3 x2/I3; shear forces spread evenly; twist by a shear stress growing from
the centre. At Gauss points these integrate back to the six resultants exactly. That is no
elasticity (the stress does not know the plies), but every number can be checked by hand.
"""

from typing import Any

import numpy as np

from plymotion.preprocess.beam.line import BeamLine
from plymotion.preprocess.beam.mode_fields import shape_resultants
from plymotion.solver.package.body.package_schema import BodyRecovery
from plymotion.solver.package.common.materials import PlyStrength, bond, material_from_dict
from plymotion.solver.package.common.recovery_schema import Ply, SectionRecovery
from plymotion.solver.strength import CRITERIA

PLY = {
    "kind": "orthotropic",
    "E1": 142e9,
    "E2": 9.8e9,
    "E3": 9.8e9,
    "G12": 6e9,
    "G13": 6e9,
    "G23": 4.8e9,
    "nu12": 0.3,
    "nu13": 0.3,
    "nu23": 0.34,
    "rho": 1600.0,
}
PLY_STRENGTH = {"Xt": 1500e6, "Xc": 1200e6, "Yt": 50e6, "Yc": 200e6, "S12": 70e6}
STEEL = {"kind": "isotropic", "E": 210e9, "nu": 0.3, "rho": 7850.0}
STEEL_STRENGTH = {"yield_stress": 355e6}
# All that judge a ply: reports have each of them.
PLY_CRITERIA = {name for name, c in CRITERIA.items() if c.strength is PlyStrength}


def plies_of(*stack: tuple[str, float]) -> tuple[Ply, ...]:
    """Plies of the region "plate" from (material, angle_deg), the outermost first."""
    return tuple(Ply("plate", i, name, angle) for i, (name, angle) in enumerate(stack))


def unit_stress_B(x2: np.ndarray, x3: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Stress in section axes per unit resultant, (p, 6, 6)."""
    A, I2, I3 = w.sum(), w @ x3**2, w @ x2**2
    stress = np.zeros((len(w), 6, 6))
    stress[:, 0, 0], stress[:, 0, 4], stress[:, 0, 5] = 1 / A, x3 / I2, -x2 / I3
    stress[:, 5, 1], stress[:, 5, 3] = 1 / A, -x3 / (I2 + I3)
    stress[:, 4, 2], stress[:, 4, 3] = 1 / A, x2 / (I2 + I3)
    return stress


def rectangle_recovery(
    width: float,
    height: float,
    plies: tuple[Ply, ...],
    materials: dict[str, dict[str, Any]],
    columns: int = 1,
) -> SectionRecovery:
    """Plies of equal thickness stacked along x3, two by two Gauss points in each of its cells."""
    gauss, n = np.array([-1.0, 1.0]) / np.sqrt(3.0), len(plies)
    middles_2 = width * ((np.arange(columns) + 0.5) / columns - 0.5)
    middles_3 = height * (0.5 - (np.arange(n) + 0.5) / n)
    x2 = (middles_2[:, None] + 0.5 * width / columns * gauss).ravel()
    x3 = (middles_3[:, None] + 0.5 * height / n * gauss).ravel()
    points = np.array([(a, b) for b in x3 for a in x2])
    ply = np.repeat(np.arange(n), 4 * columns)
    weights = np.full(len(points), width * height / len(points))
    A_BM = np.zeros((len(points), 3, 3))
    angle = np.radians([p.angle_deg for p in plies])[ply]
    c, s = np.cos(angle), np.sin(angle)
    A_BM[:, 0, 0], A_BM[:, 0, 1] = c, -s
    A_BM[:, 1, 0], A_BM[:, 1, 1] = s, c
    A_BM[:, 2, 2] = 1.0
    C_M = np.array(
        [
            material_from_dict(
                {k: v for k, v in materials[p.material].items() if k != "strength"}, p.material
            ).stiffness_M
            for p in plies
        ]
    )
    stress_M = np.linalg.solve(bond(A_BM), unit_stress_B(*points.T, weights))
    return SectionRecovery(
        points=points,
        weights=weights,
        cell=np.arange(len(points)) // 4,
        ply=ply,
        A_BM=A_BM,
        strain_M=np.linalg.solve(C_M[ply], stress_M),
        C_M=C_M,
        plies=plies,
        materials=materials,
    )


def mode_resultants(
    line: BeamLine, columns_B: Any, values: Any, mass_form: str, breaks: tuple[int, ...] = ()
) -> BodyRecovery:
    """Resultants of eigenmodes (6 n, m) of `values` (m,) [rad2/s2]."""
    return shape_resultants(line, columns_B, columns_B * values, mass_form, breaks)
