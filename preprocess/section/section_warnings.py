"""Warnings about a section: locking, ill-conditioned equations, change along the beam."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...solver.errors import coded, few
from ...solver.math.arrays import Array
from ...solver.package.common.materials import Anisotropic, Orthotropic
from .helical import CentralSolutions
from .recovery import Result
from .section_specification import ALLOWED, OF_MESH, SectionError, degree_of
from .space.layers import Layup
from .space.section_cells import CellMesh
from .space.space import SectionSpace
from .timoshenko import scaled
from .warping import SOLVABILITY

STRONG = 0.5  # least ratio of lengths of fibres at which the result is trusted without a warning
TAPER = 1e-3  # relative error of K by the neglect of taper that is worth a warning


def result_warnings(result: Result) -> list[dict[str, str]]:
    """Warnings about loads on rigid motions, the condition of the equations, and curvature."""
    warnings = []
    if result.solvability > SOLVABILITY:
        warnings += coded(
            "few-digits",
            f"the loads of the warping do work of {result.solvability:.1e} (relative) "
            f"on rigid motions, usually at most {SOLVABILITY:g}: round-off, as in a very thin open "
            "section; its shear stiffness has fewer correct digits",
        )
    if result.doubtful:
        warnings += coded(
            "ill-conditioned",
            "the equations of the warping are nearly singular; the estimate contains "
            "their round-off as far as a second solution shows it",
        )
    if isinstance(result, CentralSolutions) and result.strains.least_g < STRONG:
        size = float(np.ptp(np.stack([result.space.x2, result.space.x3]), axis=1).max())
        turn = float(np.linalg.norm(result.strains.k)) * size
        warnings += coded(
            "strongly-curved",
            f"the innermost fibre has {result.strains.least_g:.2g} of the length of the "
            f"reference line (|k| h = {turn:.2g}): end effects reach far, so that a beam is a poor "
            "model",
        )
    return warnings


def taper_error(
    spec: Mapping[str, Any], points: Array, K: Array
) -> tuple[Array | None, list[dict[str, str]]]:
    """Expected error of K (6, 6) by the neglect of taper, and a warning about it.

    The exact solutions of a wedge of half angle a under axial force and moment (Michell) differ
    from those of a prismatic beam by 2/3 a^2 and 2/5 a^2. The greater is applied to every entry;
    a = taper h / 2 with the largest dimension h of the section.

    Parameters
    ----------
    spec : description of the section; `taper` is the relative change of its size [1/m]
    points : (n, 2) nodes of its mesh [m]
    K : (6, 6) stiffness
    """
    taper = float(spec.get("taper", 0.0))
    if taper == 0.0:
        return None, []
    angle = 0.5 * abs(taper) * float(np.ptp(points, axis=0).max())
    error = 2.0 / 3.0 * angle**2
    size = np.sqrt(np.abs(np.diag(K)))
    expected = error * np.outer(size, size)
    if error <= TAPER:
        return expected, []
    return expected, coded(
        "taper-neglected",
        f"the faces are inclined by {np.degrees(angle):.2g} deg to the axis: the "
        f"stiffness of a prismatic beam is wrong by about {error:.1e}, and shear stresses lack "
        f"{angle:.2g} of the axial ones at the faces",
    )


# Bulk over shear modulus above which linear elements lock (Poisson's ratio 0.446), and above which
# elements of degree 2 lose digits (0.4999).
LOCKING = 9.0
INCOMPRESSIBLE = 5000.0
REVERSAL = 1e-3  # relative change of K by the sense of layer directions that is worth a warning
COARSE = 0.05  # estimated error of K, scaled, that is worth a warning


def bulk_over_shear(material: Orthotropic | Anisotropic) -> float:
    """Bulk modulus over the least stiffness against a change of shape without shear, halved.

    In an isotropic material, this is the bulk over the shear modulus. Small shear moduli of an
    orthotropic material, as of honeycomb, do not make it incompressible.
    """
    normal = material.compliance_M[:3, :3]
    return 2.0 * float(np.linalg.eigvalsh(normal)[-1]) / float(normal.sum())


def described_warnings(
    spec: Mapping[str, Any], space: SectionSpace, lay: Layup, where: str
) -> list[dict[str, str]]:
    """Warnings about what a specification asks for, its materials, and the degree of the warping.

    A linear field locks: EI is 18 % too large at Poisson's ratio 0.49. It is only a warning if the
    functions are those of given cells of another code.

    Parameters
    ----------
    spec : description of the section
    space : of the warping
    lay : its plies with their materials
    where : file or section, for messages

    Raises
    ------
    SectionError
        A linear field that locks and is not allowed.
    """
    linear, given = space.degree == 1, degree_of(spec) is None
    materials = {p.material: m for p, m in zip(lay.plies, lay.materials, strict=True)}
    warnings = []
    if linear:
        warnings += coded(
            "degree-1-locks",
            "linear elements are a few per cent too stiff in bending and torsion; "
            "use mesh.degree = 2",
        )
    for name, material in materials.items():
        ratio = bulk_over_shear(material)
        if ratio <= (LOCKING if linear else INCOMPRESSIBLE):
            continue
        what = f"{name} is nearly incompressible (bulk modulus {ratio:.3g} times the shear modulus)"
        if linear and not given and ALLOWED[0] not in spec.get("allow", ()):
            raise SectionError(
                f"{where}.mesh.degree = 1: expected 2, because {what}: linear elements lock; "
                f'allow = ["{ALLOWED[0]}"] computes it anyway'
            )
        effect = "linear elements lock" if linear else "stresses lose digits"
        warnings += coded("nearly-incompressible", f"{what}: {effect}")
    if models := spec.get("not_computed"):
        warnings += coded(
            "model-not-computed",
            f"the file asks for {', '.join(models)}: only the 6x6 stiffness and mass are computed",
        )
    if names := sorted(name for name, material in materials.items() if material.rho == 0.0):
        warnings += coded(
            "no-density",
            f"{few(names)}: the density is 0, so the mass does not contain all of the section",
        )
    return warnings


def coarse_warnings(
    error: Array | None, K: Array, spec_mesh: Mapping[str, Any]
) -> list[dict[str, str]]:
    """Warning if the estimated error of the stiffness is large; what helps depends on the mesh.

    Parameters
    ----------
    error : (6, 6) expected |error| of K; None: not estimated
    K : (6, 6) stiffness
    spec_mesh : table `mesh` of the description
    """
    if error is None:
        return []
    share = scaled(error, K)
    if share.max() <= COARSE:
        return []
    i, j = np.unravel_index(int(np.argmax(share)), share.shape)
    # an error as large as K itself: a coarse field is too stiff, by any factor
    lost = ", so that no digit is right and K may be too large by any factor"
    lost = lost if share.max() >= 1.0 else ""
    higher = "" if spec_mesh.get("degree") == OF_MESH else " or a higher mesh.degree"
    return coded(
        "coarse-mesh",
        f"the estimated error of K{i + 1}{j + 1} is {share[i, j]:.2g} of "
        f"sqrt(K_ii K_jj){lost}: use --accuracy, {finer_mesh(spec_mesh)}{higher}",
    )


def finer_mesh(spec_mesh: Mapping[str, Any]) -> str:
    """What makes the mesh of a section finer, in words."""
    return "a larger density" if "script" in spec_mesh else "a finer mesh in the file"


def reversal_warnings(
    lay: Layup, mesh: CellMesh, change: float, limit: float
) -> list[dict[str, str]]:
    """Warning about Cartesian layer directions that change their sense inside cells.

    Parameters
    ----------
    lay : plies; it knows the cells in which the direction reverses
    mesh : the cells
    change : of K by the other sense in these cells, relative
    limit : change that needs no warning
    """
    if change <= limit:
        return []
    cells = np.flatnonzero(lay.reversing)
    place = mesh.middles[cells[0]]
    return coded(
        "direction-reverses",
        f'with convention = "cartesian" the layer direction reverses inside '
        f"{len(cells)} cells, one at ({place[0]:.4g}, {place[1]:.4g}): where exactly changes K "
        f"by {change:.1e}; put a mesh line there, or use contour angles",
    )
