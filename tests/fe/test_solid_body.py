"""Solid bodies: package, stresses of the surface, hexahedra, load cases, error estimates."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.body_specs import beam_body
from samples.section_specs import rectangle_spec
from samples.solid_samples import ALUMINIUM, bar, bracket, model_of, step_file, thin_rib

from plymotion.preprocess import fenicsx
from plymotion.preprocess.body import build_body
from plymotion.preprocess.solid.analysis import HeldSolid, accurate_model, findings, free_hertz
from plymotion.preprocess.solid.errors import SolidError
from plymotion.preprocess.solid.recovery import SKIN
from plymotion.solver.package import ModalPackage, write_package
from plymotion.solver.package.validation import validate

LENGTH, WIDTH, HEIGHT = 0.2, 0.012, 0.008
STRONG = {**ALUMINIUM, "strength": {"yield_stress": 250e6}}
MODES = [
    {"kind": "lowest", "count": 4},
    {"kind": "attachment", "at": "tip", "directions": ["y", "z"]},
]


def end(x: float, link: str) -> dict[str, Any]:
    """Interface at an end of the bar."""
    plane = {"point": [x, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}
    return {"plane": plane, "link": link, "rotation_deg": [0.0, 0.0, 0.0]}


def bar_body(file: Path, **more: Any) -> dict[str, Any]:
    """The bar, clamped at its root."""
    return {
        "body": "bar",
        "kind": "solid",
        "solid": {
            "mesh": {"file": str(file), "size": 0.006},
            "materials": {"alloy": STRONG},
            "regions": {"all": {"material": "alloy"}},
        },
        "reference": {"kind": "clamped", "at": "root"},
        "modes": MODES,
        "damping_ratio": 0.0,
        "interfaces": {"root": end(0.0, "rigid"), "tip": end(LENGTH, "average")},
        **more,
    }


@pytest.fixture(scope="module")
def bar_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A STEP file of the bar."""
    file = tmp_path_factory.mktemp("bar") / "bar.step"
    step_file(file, bar)
    return file


@pytest.fixture(scope="module")
def package(bar_file: Path) -> ModalPackage:
    """The bar as a body."""
    return build_body(bar_body(bar_file))


def test_package_is_valid(package: ModalPackage, tmp_path: Path) -> None:
    write_package(tmp_path / "bar.vtkhdf", package)
    assert validate(tmp_path / "bar.vtkhdf") == []
    mass = 2700.0 * LENGTH * WIDTH * HEIGHT
    assert package.invariants.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(package.invariants.S0_B / mass, [0.1, 0.0, 0.0], atol=1e-12)
    assert set(package.cell_types.tolist()) == {5}  # the surface as triangles


def test_surface_stress_of_a_bent_bar(bar_file: Path) -> None:
    """M c / I on the faces at the top, in the middle of the bar; sides have it in proportion."""
    package = build_body(bar_body(bar_file))
    assert package.cell_resultants is not None
    tip = next(i for i in package.interfaces if i.name == "tip")
    force = 100.0
    q = np.linalg.solve(package.stiffness, force * tip.phi_B[2])
    cells = package.cell_resultants
    stress = np.einsum("eim,m->ei", cells.resultants_E, q)[:, :3] / SKIN
    corners = package.connectivity.reshape(-1, 3)[cells.cell]
    centre = package.nodes_B[corners].mean(axis=1)
    middle = np.abs(centre[:, 0] - LENGTH / 2.0) < LENGTH / 4.0
    inertia = WIDTH * HEIGHT**3 / 12.0
    expected = -force * (LENGTH - centre[:, 0]) * centre[:, 2] / inertia
    along = stress[:, 0] * (np.abs(cells.A_BE[:, 0, 0]) > 0.99)
    np.testing.assert_allclose(
        along[middle], expected[middle], rtol=0, atol=0.02 * np.abs(expected).max()
    )
    assert package.laminates[0].materials["alloy"]["strength"] == {"yield_stress": 250e6}


