"""Solids from STEP files: inertia as OpenCASCADE computes it, materials, interfaces, refusals."""

import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.solid_samples import (
    ALUMINIUM,
    INCH,
    MILLIMETRE,
    STEEL,
    WOUND,
    bar,
    bracket,
    cad_file,
    filleted,
    model_of,
    one_body,
    step_file,
    thin_rib,
    tube,
    two_solids,
)

from plymotion.preprocess.fenicsx import MeshError, gmsh_alone, gmsh_session
from plymotion.preprocess.solid import solid_mesh
from plymotion.preprocess.solid.materials import Curve
from plymotion.preprocess.solid.model import SolidModel
from plymotion.preprocess.solid.solid_analysis import free_hertz
from plymotion.preprocess.solid.solid_mesh import SolidError, edge_length

RTOL = 1e-4  # of mass, centre over the radius of gyration, inertia over its largest entry
NORMAL = {"normal": [0.0, 0.0, 1.0]}
ABOUT_Z = {"axis_about": {"point": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}}


def assert_inertia(model: SolidModel, expected: tuple[float, Any, Any]) -> None:
    """Compare the mass matrix of the mesh with the exact geometry."""
    body = model.body
    R = body.rigid_motions()
    rigid = R.T @ body.M @ R
    mass, centre, J = expected
    assert rigid[0, 0] == pytest.approx(mass, rel=RTOL)
    found = np.array([rigid[1, 5], rigid[2, 3], rigid[0, 4]]) / rigid[0, 0]
    gyration = np.sqrt(np.trace(J) / mass)
    np.testing.assert_allclose(found, centre, rtol=0, atol=RTOL * gyration)
    about = rigid[3:, 3:] - rigid[0, 0] * (found @ found * np.eye(3) - np.outer(found, found))
    np.testing.assert_allclose(about, J, rtol=0, atol=RTOL * np.abs(J).max())


def shaft(occ: Any) -> None:
    """Draw a cylinder whose cells are as large as its radius, but for its curvature."""
    occ.addCylinder(0, 0, 0, 0, 0, 30, 10)


@pytest.mark.parametrize(
    ("draw", "unit", "length", "size", "material", "region"),
    [
        (bracket, MILLIMETRE, 1e-3, 0.008, ALUMINIUM, {}),
        (bracket, INCH, 0.0254, 0.2, STEEL, {}),
        (filleted, MILLIMETRE, 1e-3, 0.006, ALUMINIUM, {}),
        (thin_rib, MILLIMETRE, 1e-3, 0.006, ALUMINIUM, {}),
        (tube, MILLIMETRE, 1e-3, 0.01, WOUND, ABOUT_Z),
        (shaft, MILLIMETRE, 1e-3, 0.012, ALUMINIUM, {}),
    ],
    ids=["mm", "inch", "fillets", "thin rib", "wound tube", "coarse shaft"],
)
def test_inertia_is_that_of_the_cad_geometry(
    draw: Callable[[Any], None],
    unit: str,
    length: float,
    size: float,
    material: Any,
    region: Any,
    tmp_path: Path,
) -> None:
    file = tmp_path / "part.step"
    parts = step_file(file, draw, unit)
    model = model_of(file, size, material, region=region)
    assert_inertia(model, one_body(parts, [material["rho"]], length))


def _blade(occ: Any) -> None:
    above = [(-0.5, 0.0), (-0.2, 0.08), (0.1, 0.07), (0.5, 0.005)]
    below = [(0.5, -0.005), (0.1, -0.03), (-0.2, -0.04)]
    wires = []
    for k in range(4):
        chord, turn = 30.0 - 5.0 * k, np.exp(1j * np.deg2rad(10.0 * k))
        places = [chord * turn * complex(*place) for place in above + below]
        points = [occ.addPoint(z.real, z.imag, 40.0 * k) for z in places]
        curves = [occ.addSpline(points[:4]), occ.addLine(points[3], points[4])]
        wires.append(occ.addWire([*curves, occ.addSpline([*points[4:], points[0]])]))
    occ.addThruSections(wires, makeSolid=True)


def test_default_cells_fit_thin_curved_parts(tmp_path: Path) -> None:
    """A twentieth of the diagonal is larger than the wall: its mass is off by 1e-3."""
    file = tmp_path / "blade.step"
    (part,) = step_file(file, _blade)
    exact = ALUMINIUM["rho"] * 1e-9 * part.volume
    for size, off in ((None, False), (0.0062, True)):
        body = model_of(file, size).body
        x = body.rigid_motions()[:, 0]
        assert len(x) < 20_000
        assert (abs(x @ body.M @ x / exact - 1.0) > RTOL) == off


