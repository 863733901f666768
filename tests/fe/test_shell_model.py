"""The shell model: assembly, statics, links, frequencies, one answer on all versions and ranks."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from samples.shell_element_samples import element_stiffness
from samples.shell_specs import HARD, METAL, box, mesh_from, plate

from plymotion.preprocess import fenicsx
from plymotion.preprocess.shell.analyses.frequencies import natural_modes
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.model import shell_problem
from plymotion.preprocess.shell.model.freedom import Freedom
from plymotion.preprocess.shell.model.links import averaged, carried
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.shell.shell_cells import ShellError

Record = Callable[[str, Any], None]
TIP = {"tip": {"at": "tip", "kind": "rigid"}}


def navier_centre(h: float, q: float = 1.0, terms: int = 199) -> float:
    """Deflection of the centre of a hard simply supported unit square by Mindlin's theory."""
    E, nu = METAL["E"], METAL["nu"]
    D = E * h**3 / (12.0 * (1.0 - nu**2))
    shear = 5.0 / 6.0 * E / (2.0 * (1.0 + nu)) * h
    m, n = np.meshgrid(np.arange(1, terms + 1, 2), np.arange(1, terms + 1, 2))
    k2 = np.pi**2 * (m**2 + n**2)
    amplitude = 16.0 * q / (np.pi**2 * m * n) * (1.0 + D * k2 / shear) / (D * k2**2)
    return float(np.sum(amplitude * np.sin(m * np.pi / 2) * np.sin(n * np.pi / 2)))


@pytest.mark.parametrize("h", [0.2, 0.1, 0.01, 1e-4])
def test_hard_supported_square_is_navier(h: float, record: Record) -> None:
    load = {"q": {"all": {"pressure": 1.0}}}
    found = analyse(
        plate(32, h, supports=HARD, loads=load, probes={"c": {"at": "centre", "what": "uz"}})
    )
    exact = navier_centre(h)
    record(f"shell plate h {h}", found.probes.values[0, 0] / exact)
    assert found.probes.values[0, 0] == pytest.approx(exact, rel=2e-3)
    assert found.cases.residual[0] < 1e-12
    # work and energy, reactions and load
    u, (row,) = found.cases.displacements_G[0], found.cases.loads_G
    area = np.bincount(found.mesh.cells.ravel(), np.repeat(found.mesh.area / 3.0, 3))
    assert found.cases.energy[0] == pytest.approx(0.5 * area @ u[:, 2], rel=1e-8)
    assert row[2] == pytest.approx(1.0, rel=1e-12)
    assert found.cases.reactions_G[0, :, 2].sum() == pytest.approx(-1.0, rel=1e-9)


def test_strip_bends_as_a_beam() -> None:
    """Root clamped, rim loads at the tip; nu = 0 so that a plate strip is a beam."""
    length, width, h, force = 1.0, 0.05, 0.01, 3.0
    spec = plate(
        (40, 2),
        h,
        length,
        width,
        supports={"root": {"at": "left", "fixed": "all"}},
        loads={
            "w": {"tip": {"at": "right", "force": [0.0, 0.0, force]}},
            "m": {"tip": {"at": "right", "moment": [0.0, -force, 0.0]}},
            "v": {"tip": {"at": "right", "force": [0.0, force, 0.0]}},
            "u": {"tip": {"at": "right", "force_per_length": [force / width, 0.0, 0.0]}},
        },
        probes={"tip": {"at": "right", "what": ["ux", "uy", "uz", "ry"]}},
    )
    spec["materials"]["metal"] = {**METAL, "nu": 0.0}
    found = analyse(spec)
    E = METAL["E"]
    EI, shear = E * width * h**3 / 12.0, 5.0 / 6.0 * E / 2.0 * width * h
    cases = dict(zip(found.cases.names, found.probes.values, strict=True))
    exact = force * length**3 / (3.0 * EI) + force * length / shear
    assert cases["w"][2] == pytest.approx(exact, rel=1e-3)
    assert cases["m"][3] == pytest.approx(-force * length / EI, rel=1e-9)
    assert cases["m"][2] == pytest.approx(force * length**2 / (2.0 * EI), rel=1e-9)
    assert cases["u"][0] == pytest.approx(force * length / (E * width * h), rel=1e-9)
    # two cells across: in its plane the strip bends by the membrane's own terms
    EI_wide, wide = E * h * width**3 / 12.0, 5.0 / 6.0 * E / 2.0 * width * h
    exact = force * length**3 / (3.0 * EI_wide) + force * length / wide
    assert cases["v"][1] == pytest.approx(exact, rel=1e-2)
    (root,) = found.cases.reactions_G[0]
    assert root[:3] == pytest.approx([0.0, 0.0, -force], abs=1e-8)
    assert root[3:] == pytest.approx([0.0, force * length, 0.0], abs=1e-8)