def test_second_order_displacements_are_those_of_the_beam(bar_file: Path) -> None:
    """The shortening of the bent bar, at its tip and in its sums; nothing of it is linear."""
    modes = MODES[:1]
    found = build_body(bar_body(bar_file, modes=modes, second_order=True))
    beam = build_body(
        beam_body(
            body="bar",
            length=LENGTH,
            elements=16,
            section=rectangle_spec(WIDTH, HEIGHT, ALUMINIUM),
            modes=modes,
        )
    )
    assert found.second_order is not None
    assert beam.second_order is not None
    for one, other in zip(found.interfaces, beam.interfaces, strict=True):
        if one.name == "tip":
            assert one.H_B is not None
            assert other.H_B is not None
            shortening = np.diag(other.H_B[0])
            assert (shortening < 0.0).all()
            np.testing.assert_allclose(np.diag(one.H_B[0]), shortening, rtol=2e-2)
    for sums in ("Z0_B", "Z1_B"):
        a, b = (getattr(p.second_order, sums) for p in (found, beam))
        along = (0,) if sums == "Z0_B" else (0, 0)
        np.testing.assert_allclose(np.diag(a[along]), np.diag(b[along]), rtol=2e-2)
    squares = [np.einsum("iiii->i", p.second_order.G4) for p in (found, beam)]
    np.testing.assert_allclose(squares[0], squares[1], rtol=5e-2)


