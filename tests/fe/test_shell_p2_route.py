"""The elements against another formulation on the same triangles: quadratic displacement, CR
rotations, as a UFL form (tests/shell_ufl.py). Both meet the references; both meet each other."""

import numpy as np
import pytest
import ufl
from shell_benchmarks import expected, numbers, tolerances
from shell_cantilevers import box
from shell_meshes import shell_mesh
from shell_model import Model
from shell_obstacle_course import scordelis, twisted_beam
from shell_squares import cross_ply
from shell_ufl import UflShell

from plymotion.preprocess.laminate import laminate_from_dict, laminate_stiffness
from plymotion.preprocess.shell.regions import read_materials

# The numbers of the elements are those of both DOLFINx: test_shell_benchmarks.py.
pytestmark = pytest.mark.one_end


def ufl_shell(model: Model) -> UflShell:
    """The second formulation of a problem: its mesh, lay-ups and axis."""
    plain = shell_mesh(model.script, **model.mesh)
    materials = read_materials(model.materials, "materials")
    stiffness = {}
    for region in plain.regions:
        name = model.regions.get(region) or model.regions["all"]
        made = laminate_from_dict(model.laminates[name], materials, name)
        stiffness[region] = laminate_stiffness(made.laminate, made.shear)
    return UflShell(plain, stiffness, dict.fromkeys(plain.regions, model.axis))


def test_scordelis_lo() -> None:
    model, _ = scordelis(16)
    shell = ufl_shell(model)
    shell.fix("ux ry rz", lambda p: p[:, 0] < 1e-9)
    shell.fix("uy uz", lambda p: p[:, 0] > 25.0 - 1e-9)
    shell.fix("uy rx rz", lambda p: np.abs(p[:, 1]) < 1e-9)
    load = shell.pressure(lambda x: ufl.as_vector([0.0 * x[0], 0.0 * x[0], -90.0 + 0.0 * x[0]]))
    angle = np.radians(40.0)
    edge = shell.at("uz", (0.0, 25.0 * np.sin(angle), 25.0 * np.cos(angle)))
    found = -shell.solve(load)[edge]
    assert found == pytest.approx(expected("scordelis")[0], rel=tolerances("scordelis")[0])
    assert numbers("scordelis", 16)[0] == pytest.approx(found, rel=5e-3)


@pytest.mark.parametrize("direction", ["y", "z"])
def test_twisted_beam(direction: str) -> None:
    name = f"twisted_{direction}"
    model, _ = twisted_beam((24, 4), direction)
    shell = ufl_shell(model)
    shell.fix("ux uy uz rx ry rz", lambda p: p[:, 0] < 1e-9)
    force = {"y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}[direction]
    load = shell.edge_force(shell.plain.curves["tip"], force)
    found = load @ shell.solve(load)
    assert found == pytest.approx(expected(name)[0], rel=tolerances(name)[0])
    assert numbers(name, (24, 4))[0] == pytest.approx(found, rel=1e-2)


def test_unsymmetric_laminate() -> None:
    """[0/90], a/h = 10: the coupling B, with its sign, in both."""
    model, _ = cross_ply(12, "sin", "0_90", "10")
    shell = ufl_shell(model)

    def edge(p: np.ndarray, axis: int) -> np.ndarray:
        return np.abs(p[:, axis] - 0.5) > 0.5 - 1e-9

    shell.fix("uy uz rx", lambda p: edge(p, 0))
    shell.fix("ux uz ry", lambda p: edge(p, 1))
    load = shell.pressure(
        lambda x: ufl.as_vector(
            [0.0 * x[0], 0.0 * x[0], ufl.sin(np.pi * x[0]) * ufl.sin(np.pi * x[1])]
        )
    )
    w = shell.solve(load)
    found = 0.1 * w[shell.at("uz", (0.5, 0.5, 0.0))]  # 100 h^3
    name = "fsdt_sin_0_90_ah10"
    assert found == pytest.approx(expected(name)[0], rel=tolerances(name)[0])
    # u at the middle of an edge is B's work alone: it changes sign with the order of the plies
    ux = w[shell.at("ux", (0.0, 0.5, 0.0))]
    ours = model.solved(mesh={"n_length": 32, "n_width": 32})
    row = int(np.argmin(np.linalg.norm(ours.points_G - [0.0, 0.5, 0.0], axis=1)))
    assert ours.statics.displacements[6 * row, 0] == pytest.approx(ux, rel=1e-2)
    assert abs(ux) > 0.01 * abs(w).max()


def test_composite_box_of_coupled_walls() -> None:
    """CAS 15: on 1120 triangles the second formulation meets CalculiX's S8R within 1 %."""
    model, _ = box((40, 4, 3), "cas15")
    shell = ufl_shell(model)
    shell.fix("ux uy uz rx ry rz", lambda p: p[:, 0] < 1e-9)
    found = [*shell.frequencies(6)]
    for force in ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)):
        load = shell.edge_force(shell.plain.curves["tip"], force)
        found.append(load @ shell.solve(load))
    assert found == pytest.approx(expected("ccx_box_cas15")[:8], rel=1e-2)