def test_assembly_is_the_sum_over_cells(record: Record) -> None:
    """Several regions, and reference points of links at the end. Paper: Eq. (24)."""
    problem = ShellProblem(box((3, 2, 1), links=TIP))
    n = problem.freedom.n_dof
    dense = np.zeros((n, n))
    for region in problem.regions:
        element = element_stiffness(region.geometry, region.stiffness, problem.choice)
        for cell, matrix in zip(region.cells, element, strict=True):
            dofs = (6 * problem.mesh.cells[cell][:, None] + np.arange(6)).ravel()
            dense[np.ix_(dofs, dofs)] += matrix
    size = np.abs(dense).max()
    assert np.abs(problem.K.toarray() - dense).max() < 1e-14 * size
    assert problem.K.has_sorted_indices
    trace = np.sort(np.linalg.eigvalsh(dense[:-6, :-6]))[-5:]
    record("shell box stiffness", trace)


@pytest.mark.one_end
def test_lay_ups_of_one_mesh_share_it_in_dolfinx() -> None:
    """The second one makes no mesh, and has the matrix that it has alone."""
    specs = [plate(4, h) for h in (0.01, 0.02)]
    shell_problem._surface.cache_clear()
    matrices = [ShellProblem(spec).K for spec in specs]
    found = shell_problem._surface.cache_info()
    assert (found.misses, found.hits) == (1, 1)
    shell_problem._surface.cache_clear()
    assert (matrices[1] != ShellProblem(specs[1]).K).nnz == 0
    assert (matrices[0] != matrices[1]).nnz > 0


def test_rigid_motions_have_no_energy_and_their_mass() -> None:
    for form in ("consistent", "lumped"):
        problem = ShellProblem(box(elements={"mass_form": form}))
        R = problem.freedom.rigid_motions()
        size = abs(problem.K).max()
        assert np.abs(problem.K @ R).max() < 1e-11 * size
        mass = sum(r.stiffness.mass[0] * r.geometry.area.sum() for r in problem.regions)
        assert np.diag(R.T @ (problem.M @ R))[:3] == pytest.approx(mass)


def test_rigid_link_moves_its_group_as_one() -> None:
    loads = {"a": {"f": {"at": "tip", "force": [1.0, 2.0, -3.0], "moment": [0.3, 0.2, 0.1]}}}
    links = {"tip": {"at": "tip", "kind": "rigid", "point": [1.1, 0.02, -0.03]}}
    found = analyse(box(links=links, loads=loads, probes={"p": {"at": "tip", "what": "uz"}}))
    motion = found.cases.link_motions_G[0, 0]
    tip = np.isclose(found.mesh.nodes_G[:, 0], 1.0)
    arms = found.mesh.nodes_G[tip] - [1.1, 0.02, -0.03]
    followed = carried(arms) @ motion
    u = found.cases.displacements_G[0, tip]
    assert np.abs(u - followed).max() < 1e-12 * np.abs(u).max()
    assert found.probes.values[0, 0] == motion[2]
    # reaction in balance with the load at its point
    force, moment = np.array([1.0, 2.0, -3.0]), np.array([0.3, 0.2, 0.1])
    root, point = found.cases.reactions_G[0, 0], found.supports.points_G[0]
    assert root[:3] == pytest.approx(-force, rel=1e-7)
    arm = np.array([1.1, 0.02, -0.03]) - point
    assert root[3:] == pytest.approx(-(moment + np.cross(arm, force)), rel=1e-7)
    work = 0.5 * np.concatenate([force, moment]) @ motion
    assert found.cases.energy[0] == pytest.approx(work, rel=1e-7)


