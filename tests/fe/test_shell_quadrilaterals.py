"""Shells of quadrilaterals, and of both kinds of cells: meshes, obstacle course, bodies."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers.ply_stresses import body_strength
from samples.body_specs import panel_body
from samples.shell_benchmarks import expected, numbers
from samples.shell_meshes import gmsh_file
from samples.shell_specs import CFRP, box, plate

from plymotion.preprocess.body import build_body
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.body.interfaces import mass_stations
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError
from plymotion.solver.package import validate, write_package
from plymotion.solver.package.common.cells import corner_counts
from plymotion.solver.package.shell.shell_file import read_shell, write_shell
from plymotion.solver.strength.weakest_plies import cell_centres

Record = Callable[[str, Any], None]
QUADS = {"element": "quadrilateral"}
HELD = {"root": {"at": "left", "fixed": "all"}}
PULL = {"F": {"tip": {"at": "right", "force": [1.0, 2.0, 3.0]}}}

# id, cells, bounds of found/reference
COURSE = [
    ("straight_ext", (6, 1), (0.999, 1.001)),
    ("straight_in", (6, 1), (0.99, 1.0)),
    ("straight_out", (6, 1), (0.98, 1.0)),
    ("curved_in", (12, 1), (1.0, 1.015)),
    ("twisted_y", (12, 2), (0.99, 1.01)),
    ("twisted_z", (12, 2), (0.99, 1.01)),
    ("hemisphere18", 8, (0.92, 0.95)),
    ("hemisphere18", 16, (0.99, 1.0)),
    ("scordelis", 8, (1.0, 1.01)),
    ("pinched_cyl", 8, (0.94, 0.96)),
    ("mindlin_ss_uniform_Lh10", 8, (0.999, 1.001)),
]


@pytest.mark.one_end
@pytest.mark.parametrize(("name", "n", "bounds"), COURSE)
def test_course(name: str, n: Any, bounds: tuple[float, float]) -> None:
    ratio = float((numbers(name, n, cells=QUADS) / expected(name))[0])
    assert bounds[0] < ratio < bounds[1]


@pytest.mark.parametrize(("layup", "bound"), [("0", 0.022), ("cas15", 0.006), ("cus15", 0.006)])
def test_boxes_of_160_quadrilaterals(layup: str, bound: float, record: Record) -> None:
    """f1 to f6 against S8R: 3000 triangles gave 0.8 % for CAS 15."""
    name = f"ccx_box_{layup}"
    found = numbers(name, (40, 1, 1), cells=QUADS)[:6]
    assert np.abs(found / expected(name)[:6] - 1.0).max() < bound
    record(f"shell/quads/{name}", found)


def strip(n: tuple[int, int], h: float, **cells: str) -> float:
    """Twist of a strip 10 x 1 by forces at its corners, over that of Mindlin's theory."""
    lam = np.sqrt(10.0) / (2.0 * h)
    J = h**3 / 3.0 * (1.0 - np.tanh(lam) / lam)
    G = 70e9 / 2.6
    spec = plate(n, h, 10.0, 1.0)
    spec["mesh"].update(cells)
    held = {"00": ["ux", "uy", "uz"], "01": ["ux", "uz"], "10": ["uz"]}
    spec["supports"] = {k: {"at": f"corner-{k}", "fixed": fixed} for k, fixed in held.items()}
    spec["loads"] = {"T": {"up": {"at": "corner-11", "force": [0.0, 0.0, 1.0]}}}
    spec["probes"] = {"up": {"at": "corner-11", "what": "uz"}}
    return float(analyse(spec).probes.values[0, 0] * G * J / 10.0)


@pytest.mark.one_end
@pytest.mark.parametrize("h", [0.02, 0.1, 0.5])
def test_narrow_strip_in_torsion(h: float) -> None:
    # bilinear rotations of one cell across: 1 + (h/b)^2/k in place of Mindlin's tanh
    lam = np.sqrt(10.0) / (2.0 * h)
    bilinear = (1.0 + h**2 * 1.2) * (1.0 - np.tanh(lam) / lam)
    one_cell = strip((20, 1), h, **QUADS)
    assert bilinear - 0.01 < one_cell < 1.0
    if h == 0.5:  # cubic rotations; bilinear ones have 0.890
        assert one_cell > 0.96
    assert strip((80, 8), h, **QUADS) == pytest.approx(1.0, rel=0.04)  # forces at corners


