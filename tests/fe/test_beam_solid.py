"""The free 30 deg strip as a beam and as a three-dimensional solid: two routes to its frequencies.

Free ends on both sides, because a clamped face of the solid also blocks the warping of the
section, which is no error of the beam. Quadratic hexahedra, real SLEPc.
"""

import tomllib
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("plymotion.preprocess.fenicsx")

import dolfinx
import ufl
from mpi4py import MPI

from plymotion.preprocess import fenicsx
from plymotion.preprocess.beam.line import BeamLine
from plymotion.preprocess.beam.theory import section_stiffness
from plymotion.preprocess.materials import material_from_dict, ply_rotation, rotated
from plymotion.preprocess.section import analyse

FILE = Path(__file__).resolve().parent.parent / "reference/beams/strip_30_cantilever.toml"
STRIP = tomllib.loads(FILE.read_text(encoding="utf-8"))
LENGTH, WIDTH, HEIGHT = (STRIP["geometry"][k] for k in ("length", "width", "height"))
N_RIGID = 6
SHIFT = -1e5  # [1/s2] a body free to move needs a negative target


def elastic_hz(K, M, n):
    values, _ = fenicsx.eigenpairs(K, M, N_RIGID + n, target=SHIFT)
    assert np.abs(values[:N_RIGID]).max() < 1e-6 * values[N_RIGID]
    return np.sqrt(values[N_RIGID:]) / (2 * np.pi)


@pytest.fixture(scope="module")
def solid_hz():
    material = material_from_dict(STRIP["material"], "strip")
    C = rotated(material.stiffness_M, ply_rotation(STRIP["layup"]["ply_angle_deg"]))
    mesh = dolfinx.mesh.create_box(
        MPI.COMM_SELF,
        [[0, -WIDTH / 2, -HEIGHT / 2], [LENGTH, WIDTH / 2, HEIGHT / 2]],
        [40, 6, 2],
        dolfinx.mesh.CellType.hexahedron,
    )
    space = fenicsx.vector_space(mesh, 2, 3)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)

    def strain(w):
        e = ufl.sym(ufl.grad(w))
        shear = [2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]]
        return ufl.as_vector([e[0, 0], e[1, 1], e[2, 2], *shear])

    dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 5})
    stress = ufl.as_matrix(C.tolist()) * strain(u)
    forms = [ufl.inner(stress, strain(v)) * dx, material.rho * ufl.inner(u, v) * dx]
    K, M = (fenicsx.assemble(form) for form in fenicsx.compile_forms(forms))
    return elastic_hz(K, M, 2)


def beam_hz(theory):
    spec = {
        "shape": "rectangle",
        "width": WIDTH,
        "height": HEIGHT,
        "material": STRIP["material"],
        **STRIP["layup"],
    }
    section = analyse(spec)
    K = section_stiffness(section.K, theory)
    line = BeamLine(np.linspace(0.0, LENGTH, 65), K, section.M, np.eye(3))
    return elastic_hz(line.stiffness(), line.mass_matrix("consistent"), 2)


def test_classical_beam_against_solid(solid_hz):
    """Flatwise bending 1 and 2 of the free strip."""
    assert beam_hz("classical") == pytest.approx(solid_hz, rel=5e-3)


def test_timoshenko_beam_is_softer_than_the_solid(solid_hz):
    """The documented limit of a static shear stiffness in vibration: -0.4 % and -1.6 %."""
    ratio = beam_hz("timoshenko") / solid_hz
    assert np.all(ratio < 1.0)
    assert ratio == pytest.approx([1.0, 1.0], abs=0.02)
    assert ratio[1] < beam_hz("classical")[1] / solid_hz[1]