@pytest.mark.parametrize("shape", ["cloud", "line", "point"])
def test_average_is_the_nearest_rigid_motion(shape: str) -> None:
    rng = np.random.default_rng(3)
    arms = rng.standard_normal((7, 3)) + np.array([1.0, 2.0, 3.0])
    if shape == "line":
        arms = np.outer(rng.standard_normal(7), [1.0, 2.0, -1.0]) + np.array([1.0, 2.0, 3.0])
    elif shape == "point":
        arms = np.array([[0.3, 0.2, 0.5]])
    weights = rng.random(len(arms)) + 0.1
    G = averaged(arms, weights)
    motion = rng.standard_normal(6)
    # rigid motions come back exactly, so that forces keep their resultant
    back = np.einsum("ikj,kj->i", G, carried(arms) @ motion)
    assert back == pytest.approx(motion, abs=1e-12)
    if shape != "cloud":
        return
    u = rng.standard_normal((7, 3))
    found = np.einsum("ikj,kj->i", G[:, :, :3], u)
    rows = (np.sqrt(weights)[:, None, None] * carried(arms)[:, :3]).reshape(-1, 6)
    nearest = np.linalg.lstsq(rows, (np.sqrt(weights)[:, None] * u).ravel(), rcond=None)[0]
    assert found == pytest.approx(nearest, abs=1e-12)


def test_average_link_spreads_a_load_and_stiffens_nothing() -> None:
    """Its load equals nodal forces of the same resultant, its motion a mean of the nodes'."""
    force, moment = [1.0, 2.0, -3.0], [0.3, 0.2, 0.1]
    loads = {"a": {"f": {"at": "mean", "force": force, "moment": moment}}}
    links = {"mean": {"at": "tip", "kind": "average"}}
    spec = box(links=links, loads=loads)
    found = analyse(spec)
    tip = np.isclose(found.mesh.nodes_G[:, 0], 1.0)
    assert found.cases.reactions_G[0, 0, :3] == pytest.approx([-1.0, -2.0, 3.0], rel=1e-7)
    work = 0.5 * np.array([*force, *moment]) @ found.cases.link_motions_G[0, 0]
    assert found.cases.energy[0] == pytest.approx(work, rel=1e-7)
    stiffer = analyse({**spec, "links": {"mean": {"at": "tip", "kind": "rigid"}}})
    assert stiffer.cases.energy[0] < found.cases.energy[0]
    u = found.cases.displacements_G[0, tip]
    arms = found.mesh.nodes_G[tip] - found.links.points_G[0]
    followed = carried(arms) @ found.cases.link_motions_G[0, 0]
    assert np.abs(u - followed).max() > 1e-3 * np.abs(u).max()  # the section deforms


def test_square_plate_counts_coinciding_modes(record: Record) -> None:
    """Simply supported: omega = pi^2 (m^2 + n^2) sqrt(D / m0) in thin plates, many in pairs."""
    h = 1e-3
    found = analyse(plate(32, h, supports=HARD, frequencies={"count": 9}))
    assert found.modes is not None
    D = METAL["E"] * h**3 / (12.0 * (1.0 - METAL["nu"] ** 2))
    unit = np.pi**2 * np.sqrt(D / (METAL["rho"] * h))
    exact = np.array([2, 5, 5, 8, 10, 10, 13, 13, 17]) * unit
    assert found.modes.frequencies == pytest.approx(exact, rel=2e-2)
    assert found.modes.n_zero == 0
    record("shell square modes", found.modes.frequencies / unit)


@pytest.mark.parametrize("form", ["consistent", "lumped"])
def test_free_box_has_six_rigid_modes(form: str, record: Record) -> None:
    spec = box(elements={"mass_form": form}, frequencies={"count": 5, "free": True})
    found = analyse(spec)
    assert found.modes is not None
    assert found.modes.n_zero == 6
    assert found.modes.frequencies.shape == (11,)
    assert np.all(found.modes.frequencies[:6] == 0.0)
    problem = ShellProblem({**spec, "supports": {}})
    K, M = problem.K.toarray(), problem.M.toarray()
    if form == "consistent":
        shift = found.modes.frequencies[6] ** 2
        inverse = scipy.linalg.eigh(M, K + shift * M, eigvals_only=True)[::-1][6:11]
        values = 1.0 / inverse - shift
        assert found.modes.frequencies[6:] ** 2 == pytest.approx(values, rel=1e-6)
    assert not [w for w in found.warnings if w["code"] == "zero-energy-modes"]
    record(f"shell free box {form}", found.modes.frequencies[6:])
    # mass-orthonormal
    u = found.modes.shapes_G.reshape(11, -1)
    assert np.abs(u @ M @ u.T - np.eye(11)).max() < 1e-9