def curved_out(n: tuple[int, int], **cells: str) -> float:
    """Displacement of the curved beam out of its plane over that of beam theory, 0.5022."""
    from samples.shell_model import SCRIPTS, isotropic

    stack, materials = isotropic(1e7, 0.25, 0.1)
    size = {"n_length": n[0], "n_width": n[1]}
    spec = {
        "mesh": {"file": str(SCRIPTS / "curved-beam.py"), "parameters": size, **cells},
        "materials": materials,
        "laminates": {"wall": stack},
        "regions": {"all": {"laminate": "wall"}},
        "supports": {"root": {"at": "root", "fixed": "all"}},
        "loads": {"F": {"tip": {"at": "tip", "force": [0.0, 0.0, 1.0]}}},
        "probes": {"tip": {"at": "tip", "what": "uz"}},
    }
    return float(analyse(spec).probes.values[0, 0] / 0.5022)


@pytest.mark.one_end
def test_curved_beam_out_of_its_plane() -> None:
    for n in ((6, 1), (12, 1), (48, 4)):
        assert 0.98 < curved_out(n, **QUADS) < 1.0
    assert curved_out((12, 1)) < 0.9  # triangles


RECOMBINED = """
def build(gmsh, parameters):
    occ, mesh = gmsh.model.occ, gmsh.model.mesh
    one, two = occ.addRectangle(0, 0, 0, 1, 1), occ.addRectangle(1, 0, 0, 1, 1)
    occ.fragment([(2, one)], [(2, two)])
    occ.synchronize()
    for name, entity in (("quads", one), ("rest", two)):
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [entity]), name)
    for name, x in (("left", 0.0), ("right", 2.0)):
        found = gmsh.model.getEntitiesInBoundingBox(x - .01, -.01, -.01, x + .01, 1.01, .01, 1)
        group = gmsh.model.addPhysicalGroup(1, [tag for _, tag in found])
        gmsh.model.setPhysicalName(1, group, name)
    mesh.setSize(gmsh.model.getEntities(0), 0.08)
    mesh.setRecombine(2, one)
    mesh.generate(2)
"""


def mixed(tmp_path: Path, **tables: Any) -> dict[str, Any]:
    """Two squares side by side, of quadrilaterals and of triangles."""
    script = tmp_path / "mixed.py"
    script.write_text(RECOMBINED)
    return plate(1, 0.05, **{"mesh": {"file": str(script)}, "supports": HELD, **tables})


@pytest.mark.one_end
def test_recombined_and_mixed_meshes(tmp_path: Path) -> None:
    found = analyse(mixed(tmp_path, loads=PULL, frequencies={"count": 4}))
    count = corner_counts(found.mesh.cells)
    assert set(count[found.mesh.region == 1]) == {3}
    assert (count == 4).sum() > 15
    assert found.mesh.area.sum() == pytest.approx(2.0, rel=1e-12)
    triangles = analyse(plate((40, 20), 0.05, 2.0, supports=HELD, loads=PULL,
                              frequencies={"count": 4}))  # fmt: skip
    assert found.modes is not None
    assert triangles.modes is not None
    assert found.modes.frequencies == pytest.approx(triangles.modes.frequencies, rel=0.01)
    assert found.cases.energy == pytest.approx(triangles.cases.energy, rel=0.01)
    assert found.cases.reactions_G[0, 0, :3] == pytest.approx([-1.0, -2.0, -3.0], rel=1e-9)
    target = tmp_path / "mixed.vtkhdf"
    write_shell(target, found)
    again = read_shell(target)
    assert np.array_equal(again.mesh.cells, found.mesh.cells)


@pytest.mark.one_end
def test_constant_stress_through_a_mixed_mesh(tmp_path: Path) -> None:
    held = {
        "left": {"at": "left", "fixed": ["ux", "uz", "ry", "rz"]},
        "bottom": {"at": "point", "fixed": ["uy", "rx"]},
    }
    script = RECOMBINED.replace(
        "    mesh.setSize",
        "    tag = gmsh.model.getEntitiesInBoundingBox(-.1, -.1, -.1, .1, .1, .1, 0)[0][1]\n"
        "    gmsh.model.setPhysicalName(0, gmsh.model.addPhysicalGroup(0, [tag]), 'point')\n"
        "    mesh.setSize",
    )
    path = tmp_path / "pull.py"
    path.write_text(script)
    loads = {"F": {"tip": {"at": "right", "force": [1.0, 0.0, 0.0]}}}
    found = analyse(plate(1, 0.05, mesh={"file": str(path)}, supports=held, loads=loads))
    N = found.cases.resultants_E[0]
    assert np.allclose(N[:, 0], 1.0, rtol=1e-9)
    assert np.abs(N[:, 1:3]).max() < 1e-9


