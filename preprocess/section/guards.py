"""Warnings about a section: locking of linear fields, ill-conditioned equations."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...solver.errors import few
from ...solver.math.arrays import Array
from ...solver.package.common.anisotropic import Anisotropic
from ..materials import Orthotropic
from .cells import CellMesh
from .errors import SectionError
from .estimate import scaled
from .helical import CentralSolutions
from .layers import Layup
from .mesh import OF_MESH
from .space import SectionSpace
from .timoshenko import SectionStiffness
from .warping import SOLVABILITY

# Bulk over shear modulus above which linear elements lock (Poisson's ratio 0.446), and above which
# elements of degree 2 lose digits (0.4999).
LOCKING = 9.0
INCOMPRESSIBLE = 5000.0
REVERSAL = 1e-3  # relative change of K by the sense of layer directions that is worth a warning
COARSE = 0.05  # estimated error of K, scaled, that is worth a warning
ALLOWED = ("nearly-incompressible", "ill-conditioned")  # what `allow` may list


def bulk_over_shear(material: Orthotropic | Anisotropic) -> float:
    """Bulk modulus over the least stiffness against a change of shape without shear, halved.

    In an isotropic material, this is the bulk over the shear modulus. Small shear moduli of an
    orthotropic material, as of honeycomb, do not make it incompressible.
    """
    normal = material.compliance_M[:3, :3]
    return 2.0 * float(np.linalg.eigvalsh(normal)[-1]) / float(normal.sum())


def check_degree(
    space: SectionSpace, lay: Layup, where: str, allow: Sequence[str] = (), *, given: bool = False
) -> list[dict[str, str]]:
    """Warnings about the degree of the warping field.

    Raises SectionError if a linear field locks: EI is 18 % too large at Poisson's ratio 0.49. It is
    only a warning if the functions are those of `given` cells of another code.
    """
    linear = space.degree == 1
    warnings = []
    if linear:
        warnings.append(
            {
                "code": "degree-1-locks",
                "message": "linear elements are a few per cent too stiff in bending and torsion; "
                "use mesh.degree = 2",
            }
        )
    for name, material in {
        p.material: m for p, m in zip(lay.plies, lay.materials, strict=True)
    }.items():
        ratio = bulk_over_shear(material)
        if ratio <= (LOCKING if linear else INCOMPRESSIBLE):
            continue
        what = f"{name} is nearly incompressible (bulk modulus {ratio:.3g} times the shear modulus)"
        if linear and not given and ALLOWED[0] not in allow:
            raise SectionError(
                f"{where}.mesh.degree = 1: expected 2, because {what}: linear elements lock; "
                f'allow = ["{ALLOWED[0]}"] computes it anyway'
            )
        effect = "linear elements lock" if linear else "stresses lose digits"
        warnings.append({"code": "nearly-incompressible", "message": f"{what}: {effect}"})
    return warnings


def not_computed_warnings(models: Sequence[str]) -> list[dict[str, str]]:
    """Warning about models that a file of another code asks for."""
    if not models:
        return []
    return [
        {
            "code": "model-not-computed",
            "message": f"the file asks for {', '.join(models)}: only the 6x6 stiffness and mass "
            "are computed",
        }
    ]


def density_warnings(lay: Layup) -> list[dict[str, str]]:
    """Warning about materials without density, which files of other codes may have."""
    pairs = zip(lay.plies, lay.materials, strict=True)
    names = sorted({ply.material for ply, material in pairs if material.rho == 0.0})
    if not names:
        return []
    return [
        {
            "code": "no-density",
            "message": f"{few(names)}: the density is 0, so the mass does not contain all of the "
            "section",
        }
    ]


def solvability_warnings(result: SectionStiffness | CentralSolutions) -> list[dict[str, str]]:
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


def condition_warnings(result: SectionStiffness | CentralSolutions) -> list[dict[str, str]]:
    """Warning about equations that were solved although their condition would be refused."""
    if not result.doubtful:
        return []
    return [
        {
            "code": "ill-conditioned",
            "message": "the equations of the warping are nearly singular; the estimate contains "
            "their round-off as far as a second solution shows it",
        }
    ]


def coarse_warnings(
    error: Array | None, K: Array, spec_mesh: Mapping[str, Any]
) -> list[dict[str, str]]:
    """Warning if the estimated error (6, 6) of the stiffness is large; what helps depends on the
    mesh."""
    if error is None:
        return []
    share = scaled(error, K)
    if share.max() <= COARSE:
        return []
    i, j = np.unravel_index(int(np.argmax(share)), share.shape)
    higher = "" if spec_mesh.get("degree") == OF_MESH else " or a higher mesh.degree"
    return [
        {
            "code": "coarse-mesh",
            "message": f"the estimated error of K{i + 1}{j + 1} is {share[i, j]:.2g} of "
            f"sqrt(K_ii K_jj): use --accuracy, {finer_mesh(spec_mesh)}{higher}",
        }
    ]


def finer_mesh(spec_mesh: Mapping[str, Any]) -> str:
    """What makes the mesh of a section finer, in words."""
    return "a larger density" if "script" in spec_mesh else "a finer mesh in the file"


def reversal_warnings(
    lay: Layup, mesh: CellMesh, change: float, limit: float
) -> list[dict[str, str]]:
    """Warning about Cartesian layer directions that change their sense inside cells."""
    if change <= limit:
        return []
    cells = np.flatnonzero(lay.reversing)
    place = mesh.middles[cells[0]]
    return [
        {
            "code": "direction-reverses",
            "message": f'with convention = "cartesian" the layer direction reverses inside '
            f"{len(cells)} cells, one at ({place[0]:.4g}, {place[1]:.4g}): where exactly changes K "
            f"by {change:.1e}; put a mesh line there, or use contour angles",
        }
    ]