def test_default_cells_that_would_become_too_many_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without another mesh, which could take minutes or be refused."""
    file = tmp_path / "blade.step"
    step_file(file, _blade)
    meshes: list[Any] = []
    made = solid_mesh._made
    monkeypatch.setattr(solid_mesh, "_made", lambda *how: meshes.append(how) or made(*how))
    monkeypatch.setattr(solid_mesh, "MOST", 10_000)  # the default mesh has 3400 unknowns
    model_of(file, None)
    assert len(meshes) == 1


@pytest.mark.parametrize("draw", [bracket, tube])
@pytest.mark.parametrize(("name", "length"), [("part.brep", 1e-3), ("PART.BREP", 0.0254)])
def test_brep_files_are_in_the_unit_that_is_given(
    draw: Callable[[Any], None], name: str, length: float, tmp_path: Path
) -> None:
    parts = cad_file(tmp_path / "drawn.brep", draw)
    file = (tmp_path / "drawn.brep").rename(tmp_path / name)
    with pytest.raises(SolidError, match=r"unit: missing: a \.(brep|BREP) file has no unit"):
        model_of(file, 8.0 * length)
    model = model_of(file, 8.0 * length, unit=length)
    assert_inertia(model, one_body(parts, [ALUMINIUM["rho"]], length))
    # the exact geometry as well: its cylinders are still cylinders
    assert model.mesh.exact[0].volume == pytest.approx(length**3 * parts[0].volume, rel=1e-9)


def _iges(file: Path, draw: Callable[[Any], None]) -> Any:
    try:
        return cad_file(file, draw)
    except Exception as error:  # gmsh raises bare Exception
        if "Unknown output file format" not in str(error):
            raise
        pytest.skip("this gmsh writes no IGES")


@pytest.mark.parametrize("draw", [bracket, tube])
def test_faces_of_iges_files_become_a_solid(draw: Callable[[Any], None], tmp_path: Path) -> None:
    file = tmp_path / "part.igs"
    parts = _iges(file, draw)
    model = model_of(file, 0.008)
    assert_inertia(model, one_body(parts, [ALUMINIUM["rho"]], 1e-3))
    assert model.mesh.exact[0].volume == pytest.approx(1e-9 * parts[0].volume, rel=1e-6)


def _void(occ: Any) -> None:
    box, hole = occ.addBox(0, 0, 0, 40, 20, 10), occ.addBox(10, 5, 3, 10, 10, 4)
    occ.cut([(3, box)], [(3, hole)])


def test_a_void_of_an_iges_file_stays_empty(tmp_path: Path) -> None:
    file = tmp_path / "part.igs"
    _iges(file, _void)
    assert model_of(file, 0.01).mesh.exact[0].volume == pytest.approx(7.6e-6, rel=1e-6)


def test_a_void_beside_another_solid_of_an_iges_file_is_not_filled(tmp_path: Path) -> None:
    """Faces alone do not tell a void from a solid within another."""
    file = tmp_path / "part.igs"

    def draw(occ: Any) -> None:
        _void(occ)
        occ.addBox(40, 0, 0, 20, 20, 10)

    _iges(file, draw)
    with pytest.raises(SolidError, match=r"part.igs: 3 solids intersect; expected"):
        model_of(file, 0.01)


def test_the_tip_of_a_cone_is_meshed(tmp_path: Path) -> None:
    """gmsh 4.15 makes triangles that overlap by its first algorithm, of BREP at this size."""
    file = tmp_path / "part.brep"
    (part,) = cad_file(file, lambda occ: occ.addCone(0, 0, 0, 0, 0, 20, 10, 0))
    model = model_of(file, 0.003, unit=1e-3)
    rigid = model.body.rigid_motions()[:, 0]
    assert rigid @ model.body.M @ rigid == pytest.approx(2.7e-6 * part.volume, rel=2e-4)


@pytest.mark.parametrize("shape", ["addSphere", "addTorus"])
def test_round_parts_have_sound_cells(shape: str, tmp_path: Path) -> None:
    """Some quadratic cells are turned inside out, unless their edges are straight."""
    sizes = {"addSphere": (10.0,), "addTorus": (20.0, 5.0)}
    file = tmp_path / "part.step"
    (part,) = step_file(file, lambda occ: getattr(occ, shape)(0.0, 0.0, 0.0, *sizes[shape]))
    model = model_of(file, None)
    rigid = model.body.rigid_motions()[:, 0]
    mass = ALUMINIUM["rho"] * 1e-9 * part.volume
    assert rigid @ model.body.M @ rigid == pytest.approx(mass, rel=1e-3)


@pytest.mark.parametrize("name", ["part.step", "part.igs"])
def test_two_solids_share_their_faces_and_keep_their_materials(name: str, tmp_path: Path) -> None:
    file = tmp_path / name
    parts = step_file(file, two_solids) if name == "part.step" else _iges(file, two_solids)
    mesh = {"file": str(file), "size": 0.006}
    materials = {"aluminium": ALUMINIUM, "steel": STEEL}
    names = model_of(file, 0.006).mesh.plain.regions
    assert len(names) == 2
    volumes = [part.volume for part in model_of(file, 0.006).mesh.exact]
    block = int(np.argmax(volumes))
    regions = {
        name: {"material": "aluminium" if i == block else "steel"} for i, name in enumerate(names)
    }
    model = SolidModel({"mesh": mesh, "materials": materials, "regions": regions}, {})
    density = [2700.0 if p.volume == max(q.volume for q in parts) else 7850.0 for p in parts]
    assert_inertia(model, one_body(parts, density, 1e-3))
    x = model.mesh.plain.points  # nodes of the common cylinder are there once
    assert len(np.unique(np.round(x, 9), axis=0)) == len(x)


def test_axes_of_a_wound_tube_follow_the_cylinder(tmp_path: Path) -> None:
    """Extension around is E1, along E2: strain energies of both in the stiffness of the cells."""
    file = tmp_path / "part.step"
    step_file(file, tube)
    model = model_of(file, 0.01, WOUND, region=ABOUT_Z)
    plain = model.mesh.plain
    arm = plain.points[plain.cells].mean(axis=1)
    angle = np.arctan2(arm[:, 1], arm[:, 0])
    c, s = -np.sin(angle), np.cos(angle)  # direction around
    strain = np.stack([c * c, s * s, 0 * c, 0 * c, 0 * c, 2 * c * s], axis=1)
    C_B = model.materials.C_B(arm, np.arange(len(arm)))
    around = np.einsum("ci,cij,cj->c", strain, C_B, strain)
    fixed = model_of(file, 0.01, WOUND, region={"axis": [1.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]})
    along_x = fixed.materials.C_B(arm, np.arange(len(arm)))[:, 0, 0]
    np.testing.assert_allclose(around, along_x, rtol=1e-12)
    np.testing.assert_allclose(C_B[:, 2, 2], fixed.materials.C_M[:, 1, 1], rtol=1e-12)


def test_axes_along_a_curve_are_its_tangents(tmp_path: Path) -> None:
    """A polygon of 180 sides in the wall of a tube turns the fibres as the cylinder does."""
    file = tmp_path / "part.step"
    step_file(file, tube)
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    ring = 0.0225 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    along = {"axis_along": {"points": ring.tolist()}, "normal": [0.0, 0.0, -1.0]}
    one, other = (model_of(file, 0.012, WOUND, region=region) for region in (along, ABOUT_Z))
    centres = other.mesh.plain.points[other.mesh.plain.cells].mean(axis=1)
    axes = [m.materials.axes(centres, np.arange(len(centres)))[:, :, 0] for m in (one, other)]
    # nearest points of a side stay behind those of the circle: a tenth of half its angle
    np.testing.assert_allclose(axes[0], axes[1], rtol=0, atol=0.1 * np.pi / 180.0)
    hertz = [free_hertz(m.body, 4) for m in (one, other)]
    np.testing.assert_allclose(hertz[0], hertz[1], rtol=1e-4)
    with pytest.raises(
        SolidError, match=r"axis_along.at = \"rim\": the mesh has no physical curve"
    ):
        model_of(file, 0.012, WOUND, region={"axis_along": {"at": "rim"}, **NORMAL})


def test_pieces_of_a_curve_have_no_direction() -> None:
    """Two curves of a mesh that run towards each other, and a curve that turns back."""
    angle = np.linspace(0.0, np.pi, 21)
    ring = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    pieces = np.stack([ring[:-1], ring[1:]], axis=1)
    turned = np.concatenate([pieces[:10], pieces[10:, ::-1]])
    x = np.random.default_rng(1).normal(size=(50, 3))
    one, other = (Curve(each).tangents(x) for each in (pieces, turned))
    np.testing.assert_allclose(np.abs((one * other).sum(axis=1)), 1.0, rtol=1e-12)
    back = Curve(np.array([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [0, 0, 0]]], dtype=float))
    np.testing.assert_array_equal(np.abs(back.tangents(x)[:, 0]), 1.0)


def test_a_signature_may_follow_a_step_file(tmp_path: Path) -> None:
    file = tmp_path / "part.step"
    step_file(file, bar)
    file.write_text(file.read_text() + "SIGNATURE;\nMIIB\nENDSEC;\n")
    assert model_of(file, 0.05).mesh.exact[0].volume == pytest.approx(0.2 * 0.012 * 0.008)


BORE = {"radius": 0.006, "point": [0.085, 0.02, 0.0], "direction": [0.0, 0.0, 2.0]}


def test_interfaces_are_found_by_bore_and_plane(tmp_path: Path) -> None:
    file = tmp_path / "part.step"
    step_file(file, bracket)
    interfaces = {
        "pin": {"bore": BORE, "link": "rigid", "rotation_deg": [0.0, 0.0, 0.0]},
        "half": {"bore": {**BORE, "length": 0.01}, "link": "average"},
        "base": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}, "link": "average"},
    }
    model = model_of(file, 0.005, interfaces=interfaces)
    x = {name: model.body.nodes[rows] for name, rows in model.body.groups.items()}
    r = np.hypot(*(x["pin"][:, :2] - [0.085, 0.02]).T)
    np.testing.assert_allclose(r, 0.006, rtol=1e-3)
    assert np.ptp(x["pin"][:, 2]) == pytest.approx(0.01)
    assert x["half"][:, 2].max() < 0.01  # faces with their middles below 5 mm
    np.testing.assert_allclose(x["base"][:, 2], 0.0, atol=1e-9)
    exact = 0.1 * 0.04 - np.pi * (0.008**2 + 0.006**2)
    assert exact < _area(model, "base") < 1.005 * exact  # the corners of circles are polygons


def _area(model: SolidModel, name: str) -> float:
    x = model.mesh.plain.points[model.mesh.corners[model.faces[name]]]
    return float(0.5 * np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum())


def without_unit(file: Path) -> None:
    """Remove the unit of length."""
    file.write_text(file.read_text().replace("LENGTH_UNIT() ", ""))


def open_shell(file: Path) -> None:
    """Write the faces of a box but one."""
    with gmsh_session() as gmsh:
        gmsh.clear()
        occ = gmsh.model.occ
        occ.addBox(0, 0, 0, 10, 10, 10)
        occ.synchronize()
        faces = gmsh.model.getEntities(2)
        occ.remove(gmsh.model.getEntities(3))
        occ.remove(faces[:1])
        occ.synchronize()
        gmsh.write(str(file))
        gmsh.clear()


def flat(file: Path) -> None:
    """Write a plate of no thickness."""
    with gmsh_session() as gmsh:
        gmsh.clear()
        gmsh.model.occ.addRectangle(0, 0, 0, 10, 10)
        gmsh.model.occ.synchronize()
        gmsh.write(str(file))
        gmsh.clear()


def with_box(x: float, y: float, z: float, side: float) -> Callable[[Path], Any]:
    """A spoiler that writes a cube of 10 and another of this place and side."""

    def draw(occ: Any) -> None:
        occ.addBox(0, 0, 0, 10, 10, 10)
        occ.addBox(x, y, z, side, side, side)

    return lambda file: step_file(file, draw)


def replaced(old: str, new: str) -> Callable[[Path], Any]:
    """A spoiler that replaces the first match of a pattern, as a faulty program or disk does."""

    def spoil(file: Path) -> None:
        text, count = re.subn(old, new, file.read_text(), count=1, flags=re.DOTALL)
        assert count
        file.write_text(text)

    return spoil


def crossed_edges(file: Path) -> None:
    """Turn every third edge; gmsh splits what crosses then again and again, and may abort."""
    words = re.split(r"(ORIENTED_EDGE\('',\*,\*,#\d+,\.[TF]\.)", file.read_text())
    for i in range(1, len(words), 6):
        words[i] = words[i][:-2] + ("F." if words[i].endswith("T.") else "T.")
    file.write_text("".join(words))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (without_unit, "part.step: has no LENGTH_UNIT"),
        (replaced(r"LINE\('", "LINE(('"), r"line \d+: #\d+ = LINE\(\(''.*: expected #NUMBER"),
        (replaced(r"LINE\(''", "LINE('"), r"line \d+: the text that begins here has no end"),
        (replaced(r"\n#20 =.*?;", ""), r"line \d+: expected #20 in the file"),
        (replaced(r"\n#21 =", "\n#20 ="), r"line \d+: #20 is in line \d+, too"),
        (replaced(r"ENDSEC;\s*END.*", ""), r"line \d+: expected END-ISO-10303-21; as its"),
        (crossed_edges, "gmsh (ends by|does not end|cannot mesh)"),
        (open_shell, "part.step: no closed solid, found 5 faces"),
        (flat, "part.step: no closed solid, found 1 faces"),
        (with_box(5, 5, 5, 10), "part.step: 2 solids intersect"),
        (with_box(2, 2, 2, 5), "part.step: 2 solids intersect"),
        (with_box(0, 0, 0, 10), "part.step: 2 solids intersect"),
        (with_box(10, 10, 0, 10), r"2 parts .*; two touch at \[0.01, 0.01, 0.0\] m; expected"),
        (lambda file: file.write_text("solid"), "line 1: expected ISO-10303-21"),
    ],
    ids=[
        *("no unit", "parenthesis", "quote", "missing", "twice", "cut off", "crossed edges"),
        *("open", "flat", "crossed", "within", "twice there", "by an edge", "no STEP"),
    ],
)
def test_wrong_geometry_is_refused(
    spoil: Callable[[Path], Any], words: str, tmp_path: Path
) -> None:
    file = tmp_path / "part.step"
    step_file(file, bracket)
    spoil(file)
    with pytest.raises(SolidError, match=words) as error:
        model_of(file, 0.005)
    assert "expected" in str(error.value)


def test_nearly_incompressible_materials_are_refused(tmp_path: Path) -> None:
    """Round-off of the bulk stiffness hides the lowest frequencies; it was called a hinge."""
    file = tmp_path / "part.step"
    step_file(file, bar)
    with pytest.raises(SolidError, match=r"materials.stuff: its stiffest .* nu up to 0\.499999"):
        model_of(file, 0.02, {**ALUMINIUM, "nu": 0.49999999})
    assert free_hertz(model_of(file, 0.02, {**ALUMINIUM, "nu": 0.499999}).body, 1) > 0.0


@pytest.mark.parametrize(
    ("interface", "words"),
    [
        ({"bore": {**BORE, "radius": 0.007}}, "radii about this axis: 0.006 m"),
        ({"bore": {**BORE, "point": [0.05, 0.0, 0.0]}}, "no cylinder of the solid has this axis"),
        ({"plane": {"point": [0, 0, 1], "normal": [0, 0, 1]}}, "reaches from -1 to -0.965 m"),
        ({"at": "lug"}, 'at = "lug": the solid has no physical surface of this name'),
    ],
)
def test_faces_that_are_not_there_are_named(interface: Any, words: str, tmp_path: Path) -> None:
    file = tmp_path / "part.step"
    step_file(file, bracket)
    with pytest.raises(SolidError, match=r"^interfaces\.pin") as error:
        model_of(file, 0.01, interfaces={"pin": {**interface, "link": "rigid"}})
    assert words in str(error.value)


CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
LINEAR, QUADRATIC = "4 2 1 1 1 2 3 4", "11 2 1 1 2 3 4 5 6 7 8 9 10 11"


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ((LINEAR, QUADRATIC), "one kind and degree only"),
        ((QUADRATIC, LINEAR), "one kind and degree only"),
        ((LINEAR, LINEAR), "1 cells have the corners of another one"),
    ],
)
def test_meshes_that_gmsh_or_dolfinx_would_crash_on(
    tmp_path: Path, cells: tuple[str, str], words: str
) -> None:
    pairs = [(1, 2), (2, 3), (1, 3), (1, 4), (3, 4), (2, 4)]
    middles = [tuple(0.5 * np.add(CORNERS[a], CORNERS[b])) for a, b in pairs]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "1", '3 1 "a"']
    lines += ["$EndPhysicalNames", "$Nodes", "11"]
    lines += [f"{k} {x} {y} {z}" for k, (x, y, z) in enumerate(CORNERS + middles, start=1)]
    lines += ["$EndNodes", "$Elements", "2", *(f"{k} {c}" for k, c in enumerate(cells, start=1))]
    file = tmp_path / "part.msh"
    file.write_text("\n".join([*lines, "$EndElements", ""]))
    with pytest.raises(SolidError, match=words):
        model_of(file, 1.0, unit=1.0)


def test_ten_million_unknowns_are_refused_before_meshing(tmp_path: Path) -> None:
    file = tmp_path / "part.step"
    step_file(file, bracket)
    with pytest.raises(SolidError, match=r"mesh.size = 0.0005 m: about .*e\+0[67] unknowns"):
        model_of(file, 0.0005)


def test_cells_larger_than_the_part_are_the_coarsest(tmp_path: Path) -> None:
    file = tmp_path / "part.step"
    step_file(file, bar)
    model = model_of(file, 1e308)
    assert 0 < len(model.mesh.plain.cells) <= len(model_of(file, 0.02).mesh.plain.cells)
    assert model.mesh.size == pytest.approx(np.linalg.norm([0.2, 0.012, 0.008]), rel=1e-9)


def test_the_size_of_cells_is_not_that_of_fillets(tmp_path: Path) -> None:
    """From it on, cells become smaller for `accuracy`: not by the ratio to those of fillets."""
    file = tmp_path / "part.step"
    step_file(file, filleted)
    mesh = model_of(file, None).mesh
    assert mesh.size == pytest.approx(np.linalg.norm([0.08, 0.03, 0.02]) / 20.0, rel=1e-9)
    assert edge_length(mesh) < 0.5 * mesh.size  # most edges of faces are in fillets


def test_faces_that_intersect_are_refused(tmp_path: Path) -> None:
    """A box whose top is pushed through its bottom at one corner."""
    top = [(0, 0, 1), (1, 0, 1), (1, 1, -1), (0, 1, 1)]
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), *top]
    faces = [(1, 2, 3), (1, 3, 4), (5, 6, 7), (5, 7, 8)]
    faces += [(1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 4, 8), (3, 8, 7)]
    faces += [(4, 1, 5), (4, 5, 8)]
    edges: dict[tuple[int, int], int] = {}
    lines = [f"Point({i}) = {{{x}, {y}, {z}}};" for i, (x, y, z) in enumerate(corners, 1)]
    for number, face in enumerate(faces, 1):
        loop = []
        for a, b in zip(face, (*face[1:], face[0]), strict=True):
            if (b, a) in edges:
                loop.append(-edges[b, a])
            else:
                new = edges.setdefault((a, b), len(edges) + 1)
                loop.append(new)
        lines.append(f"Curve Loop({number}) = {{{', '.join(map(str, loop))}}};")
        lines.append(f"Plane Surface({number}) = {{{number}}};")
    curves = [f"Line({n}) = {{{a}, {b}}};" for (a, b), n in edges.items()]
    shell = ", ".join(str(n) for n in range(1, len(faces) + 1))
    solid = [f"Surface Loop(1) = {{{shell}}};", "Volume(1) = {1};", "Mesh.MeshSizeMax = 0.5;"]
    file = tmp_path / "box.geo"
    file.write_text("\n".join([*lines[:8], *curves, *lines[8:], *solid]) + "\n")
    with pytest.raises(SolidError, match="expected faces that do not intersect"):
        model_of(file, 0.5, unit=1.0)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(SolidError, match=r"no\.step.*no such file"):
        model_of(tmp_path / "no.step", 0.01)


def waits(file: str, works: float) -> float:
    """Compute for some time [s], then wait without end, as for a lock that nobody gives back."""
    while time.process_time() < works:
        pass
    time.sleep(0.0 if file == "ends" else 1e6)
    return works


@pytest.mark.one_end
def test_a_process_of_gmsh_that_waits_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the clock, because it takes no processor time. One that computes may take longer."""
    monkeypatch.setattr(gmsh_alone, "STILL", 0.2)
    with pytest.raises(MeshError, match=r"^waits: gmsh waits without end; start the command again"):
        gmsh_alone.apart(waits, "waits", 0.0)
    assert gmsh_alone.apart(waits, "ends", 0.6) == 0.6
