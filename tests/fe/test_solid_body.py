"""Solid bodies: package, stresses of the surface, hexahedra, load cases, error estimates."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers.ply_stresses import body_strength
from samples.body_specs import beam_body
from samples.recovery_samples import PLY_CRITERIA
from samples.section_specs import rectangle_spec
from samples.solid_samples import (
    ALUMINIUM,
    WOUND,
    bar,
    bracket,
    model_of,
    step_file,
    thin_rib,
    tube,
)

from plymotion.preprocess import fenicsx
from plymotion.preprocess.body import build_body
from plymotion.preprocess.solid.solid_analysis import (
    HeldSolid,
    accurate_model,
    coarse_mesh,
    findings,
    free_hertz,
)
from plymotion.preprocess.solid.solid_mesh import SolidError
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


@pytest.mark.one_end
def test_package_is_valid(package: ModalPackage, tmp_path: Path) -> None:
    write_package(tmp_path / "bar.vtkhdf", package)
    assert validate(tmp_path / "bar.vtkhdf") == []
    mass = 2700.0 * LENGTH * WIDTH * HEIGHT
    assert package.invariants.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(package.invariants.S0_B / mass, [0.1, 0.0, 0.0], atol=1e-12)
    assert set(package.cell_types.tolist()) == {5}  # the surface as triangles


@pytest.mark.one_end
def test_surface_stress_of_a_bent_bar(package: ModalPackage) -> None:
    """M c / I on the faces at the top, in the middle of the bar; sides have it in proportion."""
    assert package.face_stresses is not None
    tip = next(i for i in package.interfaces if i.name == "tip")
    force = 100.0
    q = np.linalg.solve(package.stiffness, force * tip.phi_B[2])
    faces = package.face_stresses
    stress = faces.stress_M @ q
    corners = package.connectivity.reshape(-1, 3)[faces.cell]
    centre = package.nodes_B[corners].mean(axis=1)
    middle = np.abs(centre[:, 0] - LENGTH / 2.0) < LENGTH / 4.0
    inertia = WIDTH * HEIGHT**3 / 12.0
    expected = -force * (LENGTH - centre[:, 0]) * centre[:, 2] / inertia
    atol = 0.02 * np.abs(expected).max()
    np.testing.assert_allclose(stress[middle, 0], expected[middle], rtol=0, atol=atol)
    np.testing.assert_allclose(stress[middle, 1:4], 0.0, atol=atol)
    assert faces.materials["alloy"]["strength"] == {"yield_stress": 250e6}


PLY = {**WOUND, "strength": {"Xt": 1.5e9, "Xc": 1e9, "Yt": 40e6, "Yc": 180e6, "S12": 70e6}}


@pytest.mark.one_end
def test_strength_of_a_bar_pulled_at_an_angle_to_its_fibres(bar_file: Path) -> None:
    """An off-axis coupon: stresses in material axes, and the ratio of a criterion by hand."""
    c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    body = bar_body(bar_file, modes=[{"kind": "attachment", "at": "tip", "directions": ["x"]}])
    body["solid"]["materials"] = {"ply": PLY}
    body["solid"]["regions"] = {
        "all": {"material": "ply", "axis": [c, s, 0.0], "normal": [0.0, 0.0, 1.0]}
    }
    package = build_body(body)
    faces = package.face_stresses
    assert faces is not None
    tip = next(i for i in package.interfaces if i.name == "tip")
    q = np.linalg.solve(package.stiffness, 9600.0 * tip.phi_B[0])  # a stress of 100 MPa
    x = package.nodes_B[package.connectivity.reshape(-1, 3)].mean(axis=1)[:, 0]
    stress = (faces.stress_M @ q)[np.abs(x - LENGTH / 2.0) < LENGTH / 8.0]
    expected = 100e6 * np.array([c * c, s * s, 0.0, 0.0, 0.0, -c * s])
    np.testing.assert_allclose(stress, np.tile(expected, (len(stress), 1)), rtol=0, atol=2e5)
    middle = np.flatnonzero(np.abs(x - LENGTH / 2.0) < LENGTH / 8.0)
    some = replace(
        faces,
        **{name: getattr(faces, name)[middle] for name in ("cell", "material", "A_BM", "stress_M")},
    )
    found = body_strength(replace(package, face_stresses=some), np.zeros(1), q[None])
    assert found is not None
    assert set(found.worst) == PLY_CRITERIA
    assert found.worst["max-stress"].ratio == pytest.approx(40e6 / (100e6 * s * s), rel=5e-3)
    s1, s2, t12 = expected[0], expected[1], expected[5]
    square = s1**2 / 1.5e18 + s2**2 / 7.2e15 + (t12 / 70e6) ** 2 - s1 * s2 / np.sqrt(1.08e34)
    linear = s1 * (1.0 / 1.5e9 - 1.0 / 1e9) + s2 * (1.0 / 40e6 - 1.0 / 180e6)
    by_hand = (np.sqrt(linear**2 + 4.0 * square) - linear) / (2.0 * square)
    assert found.worst["tsai-wu"].ratio == pytest.approx(by_hand, rel=5e-3)


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
    bar_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Torsion converges last: its error is 3 % with the first cells."""
    wanted = 1.5e-2
    spec = bar_body(bar_file)["solid"]
    spec["mesh"] |= {"size": 0.008, "accuracy": wanted}
    model = accurate_model(spec, {})
    hexahedra(tmp_path / "bar.msh", (31, 5, 5))  # within 1.6e-3 of tetrahedra of 2.5 mm
    exact = free_hertz(model_of(tmp_path / "bar.msh", None, unit=1e-3).body, 6)
    assert np.abs(free_hertz(model.body, 6) / exact - 1.0).max() < wanted
    assert np.abs(free_hertz(model_of(bar_file, 0.008).body, 6) / exact - 1.0).max() > 2.0 * wanted
    module = "plymotion.preprocess.solid.solid_analysis"
    monkeypatch.setattr(f"{module}.MOST_FACTORISED", 20_000)  # the first mesh has 4000 unknowns
    with pytest.raises(SolidError, match=r"^mesh\.accuracy = 0\.015: the error with cells of 0"):
        accurate_model(spec, {})
    monkeypatch.setattr(f"{module}.ROUNDS", 1)
    spec["mesh"]["size"] = 0.02
    with pytest.raises(SolidError, match=r"^mesh\.accuracy = 0\.015: not reached"):
        accurate_model(spec, {})