@pytest.mark.one_end
def test_cells_become_small_enough_for_the_accuracy(
    bar_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Torsion converges last: its error is 2 % with the first cells."""
    wanted = 5e-3
    spec = bar_body(bar_file)["solid"]
    spec["mesh"] |= {"size": 0.008, "accuracy": wanted}
    model = accurate_model(spec, {}, "solid")
    exact = free_hertz(model_of(bar_file, 0.0018), 6)
    assert np.abs(free_hertz(model, 6) / exact - 1.0).max() < 2.0 * wanted
    assert np.abs(free_hertz(model_of(bar_file, 0.008), 6) / exact - 1.0).max() > 4.0 * wanted
    monkeypatch.setattr("plymotion.preprocess.solid.analysis.ROUNDS", 1)
    with pytest.raises(SolidError, match=r"solid\.mesh\.accuracy = 0\.005: not reached"):
        accurate_model(spec, {}, "solid")


def hexahedra(file: Path) -> None:
    """Write the bar as hexahedra of eight nodes in millimetres, with named ends."""
    with fenicsx.gmsh_session() as gmsh:
        gmsh.clear()
        gmsh.model.occ.addBox(0, -6, -4, 200, 12, 8)
        gmsh.model.occ.synchronize()
        for _, tag in gmsh.model.getEntities(1):
            box = np.reshape(gmsh.model.getBoundingBox(1, tag), (2, 3))
            along = int(np.argmax(box[1] - box[0]))
            gmsh.model.mesh.setTransfiniteCurve(tag, (26, 3, 3)[along])
        for _, tag in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(tag)
            gmsh.model.mesh.setRecombine(2, tag)
            x = gmsh.model.getBoundingBox(2, tag)
            for name, place in (("left", 0.0), ("right", 200.0)):
                if abs(x[0] - place) + abs(x[3] - place) < 1e-3:
                    group = gmsh.model.addPhysicalGroup(2, [tag])
                    gmsh.model.setPhysicalName(2, group, name)
        gmsh.model.mesh.setTransfiniteVolume(1)
        group = gmsh.model.addPhysicalGroup(3, [1])
        gmsh.model.setPhysicalName(3, group, "bar")
        gmsh.model.mesh.generate(3)
        gmsh.write(str(file))
        gmsh.clear()


def test_hexahedra_of_a_mesh_file(tmp_path: Path, package: ModalPackage, record: Any) -> None:
    """A mesh of another cell, in millimetres, with named faces, gives the same body."""
    file = tmp_path / "bar.msh"
    hexahedra(file)
    named = {
        "root": {"at": "left", "link": "rigid", "rotation_deg": [0.0, 0.0, 0.0]},
        "tip": {"at": "right", "link": "average", "rotation_deg": [0.0, 0.0, 0.0]},
    }
    spec = bar_body(file, interfaces=named)
    spec["solid"] = {
        **spec["solid"],
        "mesh": {"file": str(file), "unit": 1e-3},
        "regions": {"bar": {"material": "alloy"}},
    }
    found = build_body(spec)
    np.testing.assert_allclose(found.frequencies[:4], package.frequencies[:4], rtol=2e-3)
    np.testing.assert_allclose(
        found.invariants.T00_B, package.invariants.T00_B, rtol=1e-9, atol=1e-12
    )
    assert set(found.cell_types.tolist()) == {9}
    record("hexahedra", found.frequencies)
    spec["solid"]["mesh"].pop("unit")
    with pytest.raises(SolidError, match=r"mesh\.unit: missing"):
        build_body(spec)


LOADS = {
    "weight": {"all": {"gravity": [0.0, 0.0, -9.81]}},
    "end": {"tip": {"at": "tip", "force": [0.0, 0.0, 100.0], "moment": [1.0, 0.0, 0.0]}},
}


def test_load_cases_are_in_equilibrium_and_bend_as_a_beam(bar_file: Path) -> None:
    model = model_of(
        bar_file,
        0.006,
        interfaces={"root": end(0.0, "rigid"), "tip": end(LENGTH, "average")},
    )
    held = HeldSolid(model, ["root"])
    mass = 2700.0 * LENGTH * WIDTH * HEIGHT
    weight = held.case(LOADS["weight"])
    expected = np.array([0, 0, mass * 9.81, 0, -mass * 9.81 * LENGTH / 2, 0])
    np.testing.assert_allclose(weight.reactions["root"], expected, atol=1e-9)
    loaded = held.case(LOADS["end"])
    expected = np.array([0, 0, -100.0, -1.0, 100.0 * LENGTH, 0])
    np.testing.assert_allclose(loaded.reactions["root"], expected, atol=1e-7)
    bend = 100.0 * LENGTH**3 / (3.0 * 70e9 * WIDTH * HEIGHT**3 / 12.0)
    tip = np.isclose(model.body.nodes[:, 0], LENGTH)
    assert loaded.u[tip, 2].mean() == pytest.approx(bend, rel=1e-2)
    for force in (1.7e308, 1e200):  # infinite displacements; stresses whose squares are
        with pytest.raises(SolidError, match=r"loads.pull: .* expected smaller loads"):
            held.case({"tip": {"at": "tip", "force": [0.0, 0.0, force]}}, "loads.pull")


@pytest.mark.one_end
@pytest.mark.parametrize(("draw", "size"), [(bracket, 0.012), (thin_rib, 0.012), (bar, 0.008)])
def test_error_estimate_is_near_the_true_error(draw: Any, size: float, tmp_path: Path) -> None:
    """Against a mesh with cells 3.5 times as small."""
    file = tmp_path / "part.step"
    step_file(file, draw)
    model = model_of(file, size)
    mesh = {"file": str(file), "size": size}
    solid = {
        "mesh": mesh,
        "materials": {"stuff": ALUMINIUM},
        "regions": {"all": {"material": "stuff"}},
    }
    count = 4
    spec = {
        "body": "part",
        "kind": "solid",
        "solid": solid,
        "reference": {"kind": "mean-axis"},
        "modes": [{"kind": "lowest", "count": count}],
        "damping_ratio": 0.0,
        "interfaces": {},
    }
    asked = {"supports": [], "loads": {}, "error": True}
    estimate = findings(model, build_body(spec), asked, solid)["free_error"]
    true = free_hertz(model, count) / free_hertz(model_of(file, size / 3.5), count) - 1.0
    ratio = np.array(estimate) / true
    assert ((ratio > 0.5) & (ratio < 3.0)).all(), ratio
