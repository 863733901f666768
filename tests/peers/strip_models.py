"""The 30 deg strip as a three-dimensional solid: quadratic hexahedra, real SLEPc."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import ufl
from mpi4py import MPI
from peers.dolfinx_forms import assembled
from samples.beam_samples import straight_line
from samples.section_specs import rectangle_spec

from plymotion.preprocess import fenicsx
from plymotion.preprocess.beam.sections import section_stiffness
from plymotion.preprocess.fenicsx.libraries import dolfinx  # after MPI, which its wheel needs
from plymotion.preprocess.fenicsx.spaces import dof_coordinates, vector_space
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.package.common.materials import material_from_dict, ply_rotation, rotated

FILE = Path(__file__).resolve().parents[1] / "reference/beams/strip_30_cantilever.toml"
STRIP = tomllib.loads(FILE.read_text(encoding="utf-8"))
LENGTH, WIDTH, HEIGHT = (STRIP["geometry"][k] for k in ("length", "width", "height"))
N_RIGID = 6
SHIFT = -1e5  # [1/s2] a body free to move needs a negative target


def free_hz(K: Any, M: Any, n: int) -> Any:
    """Lowest n elastic frequencies of a body that nothing holds [Hz]."""
    values, _ = fenicsx.eigenpairs(K, M, N_RIGID + n, target=SHIFT)
    assert np.abs(values[:N_RIGID]).max() < 1e-6 * values[N_RIGID]
    return np.sqrt(values[N_RIGID:]) / (2 * np.pi)


def clamped_hz(K: Any, M: Any, free: Any, n: int) -> Any:
    """Lowest n frequencies with all unknowns but `free` held [Hz]."""
    values, _ = fenicsx.eigenpairs(K[free][:, free], M[free][:, free], n)
    return np.sqrt(values) / (2 * np.pi)


def solid() -> tuple[Any, Any, Any]:
    """Stiffness, mass, and the unknowns away from the face x = 0."""
    material = material_from_dict(STRIP["material"], "strip")
    C = rotated(material.stiffness_M, ply_rotation(STRIP["layup"]["ply_angle_deg"]))
    mesh = dolfinx.mesh.create_box(
        MPI.COMM_SELF,
        [[0, -WIDTH / 2, -HEIGHT / 2], [LENGTH, WIDTH / 2, HEIGHT / 2]],
        [40, 6, 2],
        dolfinx.mesh.CellType.hexahedron,
    )
    space = vector_space(mesh, 2, 3)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)

    def strain(w):
        e = ufl.sym(ufl.grad(w))
        shear = [2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]]
        return ufl.as_vector([e[0, 0], e[1, 1], e[2, 2], *shear])

    dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 5})
    stress = ufl.as_matrix(C.tolist()) * strain(u)
    forms = [ufl.inner(stress, strain(v)) * dx, material.rho * ufl.inner(u, v) * dx]
    K, M = assembled(forms)
    return K, M, np.repeat(dof_coordinates(space)[:, 0] > 1e-9 * LENGTH, 3)


def beam(theory: str) -> tuple[Any, Any, Any]:
    """The same of the beam."""
    spec = rectangle_spec(WIDTH, HEIGHT, STRIP["material"], **STRIP["layup"])
    section = analyse(spec, estimate=False)
    K = section_stiffness(section.K, theory)
    line = straight_line(np.linspace(0.0, LENGTH, 65), K, section.M, np.eye(3))
    free = np.arange(6 * line.n_node) >= 6
    return line.stiffness(), line.mass_matrix("consistent"), free