def hexahedra(file: Path, nodes: tuple[int, int, int] = (26, 3, 3)) -> None:
    """Write the bar as hexahedra of eight nodes in millimetres, with named ends."""
    with fenicsx.gmsh_session() as gmsh:
        gmsh.clear()
        gmsh.model.occ.addBox(0, -6, -4, 200, 12, 8)
        gmsh.model.occ.synchronize()
        for _, tag in gmsh.model.getEntities(1):
            box = np.reshape(gmsh.model.getBoundingBox(1, tag), (2, 3))
            along = int(np.argmax(box[1] - box[0]))
            gmsh.model.mesh.setTransfiniteCurve(tag, nodes[along])
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


def test_a_mesh_whose_cells_are_all_mirrored(tmp_path: Path) -> None:
    """Other programs count the nodes of a cell in the other sense."""
    file = tmp_path / "bar.msh"
    hexahedra(file, (6, 3, 3))
    body = model_of(file, None, unit=1e-3).body
    with fenicsx.gmsh_session() as gmsh:
        gmsh.open(str(file))
        tags, places, _ = gmsh.model.mesh.getNodes()
        for tag, (x, y, z) in zip(tags, np.reshape(places, (-1, 3)), strict=True):
            gmsh.model.mesh.setNode(tag, [x, -y, z], [])
        gmsh.write(str(file))
        gmsh.clear()
    mirrored = model_of(file, None, unit=1e-3).body
    np.testing.assert_allclose(free_hertz(mirrored, 3), free_hertz(body, 3), rtol=1e-9)


LOADS = {
    "weight": {"all": {"gravity": [0.0, 0.0, -9.81]}},
    "end": {"tip": {"at": "tip", "force": [0.0, 0.0, 100.0], "moment": [1.0, 0.0, 0.0]}},
}


def test_load_cases_are_in_equilibrium_and_bend_as_a_beam(bar_file: Path) -> None:
    model = model_of(
        bar_file, 0.006, interfaces={"root": end(0.0, "rigid"), "tip": end(LENGTH, "average")}
    )
    held = HeldSolid(model.body, model.links, ["root"])
    mass = 2700.0 * LENGTH * WIDTH * HEIGHT
    weight = held.case(LOADS["weight"], model.unit_pressure)
    expected = np.array([0, 0, mass * 9.81, 0, -mass * 9.81 * LENGTH / 2, 0])
    np.testing.assert_allclose(weight.reactions["root"], expected, atol=1e-9)
    loaded = held.case(LOADS["end"], model.unit_pressure)
    expected = np.array([0, 0, -100.0, -1.0, 100.0 * LENGTH, 0])
    np.testing.assert_allclose(loaded.reactions["root"], expected, atol=1e-7)
    bend = 100.0 * LENGTH**3 / (3.0 * 70e9 * WIDTH * HEIGHT**3 / 12.0)
    tip = np.isclose(model.body.nodes[:, 0], LENGTH)
    assert loaded.u[tip, 2].mean() == pytest.approx(bend, rel=1e-2)
    for force in (1.7e308, 1e200):  # infinite displacements; stresses whose squares are
        with pytest.raises(SolidError, match=r"loads.pull: .* expected smaller loads"):
            held.case(
                {"tip": {"at": "tip", "force": [0.0, 0.0, force]}},
                model.unit_pressure,
                "loads.pull",
            )


