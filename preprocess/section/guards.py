"""Warnings about a section: locking of linear fields, ill-conditioned equations."""

from ..materials import Orthotropic
from .errors import SectionError
from .layers import Layup
from .space import SectionSpace
from .timoshenko import SectionStiffness
from .warping import SOLVABILITY

INCOMPRESSIBLE = 9.0  # bulk over shear modulus, that of Poisson's ratio 0.446


def bulk_over_shear(material: Orthotropic) -> float:
    """Bulk modulus divided by the smallest shear modulus."""
    bulk = 1.0 / float(material.compliance_M[:3, :3].sum())
    return bulk / min(material.G12, material.G13, material.G23)


def check_degree(space: SectionSpace, lay: Layup, where: str) -> list[dict[str, str]]:
    """Warnings about a linear warping field.

    Raises SectionError if a linear field locks: EI is 18 % too large at Poisson's ratio 0.49.
    """
    if space.degree > 1:
        return []
    for ply, material in zip(lay.plies, lay.materials, strict=True):
        ratio = bulk_over_shear(material)
        if ratio > INCOMPRESSIBLE:
            raise SectionError(
                f"{where}.mesh.degree = 1: expected 2 for {ply.material}, which is nearly "
                f"incompressible (bulk modulus {ratio:.0f} times the shear modulus): linear "
                "elements lock"
            )
    return [
        {
            "code": "degree-1-locks",
            "message": "linear elements are a few per cent too stiff in bending and torsion; "
            "use mesh.degree = 2",
        }
    ]


def solvability_warnings(result: SectionStiffness) -> list[dict[str, str]]:
    """Warning if the loads of the warping do work on rigid motions beyond round-off."""
    if result.solvability <= SOLVABILITY:
        return []
    return [
        {
            "code": "few-digits",
            "message": f"the loads of the warping do work of {result.solvability:.1e} (relative) "
            f"on rigid motions, usually at most {SOLVABILITY:g}: round-off, as in a very thin open "
            "section; its shear stiffness has fewer correct digits",
        }
    ]
