"""Laminates of plies: stiffness, transverse shear, mass, ply stresses and a report.

Laminate axes `_E`: e3 the normal of the shell, plies listed BOTTOM to TOP along it, ply angles
from e1 towards e2, right-handed about e3. The reference surface is the mesh: z = 0.
Strains are (exx, eyy, gxy), curvatures (kxx, kyy, kxy), shear (gxz, gyz), with
u = u0 + z beta; resultants N [N/m], M [N], T [N/m] in the same order.
"""

from .report import LaminateReport, report
from .shear import ShearCorrection
from .spec import LaminateSpec, laminate_from_dict
from .stack import Lamina, Laminate, LaminateError, computed
from .stiffness import LaminateStiffness, laminate_stiffness
from .stress import LEVELS, strain_stress, strain_stress_at, stress_operators

__all__ = [
    "LEVELS",
    "Lamina",
    "Laminate",
    "LaminateError",
    "LaminateReport",
    "LaminateSpec",
    "LaminateStiffness",
    "ShearCorrection",
    "computed",
    "laminate_from_dict",
    "laminate_stiffness",
    "report",
    "strain_stress",
    "strain_stress_at",
    "stress_operators",
]