def test_missed_modes_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """An iteration that loses one of two coinciding modes is asked again."""
    problem = ShellProblem(plate(12, 1e-2, supports=HARD))
    whole = fenicsx.eigenpairs
    asked: list[int] = []

    def losing(K: Any, M: Any, count: int, **more: Any) -> Any:
        values, X = whole(K, M, count + 1, **more)
        asked.append(count)
        keep = np.arange(count + 1) != 1
        return (values[keep], X[:, keep]) if len(asked) == 1 else (values[:-1], X[:, :-1])

    monkeypatch.setattr(fenicsx, "eigenpairs", losing)
    free_motions = np.zeros((problem.freedom.n_dof, 0))
    found = natural_modes(problem.K, problem.M, problem.freedom, 3, free_motions)
    assert len(asked) == 2
    assert found.values[1] == pytest.approx(found.values[2], rel=1e-6)


def test_partly_supported_shell_keeps_one_rigid_mode() -> None:
    hinge = {"hinge": {"at": "left", "fixed": ["ux", "uy", "uz", "rx", "rz"]}}
    found = analyse(plate(6, 0.01, supports=hinge, frequencies={"count": 2}))
    assert found.modes is not None
    assert found.modes.n_zero == 1
    assert found.modes.frequencies[1] > 1.0


def test_results_are_in_the_order_of_the_mesh_file(tmp_path: Path) -> None:
    from plymotion.preprocess.fenicsx import gmsh

    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    path = tmp_path / "two.msh"
    with fenicsx.gmsh_session():
        gmsh.clear()
        surface = gmsh.model.addDiscreteEntity(2)
        tags = [40, 10, 30, 20]
        gmsh.model.mesh.addNodes(2, surface, tags, points.ravel().tolist())
        gmsh.model.mesh.addElementsByType(surface, 2, [7, 5], [40, 10, 30, 40, 30, 20])
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [surface]), "skin")
        gmsh.write(str(path))
        gmsh.clear()
    spec = plate(1, 0.1, frequencies={"count": 1}, mesh={"file": str(path), "scale": 0.5})
    found = analyse(spec)
    place = dict(zip(found.mesh.node_ids.tolist(), found.mesh.nodes_G.tolist(), strict=True))
    assert place == {tag: (0.5 * point).tolist() for tag, point in zip(tags, points, strict=True)}
    assert np.all(found.mesh.A_GE[:, 2, 2] == pytest.approx(1.0))
    corners = found.mesh.node_ids[found.mesh.cells]
    assert sorted(map(sorted, corners.tolist())) == [[10, 30, 40], [20, 30, 40]]


@pytest.mark.one_end
def test_curved_cells_are_refused(tmp_path: Path) -> None:
    script = tmp_path / "quads.py"
    script.write_text(
        "def build(gmsh, parameters):\n"
        "    surface = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)\n"
        "    gmsh.model.occ.synchronize()\n"
        "    gmsh.model.addPhysicalGroup(2, [surface])\n"
        "    gmsh.model.mesh.setRecombine(2, surface)\n"
        "    gmsh.model.mesh.setTransfiniteSurface(surface)\n"
        "    gmsh.option.setNumber('Mesh.ElementOrder', 2)\n"
        "    gmsh.model.mesh.generate(2)\n"
        "    gmsh.option.setNumber('Mesh.ElementOrder', 1)\n"
    )
    with pytest.raises(ShellError, match="degree 2, expected three-node triangles"):
        analyse(plate(1, 0.1, mesh={"file": str(script)}, frequencies={"count": 1}))


def test_parts_are_told_apart() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]]
    mesh = mesh_from(points, [[0, 1, 2], [3, 4, 5]], a=[[0, 1]])
    freedom = Freedom(mesh)
    part = freedom.parts()
    assert len(set(part[:3])) == len(set(part[3:])) == 1
    assert part[0] != part[3]
    assert len(freedom.free_rigid_motions()) == 12