@pytest.mark.provokes("modes-not-counted")
def test_the_iterative_solver_gives_the_same_body(
    bar_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What large solids take: held by a rigid interface, and free."""
    for reference in ({"kind": "clamped", "at": "root"}, {"kind": "mean-axis"}):
        body = bar_body(bar_file, reference=reference)
        body["solid"]["mesh"]["size"] = 0.01
        expected = build_body(body)
        with monkeypatch.context() as patch:
            patch.setattr("plymotion.preprocess.solid.model.MOST_FACTORISED", 1000)
            found = build_body(body)
        np.testing.assert_allclose(found.frequencies, expected.frequencies, rtol=1e-9)
        for one, other in zip(found.interfaces, expected.interfaces, strict=True):
            compliance = [
                p.phi_B @ np.linalg.solve(package.stiffness, p.phi_B.T)
                for p, package in ((one, found), (other, expected))
            ]
            np.testing.assert_allclose(*compliance, rtol=1e-8, atol=1e-8 * np.abs(compliance).max())
        assert "modes-not-counted" in {w["code"] for w in found.provenance["warnings"]}


def test_pressure_in_a_tube_widens_it_as_lame_says(tmp_path: Path) -> None:
    file = tmp_path / "tube.step"
    step_file(file, tube)
    axis = {"point": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}
    interfaces = {
        "foot": {"plane": {"point": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}, "link": "rigid"},
        "inside": {"bore": {"radius": 0.020, **axis}, "link": "average"},
        "top": {"plane": {"point": [0.0, 0.0, 0.12], "normal": [0.0, 0.0, 1.0]}, "link": "average"},
    }
    model = model_of(file, 0.008, interfaces=interfaces)
    area = np.pi * (0.025**2 - 0.020**2)
    on_top = model.unit_pressure("top").reshape(-1, 3).sum(axis=0)
    np.testing.assert_allclose(on_top, [0.0, 0.0, -area], atol=2e-4 * area)
    held = HeldSolid(model.body, model.links, ["foot"])
    found = held.case({"burst": {"at": "inside", "pressure": 1e6}}, model.unit_pressure)
    x = model.mesh.plain.points
    r = np.hypot(x[:, 0], x[:, 1])
    middle = np.flatnonzero((np.abs(r - 0.020) < 1e-6) & (np.abs(x[:, 2] - 0.07) < 0.01))
    radial = (x[middle, :2] * found.u[middle, :2]).sum(axis=1) / r[middle]
    ratio = (0.025**2 + 0.020**2) / (0.025**2 - 0.020**2)
    np.testing.assert_allclose(radial, 1e6 * 0.020 / 70e9 * (ratio + 0.33), rtol=1e-2)
    np.testing.assert_allclose(found.reactions["foot"], 0.0, atol=1e-3 * 1e6 * area)


def ring(occ: Any) -> None:
    """Draw a short tube along z."""
    outer = occ.addCylinder(0, 0, 0, 0, 0, 30, 25)
    occ.cut([(3, outer)], [(3, occ.addCylinder(0, 0, -1, 0, 0, 32, 20))])


@pytest.mark.one_end
@pytest.mark.parametrize(
    ("draw", "size", "finer", "material"),
    [
        (bracket, 0.012, 2.0, ALUMINIUM),
        (thin_rib, 0.012, 2.0, ALUMINIUM),
        (bar, 0.008, 2.0, ALUMINIUM),
        (ring, 0.01, 3.5, WOUND),
    ],
)
def test_error_estimate_is_near_the_true_error(
    draw: Any, size: float, finer: float, material: dict[str, Any], tmp_path: Path
) -> None:
    """Against a mesh with cells `finer` times as small.

    The wall of the ring has one cell through its thickness in a mesh of two thirds of the size,
    too: shear through the wall, soft in this material, is wrong in both alike.
    """
    file = tmp_path / "part.step"
    step_file(file, draw)
    about = {"axis_about": {"point": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}}
    region = about if material is WOUND else {}
    model = model_of(file, size, material, region=region)
    solid = {
        "mesh": {"file": str(file), "size": size},
        "materials": {"stuff": material},
        "regions": {"all": {"material": "stuff", **region}},
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
    package = build_body(spec)
    estimate = findings(model, package, asked)[0]["free_error"]
    exact = free_hertz(model_of(file, size / finer, material, region=region).body, count)
    true = package.frequencies / (2.0 * np.pi * exact) - 1.0
    ratio = np.array(estimate) / true
    assert ((ratio > 0.5) & (ratio < 3.0)).all(), ratio


@pytest.mark.provokes("solid-mesh-coarse")
def test_a_coarse_mesh_is_told(tmp_path: Path) -> None:
    """Of a thin rib; deflections have twice the error of the first frequency of the held part."""
    file = tmp_path / "rib.step"
    step_file(file, thin_rib)
    rib = bar_body(file, reference={"kind": "mean-axis"}, interfaces={})
    rib["modes"] = [{"kind": "lowest", "count": 2}]
    rib["analysis"] = {"supports": [], "loads": {}, "error": True}
    rib["solid"]["mesh"]["size"] = 0.2  # 0.01 clears it
    (found,) = build_body(rib).provenance["warnings"]
    assert found["code"] == "solid-mesh-coarse"
    held = {"free_error": [0.01], "held_error": [0.03, 0.04]}
    assert not coarse_mesh(held)
    (found,) = coarse_mesh({**held, "cases": {"end": {}}})
    assert "up to 4 % too high by the mesh, deflections about 6 % too small" in found["message"]