def test_pairs_of_triangles() -> None:
    found = ShellProblem({**plate((4, 3), 0.1), "mesh": {**plate((4, 3), 0.1)["mesh"], **QUADS}})
    assert (corner_counts(found.mesh.cells) == 4).all()
    assert len(found.mesh.cells) == 12
    distorted = plate(12, 0.1)
    distorted["mesh"]["parameters"]["distortion"] = 0.3
    distorted["mesh"] |= QUADS
    mesh = ShellProblem(distorted).mesh
    area = np.linalg.norm(mesh.area_vectors_G, axis=1)
    assert area.sum() == pytest.approx(1.0, rel=1e-12)
    assert (corner_counts(mesh.cells) == 4).mean() > 0.8


def test_cst_is_refused_with_quadrilaterals() -> None:
    spec = plate(2, 0.1, elements={"membrane": "cst"})
    spec["mesh"] |= QUADS
    with pytest.raises(ShellError, match=r"elements.membrane = 'cst'.*opt or allman"):
        ShellProblem(spec)


@pytest.mark.parametrize("form", ["consistent", "lumped"])
def test_stations_have_the_mass_of_the_matrix(form: str) -> None:
    spec = box((3, 2, 1), elements={"mass_form": form})
    spec["mesh"] |= QUADS
    problem = ShellProblem(spec)
    R = problem.freedom.rigid_motions()
    exact = R.T @ problem.M @ R
    u = R.reshape(-1, 6, 6)
    s = mass_stations(problem.mesh, problem.regions, problem.stiffeners, u, form)
    found = np.einsum("s,sia,sib->ab", s.m, s.phi_B, s.phi_B)
    found += np.einsum("sia,sij,sjb->ab", s.psi_B, s.J_B, s.psi_B)
    assert np.abs(found - exact).max() < 1e-12 * np.abs(exact).max()


@pytest.mark.one_end
def test_body_of_quadrilaterals(tmp_path: Path) -> None:
    """A package with its stresses: no findings, and the exposure of its plies at the root."""
    shell = plate((12, 4), 1.0, 0.4, 0.1)
    limits = {"Xt": 2e9, "Xc": 1.5e9, "Yt": 5e7, "Yc": 2e8, "S12": 8e7}
    shell["materials"] = {"cfrp": {**CFRP, "strength": limits}}
    plies = [{"material": "cfrp", "angle_deg": a, "thickness": 1e-3} for a in (0.0, 90.0, 0.0)]
    shell["laminates"] = {"skin": {"plies": plies}}
    shell["regions"] = {"all": {"laminate": "skin", "axis": [1.0, 0.0, 0.0]}}
    shell["mesh"] |= QUADS
    package = build_body(panel_body(shell, 3, body="wing"))
    write_package(tmp_path / "wing.vtkhdf", package)
    assert [f for f in validate(tmp_path / "wing.vtkhdf") if f.level != "note"] == []
    assert set(package.cell_types) == {9}
    found = body_strength(package, np.zeros(1), np.array([[1e-3, 0.0, 0.0]]))
    assert found is not None
    bending = np.abs(package.cell_resultants.resultants_E[:, 3, 0])
    assert bending.argmax() in np.flatnonzero(
        np.abs(cell_centres(package, package.cell_resultants)[:, 0]) < 0.05
    )
    (weakest, *_) = found.plies
    assert weakest.point[0] < 0.05


def test_mesh_of_both_shapes_of_another_program(tmp_path: Path) -> None:
    """Two squares, one of them of triangles."""
    points = [[x, y, 0.0] for x in (0.0, 1.0, 2.0) for y in (0.0, 1.0)]
    cells = [[0, 2, 3, 1], [2, 4, 5], [2, 5, 3]]
    curves = {"root": [[0, 1]], "tip": [[4, 5]]}
    file = gmsh_file(tmp_path / "wing.msh", points, cells, "skin", curves)
    held = {"root": {"at": "root", "fixed": "all"}}
    loads = {"pull": {"tip": {"at": "tip", "force": [1.0, 0.0, 0.0]}}}
    found = analyse(plate(1, 0.1, mesh={"file": file}, supports=held, loads=loads))
    assert found.mesh.regions == ("skin",)
    assert sorted(corner_counts(found.mesh.cells).tolist()) == [3, 3, 4]
    assert found.cases.reactions_G[0, 0, 0] == pytest.approx(-1.0, rel=1e-9)
